//! Measures how errors of energy and momentum grow in very long runs.
//!
//! ```text
//! cargo bench --bench long_runs -- hard_spheres 1e9     measures one scene into benches/results/long_runs/
//! cargo bench --bench long_runs -- report               draws what was measured
//! ```
//!
//! A run can be stopped at any time, because its rows are on disk. Random rounding errors grow with the square root of
//! the number of events. Systematic errors would grow in proportion to the number of events.

mod measure;
mod report;
mod row;

use std::error::Error;
use std::process::ExitCode;

const RUNS: [(&str, &str); 4] = [
    ("hard_spheres", "configs/hard_sphere_fluid.toml"),
    ("square_well", "configs/square_well_fluid.toml"),
    ("pendulum", "configs/pendulum.toml"),
    ("hopper", "configs/hopper.toml"),
];

const FOLDER: &str = "benches/results/long_runs";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    match execute(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn execute(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    match arguments {
        [word] if word == "report" => report::write(),
        [name, events] => {
            let (name, scene) =
                RUNS.iter().find(|(known, _)| known == name).ok_or(format!("no run is called {name}"))?;
            #[expect(clippy::cast_possible_truncation, reason = "no run has more events than a u64 counts")]
            let events = events.parse::<f64>()? as u64;
            measure::run(name, scene, events)
        }
        _ => {
            let names = RUNS.map(|(name, _)| name).join(", ");
            println!("long_runs: NAME EVENTS, or report; the names are {names}");
            Ok(())
        }
    }
}
