use std::ops::ControlFlow;
use std::path::Path;

use carom::engine::event::{Event, EventKind, Other, Outcome};
use carom::engine::{PairStates, Reason, Until};
use carom::model::ParticleId;
use carom::run::{ChangeError, Ending, Run, Stage};
use carom::scene::SceneError;
use carom::view::live::Shown;
use carom::{Scene, Vector};
use miette::Diagnostic;
use serde_json::{Value, json};

use crate::export;

/// File name of the scene in error messages.
pub const FILE: &str = "scene.toml";

/// Number of values that [`Page::look`] writes before the positions.
const HEADER: usize = 24;

const MOST_UPCOMING: u32 = 1000;

/// Why [`Page::advance`] returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    Events = 0,
    Time = 1,
    Idle = 2,
    Failed = 3,
    Planned = 4,
}

#[derive(Default)]
pub struct Page {
    pub room: Vec<u8>,
    pub message: String,
    /// A header, then positions and velocities. Written by [`Page::look`].
    pub numbers: Vec<f64>,
    /// Periods travelled along x, y and z by each particle.
    pub images: Vec<i32>,
    run: Option<Run>,
    shown: Option<Shown>,
    is_over: bool,
}

impl Page {
    fn request(&self) -> Result<Value, Value> {
        serde_json::from_slice(&self.room).map_err(|error| failure(&error.to_string()))
    }

    pub fn bring(&mut self, name_length: usize) {
        let mut name = std::mem::take(&mut self.room);
        let content = name.split_off(name_length.min(name.len()));
        // Outside WebAssembly, scenes read files from disk.
        #[cfg(target_family = "wasm")]
        carom::scene::bring(Path::new(&*String::from_utf8_lossy(&name)), content);
        #[cfg(not(target_family = "wasm"))]
        drop(content);
    }

    pub fn start(&mut self) -> Result<Value, Value> {
        let request = self.request()?;
        // Memory may suffice for only one simulation, so the old simulation is freed first.
        (self.run, self.shown) = (None, None);
        self.show(Run::new(scene_of(&request)?))
    }

    pub fn check(&mut self) -> Result<Value, Value> {
        scene_of(&self.request()?).map(|_| json!({}))
    }

    pub fn change(&mut self) -> Result<Value, Value> {
        let request = self.request()?;
        let run = self.run.as_ref().ok_or_else(nothing)?;
        let (text, changes) = (text_of(&request), changes_of(&request));
        let changed = run.changed(text, Path::new(FILE), &pairs(&changes)).map_err(|error| match error {
            ChangeError::Scene(error) => mistake(&error),
            other => failure(&other.to_string()),
        })?;
        self.show(changed)
    }

    fn show(&mut self, run: Run) -> Result<Value, Value> {
        let shown = Shown::of(run.simulation());
        let head = serde_json::from_str(&shown.head).map_err(|error| failure(&error.to_string()));
        (self.run, self.shown, self.is_over) = (Some(run), Some(shown), false);
        head
    }

    pub fn set(&mut self) -> Result<Value, Value> {
        let request = self.request()?;
        let simulation = self.run.as_mut().ok_or_else(nothing)?.simulation_mut();
        let id = request["id"].as_u64().and_then(|id| usize::try_from(id).ok());
        let mut snapshot = simulation.snapshot();
        let id = id.filter(|id| *id < snapshot.positions.len()).ok_or_else(|| failure("there is no such particle"))?;
        if let Some(position) = vector(&request["position"]) {
            snapshot.positions[id] = position;
            let set = simulation.set_positions(&snapshot.positions, PairStates::FromDistances);
            set.map_err(|error| failure(&error.to_string()))?;
        }
        if let Some(velocity) = vector(&request["velocity"]) {
            snapshot.velocities[id] = velocity;
            simulation.set_velocities(&snapshot.velocities).map_err(|error| failure(&error.to_string()))?;
        }
        Ok(json!({}))
    }

