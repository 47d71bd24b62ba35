//! Fuzzes instruments in scenes with little or nothing to measure.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/random_runs/choices.rs"]
mod choices;
#[path = "../../tests/random_runs/instruments.rs"]
mod instruments;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let _ = instruments::judge(rest, first % 16 == 0);
});
