//! Carom's engine as WebAssembly: the text of a scene goes in, positions and velocities come out, with the bits of the program.
//!
//! The module has no imports. A page writes a scene into [`room`], calls [`start`], then [`advance`] as often as it likes, and reads [`numbers`] after
//! [`look`]. Pointers hold until the next call. One simulation at a time; a page that wants several makes as many instances.

use std::cell::RefCell;

use carom::Scene;
use carom::engine::{Reason, Simulation, Until};
use miette::Diagnostic;

/// What the module keeps between calls.
#[derive(Default)]
struct Page {
    /// Text that the page writes.
    room: Vec<u8>,
    /// JSON of what the last call has to say.
    message: String,
    /// Time, physical events, kinetic and potential energy, then positions and velocities, three numbers of each particle in the order of their ids.
    numbers: Vec<f64>,
    simulation: Option<Simulation>,
}

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

/// Ends of [`advance`].
const BY_EVENTS: u32 = 0;
const BY_TIME: u32 = 1;
const IDLE: u32 = 2;
const FAILED: u32 = 3;

/// Room for a text of so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    PAGE.with_borrow_mut(|page| {
        page.room = vec![0; length];
        page.room.as_mut_ptr()
    })
}

/// Starts the scene whose text is in the room: 1, and a message with the number of particles, their species and radii; or 0, and one with the error, its line
/// and its cure.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> u32 {
    PAGE.with_borrow_mut(|page| {
        page.simulation = None;
        match begun(&page.room) {
            Ok((simulation, message)) => {
                page.simulation = Some(simulation);
                page.message = message.to_string();
                1
            }
            Err(message) => {
                page.message = message.to_string();
                0
            }
        }
    })
}

/// A simulation of a scene, and what there is in it; the error is what is wrong, where, and what helps.
fn begun(text: &[u8]) -> Result<(Simulation, serde_json::Value), serde_json::Value> {
    let text = str::from_utf8(text).map_err(|error| serde_json::json!({ "error": error.to_string() }))?;
    let scene = Scene::from_toml(text, "scene.toml").map_err(|error| {
        let help = error.help().map(|help| help.to_string());
        serde_json::json!({ "error": error.to_string(), "line": error.line(), "help": help })
    })?;
    let species = scene.species().iter().map(|species| {
        serde_json::json!({ "name": species.name, "diameter": species.diameter, "isStatic": species.is_static() })
    });
    let particles: Vec<u32> = scene.particles().iter().map(|particle| particle.species.0).collect();
    let message = serde_json::json!({
        "name": scene.name(),
        "species": species.collect::<Vec<_>>(),
        "particles": particles,
        "lower": scene.space().lower.as_slice(),
        "size": scene.space().size.as_slice(),
    });
    let simulation =
        Simulation::new(scene).map_err(|error| serde_json::json!({ "error": error.to_string(), "isPlanned": true }))?;
    Ok((simulation, message))
}

/// Runs for a number of physical events more, or until a simulated time, and says which came first: 0 the events, 1 the time, 2 nothing happens any more,
/// 3 the dynamics cannot go on, which the message explains.
#[unsafe(no_mangle)]
pub extern "C" fn advance(events: f64, time: f64) -> u32 {
    PAGE.with_borrow_mut(|page| {
        let Some(simulation) = &mut page.simulation else {
            page.message = serde_json::json!({ "error": "there is no simulation" }).to_string();
            return FAILED;
        };
        // Saturates at what nobody reaches.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
        let events = simulation.event_counts().physical().saturating_add(events as u64);
        match simulation.advance(Until { time, events }) {
            Ok(Reason::Events) => BY_EVENTS,
            Ok(Reason::Idle) => IDLE,
            Ok(_) => BY_TIME,
            Err(error) => {
                page.message = serde_json::json!({ "error": error.to_string() }).to_string();
                FAILED
            }
        }
    })
}

/// Puts the state into the numbers; how many there are.
#[unsafe(no_mangle)]
pub extern "C" fn look() -> usize {
    PAGE.with_borrow_mut(|page| {
        page.numbers.clear();
        if let Some(simulation) = &page.simulation {
            let (snapshot, energy) = (simulation.snapshot(), simulation.energy());
            let events = simulation.event_counts().physical() as f64;
            page.numbers.extend([snapshot.time, events, energy.kinetic, energy.potential]);
            let vectors = snapshot.positions.iter().chain(&snapshot.velocities);
            page.numbers.extend(vectors.flat_map(|vector| vector.iter().copied()));
        }
        page.numbers.len()
    })
}

/// Where the numbers are that [`look`] has put there.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    PAGE.with_borrow(|page| page.numbers.as_ptr())
}

/// Where the message of the last call is, UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn message() -> *const u8 {
    PAGE.with_borrow(|page| page.message.as_ptr())
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn message_length() -> usize {
    PAGE.with_borrow(|page| page.message.len())
}
