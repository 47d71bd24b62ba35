//! Checks that the scenes in the documents are valid.

use carom::model::Scene;
use serde_json::Value;
use toml::Table;

use crate::markdown::pages;
use crate::validator::{mistakes, schema};

/// The fragments in the documents are added to this scene.
const BASE: &str = r#"
[[species]]
name = "sphere"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["sphere", "sphere"]
potential = "hard-sphere"

[[fill]]
species = "sphere"
arrangement = "random"
count = 100
packing_fraction = 0.2
temperature = 1.0

[run]
until_events = 100
"#;

fn completed(fragment: &str) -> Table {
    let mut scene: Table = BASE.parse().unwrap();
    let fragment: Table = fragment.parse().unwrap();
    if fragment.get("space").is_some_and(|space| space.get("size").is_some()) {
        scene["fill"][0].as_table_mut().unwrap().remove("packing_fraction");
    }
    scene.extend(fragment);
    scene
}

#[test]
fn base_scene_of_the_fragments_is_valid() {
    Scene::from_toml(BASE, "base.toml").unwrap();
}

#[test]
fn every_scene_and_every_part_of_one_is_valid() {
    let schema = schema();
    let (mut scenes, mut fragments) = (0, 0);
    for page in pages() {
        for block in page.blocks() {
            let place = format!("{}:{}", page.path, block.line);
            let table = match block.info.as_str() {
                "toml" => block.text.parse().unwrap_or_else(|error| panic!("{place}: {error}")),
                "toml fragment" => completed(&block.text),
                "toml manifest" => {
                    assert!(block.text.parse::<Table>().is_ok(), "{place}");
                    continue;
                }
                info => {
                    assert!(!info.contains("toml"), "{place}: a block of `{info}`");
                    continue;
                }
            };
            let value: Value = serde_json::to_value(&table).unwrap();
            assert_eq!(mistakes(&schema, &value), [""; 0], "{place}");
            // A scene that starts from a file or a run is not built, because the file or the run may not exist.
            if !table.contains_key("file") && !table.contains_key("start") {
                Scene::from_toml(toml::to_string(&table).unwrap(), "scene.toml")
                    .unwrap_or_else(|error| panic!("{place}: {error}"));
            }
            *if block.info == "toml" { &mut scenes } else { &mut fragments } += 1;
        }
    }
    assert!(scenes >= 2 && fragments >= 5, "{scenes} scenes and {fragments} fragments");
}
