//! Counts false alarms of the audit in runs of random valid scenes.
//!
//! ```text
//! cargo bench --bench audits -- 1000        judges 1000 scenes, from seed 1 on
//! cargo bench --bench audits -- 1 4711      judges the scene of seed 4711, and prints it
//! ```
//!
//! `CAROM_DROPS=1000 cargo test --release --lib drops` tests that the audit finds the faults of a faulty engine.

mod judge;
mod scenes;

use std::collections::BTreeMap;
use std::process::ExitCode;

use judge::{Verdict, judge};

#[derive(Debug, Default)]
struct Tally {
    scenes: usize,
    refused: usize,
    events: u64,
    condemned: usize,
    longest: f64,
}

fn main() -> ExitCode {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|argument| argument.parse().ok()).collect();
    let (scenes, first) = (numbers.first().copied().unwrap_or(20), numbers.get(1).copied().unwrap_or(1));
    let mut tallies: BTreeMap<scenes::Kind, Tally> = BTreeMap::new();
    for seed in first..first + scenes {
        let scene = scenes::scene(seed);
        if scenes == 1 {
            println!("{}", scene.text);
        }
        let tally = tallies.entry(scene.kind).or_default();
        tally.scenes += 1;
        tally.longest = tally.longest.max(scene.longest);
        match judge(&scene.text) {
            Verdict::Refused(why) => {
                eprintln!("seed {seed}, {:?}: refused: {why}", scene.kind);
                tally.refused += 1;
            }
            Verdict::Sound(events) => tally.events += events,
            Verdict::Condemned(why) => {
                eprintln!("seed {seed}, {:?}, longest edge {:e}: {why}", scene.kind, scene.longest);
                tally.condemned += 1;
            }
        }
    }
    println!("| scenes | number | refused | longest edge | events | false audits |\n|---|---|---|---|---|---|");
    for (kind, tally) in &tallies {
        let Tally { scenes, refused, events, condemned, longest } = tally;
        println!("| {kind:?} | {scenes} | {refused} | {longest:.1e} | {events} | {condemned} |");
    }
    if tallies.values().any(|tally| tally.condemned > 0) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
