//! The verifier and the reference engine share no code with the engine, because they could not check shared code.
//!
//! Both may import the scene. The verifier may also import the states that it is given, and Algorithm 1 with the
//! features of surfaces from the reference engine.

use std::fs;
use std::path::Path;

/// Modules with the names that may be imported from them. An empty list allows all names.
type Allowed = [(&'static str, &'static [&'static str])];

const OF_VERIFIER: &Allowed = &[
    ("Vector", &[]),
    // Algorithm 1, and the features of surfaces (faces, edges and corners).
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
    // The states that the verifier is given, and the errors with which a run stops.
    ("engine", &["Arrest", "Elapsed", "InvariantBroken", "States"]),
    ("engine::event", &[]),
    ("model", &[]),
    ("scene", &[]),
];
/// The reference engine may import the scene and one number conversion. It imports its own parts by `self::` or
/// `super::`, which this test does not count.
const OF_REFERENCE: &Allowed = &[("Vector", &[]), ("base::numbers", &["id"]), ("model", &[])];
/// File of the verifier that replays a run with the engine. Only this file may import everything from the engine.
const REPLAY: &str = "replay.rs";

/// Returns the imports of a file without its unit tests: each path after `crate::`, for example `a::b::c`. A list in
/// braces gives one path per name.
fn taken(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code: String = lines.collect::<Vec<_>>().join(" ").split_whitespace().collect();
    let mut taken = Vec::new();
    for rest in code.split("crate::").skip(1) {
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(rest.len());
        let (path, rest) = rest.split_at(end);
        match rest.strip_prefix('{').and_then(|list| list.split('}').next()) {
            Some(list) if path.ends_with("::") => taken.extend(list.split(',').map(|name| format!("{path}{name}"))),
            _ => taken.push(path.to_owned()),
        }
    }
    taken
}

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

/// Asserts that a module and the files in its folder import only what `allowed` lists. Returns the number of imports.
fn assert_independent(module: &str, allowed: &Allowed) -> usize {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/check");
    let mut files = vec![root.join(module).with_extension("rs")];
    let entries = fs::read_dir(root.join(module)).unwrap().map(|entry| entry.unwrap().path());
    // Unit tests are exempt, because they compare with the engine.
    files.extend(entries.filter(|path| path.is_file() && !path.ends_with("tests.rs")));
    assert!(files.len() > 4);
    let mut all = 0;
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        for path in taken(&fs::read_to_string(&file).unwrap()) {
            all += 1;
            assert!(is_allowed(allowed, &name, &path), "{module}: {name} takes {path}");
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
    let taken = taken(text);
    for allowed in [OF_VERIFIER, OF_REFERENCE] {
        assert!(taken.iter().any(|path| !is_allowed(allowed, "world.rs", path)), "{taken:?}");
        for path in [
            "physics::response::respond",
            "engine::pairs::rules::Rules",
            "engine::schedule::EventQueue",
            "engine::neighbours::Neighbours",
        ] {
            assert!(!is_allowed(allowed, "world.rs", path), "{path}");
        }
    }
    let is_allowed = |file, path| is_allowed(OF_VERIFIER, file, path);
    assert!(!is_allowed("world.rs", "engine::Simulation") && is_allowed("replay.rs", "engine::Simulation"));
    for path in ["physics::overlap::Quartic", "engine::event::Event", "check::verify::Step", "base::sum::Sum"] {
        assert!(!self::is_allowed(OF_REFERENCE, "reference.rs", path), "{path}");
    }
}
