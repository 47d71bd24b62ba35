//! Fuzzes the extended XYZ reader. If a frame can be read, it can be written and read again without changes.
#![no_main]

use carom::trajectory::Frame;
use carom::trajectory::extended_xyz::{FrameReader, write_frame};
use libfuzzer_sys::fuzz_target;

const MOST: usize = 8;

fn read(bytes: &[u8]) -> Vec<Frame> {
    FrameReader::new(bytes).take(MOST).map_while(Result::ok).collect()
}

fuzz_target!(|bytes: &[u8]| {
    for frame in read(bytes) {
        let mut written = Vec::new();
        if write_frame(&mut written, &frame).is_err() {
            continue;
        }
        let again = read(&written);
        let [again] = &again[..] else { panic!("written, but cannot be read back: {}", String::from_utf8_lossy(&written)) };
        // NaN is not equal to itself, so texts are compared.
        assert_eq!(format!("{:?}", frame.particles), format!("{:?}", again.particles));
    }
});
