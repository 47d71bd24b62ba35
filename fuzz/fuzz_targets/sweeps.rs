//! Fuzzes the axes of sweeps, and several sweep calls in the same folder, with the code of `tests/random_runs`.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/random_runs/choices.rs"]
mod choices;
#[path = "../../tests/random_runs/sweeps.rs"]
mod sweeps;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    if first % 8 == 0 {
        let _ = sweeps::calls(rest, true);
    } else {
        let _ = sweeps::plan(rest);
    }
});
