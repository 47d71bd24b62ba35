//! Compares a stepped potential with velocity Verlet in the smooth potential.

mod fluid;
mod stepped;
mod verlet;

use super::Outcome;
use super::clock::Stopwatch;
use super::plot::{Panel, Series, draw};
use super::sheet::{Sheet, number};
use carom::analysis::statistics::standard_error;
use fluid::{Fluid, State, Thermodynamics};

const SHEET: &str = "lennard_jones";

/// Cutoff of the potential `4 [(1/r)^12 - (1/r)^6]`. The potential is shifted to zero at the cutoff.
const CUTOFF: f64 = 2.5;

const STEPS: [usize; 6] = [5, 10, 20, 50, 100, 200];

/// The smallest time step gives the reference.
const TIME_STEPS: [f64; 6] = [0.001, 0.002, 0.005, 0.01, 0.015, 0.02];

const INTERVAL: f64 = 0.05;

/// Processor time after which velocity Verlet ends early, for the reference and for the other runs `[s]`.
const MOST_SECONDS: [f64; 2] = [40.0, 8.0];

struct Plan {
    name: &'static str,
    density: f64,
    temperature: f64,
    duration: f64,
    relaxation: f64,
    skin: f64,
    /// Processor time after which a stepped run ends early `[s]`.
    most_seconds: f64,
}

const PLANS: [Plan; 2] = [
    Plan {
        name: "gas",
        density: 0.05,
        temperature: 1.5,
        duration: 1_000.0,
        relaxation: 10.0,
        skin: 1.0,
        most_seconds: 6.0,
    },
    Plan {
        name: "liquid",
        density: 0.8,
        temperature: 1.2,
        duration: 300.0,
        relaxation: 5.0,
        skin: 0.6,
        most_seconds: 18.0,
    },
];

struct Measured {
    microseconds: f64,
    duration: f64,
    mean: Thermodynamics,
    error: Thermodynamics,
}

const COLUMNS: [&str; 13] = [
    "fluid",
    "method",
    "step",
    "us per particle and time",
    "simulated time",
    "temperature",
    "energy",
    "energy error",
    "+-",
    "pressure",
    "pressure error",
    "+- ",
    "total energy drift",
];

pub fn measure() -> Outcome {
    let mut sheet = Sheet::new(SHEET, &COLUMNS);
    for plan in &PLANS {
        let start = verlet::equilibrate(plan);
        let mut reference = None;
        for dt in TIME_STEPS {
            let seconds = MOST_SECONDS[usize::from(dt != TIME_STEPS[0])];
            let measured = run(plan, &mut verlet::Verlet::new(plan, &start, dt), start.particles(), seconds);
            let mut cells = vec![plan.name.to_owned(), "velocity Verlet".to_owned(), number(dt)];
            cells.extend(compared(&measured, reference.as_ref().unwrap_or(&measured), &start));
            sheet.push(cells)?;
            reference.get_or_insert(measured);
        }
        for steps in STEPS {
            let Some(mut fluid) = stepped::Stepped::new(&start, steps)? else {
                println!("{SHEET}: {}, {steps} steps: skipped, potential energy exceeds total energy", plan.name);
                continue;
            };
            let measured = run(plan, &mut fluid, start.particles(), plan.most_seconds);
            let mut cells = vec![plan.name.to_owned(), "stepped".to_owned(), steps.to_string()];
            cells.extend(compared(&measured, reference.as_ref().unwrap_or(&measured), &start));
            sheet.push(cells)?;
        }
    }
    Ok(())
}

/// Relaxes, then samples until the simulated time or the processor time reaches its limit.
fn run(plan: &Plan, fluid: &mut impl Fluid, particles: f64, most_seconds: f64) -> Measured {
    let stopwatch = Stopwatch::start();
    let mut time = 0.0;
    while time < plan.relaxation && stopwatch.seconds() < 0.2 * most_seconds {
        fluid.advance(INTERVAL);
        time += INTERVAL;
    }
    let stopwatch = Stopwatch::start();
    let mut samples: Vec<Thermodynamics> = Vec::new();
    while (samples.len() as f64 * INTERVAL) < plan.duration && stopwatch.seconds() < most_seconds {
        samples.push(fluid.advance(INTERVAL));
    }
    let duration = samples.len() as f64 * INTERVAL;
    let series = |value: fn(&Thermodynamics) -> f64| samples.iter().map(value).collect::<Vec<_>>();
    let mean = |value: fn(&Thermodynamics) -> f64| series(value).iter().sum::<f64>() / samples.len() as f64;
    let error = |value: fn(&Thermodynamics) -> f64| standard_error(&series(value)).unwrap_or(f64::NAN);
    Measured {
        microseconds: stopwatch.seconds() * 1e6 / (particles * duration),
        duration,
        mean: Thermodynamics::each(mean),
        error: Thermodynamics::each(error),
    }
}

