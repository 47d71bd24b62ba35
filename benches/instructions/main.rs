//! Counts instructions per event, which do not depend on the load of the machine: `cargo bench --bench instructions`.
//!
//! `valgrind --tool=callgrind` counts the instructions of the event loop. Arguments select systems by name.

#[allow(dead_code, reason = "the bench of the engine uses all of it")]
#[path = "../engine/systems.rs"]
mod systems;

use carom::engine::{Simulation, Until};
use std::error::Error;
use std::process::{Command, ExitCode};
use systems::{SYSTEMS, System};

/// First argument of the child processes. Each child runs one system.
const CHILD: &str = "instructions-of-one";

const EVENTS: u64 = 50_000;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let outcome = match &arguments[..] {
        [word, name] if word == CHILD => run_one(name),
        names => run_all(names),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run_all(names: &[String]) -> Result<(), Box<dyn Error>> {
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("valgrind is not installed: no instructions were counted");
        return Ok(());
    }
    println!("| system | instructions per event | cell transitions per event |\n|---|---|---|");
    let is_meant = |system: &&System| names.is_empty() || names.iter().any(|name| system.name.contains(name.as_str()));
    for system in SYSTEMS.iter().filter(is_meant) {
        let (instructions, transitions) = count(system.name)?;
        println!("| {} | {:.0} | {transitions:.2} |", system.name, instructions / EVENTS as f64);
    }
    Ok(())
}

/// Returns the number of instructions for all counted events, and the number of cell transitions per event.
fn count(name: &str) -> Result<(f64, f64), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("callgrind.out");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--toggle-collect=*counted_events*"])
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(std::env::current_exe()?)
        .args([CHILD, name])
        .output()?;
    let log = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("{name}: valgrind ended with {}:\n{log}", output.status).into());
    }
    let collected = log.lines().find_map(|line| line.split("Collected :").nth(1)).ok_or("no count in the log")?;
    let transitions = String::from_utf8_lossy(&output.stdout).trim().parse()?;
    Ok((collected.trim().parse()?, transitions))
}

fn run_one(name: &str) -> Result<(), Box<dyn Error>> {
    let system = SYSTEMS.iter().find(|system| system.name == name).ok_or("no such system")?;
    let mut simulation = (system.start)();
    let before = simulation.event_counts().transition;
    counted_events(&mut simulation);
    println!("{}", (simulation.event_counts().transition - before) as f64 / EVENTS as f64);
    Ok(())
}

/// The counted part of a run. `callgrind` finds this function by its name.
#[inline(never)]
fn counted_events(simulation: &mut Simulation) {
    let events = simulation.event_counts().physical() + EVENTS;
    simulation.advance(Until::events(events)).expect("the run goes on");
}
