//! Inputs of a run are never overwritten, and changes are detected by checksums.

use std::fs;

use super::place::{Place, code, errors};

const START: &str = "2\nLattice=\"9 0 0 0 9 0 0 0 9\" Properties=type:S:1:pos:R:3:velo:R:3 pbc=\"T T T\"\n\
    ball 1 2 3 1 0.5 0.2\nball 4 2 3 -1 0.4 0.1\n";

const SCENE: &str = r#"
[[species]]
name = "ball"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["ball", "ball"]
potential = "hard-sphere"
[[file]]
path = "start.xyz"
[run]
until_time = 20.0
"#;

fn place() -> Place {
    let place = Place::with(SCENE);
    fs::write(place.path().join("start.xyz"), START).unwrap();
    place.done(&["run", "scene.toml", "--out", "runs/a"]);
    place
}

fn plain(text: &str) -> String {
    text.replace('│', " ").split_whitespace().collect()
}

#[test]
fn changed_input_file_of_a_run_is_detected() {
    let place = place();
    let summary = place.summary("runs/a");
    assert!(summary["inputs"][0]["path"].as_str().unwrap().ends_with("start.xyz"));
    assert!(summary["inputs"][0]["checksum"].as_str().unwrap().starts_with("crc32:"));
    place.done(&["verify", "runs/a"]);
    let before = place.read("runs/a/thermo.csv");
    fs::write(place.path().join("start.xyz"), START.replace("0.5 0.2", "0.5 0.3")).unwrap();
    for command in [&["verify", "runs/a"][..], &["run", "--resume", "runs/a", "--until-time", "30"]] {
        let output = place.carom(command);
        assert_eq!(code(&output), 2, "{command:?}: {}", errors(&output));
        let said = plain(&errors(&output));
        assert!(said.contains("start.xyz") && said.contains("haschanged:itschecksumiscrc32:"), "{said}");
    }
    assert_eq!(place.read("runs/a/thermo.csv"), before);
    fs::write(place.path().join("start.xyz"), START).unwrap();
    place.done(&["verify", "runs/a"]);
    // The checkpoint contains the state, so a resumed run does not need the start file.
    fs::remove_file(place.path().join("start.xyz")).unwrap();
    place.done(&["run", "--resume", "runs/a", "--until-time", "30"]);
}

#[test]
fn nothing_that_is_read_is_written_over() {
    let place = place();
    let read = || {
        let names =
            ["runs/a/trajectory.xyz", "runs/a/scene.toml", "runs/a/summary.json", "runs/a/thermo.csv", "start.xyz"];
        names.map(|name| place.read(name))
    };
    let before = read();
    fs::create_dir_all(place.path().join("case")).unwrap();
    fs::write(place.path().join("case/mine.toml"), SCENE.replace("start.xyz", "../start.xyz")).unwrap();
    for command in [
        // Each command would overwrite its input or another file of the run.
        &["run", "runs/a/scene.toml", "--out", "runs/a"][..],
        &["run", "case/mine.toml", "--out", "case"],
        &["run", "scene.toml", "--set", "file.0.path=runs/a/trajectory.xyz", "--out", "runs/a"],
        &["convert", "runs/a", "--to", "csv", "--out", "runs/a/thermo.csv", "--force"],
        &["convert", "runs/a", "--to", "xyz", "--out", "runs/a/trajectory.xyz", "--force"],
        &["render", "runs/a", "--out", "runs/a/trajectory.xyz"],
        &["render", "runs/a/trajectory.xyz", "--out", "runs/a/../a/scene.toml"],
        &["report", "runs/a", "--out", "runs/a/summary.json"],
    ] {
        let output = place.carom(command);
        assert_eq!(code(&output), 2, "{command:?}: {}", errors(&output));
        let said = plain(&errors(&output));
        assert!(said.contains("--out"), "{command:?}: {said}");
        assert!(read() == before, "{command:?}");
    }
    assert_eq!(fs::read_dir(place.path().join("case")).unwrap().count(), 1);
}

#[test]
fn a_run_starts_from_the_last_frame_of_another() {
    let scene = r#"
[space]
size = [7.0, 7.0, 7.0]
[[species]]
name = "bead"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["bead", "bead"]
potential = "hard-sphere"
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.6
longest = 0.9
[[chain]]
species = "bead"
length = 5
count = 4
bond = "link"
temperature = 1.0
[run]
until_events = 500
"#;
    let place = Place::with(scene);
    place.done(&["run", "scene.toml", "--out", "runs/a"]);
    let trajectory = place.read("runs/a/trajectory.xyz");
    let last = trajectory.matches("Lattice=").count() - 1;
    let (head, rest) = scene.split_once("[[chain]]").unwrap();
    let run = &rest[rest.find("[run]").unwrap()..];
    let head = head.replace("[space]\nsize = [7.0, 7.0, 7.0]\n", "");
    let next = format!("{head}[[file]]\npath = \"runs/a/trajectory.xyz\"\nframe = {last}\n{run}");
    fs::write(place.path().join("next.toml"), next).unwrap();
    place.done(&["run", "next.toml", "--out", "runs/b"]);
    let bonds = |text: &str| {
        let line = text.lines().nth(1).unwrap().to_owned();
        line[line.find(" bonds=").unwrap()..].to_owned()
    };
    assert_eq!(bonds(&place.read("runs/b/trajectory.xyz")), bonds(&trajectory));
    place.done(&["verify", "runs/b", "--events", "300"]);
}
