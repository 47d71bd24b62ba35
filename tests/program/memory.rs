//! Behaviour when memory runs out.

#![cfg(target_os = "linux")]

use std::process::{Command, Output};

use super::place::{FLUID, Place, code, errors, words};

/// Runs the program with a limited address space `[KiB]`.
fn within(place: &Place, room: u64, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {room}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_carom")]);
    command.args(arguments).current_dir(place.path()).env("NO_COLOR", "1").output().unwrap()
}

/// Returns the smallest address space in which the program starts `[KiB]`. With less, the C library may abort.
fn least_room(place: &Place) -> u64 {
    let starts = |room: &u64| within(place, *room, &["--version"]).status.success();
    // Near the smallest limit, chance decides whether the program starts, so two steps are added.
    let rooms: Vec<u64> = (0..64).map(|step| (1 << 12) + (step << 10)).collect();
    let ends = rooms.iter().rposition(|room| !starts(room)).expect("four megabytes are too few");
    *rooms.get(ends + 2).expect("an empty program starts within 64 megabytes")
}

/// Whether the C library itself ended the program, because it had no memory for its own data. The program cannot
/// prevent this.
fn was_ended_by_the_c_library(output: &Output) -> bool {
    output.status.code().is_none() && errors(output).starts_with("Fatal glibc error")
}

#[test]
fn a_run_without_memory_says_so_and_can_be_resumed() {
    let place = Place::with(&FLUID.replace("count = 108", "count = 13500"));
    place.done(&["run", "scene.toml", "--quiet"]);
    let before = place.read("runs/scene/thermo.csv");
    let least = least_room(&place);
    let mut room = 2 * least + (1 << 15);
    let ended = loop {
        let output = within(&place, room, &["run", "--quiet", "--resume", "runs/scene", "--until-events", "4001"]);
        if !output.status.success() && !was_ended_by_the_c_library(&output) {
            break output;
        }
        assert!(room > least, "the run needs no more memory than an empty program");
        room = least.max(room * 7 / 8);
    };
    assert_eq!(ended.status.code(), Some(1), "{room} KiB: {ended:?}");
    // Carom must not end by a signal, whichever allocation fails.
    for part in 0..64 {
        let between = room + room / 7 * part / 64;
        let output = within(&place, between, &["run", "--quiet", "--resume", "runs/scene", "--until-events", "4001"]);
        let is_told = output.status.code().is_some_and(|code| code <= 1);
        assert!(is_told || was_ended_by_the_c_library(&output), "{between} KiB: {output:?}");
    }
    let text = errors(&ended);
    assert!(text.starts_with("Error: out of memory") && text.lines().count() == 1, "{room} KiB: {text}");
    let output = place.carom(&["run", "--quiet", "--resume", "runs/scene", "--until-events", "4001"]);
    assert_eq!(code(&output), 0, "{}{}", words(&output), errors(&output));
    let rows = |text: &str| text.lines().count();
    assert!(rows(&place.read("runs/scene/thermo.csv")) >= rows(&before));
}

fn peak(count: u32, instruments: &str) -> f64 {
    let scene = FLUID.replace("count = 108", &format!("count = {count}")).replace("= 0.3", "= 0.49");
    let place = Place::with(&format!("{scene}{instruments}"));
    place.done(&["run", "scene.toml", "--quiet"]);
    let summary: serde_json::Value = serde_json::from_str(&place.read("runs/scene/summary.json")).unwrap();
    summary["speed"]["peak_memory_bytes"].as_f64().unwrap()
}

#[test]
fn memory_per_particle_stays_within_its_limit() {
    // A second copy of the engine would take 180 bytes per particle. Memory pages of two megabytes may add 60 bytes.
    for (instruments, most) in
        [("", 400.0), ("[output]\ncontacts = true\n", 400.0), ("[measure]\npressure_tensor = true\n", 750.0)]
    {
        let bytes = (peak(32_000, instruments) - peak(108, instruments)) / 32_000.0;
        assert!((150.0..most).contains(&bytes), "{instruments}: {bytes} bytes of each particle");
    }
}

#[test]
fn a_scene_beyond_the_memory_of_the_process_is_refused() {
    let place = Place::with(&FLUID.replace("count = 108", "count = 10_000_000"));
    let output = within(&place, 1 << 20, &["check", "scene.toml"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(errors(&output).contains("expected at most 1"), "{}", errors(&output));
}
