//! Data of the Python package that are saved with a simulation.

use std::path::PathBuf;
use std::sync::Arc;

use carom::engine::Simulation as Engine;
use carom::model::{Scene as Model, Threads};
use carom::scene::GivenParticles;
use serde::{Deserialize, Serialize};

use crate::given::Given;
use crate::scene::Scene;
use crate::simulation::State;

/// Texts are stored as bytes, so that they can have any length.
#[derive(Serialize, Deserialize)]
pub struct Beside {
    model: Model,
    text: Vec<u8>,
    name: Vec<u8>,
    set: Vec<(Vec<u8>, Vec<u8>)>,
    given: Option<GivenParticles>,
    pending: Vec<u8>,
    baths: usize,
}

impl Beside {
    pub fn of(scene: &Scene, state: &State) -> Self {
        // The path becomes absolute, because the simulation may be loaded in another folder.
        let name = std::path::absolute(&scene.name).unwrap_or_else(|_| scene.name.clone());
        Self {
            model: scene.model.clone(),
            text: scene.text.clone().into_bytes(),
            name: name.to_string_lossy().into_owned().into_bytes(),
            set: scene.set.iter().map(|(key, value)| (key.clone().into(), value.clone().into())).collect(),
            given: scene.given.as_ref().map(|given| GivenParticles::clone(&given.0)),
            pending: state.pending.clone(),
            baths: state.baths,
        }
    }
}

/// Returns the saved state and scene. Without `threads`, uses the number of threads in the scene.
pub fn engine_of((mut engine, beside): (Engine, Beside), threads: Option<Threads>) -> (State, Scene) {
    let Beside { model, text, name, set, given, pending, baths } = beside;
    engine.set_threads(threads.unwrap_or(model.run().threads));
    let scene = Scene {
        model,
        text: string(text),
        name: PathBuf::from(string(name)),
        set: set.into_iter().map(|(key, value)| (string(key), string(value))).collect(),
        given: given.map(|given| Given(Arc::new(given))),
    };
    (State { engine, pending, baths }, scene)
}

fn string(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}
