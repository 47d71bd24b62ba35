//! Measures the speed and the accuracy of Carom and of alternative methods.
//!
//! ```text
//! cargo bench --bench speed_against_error                    measures all sections and writes the report
//! cargo bench --bench speed_against_error -- kernels size    measures some sections and writes the report
//! cargo bench --bench speed_against_error -- report          writes the report from what was measured before
//! ```
//!
//! Each section writes `benches/results/speed_against_error/*.csv`. All of these files together make the report
//! `benches/results/speed_against_error.md`.

mod clock;
mod granular;
mod kernels;
mod length;
mod lennard_jones;
mod machine;
mod neighbours;
mod plot;
mod report;
mod sheet;
mod size;

#[path = "../../tests/oracle"]
#[allow(dead_code, reason = "the tests use all of it")]
mod oracle {
    pub mod cases;
    pub mod crossing;
    pub mod dyadic;
    pub mod exact;
    pub mod hard_cases;
    pub mod measure;
    pub mod polynomial;
    pub mod random;
    pub mod rule;
    pub mod sturm;
    pub mod witness;
}

use std::error::Error;
use std::process::ExitCode;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

struct Section {
    name: &'static str,
    measure: fn() -> Outcome,
    /// Appends tables and text to the report, and draws plots.
    describe: fn(&mut String) -> Outcome,
}

const SECTIONS: [Section; 5] = [
    Section { name: "kernels", measure: kernels::measure, describe: kernels::describe },
    Section { name: "lennard_jones", measure: lennard_jones::measure, describe: lennard_jones::describe },
    Section { name: "granular", measure: granular::measure, describe: granular::describe },
    Section { name: "length", measure: length::measure, describe: length::describe },
    Section { name: "size", measure: size::measure, describe: size::describe },
];

const FOLDER: &str = "benches/results/speed_against_error";

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

fn execute(arguments: &[String]) -> Outcome {
    if let [word, rest @ ..] = arguments
        && word == size::CHILD
    {
        return size::measure_one(rest);
    }
    let known = |name: &String| name == "report" || SECTIONS.iter().any(|section| section.name == name);
    if let Some(unknown) = arguments.iter().find(|name| !known(name)) {
        let names = SECTIONS.map(|section| section.name).join(", ");
        return Err(format!("no section is called {unknown}; there are {names}, and report").into());
    }
    std::fs::create_dir_all(FOLDER)?;
    for section in &SECTIONS {
        if arguments.is_empty() || arguments.iter().any(|name| name == section.name) {
            let stopwatch = std::time::Instant::now();
            (section.measure)()?;
            println!("{}: {:.0} s", section.name, stopwatch.elapsed().as_secs_f64());
        }
    }
    report::write()
}
