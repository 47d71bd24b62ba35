//! `carom live`: the page on which a scene runs, and what it refuses.

use super::place::{FLUID, Place, code, contents, errors, line, words};

/// A file that begins as WebAssembly does, of other sources than the program.
const MODULE: &[u8] = b"\0asm\x01\0\0\0";

fn place() -> Place {
    let place = Place::with(FLUID);
    std::fs::write(place.path().join("engine.wasm"), MODULE).unwrap();
    place
}

#[test]
fn a_page_has_the_scene_as_it_is_to_be_run() {
    let place = place();
    let output =
        place.carom(&["live", "scene.toml", "--module", "engine.wasm", "--seed", "7", "--set", "fill.0.count=32"]);
    assert_eq!((code(&output), words(&output).trim()), (0, "live.html"), "{}", errors(&output));
    assert!(errors(&output).contains("the module was made from other sources"), "{}", errors(&output));
    let page = place.read("live.html");
    let json = page.split_once("id=\"scene\">").unwrap().1.split_once("</script>").unwrap().0;
    let told: serde_json::Value = serde_json::from_str(json).unwrap();
    place.write("again.toml", told["text"].as_str().unwrap());
    for (scene, more) in [("scene.toml", ["--seed", "7", "--set", "fill.0.count=32"].as_slice()), ("again.toml", &[])] {
        let arguments = [&["run", scene, "-q", "--out", scene.trim_end_matches(".toml")], more].concat();
        assert_eq!(code(&place.carom(&arguments)), 0);
    }
    assert_eq!(place.read("scene/trajectory.xyz"), place.read("again/trajectory.xyz"));
    // The same page again is no replacement, another one is.
    assert_eq!(
        code(&place.carom(&[
            "live",
            "scene.toml",
            "--module",
            "engine.wasm",
            "--seed",
            "7",
            "--set",
            "fill.0.count=32"
        ])),
        0
    );
    let other = ["live", "scene.toml", "--module", "engine.wasm"];
    assert_eq!(code(&place.carom(&other)), 2);
    assert_eq!(place.read("live.html"), page);
    assert_eq!(code(&place.carom(&[other.as_slice(), &["--force"]].concat())), 0);
    assert_ne!(place.read("live.html"), page);
}

#[test]
fn what_has_no_page_is_refused_and_leaves_nothing() {
    let place = place();
    place.write("text.wasm", "no module");
    place.write("ball.obj", "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
    place.write("mesh.toml", &FLUID.replace("[run]", "[[surface]]\nshape = \"mesh\"\npath = \"ball.obj\"\n\n[run]"));
    let exchange = "[exchange]\ntemperatures = [1.0, 2.0]\ninterval = 1.0\nrate = 1.0\n\n[run]";
    place.write("replicas.toml", &FLUID.replace("[run]", exchange));
    let before = contents(place.path());
    for (arguments, expected) in [
        (["scene.toml", "--module", "nothing.wasm"], "nothing.wasm cannot be read"),
        (["scene.toml", "--module", "text.wasm"], "not WebAssembly"),
        (["mesh.toml", "--module", "engine.wasm"], "ball.obj, expected no other files"),
        (["replicas.toml", "--module", "engine.wasm"], "[exchange]"),
        (["nothing.toml", "--module", "engine.wasm"], "nothing.toml"),
    ] {
        let output = place.carom(&[["live"].as_slice(), &arguments].concat());
        assert_eq!(code(&output), 2, "{arguments:?}: {}", errors(&output));
        assert!(line(&output).contains(expected), "{arguments:?}: {}", line(&output));
        assert!(contents(place.path()) == before, "{arguments:?}");
    }
}
