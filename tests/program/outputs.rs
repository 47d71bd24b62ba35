//! Paths that cannot be written are reported like bad input.

#![cfg(target_os = "linux")]

use super::exchange::CHAIN;
use super::place::{FLUID, Place, contents, run};

#[test]
fn a_place_that_cannot_be_written_to_is_bad_input_for_every_command() {
    let place = Place::with(FLUID);
    run(&place, &["scene.toml"]);
    place.write("chain.toml", CHAIN);
    place.write("file", "mine");
    let before = contents(place.path());
    let commands: [(&[&str], &str); 9] = [
        (&["run", "scene.toml"], "x"),
        (&["sweep", "scene.toml", "--vary", "seed=1,2"], "x"),
        (&["exchange", "chain.toml"], "x"),
        (&["report", "runs/scene"], "x.html"),
        (&["render", "runs/scene", "--size", "32x32"], "x.png"),
        (&["movie", "runs/scene", "--size", "32x32"], "x.gif"),
        (&["movie", "runs/scene", "--size", "32x32"], "x.apng"),
        (&["convert", "runs/scene", "--to", "csv"], "x.csv"),
        (&["convert", "runs/scene", "--to", "npy"], "x-npy"),
    ];
    let long = "x".repeat(300);
    for (command, name) in commands {
        // Not even root can write inside a regular file, inside `/proc`, or under a name that is too long.
        for out in [format!("file/{name}"), format!("/proc/nothing/{name}"), format!("{long}{name}")] {
            place.refused(&[command, &["--out", &out]].concat(), &["help:"]);
        }
    }
    assert!(contents(place.path()) == before);
}

#[test]
fn a_picture_is_not_written_under_the_name_of_another_format() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml", "--quiet"]);
    place.refused(&["render", "runs/scene", "--out", "x.jpg"], &["x.jpg ends with .jpg, but pictures are PNG files"]);
    assert!(!place.path().join("x.jpg").exists());
}
