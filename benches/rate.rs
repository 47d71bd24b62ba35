//! Measures the events per second of one system, for comparison with other programs:
//!
//!     cargo bench --bench rate -- hard_spheres 10976 0.49
//!     cargo bench --bench rate -- square_well 10976 0.8 2.0
//!     cargo bench --bench rate -- configs/hopper.toml
//!     cargo bench --bench rate -- hard_spheres 1000000 0.49 threads=2
//!
//! Prints the events per second, the time from the scene to the first event, and the peak memory per particle. The
//! particles are shuffled, because memory is not in spatial order after a long simulation of a fluid.

use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::scene::{Amount, Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};
use std::error::Error;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Events per particle before the timing, enough to melt a lattice.
const BEFORE: f64 = 30.0;

const TIMED: Duration = Duration::from_secs(4);

/// Freezing packing fraction of hard spheres. Less dense systems start from a lattice that melts.
const FREEZING: f64 = 0.494;

fn spheres(
    potential: Potential,
    count: u64,
    amount: Amount,
    is_fluid: bool,
    temperature: f64,
) -> Result<Scene, Box<dyn Error>> {
    let lattice = if is_fluid { Lattice::BodyCentredCubic } else { Lattice::FaceCentredCubic };
    let scene = SceneBuilder::new("rate")
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("sphere", "sphere"))
        .fill(Fill { amount: Some(amount), ..Fill::new(lattice, "sphere").count(count) })
        .temperature(temperature)
        .build()?;
    let mut random = 1_u64;
    let mut parts = scene.into_parts();
    for last in (1..parts.particles.len()).rev() {
        // Knuth's linear congruential generator.
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        parts.particles.swap(last, (random >> 33) as usize % (last + 1));
    }
    Ok(Scene::new(parts)?)
}

fn system(arguments: &[String]) -> Result<(Scene, f64), Box<dyn Error>> {
    let number =
        |at: usize| -> Result<f64, Box<dyn Error>> { Ok(arguments.get(at).ok_or("a number is missing")?.parse()?) };
    #[expect(clippy::cast_possible_truncation, reason = "no scene has more particles than a u64 counts")]
    let count = || -> Result<u64, Box<dyn Error>> { Ok(number(1)? as u64) };
    match arguments.first().map(String::as_str) {
        Some("hard_spheres") => {
            let (count, packing_fraction) = (count()?, number(2)?);
            let amount = Amount::PackingFraction(packing_fraction);
            let scene = spheres(Potential::hard_sphere(1.0)?, count, amount, packing_fraction < FREEZING, 1.0)?;
            Ok((scene, BEFORE))
        }
        Some("square_well") => {
            let (count, density, temperature) = (count()?, number(2)?, number(3)?);
            let well = Potential::square_well(1.0, 1.5, 1.0)?;
            Ok((spheres(well, count, Amount::NumberDensity(density), true, temperature)?, 4.0 * BEFORE))
        }
        Some(path) if path.ends_with(".toml") => Ok((Scene::from_file(path)?, 4.0 * BEFORE)),
        _ => {
            Err("expected `hard_spheres N PACKING_FRACTION`, `square_well N DENSITY TEMPERATURE` or a scene file"
                .into())
        }
    }
}

fn measure(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let (scene, before) = system(arguments)?;
    let threads = arguments.iter().find_map(|argument| argument.strip_prefix("threads="));
    let threads = threads.map_or(Ok(1), str::parse)?;
    let particles = scene.particles().len() as f64;
    let start = Instant::now();
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::events(1))?;
    simulation.set_threads(threads);
    let start = start.elapsed().as_secs_f64();
    #[expect(clippy::cast_possible_truncation, reason = "some thousands of events per particle")]
    let before = (before * particles) as u64;
    simulation.advance(Until::events(before))?;
    // Time in which at least a million events are expected. Short advances would be slow, because several threads
    // return the state to a single engine after each advance.
    let chunk = simulation.time() / before as f64 * (8.0 * particles).max(1e6);
    let (first, begin) = (simulation.event_counts().physical(), Instant::now());
    while begin.elapsed() < TIMED {
        simulation.advance(Until::time(simulation.time() + chunk))?;
    }
    if let Some(work) = simulation.thread_work() {
        println!("{work}");
    }
    let rate = (simulation.event_counts().physical() - first) as f64 / begin.elapsed().as_secs_f64();
    let memory = peak_memory().map_or("unknown".to_owned(), |bytes| format!("{:.0}", bytes / particles));
    println!(
        "{}: {rate:.0} events per second, first event after {start:.2} s, {memory} bytes per particle, deepest overlap {:.1e}, {}",
        arguments.join(" "),
        simulation.event_counts().deepest_overlap,
        simulation.engine(),
    );
    Ok(())
}

/// Peak memory of this process `[byte]`, if known.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(1024.0 * line.split_whitespace().nth(1)?.parse::<f64>().ok()?)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match measure(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
