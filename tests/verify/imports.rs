//! What the verifier takes from the rest of the program: the scene, what it is shown, and Algorithm 1 as printed. Whatever it shared
//! with the engine it could not check.

use std::fs;
use std::path::Path;

/// Parts of the program, and what may be taken from them; nothing is everything.
const ALLOWED: [(&str, &[&str]); 6] = [
    ("Vector", &[]),
    ("check::reference", &["Polynomial", "next_event"]),
    // The form in which states are shown, and how a run says that it cannot go on.
    ("engine", &["Arrest", "Elapsed", "InvariantBroken", "States"]),
    ("engine::event", &[]),
    ("model", &[]),
    ("scene", &[]),
];
/// Where the run is replayed that is to be proven.
const REPLAY: &str = "replay.rs";

/// Everything after `crate::` in the code of a file, without its unit tests, one name at a time: `a::b::c`.
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

fn is_allowed(file: &str, path: &str) -> bool {
    if file == REPLAY && path.starts_with("engine::") {
        return true;
    }
    // The longest that fits: `engine::event` before `engine`.
    let rests =
        ALLOWED.iter().filter_map(|(part, names)| path.strip_prefix(part).map(|rest| (part.len(), rest, names)));
    let within =
        rests.filter(|(_, rest, _)| rest.is_empty() || rest.starts_with("::")).max_by_key(|(length, _, _)| *length);
    within.is_some_and(|(_, rest, names)| {
        names.is_empty() || rest.split("::").nth(1).is_some_and(|name| names.contains(&name))
    })
}

#[test]
fn the_verifier_shares_no_code_with_the_engine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![root.join("check/verify.rs")];
    files.extend(fs::read_dir(root.join("check/verify")).unwrap().map(|entry| entry.unwrap().path()));
    assert!(files.len() > 10);
    let mut all = 0;
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        for path in taken(&fs::read_to_string(&file).unwrap()) {
            all += 1;
            assert!(is_allowed(&name, &path), "{name} takes {path} from the engine");
        }
    }
    assert!(all > 30);
}

#[test]
fn what_the_engine_uses_would_be_noticed() {
    let text = "use crate::{\n    engine::pairs::rules::Rules,\n    Vector,\n};\nuse crate::engine::{Elapsed,\n    Simulation};";
    let taken = taken(text);
    assert!(taken.iter().any(|path| !is_allowed("world.rs", path)), "{taken:?}");
    for path in [
        "physics::response::respond",
        "engine::pairs::rules::Rules",
        "engine::schedule::EventQueue",
        "engine::neighbours::Neighbours",
    ] {
        assert!(!is_allowed("world.rs", path), "{path}");
    }
    assert!(!is_allowed("world.rs", "engine::Simulation") && is_allowed("replay.rs", "engine::Simulation"));
}