    pub fn upcoming(&mut self, count: u32) -> Result<Value, Value> {
        let mut ahead = self.run.as_ref().ok_or_else(nothing)?.simulation().clone();
        let mut events = Vec::new();
        let most = count.min(MOST_UPCOMING) as usize;
        let until = Until::events(ahead.event_counts().physical().saturating_add(u64::from(count)));
        let _ = ahead.advance_with(until, |event| {
            events.push(told(event));
            if events.len() < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        Ok(json!(events))
    }

    pub fn scene(&mut self) -> Result<Value, Value> {
        let request = self.request()?;
        let run = self.run.as_ref().ok_or_else(nothing)?;
        let text = export::scene(text_of(&request), run.simulation(), run.stage() == Stage::Measurement);
        text.map(|text| json!({ "text": text })).map_err(|error| failure(&error))
    }

    pub fn poses(&self) -> Value {
        let (Some(run), Some(shown)) = (&self.run, &self.shown) else { return json!([]) };
        json!(shown.poses(run.simulation().time(), &run.simulation().surfaces_present()))
    }

    pub fn advance(&mut self, events: f64, time: f64) -> End {
        let Some(mut run) = self.run.take() else {
            self.message = nothing().to_string();
            return End::Failed;
        };
        // An infinite number of events becomes a number that is never reached.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
        let events = run.simulation().event_counts().physical().saturating_add(events as u64);
        let until = Until::time(time).or_events(events);
        if self.is_over {
            let reason = run.simulation_mut().advance(until);
            self.run = Some(run);
            return match reason {
                Ok(Reason::Events) => End::Events,
                Ok(Reason::Idle) => End::Idle,
                Ok(_) => End::Time,
                Err(error) => self.fail(&error.to_string()),
            };
        }
        let (run, ending) = match run.advance(until, &mut ()) {
            Ok(advanced) => advanced,
            Err(error) => return self.fail(&error.to_string()),
        };
        let is_by_events = run.simulation().event_counts().physical() >= events;
        self.run = Some(run);
        match ending {
            None if is_by_events => End::Events,
            None => End::Time,
            Some(ending) => {
                self.is_over = true;
                self.end(&ending)
            }
        }
    }

    fn end(&mut self, ending: &Ending) -> End {
        match ending {
            Ending::Idle => End::Idle,
            Ending::Arrested(arrest) => self.fail(&arrest.to_string()),
            Ending::Broken(broken) => self.fail(&broken.to_string()),
            Ending::Jammed(jam) => self.fail(&jam.to_string()),
            Ending::GaveUp | Ending::Unsettled => self.fail(&format!("the run {}", ending.word())),
            _ => End::Planned,
        }
    }

    fn fail(&mut self, error: &str) -> End {
        self.message = failure(error).to_string();
        End::Failed
    }

    /// Writes the state and returns the number of values.
    ///
    /// The header contains time, physical events, kinetic and potential energy, collisional virial, index of the stage
    /// in the description, whether the plan is over, displacement of a sheared box, growth factor, acceleration (3),
    /// numbers of events (core, capture, release, bounce, wall, thermostat), energy dissipated and supplied. Positions
    /// and velocities start at index 24, three numbers for each particle.
    pub fn look(&mut self) -> usize {
        self.numbers.clear();
        self.images.clear();
        let Some(run) = &self.run else { return 0 };
        let simulation = run.simulation();
        let (snapshot, energy, counts) = (simulation.snapshot(), simulation.energy(), simulation.event_counts());
        let plan = simulation.scene().run();
        let stage = Stage::simulated(plan).position(|stage| stage == run.stage()).unwrap_or_default();
        let species = simulation.scene().species();
        let acceleration =
            species.iter().find(|species| !species.is_static()).map_or(Vector::zeros(), |species| species.acceleration);
        let (events, stage, is_over) = (counts.physical() as f64, stage as f64, f64::from(u8::from(self.is_over)));
        self.numbers.extend([snapshot.time, events, energy.kinetic, energy.potential, counts.virial.total()]);
        self.numbers.extend([stage, is_over, snapshot.displacement, snapshot.scale]);
        self.numbers.extend(acceleration.iter());
        let kinds = [counts.core, counts.capture, counts.release, counts.bounce, counts.wall, counts.thermostat];
        self.numbers.extend(kinds.map(|count| count as f64));
        self.numbers.extend([counts.dissipated.total(), counts.supplied.total()]);
        self.numbers.resize(HEADER, 0.0);
        let vectors = snapshot.positions.iter().chain(&snapshot.velocities);
        self.numbers.extend(vectors.flat_map(|vector| vector.iter().copied()));
        self.images.extend(snapshot.images.iter().flatten());
        self.numbers.len()
    }
}

fn failure(error: &str) -> Value {
    json!({ "error": error })
}

fn nothing() -> Value {
    failure("there is no simulation")
}

fn mistake(error: &SceneError) -> Value {
    let help = error.help().map(|help| help.to_string());
    let span = error.labels().and_then(|mut labels| labels.next());
    let [offset, length] = span.map_or([None; 2], |span| [Some(span.offset()), Some(span.len())]);
    json!({ "error": error.to_string(), "line": error.line(), "help": help, "offset": offset, "length": length })
}

fn text_of(request: &Value) -> &str {
    request["text"].as_str().unwrap_or_default()
}

/// Reads overrides of the scene, such as `{"fill.0.temperature": "2.5"}`.
fn changes_of(request: &Value) -> Vec<(String, String)> {
    let changes = request["changes"].as_object();
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    changes.map(|changes| changes.iter().map(|(key, value)| (key.clone(), text(value))).collect()).unwrap_or_default()
}

fn pairs(changes: &[(String, String)]) -> Vec<(&str, &str)> {
    changes.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect()
}

fn scene_of(request: &Value) -> Result<Scene, Value> {
    let changes = changes_of(request);
    let scene = Scene::from_toml_with(text_of(request), FILE, &pairs(&changes)).map_err(|error| mistake(&error))?;
    if scene.run().has_barostat() {
        return Err(failure(
            "the scene has a barostat, but the box of a page has a constant size: remove the barostat",
        ));
    }
    if scene.has_flow() {
        return Err(failure(
            "particles enter or leave, but a page shows the same particles at all times: remove the inlets and outlets",
        ));
    }
    Ok(scene)
}

fn vector(value: &Value) -> Option<Vector> {
    let number = |k: usize| value.get(k).and_then(Value::as_f64);
    Some(Vector::new(number(0)?, number(1)?, number(2)?))
}

fn told(event: &Event) -> Value {
    let kind = match event.kind {
        EventKind::Pair(Outcome::Core) => "core",
        EventKind::Pair(Outcome::Capture) => "capture",
        EventKind::Pair(Outcome::Release) => "release",
        EventKind::Pair(_) => "bounce",
        EventKind::Surface => "wall",
        _ => "thermostat",
    };
    let partner = match event.other {
        Other::Particle(ParticleId(id)) => Some(id),
        _ => None,
    };
    let place = event.positions[0];
    json!({ "time": event.time, "kind": kind, "a": event.particle.0, "b": partner, "x": place.x, "y": place.y, "z": place.z })
}
