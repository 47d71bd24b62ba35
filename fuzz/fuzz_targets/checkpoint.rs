//! Bytes as a checkpoint: refused with a message, whatever is wrong with them.
//!
//! The checksum is made right first, or no other mistake would ever be reached. A corpus to start from are the checkpoints of some runs.
#![no_main]

use std::fs;

use carom::run::checkpoint::Checkpoint;
use libfuzzer_sys::fuzz_target;

/// Length and checksum at the end.
const TAIL: usize = 12;
/// Magic number, version and layout at the start.
const HEAD: usize = 32;

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("carom-fuzz-{}.checkpoint", std::process::id()));
    let mut sealed = bytes[..bytes.len().saturating_sub(TAIL)].to_vec();
    sealed.extend((sealed.len().saturating_sub(HEAD) as u64).to_le_bytes());
    sealed.extend(crc32fast::hash(&sealed).to_le_bytes());
    for content in [bytes, &sealed] {
        if fs::write(&path, content).is_ok() {
            let _ = Checkpoint::read(&path);
        }
    }
    let _ = fs::remove_file(&path);
});
