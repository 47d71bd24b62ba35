//! Runs a random scene and audits it. The audit of a valid run must pass.

use std::ops::ControlFlow;

use carom::model::Scene;
use carom::run::{Ending, run};

/// Number of checks after which a run is stopped.
const PATIENCE: u32 = 2_000;

#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// The scene is invalid, for this reason.
    Refused(String),
    /// The audit passed after this number of events.
    Sound(u64),
    Condemned(String),
}

pub fn judge(text: &str) -> Verdict {
    let scene = match Scene::from_toml(text, "random.toml") {
        Ok(scene) => scene,
        Err(refused) => return Verdict::Refused(refused.to_string()),
    };
    let mut asked = 0;
    let finished = run(scene, &mut (), &mut |_| {
        asked += 1;
        if asked > PATIENCE { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let Ok(finished) = finished;
    let faults: Vec<String> = finished.audit.faults().iter().map(ToString::to_string).collect();
    match finished.ending {
        Ending::Broken(broken) => Verdict::Condemned(broken.to_string()),
        _ if faults.is_empty() => Verdict::Sound(finished.simulation.event_counts().physical()),
        _ => Verdict::Condemned(faults.join("; ")),
    }
}
