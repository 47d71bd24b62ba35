//! Compares Carom with springs and dashpots, for dissipative contacts with a known solution.

mod column;
mod cooling;
mod heap;
mod spring_dashpot;
mod three_spheres;

use super::Outcome;
use super::clock::Stopwatch;
use super::plot::{Panel, Series, draw};
use super::sheet::Sheet;

pub fn measure() -> Outcome {
    three_spheres::measure()?;
    column::measure()?;
    cooling::measure()?;
    heap::measure()
}

const CAROM: &str = "Carom";
const BASELINE: &str = "spring-dashpot";

#[derive(Debug, Clone, Copy)]
enum Method {
    Carom { contact_time: f64 },
    SpringDashpot { stiffness: f64, steps_per_contact: f64 },
}

const PARAMETER: &str = "k or t_c";

const METHOD_COLUMNS: [&str; 3] = ["method", PARAMETER, "steps per contact"];

impl Method {
    fn cells(self) -> [String; 3] {
        match self {
            Self::Carom { contact_time: 0.0 } => [CAROM.to_owned(), "-".to_owned(), "-".to_owned()],
            Self::Carom { contact_time } => [CAROM.to_owned(), contact_time.to_string(), "-".to_owned()],
            Self::SpringDashpot { stiffness, steps_per_contact } => {
                [BASELINE.to_owned(), format!("{stiffness:e}"), steps_per_contact.to_string()]
            }
        }
    }
}

fn sheet(name: &str, columns: &[&str]) -> Sheet {
    let last = columns.iter().copied();
    Sheet::new(name, &METHOD_COLUMNS.into_iter().chain(last).collect::<Vec<_>>())
}

/// Repeats a run until the total processor time is measurable. Returns the time of one run `[us]` and the last result.
fn timed<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    const SECONDS: f64 = 0.2;
    let stopwatch = Stopwatch::start();
    let mut repeats = 0.0;
    loop {
        let last = run();
        repeats += 1.0;
        let seconds = stopwatch.seconds();
        if seconds > SECONDS {
            return (seconds * 1e6 / repeats, last);
        }
    }
}

const EXPLANATION: &str = "
## Granular

Carom is compared with a plain discrete element method written for this report: linear springs and dashpots along the line of centres,
leapfrog integration, neighbour lists, one thread. Mass and diameter are 1. The dashpot constant follows from the spring constant and the
restitution. The contact of a pair lasts `pi / sqrt(omega^2 - eta^2)`, and the time step is a fraction of this duration (`omega` is the
frequency of the undamped spring, and `eta` its decay rate). Carom has neither a spring constant nor a time step. However, heaps need
Carom's TC model, and the benchmark varies its contact time `t_c`. For the column and the three spheres, the processor times include the
set-up of the run. In the plots, values below 1e-17 are drawn at 1e-17.

";

const LIMITS: &str = "
*What it shows*: to simulate hard grains, springs need small time steps. The error of a spring decreases with its stiffness, and the cost
grows with the square root of the stiffness. An overlap at the start adds energy to a simulation with springs, but not to an event-driven
simulation. In a heap at rest, the advantage is reversed. Lasting contacts do not increase the cost of springs, but an event-driven
simulation repeats each lasting contact after every `t_c`.

*What it does not show*: friction, rotation and cohesion; grains whose softness matters; springs with other force laws (Hertz); the
packing of a real heap. Haff's law is itself an approximation (it neglects correlations between velocities), and differences of less than
twice *+-* are not significant.

";

pub fn describe(text: &mut String) -> Outcome {
    let parts = [three_spheres::SHEET, column::SHEET, cooling::SHEET, heap::SHEET].map(Sheet::read);
    let [Some(three), Some(column), Some(cooling), Some(heap)] = parts else { return Ok(()) };
    *text += EXPLANATION;
    *text += &format!("{}\n", three.provenance);
    let explained = [three_spheres::EXPLANATION, column::EXPLANATION, cooling::EXPLANATION, heap::EXPLANATION];
    for (sheet, explanation) in [&three, &column, &cooling, &heap].into_iter().zip(explained) {
        *text += &format!("\n{explanation}\n\n{}", sheet.markdown());
    }
    *text += LIMITS;
    *text += "![Errors of the granular examples against processor time](speed_against_error/granular.svg)\n";
    let panel = |sheet: &Sheet, title: &str, value: &str, y: &str| Panel {
        title: title.to_owned(),
        x: "processor time per particle and unit time [us]".to_owned(),
        y: y.to_owned(),
        series: series(sheet, value),
    };
    let start =
        |name: &str| panel(&three.with("start", name), name, "position error", "error of a position at t = 10 [sigma]");
    draw(
        "granular",
        &[
            vec![start(three_spheres::VALID), start(three_spheres::OVERLAPPED)],
            vec![
                panel(&cooling, "cooling gas", "error", "relative error of the energy (Haff's law)"),
                panel(&cooling, "cooling gas", "deepest overlap", "deepest overlap [sigma]"),
            ],
            vec![
                panel(&column, "column at rest", "height error", "largest error of a height [sigma]"),
                panel(&column, "column at rest", UNREST, "kinetic energy per particle [m g sigma]"),
            ],
            vec![
                panel(&heap, "heap at rest", "deepest overlap", "deepest overlap [sigma]"),
                panel(&heap, "heap at rest", UNREST, "kinetic energy per particle [m g sigma]"),
            ],
        ],
    )
}

/// Shows how close the grains are to rest.
const UNREST: &str = "kinetic energy per particle";

const COST: &str = "us per particle and time";

/// One curve for Carom, and one for each stiffness of the springs.
fn series(sheet: &Sheet, value: &str) -> Vec<Series> {
    let named = |name: String, rows: Sheet| Series { name, points: rows.points(COST, value), has_line: true };
    let mut all = vec![named(CAROM.to_owned(), sheet.with("method", CAROM))];
    let springs = sheet.with("method", BASELINE);
    let stiffnesses = springs.values(PARAMETER);
    all.extend(stiffnesses.iter().map(|k| named(format!("{BASELINE}; k = {k}"), springs.with(PARAMETER, k))));
    all
}
