//! Runs every command while the disk fails or the command is killed. No existing file may be lost, and interrupted work
//! must continue to bitwise identical results. `shim.c` injects the faults.
//!
//! `CAROM_FAULTS=1000 cargo test --release --test faults -- --nocapture` runs 1000 faults and prints counts.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

#[path = "../program/files.rs"]
mod files;
mod place;
mod scenarios;

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use place::{Kind, Place};
use scenarios::SCENARIOS;

const FEW: usize = 64;

#[test]
fn no_fault_and_no_kill_loses_a_file_or_changes_a_bit() {
    let Some(place) = Place::new() else {
        assert!(std::env::var_os("CAROM_REQUIRE").is_none(), "there is no C compiler");
        println!("skipped, because there is no C compiler");
        return;
    };
    let trials = std::env::var("CAROM_FAULTS").map_or(FEW, |text| text.parse().expect("CAROM_FAULTS is a number"));
    let counts: Vec<u64> = SCENARIOS.iter().map(|scenario| place.calls_of(scenario)).collect();
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let mut met = [0; Kind::ALL.len()];
    for trial in 0..trials {
        let which = trial % SCENARIOS.len();
        let kind = (trial / SCENARIOS.len()) % Kind::ALL.len();
        // The number of calls varies, because checkpoints are written at intervals of real time.
        let at = 1 + random.next_u64() % counts[which];
        met[kind] += usize::from(place.meet(&SCENARIOS[which], Kind::ALL[kind], at));
    }
    for (scenario, calls) in SCENARIOS.iter().zip(counts) {
        println!("{}: {calls} calls that change the disk", scenario.name);
    }
    for (kind, met) in Kind::ALL.iter().zip(met) {
        println!("{kind:?}: {met} met");
    }
    println!("{trials} faults, 0 differences, 0 files lost");
    assert!(met.iter().sum::<usize>() >= trials / 2, "most faults are met");
}
