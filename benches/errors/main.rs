//! Compares the standard errors that runs print with the scatter of the results over seeds.
//!
//! ```text
//! cargo bench --bench errors -- 48              48 seeds of thirteen systems, in short and five times longer runs
//! cargo bench --bench errors -- 48 crystal      only systems with `crystal` in their names
//! ```

mod systems;
mod tally;

use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use carom::exchange::{Exchange, PotentialEnergies};
use carom::model::Scene;
use carom::run::run;
use systems::{System, systems};
use tally::Tally;

/// Lengths of the runs, in units of a short run.
const LENGTHS: [f64; 2] = [1.0, 5.0];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let seeds: u64 = arguments.first().and_then(|number| number.parse().ok()).unwrap_or(4);
    let is_asked_for = |system: &&System| arguments.get(1).is_none_or(|part| system.name.contains(part.as_str()));
    println!(
        "| system | length | in 0.8 to 1.25 | below | above | withheld | largest deviation |\n|---|---|---|---|---|---|---|"
    );
    let mut tables = Vec::new();
    for system in systems().iter().filter(is_asked_for) {
        let mut tallies = Vec::new();
        for factor in LENGTHS {
            match campaign(system, factor, seeds) {
                Ok(tally) => tallies.push(tally),
                Err(trouble) => {
                    eprintln!("{}: {trouble}", system.name);
                    return ExitCode::FAILURE;
                }
            }
        }
        for (tally, factor) in tallies.iter().zip(LENGTHS) {
            println!("| {} | {} | {} |", system.name, factor * system.short, tally.line());
        }
        tables.push((system.name, tallies));
    }
    for (name, tallies) in &tables {
        println!("\n{}", tally::table(name, tallies));
    }
    ExitCode::SUCCESS
}

fn campaign(system: &System, factor: f64, seeds: u64) -> Result<Tally, String> {
    let (next, tally, trouble) = (AtomicU64::new(1), Mutex::new(Tally::default()), Mutex::new(None));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed > seeds {
                        return;
                    }
                    let add = |add: &dyn Fn(&mut Tally)| add(&mut tally.lock().unwrap_or_else(PoisonError::into_inner));
                    match simulate(&system.scene(factor, seed), add) {
                        Ok(()) => {}
                        Err(why) => *trouble.lock().unwrap_or_else(PoisonError::into_inner) = Some(why),
                    }
                }
            });
        }
    });
    match trouble.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(trouble) => Err(trouble),
        None => Ok(tally.into_inner().unwrap_or_else(PoisonError::into_inner)),
    }
}

fn simulate(text: &str, add: impl Fn(&dyn Fn(&mut Tally))) -> Result<(), String> {
    let scene = Scene::from_toml(text, "errors.toml").map_err(|refused| refused.to_string())?;
    if scene.exchange().is_none() {
        let Ok(finished) = run(scene, &mut (), &mut |_| ControlFlow::Continue(()));
        if let Some(trouble) = finished.trouble() {
            return Err(trouble);
        }
        add(&|tally| tally.add(&finished));
        return Ok(());
    }
    let exchange = Exchange::new(scene).map_err(|refused| refused.to_string())?;
    let mut energies = PotentialEnergies::default();
    let exchange = exchange.execute(1, &mut energies, &mut |_| ControlFlow::Continue(()));
    let exchange = exchange.map_err(|failed| failed.to_string())?;
    let (results, curves) = (exchange.results(), energies.curves(&exchange));
    if let Some(fault) = results.faults.first() {
        return Err(fault.clone());
    }
    add(&|tally| tally.add_exchange(&results, &curves));
    Ok(())
}
