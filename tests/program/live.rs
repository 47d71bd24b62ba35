//! `carom live`: the page that runs a scene, and rejected inputs.

use super::place::{FLUID, Place, code, contents, errors, words};

/// An engine module that claims to be built from other sources.
const MODULE: &str = "carom engine 0123456789abcdef\npacked";

const ENGINE: [&str; 2] = ["--module", "engine.module"];

fn place() -> Place {
    let place = Place::with(FLUID);
    place.write("engine.module", MODULE);
    place
}

fn told(page: &str) -> serde_json::Value {
    let json = page.split_once("id=\"scene\">").unwrap().1.split_once("</script>").unwrap().0;
    serde_json::from_str(json).unwrap()
}

fn live(place: &Place, arguments: &[&str]) -> std::process::Output {
    place.carom(&[&["live"], arguments, &ENGINE].concat())
}

#[test]
fn live_page_contains_the_scene_text_and_its_overrides() {
    let place = place();
    let changed = ["scene.toml", "--seed", "7", "--set", "fill.0.count=32"];
    let output = live(&place, &changed);
    assert_eq!((code(&output), words(&output).trim()), (0, "live.html"), "{}", errors(&output));
    assert!(errors(&output).contains("the module was built from other sources"), "{}", errors(&output));
    let page = place.read("live.html");
    assert_eq!(told(&page)["text"], place.read("scene.toml"));
    assert_eq!(told(&page)["changes"], serde_json::json!({ "seed": "7", "fill.0.count": "32" }));
    assert_eq!(code(&live(&place, &changed)), 0);
    assert_eq!(code(&live(&place, &["scene.toml"])), 2);
    assert_eq!(place.read("live.html"), page);
    assert_eq!(code(&live(&place, &["scene.toml", "--force"])), 0);
    assert_eq!(told(&place.read("live.html"))["changes"], serde_json::json!({}));
}

#[test]
fn live_page_contains_the_files_of_the_scene() {
    let place = place();
    std::fs::create_dir(place.path().join("scenes")).unwrap();
    place.write("scenes/ball.obj", "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
    let surface = "[[surface]]\nshape = \"mesh\"\npath = \"ball.obj\"\n";
    place.write("scenes/mesh.toml", &format!("allow_invalid_start = true\n{FLUID}\n{surface}"));
    let output = live(&place, &["scenes/mesh.toml"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let files = told(&place.read("live.html"))["files"].clone();
    assert_eq!((files.as_array().unwrap().len(), &files[0]["name"]), (1, &"ball.obj".into()));
    // The page would overwrite an input file of the scene.
    let output = live(&place, &["scenes/mesh.toml", "--out", "scenes/ball.obj", "--force"]);
    assert_eq!(code(&output), 2, "{}", errors(&output));
    assert!(place.read("scenes/ball.obj").starts_with("v 1"));
}

#[test]
fn live_rejects_unsupported_scenes_and_modules_without_writing() {
    let place = place();
    place.write("plain.wasm", "\0asm");
    let run = ["run", "scene.toml", "-q", "--out", "run", "--set", "fill.0.count=8", "--until-events", "10"];
    place.done(&run);
    place.write("later.toml", "[start]\nfrom = \"run\"\n[run]\nuntil_time = 1.0\n");
    let exchange = "[exchange]\ntemperatures = [1.0, 2.0]\ninterval = 1.0\nrate = 1.0\n\n[run]";
    place.write("replicas.toml", &FLUID.replace("[run]", exchange));
    let before = contents(place.path());
    for (arguments, expected) in [
        (["scene.toml", "--module", "nothing.wasm"], "cannot read nothing.wasm"),
        (["scene.toml", "--module", "plain.wasm"], "not an engine for browsers"),
        (["later.toml", "--module", "engine.module"], "starts from a run"),
        (["replicas.toml", "--module", "engine.module"], "[exchange]"),
        (["nothing.toml", "--module", "engine.module"], "nothing.toml"),
    ] {
        place.refused(&[["live"].as_slice(), &arguments].concat(), &[expected]);
        assert!(contents(place.path()) == before, "{arguments:?}");
    }
}
