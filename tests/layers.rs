//! Checks that no module imports from a higher layer. `docs/architecture.md` shows the layers.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The layers from the bottom up. Each layer uses only the layers before it.
const LAYERS: [&str; 16] = [
    "base",
    "physics",
    "model",
    "mesh",
    "engine",
    "analysis",
    "trajectory",
    "prepare",
    "scene",
    "run",
    "io",
    "exchange",
    "sweep",
    "check",
    "view",
    "cli",
];

/// Collects all Rust files of a folder.
fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            sources(&path, files);
        } else if name.ends_with(".rs") {
            files.push(path);
        }
    }
}

/// The code of a file without comments and without its inline test module.
fn code(text: &str) -> String {
    let end = text.match_indices("#[cfg(test)]").find(|(at, _)| {
        text[*at..].lines().nth(1).is_some_and(|line| line.contains("mod ") && line.trim_end().ends_with('{'))
    });
    let text = end.map_or(text, |(at, _)| &text[..at]);
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Modules that are compiled only for tests, declared by `#[cfg(test)]` and `mod name;`.
fn test_modules(text: &str) -> BTreeSet<String> {
    let lines: Vec<&str> = text.lines().collect();
    let pairs = lines.windows(2).filter(|pair| pair[0].trim() == "#[cfg(test)]");
    let names = pairs.filter_map(|pair| pair[1].trim().strip_suffix(';').and_then(|line| line.rsplit(' ').next()));
    names.map(str::to_owned).collect()
}

/// Paths after `crate::` or `carom::`: the first name and the second name, if there is one.
fn imports(code: &str) -> Vec<(String, Option<String>)> {
    let mut found = Vec::new();
    for root in ["crate::", "carom::"] {
        for (at, _) in code.match_indices(root) {
            if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$' || c == ':') {
                continue;
            }
            let path: String =
                code[at + root.len()..].chars().take_while(|c| c.is_alphanumeric() || *c == '_' || *c == ':').collect();
            let mut parts = path.split("::").filter(|part| !part.is_empty()).map(str::to_owned);
            if let Some(first) = parts.next() {
                found.push((first, parts.next()));
            }
        }
    }
    found
}

/// The imports of each top-level module, including those of its submodules.
fn relations() -> BTreeMap<String, BTreeSet<(String, String)>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let only_for_tests: BTreeSet<PathBuf> = files
        .iter()
        .flat_map(|path| {
            let folder = path.with_extension("");
            let names = test_modules(&fs::read_to_string(path).unwrap());
            names.into_iter().map(move |name| folder.join(name))
        })
        .collect();
    let mut relations: BTreeMap<String, BTreeSet<(String, String)>> = BTreeMap::new();
    for path in files.iter().filter(|path| !only_for_tests.iter().any(|test| path.with_extension("").starts_with(test)))
    {
        let below = path.strip_prefix(&root).unwrap().with_extension("");
        let layer = below.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
        let layer = if layer == "main" { "cli".to_owned() } else { layer };
        for (first, _) in imports(&code(&fs::read_to_string(path).unwrap())) {
            let from = path.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
            relations.entry(layer.clone()).or_default().insert((first, from));
        }
    }
    relations
}

fn rank(layer: &str) -> Option<usize> {
    LAYERS.iter().position(|known| *known == layer)
}

#[test]
fn no_layer_imports_from_a_layer_above() {
    let mut compared = 0;
    for (layer, imports) in relations() {
        let Some(own) = rank(&layer) else { continue };
        for (other, file) in imports {
            let Some(rank) = rank(&other) else { continue };
            compared += 1;
            assert!(rank <= own, "src/{file}: {layer} imports {other}, which is a layer above it");
        }
    }
    assert!(compared > 300, "{compared} imports were compared");
}

#[test]
fn every_source_is_in_a_layer() {
    let outside = ["lib", "main"];
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(rank(&name).is_some() || outside.contains(&name.as_str()), "src/{name} is in no layer");
    }
}

#[test]
fn imports_are_found_outside_comments_and_tests() {
    let text = "//! use crate::cli::x;\nuse crate::scene::{A, b};\nlet x = crate::run::f();\n#[cfg(test)]\nmod tests {\nuse crate::view::V;\n}\n";
    let found: Vec<String> = imports(&code(text)).into_iter().map(|(first, _)| first).collect();
    assert_eq!(found, ["scene", "run"]);
    assert!(rank("scene") < rank("run"));
    assert_eq!(test_modules("#[cfg(test)]\nmod tests;\nmod x;\n").into_iter().collect::<Vec<_>>(), ["tests"]);
}
