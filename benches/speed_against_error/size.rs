//! Time per event and memory against the number of particles. Each size runs in its own process.

use super::Outcome;
use super::clock::Stopwatch;
use super::oracle::random::Random;
use super::plot::{Panel, Series, draw};
use super::sheet::{Sheet, number};
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::fs;
use std::process::Command;

const SHEET: &str = "size";

/// First argument of the child processes. Each child measures one size.
pub const CHILD: &str = "size-of-one";

/// Numbers of particles that fill a cube of the face-centred cubic lattice.
const SIZES: [u64; 5] = [1_372, 10_976, 108_000, 1_000_188, 10_061_824];

const PACKING_FRACTIONS: [f64; 2] = [0.49, 0.10];

/// Maximum number of events before the timing. In small systems, the timing starts after 20 events per particle.
const MOST_EVENTS_BEFORE: u64 = 1_500_000;

const TIMED_EVENTS: u64 = 300_000;

/// Required free memory `[byte / particle]`.
const ROOM: u64 = 700;

pub fn measure() -> Outcome {
    let mut sheet = Sheet::new(
        SHEET,
        &[
            "packing fraction",
            "N",
            "contacts per particle before",
            "ns per event",
            "events per second",
            "start-up [s]",
            "peak memory [MB]",
            "bytes per particle",
        ],
    );
    for packing_fraction in PACKING_FRACTIONS {
        for size in SIZES {
            if available_memory().is_some_and(|bytes| bytes < ROOM * size) {
                println!("{SHEET}: too little free memory for N = {size}");
                continue;
            }
            let mut child = Command::new(std::env::current_exe()?);
            let output = child.args([CHILD.to_owned(), size.to_string(), packing_fraction.to_string()]).output()?;
            if !output.status.success() {
                println!("{SHEET}: N = {size} ended with {}", output.status);
                continue;
            }
            let text = String::from_utf8(output.stdout)?;
            sheet.push(text.trim().split(',').map(str::to_owned).collect())?;
        }
    }
    Ok(())
}

pub fn measure_one(arguments: &[String]) -> Outcome {
    let [size, packing_fraction] = arguments else { return Err("expected a size and a packing fraction".into()) };
    let (size, packing_fraction): (u64, f64) = (size.parse()?, packing_fraction.parse()?);
    let stopwatch = Stopwatch::start();
    let scene = SceneBuilder::new("size")
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(size).packing_fraction(packing_fraction))
        .temperature(1.0)
        .build()?;
    let placed = stopwatch.seconds();
    // Shuffles the particles, because memory is not in spatial order after a long simulation of a fluid.
    let mut random = Random::new(size);
    let mut parts = scene.into_parts();
    for last in (1..parts.particles.len()).rev() {
        parts.particles.swap(last, random.below(last + 1));
    }
    let scene = Scene::new(parts)?;
    let stopwatch = Stopwatch::start();
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::events(1))?;
    let start_up = placed + stopwatch.seconds();
    let before = (20 * size).min(MOST_EVENTS_BEFORE);
    simulation.advance(Until::events(before))?;
    let stopwatch = Stopwatch::start();
    simulation.advance(Until::events(before + TIMED_EVENTS))?;
    let seconds = stopwatch.seconds() / TIMED_EVENTS as f64;
    let peak = peak_memory().unwrap_or(f64::NAN);
    let contacts = 2.0 * before as f64 / size as f64;
    let measured = [contacts, seconds * 1e9, seconds.recip(), start_up, peak / 1e6, peak / size as f64];
    println!("{packing_fraction},{size},{}", measured.map(number).join(","));
    Ok(())
}

fn peak_memory() -> Option<f64> {
    Some(kibibytes("/proc/self/status", "VmHWM:")? as f64 * 1024.0)
}

fn available_memory() -> Option<u64> {
    Some(kibibytes("/proc/meminfo", "MemAvailable:")? * 1024)
}

fn kibibytes(path: &str, key: &str) -> Option<u64> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

const EXPLANATION: &str = "
## Size

Hard spheres start from the face-centred cubic lattice and are numbered in random order. Each row is measured in a separate process.
*Start-up* is the processor time from the scene to the first event. *Memory* is the peak memory of the process, including the scene and the
program. In small systems, the program itself takes a large part of this memory.

*What it shows*: how the time per event grows with the number of particles, at the density of a liquid and at the density of a gas, and how
much memory a particle takes. The time grows because memory access becomes slower. The work per event stays the same.

*What it does not show*: other potentials; long runs of the largest systems, whose lattice has hardly begun to melt (see the column of
contacts before the measurement); very long runs, in which particles that are close in memory are no longer close in space.

";

pub fn describe(text: &mut String) -> Outcome {
    let Some(sheet) = Sheet::read(SHEET) else { return Ok(()) };
    *text += EXPLANATION;
    *text += &format!("{}\n\n{}\n", sheet.provenance, sheet.markdown());
    *text += "![Time per event and memory against the number of particles](speed_against_error/size.svg)\n";
    let panel = |column: &str, y: &str| Panel {
        title: y.to_owned(),
        x: "particles".to_owned(),
        y: y.to_owned(),
        series: series(&sheet, column),
    };
    let memory = panel("bytes per particle", "peak memory per particle [byte]");
    draw(SHEET, &[vec![panel("ns per event", "time per event [ns]"), memory]])
}

fn series(sheet: &Sheet, column: &str) -> Vec<Series> {
    let of = |fraction: String| {
        let points = sheet.with("packing fraction", &fraction).points("N", column);
        Series { name: format!("packing fraction {fraction}"), points, has_line: true }
    };
    sheet.values("packing fraction").into_iter().map(of).collect()
}
