//! Measures the speed of two threads relative to one, and estimates the speed of more cores.
//!
//!     cargo bench --bench cores                          all systems, about an hour; writes benches/results/cores.md and cores.svg
//!     cargo bench --bench cores -- 100000 0.49           a number of spheres at a packing fraction, for a quick look
//!     cargo bench --bench cores -- 100000 wells more     `wells` or `mixture`; `more` estimates 2 to 64 cores, too
//!
//! The control are two independent systems of half the size, side by side. Their rates together are the most that two
//! threads can reach on the machine.
//!
//! The domains of more cores run one after the other on one thread. The estimate uses the time of the slowest domain.
//! The time for comparison and exchange is divided by the number of domains. Contention for memory is ignored.

mod plot;

use carom::engine::{DomainWork, Simulation, ThreadWork, Until};
use carom::model::{Potential, Scene, Space};
use carom::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::error::Error;
use std::fmt::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// Events per particle before the timing, enough to melt a lattice.
const BEFORE: f64 = 25.0;

/// Minimum numbers of timed events: per particle, and in total.
const TIMED: f64 = 6.0;
const LEAST: f64 = 4e6;

/// Number of repeats.
const TURNS: usize = 3;

/// Freezing packing fraction of hard spheres. At lower values, the particles start from a lattice that melts.
const FREEZING: f64 = 0.494;

const HEAD: &str = "\
# One system on several cores

This page gives the measured speed of two threads, from alternating runs, and an estimate for more cores. Two independent systems of half the
size, side by side, are the control: their rates together are the most that two threads can reach on the machine. [One system
on several cores and machines](../../docs/parallel.md#speed-on-many-cores) explains the numbers. Made by

    cargo bench --bench cores

If there were more domains than cores, one thread simulated the domains one after the other. In this case, the time of a window is the time of its
slowest domain, and the time for comparison and exchange is divided by the number of domains. The estimate neglects that several cores
compete for memory bandwidth. The ratios compare runs that were made side by side. The rates depend on the machine. Documents that quote
rates name the machine.

![Speed against the number of cores](cores.svg)

";

struct System {
    name: String,
    count: u64,
    scene: Box<dyn Fn(u64) -> Outcome<Scene>>,
    domains: &'static [usize],
}

impl System {
    fn new(name: &str, count: u64, domains: &'static [usize], scene: impl Fn(u64) -> Outcome<Scene> + 'static) -> Self {
        Self { name: name.to_owned(), count, scene: Box::new(scene), domains }
    }
}

struct Row {
    name: String,
    /// For each repeat: events per second with one thread, with two threads, and of two independent halves side by side.
    turns: Vec<[f64; 3]>,
    work: ThreadWork,
    cores: Vec<Estimate>,
}

/// Speed on a number of cores, relative to one thread.
pub struct Estimate {
    cores: usize,
    speedup: f64,
    /// Number of all steps, divided by the number of steps of original particles. Copies make further steps.
    steps: f64,
    /// Mean time of the domains, divided by the time of the slowest domain.
    balance: f64,
    /// Time outside of the steps, divided by the time of the slowest domain.
    others: f64,
}

fn spheres(count: u64, phi: f64) -> Outcome<Scene> {
    let lattice = if phi < FREEZING { Lattice::BodyCentredCubic } else { Lattice::FaceCentredCubic };
    let scene = SceneBuilder::new("spheres")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(lattice, "A").count(count).packing_fraction(phi))
        .temperature(1.0);
    Ok(scene.build()?)
}

fn wells(count: u64) -> Outcome<Scene> {
    let scene = SceneBuilder::new("wells")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0)?).between("A", "A"))
        .fill(Fill::new(Lattice::BodyCentredCubic, "A").count(count).number_density(0.5))
        .temperature(2.0);
    Ok(scene.build()?)
}

fn mixture(count: u64) -> Outcome<Scene> {
    let hard = || Potential::hard_sphere(1.0);
    let scene = SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.3).diameter(0.6))
        .interaction(InteractionDraft::new(hard()?).between("A", "A"))
        .interaction(InteractionDraft::new(hard()?).between("A", "B").restitution(0.8))
        .interaction(InteractionDraft::new(hard()?).between("B", "B").restitution(0.6))
        .space(Space::periodic_cube((count as f64 / 0.5).cbrt()))
        .fill(Fill::new(Arrangement::Random, "A").count(count / 2))
        .fill(Fill::new(Arrangement::Random, "B").count(count / 2))
        .temperature(1.0);
    Ok(scene.build()?)
}

