use std::path::PathBuf;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use crate::base::text::{clock, size};
use crate::engine::{Reason, Simulation, Until};
use crate::exchange::ExchangeFolder;
use crate::io::estimate::{SizeEstimate, allowance, free_disk};
use crate::model::Scene;
use crate::run::{self, NoRate};
use crate::view::{describe, description};
use clap::Args;

use super::SceneArgs;
use super::failure::Failure;

/// Describes the simulation in words and reports mistakes in the scene
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  carom check hopper.toml --set mesh.funnel.spacing=2.5")]
pub struct Check {
    #[command(flatten)]
    scene: SceneArgs,
}

impl Check {
    pub fn execute(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let per_second = per_second(&scene);
        let rate = run::foreseen_rate(&scene);
        let estimate = of_replicas(&scene, SizeEstimate::of(&scene, rate.ok()));
        let mut warnings = description::warnings(&scene);
        let mut text = description::text(&scene);
        let (meshes, faults) = describe::meshes(&scene);
        for (index, mesh) in meshes.iter().enumerate() {
            text.push_str(&description::line(if index == 0 { "looked at" } else { "" }, mesh));
        }
        warnings.extend(faults);
        text.push_str(&needs(&estimate, per_second, rate.err()));
        let folder = PathBuf::from("runs").join(scene.name());
        warnings.extend(too_much(&estimate, free_disk(&folder)));
        for warning in &warnings {
            text.push_str(&format!("warning: {warning}\n"));
        }
        text.push_str(if warnings.is_empty() {
            "The scene is valid.\n"
        } else {
            "The scene is valid, with the warnings above.\n"
        });
        super::print_report(&text)
    }
}

/// Measures the event rate in a short trial. Returns `None` if the trial is too slow or has too few events.
fn per_second(scene: &Scene) -> Option<f64> {
    let (sender, receiver) = mpsc::channel();
    let scene = scene.clone();
    // If the trial takes too long, its thread ends with the program.
    std::thread::spawn(move || {
        let mut simulation = Simulation::without_plan(scene);
        let begun = Instant::now();
        while begun.elapsed() < TRY {
            let until = Until::events(simulation.event_counts().physical() + 1000);
            if !matches!(simulation.advance(until), Ok(Reason::Events)) {
                break;
            }
        }
        let events = simulation.event_counts().physical() as f64;
        // If the trial took too long, the receiver is gone.
        let _ = sender.send((events >= 10.0).then_some(events / begun.elapsed().as_secs_f64()));
    });
    receiver.recv_timeout(PATIENCE).ok().flatten()
}

const TRY: Duration = Duration::from_millis(200);
const PATIENCE: Duration = Duration::from_secs(2);

/// Returns two lines of the report: the output of the run, and its memory, events and wall time.
fn needs(estimate: &SizeEstimate, per_second: Option<f64>, no_rate: Option<NoRate>) -> String {
    let count = |count: Option<f64>, noun| match count {
        Some(1.0) => format!("1 {noun}"),
        Some(count) => format!("{} {noun}s", about(count)),
        None => format!("an unknown number of {noun}s"),
    };
    let least = if estimate.is_complete { "some" } else { "at least" };
    let rows = format!("{} and {}", count(estimate.rows, "row"), count(estimate.frames, "frame"));
    let few = estimate.frames_limit.map_or_else(String::new, |reason| format!(" ({reason})"));
    let mut work = match (estimate.events, no_rate) {
        (Some(_), _) => count(estimate.events, "event"),
        (None, Some(why)) => format!("number of events: cannot be estimated ({why})"),
        (None, None) => "number of events: cannot be estimated".to_owned(),
    };
    if let (Some(events), Some(per_second)) = (estimate.events, per_second) {
        work.push_str(&format!(
            ", about {} on this computer at the rate of the first events",
            clock(events / per_second)
        ));
    }
    let (bytes, memory) = (size(estimate.bytes), size(estimate.memory));
    description::line("writes", &format!("{rows}{few}, {least} {bytes}"))
        + &description::line("needs", &format!("some {memory} of memory; {work}"))
}

fn of_replicas(scene: &Scene, run: SizeEstimate) -> SizeEstimate {
    let Some(plan) = scene.exchange() else { return run };
    let (replicas, time) = (plan.replicas() as f64, scene.run().limit.time.unwrap_or(0.0));
    let frames = ExchangeFolder::expected_frames(scene);
    SizeEstimate {
        rows: Some((time / plan.interval).round()),
        frames: Some(frames),
        frames_limit: ExchangeFolder::frames_limit(scene),
        events: run.events.map(|events| replicas * events),
        memory: replicas * run.memory,
        bytes: ExchangeFolder::expected_bytes(scene),
        ..run
    }
}

fn about(count: f64) -> String {
    if count < 1e4 { format!("{count:.0}") } else { format!("{count:.1e}") }
}

fn too_much(estimate: &SizeEstimate, free: Option<f64>) -> Option<String> {
    let most = allowance(free);
    (estimate.bytes > most).then(|| {
        let (bytes, most) = (size(estimate.bytes), size(most));
        format!(
            "a run would write about {bytes}; more than {most} requires --force: choose longer intervals in [output]"
        )
    })
}
