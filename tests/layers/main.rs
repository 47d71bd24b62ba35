//! No module imports from a layer above its own. `docs/architecture.md` shows the layers.

mod checks;
mod imports;

use imports::Visitor;
use std::fs;
use std::path::Path;

/// The layers from the bottom up.
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
/// Names in the root of the crate, and the layers in which they are defined.
const ROOT: [(&str, &str); 7] = [
    ("Vector", "base"),
    ("Potential", "model"),
    ("Scene", "model"),
    ("Event", "engine"),
    ("Simulation", "engine"),
    ("Until", "engine"),
    ("SceneBuilder", "scene"),
];

fn rank(layer: &str) -> Option<usize> {
    LAYERS.iter().position(|known| *known == layer)
}

fn layer(path: &str) -> &str {
    let first = path.split("::").next().unwrap_or_default();
    ROOT.iter().find(|(name, _)| *name == first).map_or(first, |(_, layer)| layer)
}

fn layer_of_file(file: &str) -> Option<&str> {
    match file.split(['/', '.']).next() {
        Some("lib") => None,
        Some("main") => Some("cli"),
        first => first,
    }
}

/// Returns the first path that a file uses from a higher or unknown layer.
fn upwards<'a>(file: &str, paths: impl IntoIterator<Item = &'a String>) -> Option<&'a String> {
    let own = rank(layer_of_file(file)?).unwrap();
    paths.into_iter().find(|path| rank(layer(path)).is_none_or(|other| other > own))
}

#[test]
fn no_import_goes_up() {
    let mut compared = 0;
    let mut found = Vec::new();
    for used in imports::of_sources() {
        compared += used.paths.len();
        found.extend(upwards(&used.file, &used.paths).map(|path| format!("src/{} uses {path}", used.file)));
    }
    assert!(found.is_empty(), "from a layer above: {found:#?}");
    assert!(compared > 5000, "{compared} paths were compared");
}

#[test]
fn every_source_is_in_a_layer() {
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(layer_of_file(&name).is_none_or(|layer| rank(layer).is_some()), "src/{name} is in no layer");
    }
}

#[test]
fn an_import_that_goes_up_is_noticed_in_every_form() {
    let noticed = |text: &str| {
        let module = ["scene", "parse", "surface"].map(str::to_owned).to_vec();
        upwards("scene/parse/surface.rs", &Visitor::of(text, module).paths).cloned()
    };
    for text in [
        "use crate::cli::x;",
        "use crate::{base::text, view::report};",
        "use crate::{scene::{limits, names}, run};",
        "use super::super::super::view::report as page;",
        "use super::{a, super::{b, super::io::c}};",
        "mod inner { use super::super::super::super::view::report; }",
        "use crate::view::*;",
        "fn f() { crate::run::begin() }",
        "fn f(x: &crate::io::Folder) {}",
        "fn f() -> Vec<crate::sweep::Plan> { g::<crate::sweep::Plan>() }",
        "fn f() { assert!(crate::check::verify::holds(1)) }",
        "fn f() { match x { super::super::super::view::A => {} } }",
        "table! { A => [crate::base::B, crate::view::V] }",
        "impl crate::exchange::T for A {}",
        "use crate::unknown::x;",
    ] {
        assert!(noticed(text).is_some(), "{text}");
    }
    for text in [
        "//! use crate::cli::x;\nuse crate::scene::{A, b};\nuse super::{limits, super::names};",
        "mod inner { use super::super::super::view::x; }",
        "use crate::{Vector, engine::Simulation}; use std::{fs, io};",
        "#[cfg(test)]\nmod tests { use crate::view::V; }",
        "#[cfg(test)]\nuse crate::view::V;",
        "table! { #[doc = \"See crate::view::V\"] A => crate::base::B }",
        "const TEXT: &str = \"crate::view::V\"; fn f() { cli::g(); let view = 1; }",
    ] {
        assert_eq!(noticed(text), None, "{text}");
    }
}