/// Returns the cells of a row: energy and pressure, each with the difference from the reference and its standard error.
fn compared(run: &Measured, reference: &Measured, start: &State) -> Vec<String> {
    let both = |a: f64, b: f64| if std::ptr::eq(run, reference) { a } else { a.hypot(b) };
    [
        run.microseconds,
        run.duration,
        run.mean.temperature,
        run.mean.potential,
        run.mean.potential - reference.mean.potential,
        both(run.error.potential, reference.error.potential),
        run.mean.pressure,
        run.mean.pressure - reference.mean.pressure,
        both(run.error.pressure, reference.error.pressure),
        run.mean.total - start.energy,
    ]
    .map(number)
    .to_vec()
}

const EXPLANATION: &str = "
## Lennard-Jones

The system is a Lennard-Jones fluid of 864 particles, with the potential cut off at 2.5 and shifted to zero there. *Stepped* is Carom with
this potential divided into n steps. The energy of each step is the average over the volume of its shell. *Velocity Verlet* is a plain
baseline written for this report (neighbour lists from cells, one thread, no hand-written SIMD). All runs of a fluid start from one
configuration with the same total energy. Both methods conserve the total energy, so the ensemble is the same (N, V, E). The tables compare
the mean potential energy per particle and the pressure. Errors are differences from velocity Verlet at the smallest time step. The columns
*+-* give the standard error of the difference, from block averages; in the row of the reference, they give its own standard error. Runs end
after a given simulated time or a given processor time. A stepped run that covers only a few units of time shows the cost of the potential,
but is still close to the initial configuration. A row of dashes is a run that diverged. Potentials with fewer steps than
listed cannot be simulated: with them, the potential energy of the initial configuration exceeds the total energy.

*What it shows*: for a smooth potential, time steps are a better discretisation than steps of the potential. A stepped potential with few
steps describes a different fluid, and every step costs events. With a stepped potential the total energy is conserved exactly; with large
time steps it drifts. A stepped potential is worthwhile if it is the model itself, or if few steps are enough.

*What it does not show*: potentials with fewer steps of unequal, carefully chosen widths; transport coefficients; long-range or many-body
forces; the gain of vectorised or parallel codes; errors below the standard error. For example, *0.001 +- 0.002* only says that no error was
found. For runs shorter than about ten units of time, the standard errors are uncertain, too.

";

pub fn describe(text: &mut String) -> Outcome {
    let Some(sheet) = Sheet::read(SHEET) else { return Ok(()) };
    *text += EXPLANATION;
    *text += &format!("{}\n\n{}\n", sheet.provenance, sheet.markdown());
    *text += "![Error of energy and pressure against processor time](speed_against_error/lennard_jones.svg)\n";
    let panel = |fluid: &str, quantity: &str, unit: &str, spread: &str| Panel {
        title: format!("{fluid}: error of the mean {quantity}"),
        x: "processor time per particle and unit time [us]".to_owned(),
        y: format!("difference from the reference [{unit}]"),
        series: series(&sheet.with("fluid", fluid), &format!("{quantity} error"), spread),
    };
    let row = |fluid: &str| {
        let energy = panel(fluid, "energy", "epsilon per particle", "+-");
        vec![energy, panel(fluid, "pressure", "epsilon / sigma^3", "+- ")]
    };
    draw(SHEET, &PLANS.map(|plan| row(plan.name)))
}

/// Returns the errors of each method, and their standard errors.
fn series(rows: &Sheet, error: &str, spread: &str) -> Vec<Series> {
    let mut all = Vec::new();
    for method in rows.values("method") {
        let of_method = rows.with("method", &method);
        let points = of_method.points("us per particle and time", error);
        let points = points.into_iter().filter(|point| point.1 != 0.0).collect();
        all.push(Series { name: method.clone(), points, has_line: true });
        let limits = of_method.points("us per particle and time", spread);
        all.push(Series { name: format!("{method}: standard error"), points: limits, has_line: false });
    }
    all
}