const SYSTEMS: &str = "a packing fraction, `wells` or `mixture`";

fn unknown(argument: &str, expected: &str) -> Box<dyn Error> {
    format!("unknown argument `{argument}`: expected {expected}").into()
}

fn systems(arguments: &[String]) -> Outcome<Vec<System>> {
    const MANY: u64 = 1_000_000;
    const FEWER: u64 = 100_000;
    const CORES: &[usize] = &[2, 4, 8, 16, 64];
    let of_spheres = |count, phi: f64, domains| {
        System::new(&format!("hard spheres, {phi:.2}"), count, domains, move |count| spheres(count, phi))
    };
    let chosen = match arguments {
        [] => {
            let dense = [(0.10, CORES), (0.30, &[]), (0.49, CORES), (0.54, &[])];
            let dense = dense.map(|(phi, domains)| of_spheres(MANY, phi, domains));
            let others = [
                System::new("square wells, density 0.5", MANY, &[], wells),
                of_spheres(FEWER, 0.49, &[]),
                System::new("two sizes, dissipative", FEWER, &[], mixture),
            ];
            dense.into_iter().chain(others).collect()
        }
        [count, rest @ ..] => {
            let count = count.parse().map_err(|_| unknown(count, "a number of particles"))?;
            let Some((system, rest)) = rest.split_first() else {
                return Err(format!("expected {SYSTEMS} after the number of particles").into());
            };
            let domains = match rest {
                [] => &[],
                [more] if more == "more" => CORES,
                [more] => return Err(unknown(more, "`more` or nothing")),
                [_, further, ..] => return Err(unknown(further, "at most three arguments")),
            };
            vec![match (system.as_str(), system.parse()) {
                ("wells", _) => System::new("square wells, density 0.5", count, domains, wells),
                ("mixture", _) => System::new("two sizes, dissipative", count, domains, mixture),
                (_, Ok(phi)) => of_spheres(count, phi, domains),
                _ => return Err(unknown(system, SYSTEMS)),
            }]
        }
    };
    Ok(chosen)
}

/// Runs about `per_particle` events per particle. Returns the events per second of wall time. `before` is the earlier
/// number of events per particle and unit of simulated time.
fn rate(simulation: &mut Simulation, per_particle: f64, before: f64) -> Outcome<f64> {
    let (first, begin) = (simulation.event_counts().physical(), Instant::now());
    // Stops at a given time, because a limit on the number of events makes the last window run on a single engine.
    simulation.advance(Until::time(simulation.time() + per_particle / before))?;
    Ok((simulation.event_counts().physical() - first) as f64 / begin.elapsed().as_secs_f64())
}

/// A system in its steady state, and its number of events per particle and unit of simulated time.
struct Prepared {
    simulation: Simulation,
    density: f64,
    timed: f64,
}

impl Prepared {
    fn new(scene: Scene) -> Outcome<Self> {
        let particles = scene.particles().len() as f64;
        let mut simulation = Simulation::without_plan(scene);
        simulation.set_threads(2);
        #[expect(clippy::cast_possible_truncation, reason = "some events per particle")]
        let [half, before] = [0.5 * BEFORE, BEFORE].map(|part| (part * particles) as u64);
        simulation.advance(Until::events(half))?;
        let start = simulation.time();
        simulation.advance(Until::events(before))?;
        simulation.set_threads(1);
        let density = 0.5 * BEFORE / (simulation.time() - start);
        Ok(Self { simulation, density, timed: TIMED.max(LEAST / particles) })
    }

    fn on_threads(&self, threads: usize) -> Outcome<Simulation> {
        self.with(|simulation| simulation.set_threads(threads))
    }

    fn with(&self, change: impl FnOnce(&mut Simulation)) -> Outcome<Simulation> {
        let mut simulation = self.simulation.clone();
        change(&mut simulation);
        simulation.advance(Until::time(simulation.time() + 0.1 / self.density))?;
        Ok(simulation)
    }

    fn rate(&self, simulation: &mut Simulation) -> Outcome<f64> {
        rate(simulation, self.timed, self.density)
    }

    /// Returns the sum of the rates of two copies that run side by side.
    fn rate_of_two(&self) -> Outcome<f64> {
        let run = || {
            let mut simulation = self.on_threads(1).map_err(|error| error.to_string())?;
            self.rate(&mut simulation).map_err(|error| error.to_string())
        };
        std::thread::scope(|scope| {
            let two = [scope.spawn(run), scope.spawn(run)];
            let rates = two.map(|thread| thread.join().unwrap_or_else(|_| Err("a thread has panicked".to_owned())));
            rates.into_iter().sum::<Result<f64, String>>().map_err(Into::into)
        })
    }
}

