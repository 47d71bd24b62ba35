//! Whole runs, sweeps and folders from random bytes. Each input must be rejected with a message or finish well. The
//! targets in `fuzz/` call the same functions. `CAROM_FUZZ_RUNS` is the number of cases of each kind, and
//! `CAROM_FUZZ_SEED` is the first seed (1 by default):
//!
//! ```text
//! CAROM_FUZZ_RUNS=100000 cargo test --release --test random_runs -- --nocapture
//! ```

mod choices;
mod folders;
mod instruments;
mod sweeps;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use choices::bytes;
use instruments::End;

const BYTES: usize = 160;

fn setting(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().map_or(usual, |text| text.parse().unwrap_or_else(|_| panic!("{name} = {text}")))
}

/// Calls `judge` for random cases and returns the results. After a panic in `judge`, continues with the other cases.
/// Finally panics with all failed seeds and the first failed case.
fn all<T>(cases: u64, show: impl Fn(&[u8]) -> String, judge: impl Fn(u64, &[u8]) -> T) -> Vec<T> {
    let first = setting("CAROM_FUZZ_SEED", 1);
    let mut objections = Vec::new();
    let mut found = Vec::new();
    for seed in first..first + setting("CAROM_FUZZ_RUNS", cases) {
        let bytes = bytes(seed, BYTES);
        if std::env::var_os("CAROM_FUZZ_TELL").is_some() {
            eprintln!("{seed}");
        }
        match catch_unwind(AssertUnwindSafe(|| judge(seed, &bytes))) {
            Ok(one) => found.push(one),
            Err(_) => objections.push(seed),
        }
    }
    if let Some(seed) = objections.first() {
        panic!("seeds {objections:?}; the first is\n{}", show(&bytes(*seed, BYTES)));
    }
    found
}

#[test]
fn instruments_handle_scenes_without_events() {
    let ends = all(400, instruments::scene, |seed, bytes| instruments::judge(bytes, seed % 20 == 0));
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for end in &ends {
        let word = match end {
            End::Refused(why) => format!("refused: {why}"),
            End::Over(word) => (*word).to_owned(),
        };
        *counts.entry(word).or_default() += 1;
    }
    println!("{counts:#?}");
    let ran = ends.iter().filter(|end| matches!(end, End::Over(_))).count();
    assert!(4 * ran > ends.len(), "many scenes are there to run: {counts:?}");
}

#[test]
fn sweep_axes_give_distinct_runs() {
    let show = |bytes: &[u8]| format!("{:?}", sweeps::axes(&mut choices::Choices::new(bytes)));
    let points = all(200, show, |_, bytes| sweeps::plan(bytes));
    let plans = points.iter().flatten().count();
    println!("{plans} of {}", points.len());
    assert!(20 * plans > points.len(), "many axes make a plan");
}

#[test]
fn a_folder_of_sweeps_holds_the_runs_of_its_points() {
    let over: usize = all(9, |bytes| format!("{bytes:?}"), |_, bytes| sweeps::calls(bytes, false)).iter().sum();
    assert!(over >= 9, "sweeps come to their end: {over}");
}

#[test]
fn nothing_outside_of_a_prepared_folder_changes() {
    let judge = |_, bytes: &[u8]| folders::judge(bytes, &folders::Change::ALL);
    let over: usize = all(150, |bytes| format!("{bytes:?}"), judge).iter().sum();
    println!("{over} calls");
    assert!(over > 60, "calls come to their end: {over}");
}
