//! How the program shows text from users and files.

use std::fs;

use super::place::{FLUID, Place, code, errors, words};

#[test]
fn no_control_character_reaches_the_terminal() {
    let place = Place::with(FLUID);
    let escape = "\u{1b}[31m\u{9b}2J\u{7}";
    fs::write(place.path().join("broken.toml"), format!("# {escape}\r\nname = \"{escape}\n")).unwrap();
    let set = format!("species.0.name={escape}");
    let unknown = format!("no_such_key{escape}=1");
    let file = format!("{escape}.toml");
    for command in [
        &["check", "broken.toml"][..],
        &["check", "scene.toml", "--set", &set],
        &["check", "scene.toml", "--set", &unknown],
        &["run", &file],
        &["convert", &file, "--to", "csv"],
        &["verify", &file],
        &["render", "scene.toml", "--size", escape],
        &[escape],
    ] {
        let output = place.carom(command);
        assert_eq!(code(&output), 2, "{command:?}");
        let said = errors(&output) + &words(&output);
        assert!(!said.contains(|c: char| c.is_control() && c != '\n'), "{command:?}: {said:?}");
        assert!(said.len() > 20, "{command:?}: {said}");
    }
}

#[test]
fn check_prints_no_restitution_for_a_thermal_wall() {
    let place = Place::with(
        "[space]\nsize = [4.0, 4.0, 4.0]\nx = { lower = \"wall\", upper = \"wall\", temperature = 1.5 }\ny = \"walls\"\n\
        [[species]]\nname = \"ball\"\nmass = 1.0\ndiameter = 1.0\n[[particle]]\nspecies = \"ball\"\nposition = [2.0, 2.0, 2.0]\n\
        velocity = [1.0, 0.0, 0.0]\n[run]\nuntil_time = 1.0\n",
    );
    let output = place.done(&["check", "scene.toml"]);
    let said = words(&output);
    assert!(said.contains("wall (temperature 1.5)") && said.matches("restitution 1").count() == 1, "{said}");
    let walls = "space.x={ lower = { temperature = 1.5 }, upper = { restitution = 0.5 } }";
    let output = place.done(&["check", "scene.toml", "--set", walls]);
    let said = words(&output);
    assert!(said.contains("wall (temperature 1.5) below, wall (restitution 0.5) above"), "{said}");
}
