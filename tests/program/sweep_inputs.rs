use std::fs;

use super::place::{FLUID, Place, code, errors, words};

const FROM_FILE: &str = r#"
[space]
size = [8.0, 8.0, 8.0]

[[species]]
name = "A"
mass = 1.3
diameter = 1.0

[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"

[[file]]
path = "start.xyz"

[run]
until_time = 1.0
"#;

fn start(speed: f64) -> String {
    format!("2\nProperties=species:S:1:pos:R:3:velo:R:3\nA 1 1 1 {speed} 0 0\nA 4 1 1 0 0 0\n")
}

#[test]
fn sweep_rejects_a_changed_input_file() {
    let place = Place::with(FROM_FILE);
    place.write("start.xyz", &start(1.0));
    let sweep = |times: &str| place.carom(&["sweep", "scene.toml", "--vary", times, "--out", "s", "--quiet"]);
    let first = sweep("run.until_time=10,20");
    assert_eq!(code(&first), 0, "{}", errors(&first));
    let table = place.read("s/sweep.csv");
    place.write("start.xyz", &start(2.0));
    for times in ["run.until_time=10,20", "run.until_time=10,20,30"] {
        let other = sweep(times);
        assert_eq!(code(&other), 2, "{}", words(&other));
        assert!(errors(&other).contains("start.xyz has changed"), "{}", errors(&other));
    }
    let by_folder = place.carom(&["sweep", "s", "--quiet"]);
    assert_eq!(code(&by_folder), 2, "{}", words(&by_folder));
    assert_eq!(place.read("s/sweep.csv"), table);
    place.write("start.xyz", &start(1.0));
    let again = sweep("run.until_time=10,20,30");
    assert_eq!(code(&again), 0, "{}", errors(&again));
}

#[test]
fn sweep_rejects_a_replaced_starting_run() {
    let place = Place::with(FLUID);
    let run = |seed: &str| place.carom(&["run", "scene.toml", "-q", "--seed", seed, "--out", "first", "--force"]);
    assert_eq!(code(&run("1")), 0);
    let next = "start.from = \"first\"\nrun.until_events = 500\n";
    place.write("next.toml", next);
    let vary = ["sweep", "next.toml", "--vary", "run.until_events=500,900", "--out", "s", "--quiet"];
    place.done(&vary);
    assert_eq!(code(&run("2")), 0);
    place.refused(&vary, &["checkpoint has changed"]);
}

#[test]
fn sweep_checks_the_input_files_of_all_points() {
    let place = Place::with(FROM_FILE);
    for name in ["start.xyz", "other.xyz"] {
        place.write(name, &start(1.0));
    }
    let sweep =
        || place.carom(&["sweep", "scene.toml", "--vary", "file.0.path=start.xyz,other.xyz", "--out", "s", "-q"]);
    assert_eq!(code(&sweep()), 0);
    place.write("other.xyz", &start(2.0));
    let other = sweep();
    assert_eq!(code(&other), 2, "{}", words(&other));
    assert!(errors(&other).contains("other.xyz has changed"), "{}", errors(&other));
}

#[test]
fn sweep_checks_the_meshes_of_all_points() {
    let surface = "[[surface]]\nshape = \"mesh\"\npath = \"one.obj\"\n";
    let place = Place::with(&format!("{FROM_FILE}{surface}"));
    place.write("start.xyz", &start(1.0));
    let mesh = |x: f64| format!("v 1 6 6\nv {x} 6 6\nv 4 7 7\nf 1 2 3\n");
    for name in ["one.obj", "two.obj"] {
        place.write(name, &mesh(6.0));
    }
    let sweep =
        || place.carom(&["sweep", "scene.toml", "--vary", "surface.0.path=one.obj,two.obj", "--out", "s", "-q"]);
    let first = sweep();
    assert_eq!(code(&first), 0, "{}", errors(&first));
    place.write("two.obj", &mesh(7.0));
    let other = sweep();
    assert_eq!(code(&other), 2, "{}", words(&other));
    assert!(errors(&other).contains("two.obj has changed"), "{}", errors(&other));
}

#[test]
fn sweep_over_seeds_without_effect_is_rejected() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "-q", "--out", "first"]);
    place.write("next.toml", "start.from = \"first\"\nrun.until_events = 500\n");
    let vary = ["sweep", "next.toml", "--vary", "seed=1..4", "--out", "s", "--quiet"];
    place.refused(&vary, &["the seed changes nothing"]);
    assert!(!fs::exists(place.path().join("s")).unwrap());
    let bath = "run.thermostat={ kind = \"andersen\", temperature = 1.0, rate = 1.0 }";
    place.done(&[&vary[..], &["--set", bath]].concat());
}

#[test]
fn whole_numbers_may_be_written_with_an_exponent() {
    let place = Place::with(FLUID);
    let vary = "fill.0.packing_fraction=0.1,0.2; run.until_events=1e3,2e3";
    place.done(&["sweep", "scene.toml", "--vary", vary, "--out", "s", "--quiet"]);
    let events: Vec<u64> = ["1e3", "2e3"]
        .iter()
        .zip(["0.1", "0.2"])
        .map(|(events, density)| {
            let summary = place.summary(&format!("s/packing_fraction-{density}_until_events-{events}"));
            summary["events"]["total"].as_u64().unwrap_or_else(|| panic!("{summary}"))
        })
        .collect();
    assert_eq!(events, [1000, 2000]);
}

#[test]
fn too_large_whole_numbers_are_rejected_with_their_line() {
    let place = Place::with(&format!("seed = 9223372036854775808\n{FLUID}"));
    for command in ["check", "run"] {
        let output = place.carom(&[command, "scene.toml"]);
        assert_eq!(code(&output), 2, "{}", words(&output));
        let text = errors(&output);
        assert!(text.contains("scene.toml:1:8") && text.contains("9223372036854775807"), "{text}");
    }
}
