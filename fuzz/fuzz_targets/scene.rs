//! Text as a scene: refused with a message or built, and what is small runs for some events that are all proven.
//!
//! A corpus to start from are the scenes of `configs` and of `tests/bad_scenes`.
#![no_main]

use std::ops::ControlFlow;

use carom::model::{Limit, Scene};
use carom::check::verify::{End, Fault, EventRange, Violation, verify};
use libfuzzer_sys::fuzz_target;

/// More particles than this are not run.
const MOST: usize = 64;

fuzz_target!(|text: &str| {
    // A scene may name files; those of the machine are no part of the input.
    if text.contains("path") {
        return;
    }
    let Ok(scene) = Scene::from_toml(text, "fuzz.toml") else { return };
    if scene.particles().len() > MOST || scene.is_driven() {
        return;
    }
    // No longer than it takes the fastest to go a few hundred times through the box.
    let fastest = scene.particles().iter().map(|particle| particle.velocity.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let longest = 100.0 * scene.longest_range() / fastest;
    let planned = scene.run().limit;
    let limit = Limit { time: Some(planned.time.map_or(longest, |time| time.min(longest))), ..planned };
    let Ok(scene) = scene.with_limit(limit) else { return };
    let certificate = verify(scene, EventRange { from: 0, events: 30 }, &mut |_| ControlFlow::Continue(()));
    match certificate.end {
        End::Violated(Violation { fault: Fault::TooFast { .. } | Fault::WithoutDigits { .. }, .. }) => {}
        End::Violated(violation) => panic!("{violation}"),
        _ => {}
    }
});
