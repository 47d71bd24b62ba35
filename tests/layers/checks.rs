//! The verifier and the reference engine check the engine, so they may import only what is listed here.

use super::imports::{Visitor, of_sources};

/// Modules and the names that may be imported from them. An empty list allows all names.
type Allowed = [(&'static str, &'static [&'static str])];

const OF_VERIFIER: &Allowed = &[
    ("Vector", &[]),
    (
        "check::reference",
        &[
            "Across",
            "Barrier",
            "Extents",
            "Feature",
            "Motion",
            "Passage",
            "Polynomial",
            "Touch",
            "features",
            "first_on",
            "next_event",
        ],
    ),
    ("engine", &["Arrest", "Elapsed", "InvariantBroken", "States"]),
    ("engine::event", &[]),
    ("model", &[]),
    ("scene", &[]),
];
const OF_REFERENCE: &Allowed = &[("Vector", &[]), ("base::numbers", &["id"]), ("model", &[])];
/// This file of the verifier replays a run, so it may import all of the engine.
const REPLAY: &str = "check/verify/replay.rs";

fn is_allowed(allowed: &Allowed, file: &str, path: &str) -> bool {
    if file == REPLAY && path.starts_with("engine::") {
        return true;
    }
    // The longest matching module decides, for example `engine::event` before `engine`.
    let rests =
        allowed.iter().filter_map(|(part, names)| path.strip_prefix(part).map(|rest| (part.len(), rest, names)));
    let within =
        rests.filter(|(_, rest, _)| rest.is_empty() || rest.starts_with("::")).max_by_key(|(length, _, _)| *length);
    within.is_some_and(|(_, rest, names)| {
        names.is_empty() || rest.split("::").nth(1).is_some_and(|name| names.contains(&name))
    })
}

/// Asserts that a part of `check` imports only what is allowed. Returns the number of imports.
fn assert_independent(module: &str, allowed: &Allowed) -> usize {
    let own = format!("check::{module}");
    let is_within = |path: &str| path.strip_prefix(&own).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"));
    let [file, folder] = [".rs", "/"].map(|end| format!("check/{module}{end}"));
    let mut all = 0;
    for used in of_sources().iter().filter(|used| used.file == file || used.file.starts_with(&folder)) {
        for path in used.paths.iter().filter(|path| !is_within(path)) {
            all += 1;
            assert!(is_allowed(allowed, &used.file, path), "{} takes {path}", used.file);
        }
    }
    all
}

#[test]
fn the_verifier_shares_no_code_with_the_engine() {
    assert!(assert_independent("verify", OF_VERIFIER) > 30);
}

#[test]
fn the_reference_engine_shares_no_code_with_the_engine() {
    assert!(assert_independent("reference", OF_REFERENCE) > 8);
}

#[test]
fn imports_from_the_engine_are_detected() {
    let text = "use crate::{\n    engine::pairs::rules::Rules,\n    Vector,\n};\nuse crate::engine::{Elapsed,\n    Simulation};";
    let taken = Visitor::of(text, Vec::new()).paths;
    for allowed in [OF_VERIFIER, OF_REFERENCE] {
        assert!(taken.iter().any(|path| !is_allowed(allowed, "check/verify/world.rs", path)), "{taken:?}");
        for path in [
            "physics::response::respond",
            "engine::pairs::rules::Rules",
            "engine::schedule::EventQueue",
            "engine::neighbours::Neighbours",
        ] {
            assert!(!is_allowed(allowed, "check/verify/world.rs", path), "{path}");
        }
    }
    let is_allowed = |file, path| is_allowed(OF_VERIFIER, file, path);
    assert!(!is_allowed("check/verify/world.rs", "engine::Simulation") && is_allowed(REPLAY, "engine::Simulation"));
    for path in ["physics::overlap::Quartic", "engine::event::Event", "check::verify::Step", "base::sum::Sum"] {
        assert!(!self::is_allowed(OF_REFERENCE, "check/reference.rs", path), "{path}");
    }
}
