//! Fuzzes runs, sweeps and exchanges in prepared folders, with the code of `tests/random_runs`.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/random_runs/choices.rs"]
mod choices;
#[path = "../../tests/random_runs/folders.rs"]
mod folders;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = folders::judge(bytes, &folders::Change::ALL);
});
