//! Fuzzes the checkpoint reader, which must reject invalid bytes with an error.
//!
//! Each input is read twice: unchanged, and with a corrected length and checksum. Without the correction, nearly all
//! inputs fail at the checksum. Checkpoints of a few runs are a good initial corpus.
#![no_main]

use std::fs;

use carom::run::checkpoint::Checkpoint;
use libfuzzer_sys::fuzz_target;

/// Bytes at the end of a checkpoint: the length of the data and the checksum.
const TAIL: usize = 12;
/// Bytes at the start of a checkpoint: the magic number, the version and the layout.
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
