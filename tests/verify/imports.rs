//! What the verifier takes from the rest of the program: the scene, what it is shown, and Algorithm 1 as printed. Whatever it shared
//! with the engine it could not check.

use std::fs;
use std::path::Path;

/// Parts of the program, and what may be taken from them; nothing is everything.
const ALLOWED: [(&str, &[&str]); 7] = [
    ("Vector", &[]),
    ("event", &[]),
    ("potential", &[]),
    ("reference", &["Polynomial", "next_event"]),
    ("scene", &[]),
    // The form in which states are shown, and how a run says that it cannot go on.
    ("simulation", &["Arrest", "Elapsed", "States"]),
    ("space", &["Boundary", "Face"]),
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
    let mut parts = path.split("::");
    let (module, name) = (parts.next().unwrap_or_default(), parts.next());
    if file == REPLAY && module == "simulation" {
        return true;
    }
    let names = ALLOWED.iter().find(|(allowed, _)| *allowed == module).map(|(_, names)| *names);
    names.is_some_and(|names| names.is_empty() || name.is_some_and(|name| names.contains(&name)))
}

#[test]
fn the_verifier_shares_no_code_with_the_engine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![root.join("verify.rs")];
    files.extend(fs::read_dir(root.join("verify")).unwrap().map(|entry| entry.unwrap().path()));
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
    let text = "use crate::{\n    interaction::rules::Rules,\n    Vector,\n};\nuse crate::simulation::{Elapsed,\n    Simulation};";
    let taken = taken(text);
    assert!(taken.iter().any(|path| !is_allowed("world.rs", path)), "{taken:?}");
    for path in ["response::respond", "interaction::rules::Rules", "queue::EventQueue", "neighbours::Neighbours"] {
        assert!(!is_allowed("world.rs", path), "{path}");
    }
    assert!(!is_allowed("world.rs", "simulation::Simulation") && is_allowed("replay.rs", "simulation::Simulation"));
}
