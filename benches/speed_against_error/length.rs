//! Drift and deepest overlap against the number of events.

#[path = "../long_runs"]
#[allow(dead_code, reason = "that bench uses all of it")]
mod long_runs {
    pub const FOLDER: &str = "benches/results/long_runs";

    pub mod measure;
    pub mod row;
}

use super::Outcome;
use super::clock::Stopwatch;
use super::plot::{Panel, Series, draw};
use super::sheet::{Sheet, number};
use carom::engine::{Simulation, Until};
use carom::model::potential::Potential;
use carom::scene::{Amount, Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};
use long_runs::measure::Start;
use long_runs::row::{self, Row};

const SHEET: &str = "length";

const PARTICLES: u64 = 500;
const MOST_EVENTS: f64 = 1e7;

/// Processor time after which a run ends early `[s]`.
const MOST_SECONDS: f64 = 60.0;

const COLUMNS: [&str; 6] =
    ["run", "events", "energy error", "momentum drift", "deepest overlap", "events in invalid states"];

pub fn measure() -> Outcome {
    let mut sheet = Sheet::new(SHEET, &COLUMNS);
    let hard = Potential::hard_sphere(1.0)?;
    let well = Potential::square_well(1.0, 1.5, 1.0)?;
    run(&mut sheet, "hard spheres; N = 500", hard, Amount::PackingFraction(0.4))?;
    run(&mut sheet, "square well; N = 500", well, Amount::NumberDensity(0.5))
}

fn run(sheet: &mut Sheet, name: &str, potential: Potential, amount: Amount) -> Outcome {
    let scene = SceneBuilder::new("length")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("A", "A"))
        .fill(Fill { amount: Some(amount), ..Fill::new(Lattice::FaceCentredCubic, "A").count(PARTICLES) })
        .temperature(2.0)
        .build()?;
    let mut simulation = Simulation::without_plan(scene);
    let start = Start::of(&simulation);
    let stopwatch = Stopwatch::start();
    let mut events: f64 = 1e3;
    while events < 1.01 * MOST_EVENTS && stopwatch.seconds() < MOST_SECONDS {
        #[expect(clippy::cast_possible_truncation, reason = "MOST_EVENTS at most")]
        let whole = events.round() as u64;
        simulation.advance(Until::events(whole))?;
        sheet.push(cells(name, &start.row(&simulation, stopwatch.seconds())))?;
        events *= 10_f64.sqrt();
    }
    Ok(())
}

fn cells(name: &str, row: &Row) -> Vec<String> {
    let mut cells = vec![name.to_owned()];
    cells.extend([row.events, row.energy, row.momentum, row.overlap, row.invalid].map(number));
    cells
}

const EXPLANATION: &str = "
## Length

The results are from one run of 500 hard spheres (packing fraction 0.40), one run of 500 square wells (lambda 1.5, density 0.5), and the
runs of `cargo bench --bench long_runs`. *Energy error* is the relative deviation from the initial energy, and *momentum drift* is the
relative deviation from the initial momentum. *Deepest overlap* is the deepest so far, relative to the distance of the discontinuity.

*What it shows*: the errors of energy and momentum stay below the error of a random walk with one rounding of the total per event. Overlaps
are as small as one rounding of a coordinate, even in long runs. No error grows in proportion to the number of events.

*What it does not show*: whether trajectories are right. Trajectories are chaotic: if two trajectories differ in the last digit, they
diverge within a few tens of events per particle. `carom verify` proves what can be proven about a trajectory.

";

pub fn describe(text: &mut String) -> Outcome {
    let Some(mut sheet) = Sheet::read(SHEET) else { return Ok(()) };
    *text += EXPLANATION;
    *text += &format!("{}\n\n", sheet.provenance);
    let mut table = sheet.clone();
    for name in ["hard_spheres", "square_well", "pendulum", "hopper"] {
        let rows = row::read(name)?;
        let named = |row: &Row| cells(&format!("{}; long run", name.replace('_', " ")), row);
        sheet.rows.extend(rows.iter().map(named));
        table.rows.extend(rows.iter().filter(|row| is_power_of_ten(row.events)).map(named));
    }
    table.rows.retain(|cells| cells[1].parse().is_ok_and(is_power_of_ten));
    *text += &format!("{}\n![Errors against the number of events](speed_against_error/length.svg)\n", table.markdown());
    let panel = |title: &str, column: &str, has_walk: bool| Panel {
        title: title.to_owned(),
        x: "events".to_owned(),
        y: format!("{column}; relative; at least 1e-17"),
        series: series(&sheet, column, has_walk),
    };
    let energy = panel("energy", "energy error", true);
    let momentum = panel("momentum", "momentum drift", true);
    draw(SHEET, &[vec![energy, momentum], vec![panel("overlap", "deepest overlap", false)]])
}

fn is_power_of_ten(events: f64) -> bool {
    (events.log10() - events.log10().round()).abs() < 1e-6
}

fn series(sheet: &Sheet, column: &str, has_walk: bool) -> Vec<Series> {
    let of = |run: &String| {
        let points = sheet.with("run", run).points("events", column);
        Series { name: run.clone(), points, has_line: true }
    };
    let mut all: Vec<Series> = sheet.values("run").iter().map(of).collect();
    if has_walk {
        let most = sheet.numbers("events").into_iter().fold(1e3, f64::max);
        let points = [1e3, most].map(|n| (n, f64::EPSILON * n.sqrt())).to_vec();
        all.push(Series { name: "eps sqrt(n): a random walk".to_owned(), points, has_line: true });
    }
    all
}