fn measure(system: &System) -> Outcome<Row> {
    let [whole, half] = [system.count, system.count / 2].map(|count| Prepared::new((system.scene)(count)?));
    let (whole, half) = (whole?, half?);
    let name = format!("{} {}", system.count, system.name);
    let mut row = Row { name, turns: Vec::new(), work: ThreadWork::default(), cores: Vec::new() };
    for _ in 0..TURNS {
        let one = whole.rate(&mut whole.on_threads(1)?)?;
        let mut simulation = whole.on_threads(2)?;
        let two = whole.rate(&mut simulation)?;
        row.work = simulation.thread_work().ok_or("one thread did all work")?;
        row.turns.push([one, two, half.rate_of_two()?]);
    }
    for &domains in system.domains {
        let one = whole.rate(&mut whole.on_threads(1)?)?;
        let mut simulation = whole.with(|simulation| simulation.set_domains(domains, 1))?;
        let before = simulation.domain_work().unwrap_or_default();
        let first = simulation.event_counts().physical();
        whole.rate(&mut simulation)?;
        let events = (simulation.event_counts().physical() - first) as f64;
        row.cores.push(estimate(domains, one, events, before, simulation.domain_work().unwrap_or_default()));
    }
    Ok(row)
}

/// Estimates the speed on several cores from domains that ran one after the other.
fn estimate(cores: usize, one: f64, events: f64, before: DomainWork, after: DomainWork) -> Estimate {
    let since = |of: fn(&DomainWork) -> Duration| (of(&after) - of(&before)).as_secs_f64();
    let slowest = since(|work| work.slowest);
    let others = since(|work| work.comparing + work.exchanging + work.moving) / cores as f64;
    let [own, all] = [0, 1].map(|k| (after.steps[k] - before.steps[k]) as f64);
    Estimate {
        cores,
        speedup: events / (slowest + others) / one,
        steps: all / own,
        balance: since(|work| work.simulating) / (cores as f64 * slowest),
        others: others / slowest,
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn report(rows: &[Row]) -> Outcome<String> {
    let mut text = String::from(
        "| system | one thread, 1000 events/s | two threads | two halves side by side | two threads / one | halves / one | two threads / halves, each turn | steps near faces | windows repeated |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for Row { name, turns, work, .. } in rows {
        let of = |k: usize| median(turns.iter().map(|turn| turn[k]).collect());
        let over = |k: usize, l: usize| turns.iter().map(|turn| turn[k] / turn[l]).collect::<Vec<f64>>();
        let ratios: Vec<String> = over(1, 2).iter().map(|ratio| format!("{ratio:.2}")).collect();
        let [deep, near, alone] = work.steps.map(|steps| steps as f64);
        let repeated = work.conflicts as f64 / work.windows as f64;
        writeln!(
            text,
            "| {name} | {:.0} | {:.0} | {:.0} | {:.2} | {:.2} | {} | {:.1} % | {:.2} % |",
            of(0) / 1e3,
            of(1) / 1e3,
            of(2) / 1e3,
            median(over(1, 0)),
            median(over(2, 0)),
            ratios.join(", "),
            100.0 * near / (deep + near + alone),
            100.0 * repeated
        )?;
    }
    text.push_str("\n| system | cores | speed relative to one thread | steps per necessary step | mean domain / slowest domain | comparison and exchange / slowest domain |\n|---|---|---|---|---|---|\n");
    for Row { name, cores, .. } in rows {
        for Estimate { cores, speedup, steps, balance, others } in cores {
            writeln!(
                text,
                "| {name} | {cores} | {speedup:.2} | {steps:.2} | {balance:.2} | {:.1} % |",
                100.0 * others
            )?;
        }
    }
    Ok(text)
}

fn execute(arguments: &[String]) -> Outcome {
    let mut rows = Vec::new();
    for system in &systems(arguments)? {
        rows.push(measure(system)?);
        let row = &rows[rows.len() - 1];
        println!("{}\n{}\n", report(std::slice::from_ref(row))?, row.work);
    }
    if arguments.is_empty() {
        std::fs::write("benches/results/cores.md", format!("{HEAD}{}", report(&rows)?))?;
        let cores = rows.iter().filter(|row| !row.cores.is_empty()).map(|row| (row.name.as_str(), &row.cores[..]));
        plot::draw("benches/results/cores.svg", &cores.collect::<Vec<_>>())?;
    }
    Ok(())
}

fn main() -> ExitCode {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match execute(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
