//! Fuzzes the scene reader. Small valid scenes without external driving then run for up to 30 verified events.
//!
//! The scenes in `configs` and the output of `tests/bad_scenes/scenes.py` are a good initial corpus.
#![no_main]

use std::ops::ControlFlow;

use carom::model::{Scene, Until};
use carom::check::verify::{End, Fault, EventRange, Violation, verify};
use libfuzzer_sys::fuzz_target;

const MOST: usize = 64;

fuzz_target!(|text: &str| {
    // Skips scenes that name files, because files are not part of the input.
    if text.contains("path") {
        return;
    }
    let Ok(scene) = Scene::from_toml(text, "fuzz.toml") else { return };
    if scene.particles().len() > MOST || scene.is_driven() {
        return;
    }
    // Limits the run to the time in which the fastest particle travels 100 times the longest interaction range.
    let fastest = scene.particles().iter().map(|particle| particle.velocity.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let longest = 100.0 * scene.longest_range() / fastest;
    let planned = scene.run().limit;
    let limit = Until { time: Some(planned.time.map_or(longest, |time| time.min(longest))), ..planned };
    let Ok(scene) = scene.with_limit(limit) else { return };
    let certificate = verify(scene, EventRange { from: 0, events: 30 }, &mut |_| ControlFlow::Continue(()));
    match certificate.end {
        End::Violated(Violation { fault: Fault::TooFast { .. } | Fault::WithoutDigits { .. }, .. }) => {}
        End::Violated(violation) => panic!("{violation}"),
        _ => {}
    }
});
