//! The verifier proves correct runs and finds every error.

mod broken_engines;
mod contact_laws;
mod endings;
mod extremes;
mod scenes;
mod sleep;
mod surfaces;
mod tampered_events;

use std::ops::ControlFlow;

use carom::check::verify::{Certificate, EventRange, Fault, Verifier, verify};
use carom::engine::event::Event;
use carom::engine::{Simulation, States, Until};
use carom::model::Scene;

fn prove(scene: Scene, from: u64, events: u64) -> Certificate {
    verify(scene, EventRange { from, events }, &mut |_| ControlFlow::Continue(()))
}

fn config(name: &str) -> Scene {
    Scene::from_file(format!("configs/{name}.toml")).unwrap()
}

fn scene(toml: &str) -> Scene {
    Scene::from_toml(toml, "scene.toml").unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

/// Verifies that no event follows the start of a scene.
fn end_of(scene: &Scene) -> Result<(), Fault> {
    let mut states = States::default();
    Simulation::without_plan(scene.clone()).states(&mut states);
    Verifier::new(scene, &states).unwrap().witness_end()
}

#[derive(Clone)]
struct Recording {
    scene: Scene,
    start: States,
    events: Vec<(Event, States)>,
}

impl Recording {
    fn of(scene: Scene, count: usize) -> Self {
        Self::until(scene, Until::default(), count)
    }

    fn until(scene: Scene, until: Until, count: usize) -> Self {
        let mut simulation = Simulation::without_plan(scene.clone());
        let mut start = States::default();
        simulation.states(&mut start);
        let mut events = Vec::new();
        while events.len() < count {
            // Several grains may fall asleep or wake up at the same time.
            let mut executed = Vec::new();
            let see = |event: &Event| {
                executed.push(*event);
                ControlFlow::Break(())
            };
            simulation.advance_with(until, see).unwrap();
            if executed.is_empty() {
                break;
            }
            let mut states = States::default();
            simulation.states(&mut states);
            events.extend(executed.into_iter().map(|event| (event, states.clone())));
        }
        Self { scene, start, events }
    }

    fn fault(&self) -> Option<(usize, Fault)> {
        let mut verifier = Verifier::new(&self.scene, &self.start).unwrap();
        self.fault_for(&mut verifier)
    }

    /// Returns the first fault of an event, or the fault of the end of the run if all events are right.
    fn fault_or_end(&self) -> Fault {
        let mut verifier = Verifier::new(&self.scene, &self.start).unwrap();
        self.fault_for(&mut verifier).map_or_else(|| verifier.witness_end().unwrap_err(), |(_, fault)| fault)
    }

    fn fault_for(&self, verifier: &mut Verifier) -> Option<(usize, Fault)> {
        let mut faults = self.events.iter().enumerate();
        faults.find_map(|(at, (event, states))| verifier.witness(event, states).err().map(|fault| (at, fault)))
    }
}

const FLUID: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "fcc"
count = 256
packing_fraction = 0.35
temperature = 1.0
[run]
until_events = 100000
"#;

const WELL: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[fill]]
species = "A"
arrangement = "fcc"
count = 256
packing_fraction = 0.15
temperature = 1.5
[run]
until_events = 100000
"#;
