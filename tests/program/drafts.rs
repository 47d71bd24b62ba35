//! A command removes the temporary files of killed processes from its folder, and nothing else.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Child;

use super::exchange::CHAIN;
use super::place::{FLUID, Place, code, errors, killed, run, wait_until};

/// A temporary file of a process that no longer exists.
const LEFT: &str = ".carom-4711-0.partial";

fn drafts(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.starts_with(".carom-")).collect()
}

fn drawing(place: &Place) -> Child {
    let arguments = ["movie", "runs/scene", "--out", "runs/scene/film.apng", "--size", "2000x2000", "-q"];
    let child = place.start(&arguments);
    wait_until(|| drafts(&place.path().join("runs/scene")).iter().any(|name| name != LEFT));
    child
}

#[test]
fn temporary_file_is_removed_only_after_its_process_has_ended() {
    let place = Place::with(&format!("{FLUID}[output]\nframe_interval = 0.01\n"));
    run(&place, &["scene.toml"]);
    let folder = place.path().join("runs/scene");
    fs::write(folder.join(LEFT), "half").unwrap();
    let child = drawing(&place);
    place.done(&["render", "runs/scene", "--size", "32x32"]);
    let [of_movie] = drafts(&folder).try_into().unwrap();
    assert_ne!(of_movie, LEFT);
    killed(child);
    assert_eq!(drafts(&folder), [of_movie]);
    run(&place, &["--resume", "runs/scene", "--until-events", "4100"]);
    assert!(drafts(&folder).is_empty());
}

#[test]
fn every_command_removes_stale_temporary_files_in_its_folder() {
    let place = Place::with(FLUID);
    run(&place, &["scene.toml"]);
    place.write("chain.toml", CHAIN);
    let few = ["--set", "run.until_time=30", "--set", "run.equilibration_time=3"];
    let exchange = [&["exchange", "chain.toml", "-q", "--out", "pair"][..], &few].concat();
    let sweep = ["sweep", "scene.toml", "--vary", "seed=1,2", "--out", "s", "-q", "--set", "run.until_events=600"];
    for (arguments, folder) in [
        (&exchange[..], "pair"),
        (&exchange, "pair"),
        (&sweep, "s"),
        (&sweep, "s"),
        (&["convert", "runs/scene", "--to", "csv"], "runs/scene"),
        (&["report", "runs/scene"], "runs/scene"),
        (&["run", "scene.toml", "-q", "--out", "new"], "new"),
        (&["run", "scene.toml", "-q", "--force"], "runs/scene"),
    ] {
        fs::create_dir_all(place.path().join(folder)).unwrap();
        place.write(&format!("{folder}/{LEFT}"), "half");
        let output = place.carom(arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", errors(&output));
        assert!(drafts(&place.path().join(folder)).is_empty(), "{arguments:?}");
    }
}
