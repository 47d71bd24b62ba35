//! How runs end: arrests, limits, signals.

use std::fs;
use std::process::{Command, Stdio};

use super::place::{COLLAPSE, FLUID, Place, code, errors, line, send_signal, wait_until, words};

#[test]
fn an_arrest_is_an_error_with_complete_files_and_a_cure() {
    let place = Place::with(COLLAPSE);
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 1, "{}", words(&output));
    assert!(errors(&output).contains("dynamical arrest at time 4.24264"), "{}", errors(&output));
    assert!(errors(&output).contains("contact_time"), "{}", errors(&output));
    let summary = place.summary("runs/scene");
    assert!((summary["time"].as_f64().unwrap() - 3.0 * 2.0_f64.sqrt()).abs() < 1e-6);
    assert!(place.read("runs/scene/report.txt").contains("FAILED"));
}

#[test]
fn arrest_of_a_ball_at_rest_names_the_cure() {
    let ball = "name = \"ball\"\n[space]\nsize = [4.0, 4.0, 40.0]\n\
        z = { lower = \"wall\", upper = \"open\", restitution = 0.5 }\n\
        [dynamics]\ngravity = [0.0, 0.0, -1.0]\n[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n\
        [[particle]]\nspecies = \"A\"\nposition = [1.0, 1.0, 0.5]\n[run]\nuntil_time = 10.0\n";
    let place = Place::with(ball);
    for command in ["run", "verify"] {
        let output = place.carom(&[command, "scene.toml"]);
        assert_eq!(code(&output), 1, "{}", words(&output));
        let help = line(&output);
        assert!(help.contains("dynamical arrest at time 0"), "{help}");
        assert!(help.contains("set dynamics.contact_time"), "{help}");
        assert!(help.contains("particles that rest in contact"), "{help}");
    }
}

/// A file that reaches the size limit is reported like a full disk. The program is not killed by a signal.
#[test]
#[cfg(target_os = "linux")]
fn run_over_the_file_size_limit_fails_with_help() {
    let place = Place::with(&format!("{FLUID}[output]\nevents = true\n"));
    let limited = |arguments: &str| {
        let command = format!("ulimit -f 200; exec \"$0\" {arguments}");
        let mut shell = Command::new("bash");
        shell.args(["-c", &command, env!("CARGO_BIN_EXE_carom")]).current_dir(place.path()).env("NO_COLOR", "1");
        shell.output().unwrap()
    };
    let output = limited("run scene.toml --quiet");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let text = line(&output);
    assert!(text.contains("File too large") && text.contains("free some space"), "{text}");
    place.done(&["run", "scene.toml", "--quiet", "--force"]);
}

#[test]
fn a_run_over_a_limit_of_the_scene_says_which_one_failed() {
    let place = Place::with(FLUID);
    let output = place.carom(&["run", "scene.toml", "--set", "audit.overlap=1e-17"]);
    assert_eq!(code(&output), 1, "{}", words(&output));
    assert!(errors(&output).contains("1.0e-17"), "{}", errors(&output));
    let summary = place.summary("runs/scene");
    assert_eq!(summary["faults"].as_array().unwrap().len(), 1, "{summary}");
    assert_eq!(summary["overlap"]["limit"], 1e-17);
    assert!(place.read("runs/scene/report.txt").contains("FAILED"));
    let output = place.carom(&["run", "scene.toml", "--force"]);
    assert_eq!(code(&output), 0, "{}", words(&output));
    assert!(place.summary("runs/scene")["faults"].as_array().unwrap().is_empty());
}

#[test]
fn a_run_from_overlaps_says_when_the_last_one_was_gone() {
    let more = |x: f64| format!("[[particle]]\nspecies = \"sphere\"\nposition = [{x}, 0.2, 0.1]\n");
    let place = Place::with(&format!("allow_invalid_start = true\n{FLUID}\n{}{}", more(0.3), more(3.0)));
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", words(&output));
    let overlap = &place.summary("runs/scene")["overlap"];
    println!("{overlap}");
    assert!(overlap["initial"].as_u64().unwrap() > 0 && overlap["final"] == 0, "{overlap}");
    assert!(overlap["resolved_after"].as_f64().unwrap() > 0.0, "{overlap}");
    assert!(place.read("runs/scene/report.txt").contains("all resolved after a time of"));
}

#[test]
fn an_arrest_ends_a_proof_with_the_cure() {
    let place = Place::with(COLLAPSE);
    let output = place.carom(&["verify", "scene.toml"]);
    assert_eq!(code(&output), 1, "{}", words(&output));
    assert!(words(&output).contains("ARRESTED"), "{}", words(&output));
    assert!(errors(&output).contains("contact_time"), "{}", errors(&output));
}

#[test]
fn run_ends_when_no_event_can_follow() {
    // Two spheres fly apart, so they never reach the requested number of events.
    let scene = r#"
[space]
size = [10.0, 0.0, 0.0]
x = "open"
y = "flat"
z = "flat"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[particle]]
species = "A"
position = [2.0, 0.0, 0.0]
velocity = [1.0, 0.0, 0.0]
[[particle]]
species = "A"
position = [5.0, 0.0, 0.0]
[run]
until_events = 10
"#;
    let place = Place::with(scene);
    let output = place.done(&["run", "scene.toml"]);
    assert!(words(&output).contains("nothing will happen any more"), "{}", words(&output));
    assert_eq!(place.summary("runs/scene")["events"]["total"], 1);
}

#[cfg(unix)]
#[test]
fn a_stopped_run_leaves_complete_files() {
    let place = Place::with(FLUID);
    let arguments = ["run", "scene.toml", "--until-time", "1e5", "--set", "output.thermo_interval=0.1"];
    let mut child = place.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let partial = place.path().join("runs/scene/thermo.csv.partial");
    // The table is written every two seconds. A table with rows shows that the run has started.
    wait_until(|| fs::metadata(&partial).is_ok_and(|metadata| metadata.len() > 1000));
    send_signal(&child, "-TERM");
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(1));
    assert!(!partial.exists());
    assert!(place.summary("runs/scene")["events"]["total"].as_u64().unwrap() > 0);
    assert!(place.read("runs/scene/report.txt").contains("INTERRUPTED"));
    let thermo = place.read("runs/scene/thermo.csv");
    assert!(thermo.ends_with('\n'));
    let last = thermo.lines().last().unwrap().split(',').next().unwrap();
    let summary = place.read("runs/scene/summary.json");
    assert!(summary.contains(&format!("\"time\": {last},")), "{last}: {summary}");
}

#[test]
fn rows_end_when_no_event_can_follow() {
    let scene = "
        [output]
        thermo_interval = 0.01
        [[species]]
        name = 'ball'
        mass = 0.3
        diameter = 1.0
        [[interaction]]
        species = ['ball', 'ball']
        potential = 'hard-sphere'
        [space]
        size = [20.0, 20.0, 20.0]
        x = 'open'
        y = 'open'
        z = 'open'
        [[particle]]
        species = 'ball'
        position = [5.0, 5.0, 5.0]
        velocity = [1.0, 0.0, 0.0]
        [[particle]]
        species = 'ball'
        position = [8.0, 5.2, 5.0]
        [run]
        until_events = 100
        ";
    let place = Place::with(scene);
    let run = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&run), 0, "{}", words(&run));
    assert!(words(&run).contains("nothing will happen any more"), "{}", words(&run));
    let rows = place.read("runs/scene/thermo.csv").lines().count();
    assert!(rows < 10_000, "{rows} rows");
}

/// Two grains above a floor. The first grain is almost at rest, with the given height and speed.
fn at_rest(height: f64, speed: f64) -> String {
    format!(
        r#"
[space]
size = [6.0, 6.0, 6.0]
x = "open"
y = "open"
z = {{ lower = "wall", upper = "open", restitution = 0.8 }}

[dynamics]
gravity = [0.0, 0.0, -1.0]
contact_time = 1e-3

[[species]]
name = "ball"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["ball", "ball"]
potential = "hard-sphere"
restitution = 0.8

[[particle]]
species = "ball"
position = [2.0, 2.0, {}]
velocity = [0.0, 0.0, {speed:?}]

[[particle]]
species = "ball"
position = [4.0, 4.0, 3.5]

[run]
until_time = 10.0
"#,
        0.5 + height
    )
}

#[test]
fn grain_resting_on_a_wall_gets_a_warning_and_arrests() {
    for (speed, happens) in
        [(0.0, "ends immediately with a dynamical arrest"), (1e-12, "in contact again every 2.000e-12 of time")]
    {
        let place = Place::with(&at_rest(0.0, speed).replace("contact_time = 1e-3", ""));
        let checked = words(&place.carom(&["check", "scene.toml"]));
        let warning = "particle 0 rests on the lower wall of z";
        assert!(checked.contains(warning) && checked.contains(happens), "{checked}");
        assert!(checked.contains("set dynamics.contact_time"), "{checked}");
        let output = place.carom(&["run", "scene.toml", "-q"]);
        assert_eq!(code(&output), 1, "{}", words(&output));
        let told = line(&output);
        assert!(told.contains(warning) && told.contains("dynamical arrest at time 0"), "{told}");
        assert!(told.contains("set dynamics.contact_time"), "{told}");
    }
}

#[test]
fn rattling_in_a_narrow_slit_ends_in_a_storm() {
    // The ball has a gap of 1e-10 and a speed of 1. In a contact time of 1e-3, it meets the walls ten million times.
    let slit = at_rest(0.0, 1.0)
        .replace("size = [6.0, 6.0, 6.0]", "size = [6.0, 6.0, 1.0000000001]")
        .replace("upper = \"open\"", "upper = \"wall\"")
        .replace("position = [4.0, 4.0, 3.5]", "position = [4.0, 4.0, 0.5]");
    let output = Place::with(&slit).carom(&["run", "scene.toml", "-q"]);
    assert_eq!(code(&output), 1, "{}", words(&output));
    // Long messages are broken into lines that begin with a bar.
    let told = line(&output);
    assert!(told.contains("1020000 events while time advances by"), "{told}");
    assert!(told.contains("give the particles more room, or set a longer dynamics.contact_time"), "{told}");
}

#[test]
fn grain_resting_on_a_wall_runs_with_a_contact_time() {
    // In the TC model, a grain at rest bounces to a height of `g tc^2 / 8`, which is 1.25e-7.
    for (height, speed) in [(0.0, 0.0), (0.0, 1e-12), (1.25e-7, 0.0)] {
        let place = Place::with(&at_rest(height, speed));
        assert!(words(&place.carom(&["check", "scene.toml"])).contains("The scene is valid.\n"));
        place.done(&["run", "scene.toml", "-q"]);
        let summary = place.summary("runs/scene");
        let events = summary["events"]["total"].as_u64().unwrap();
        assert!((5_000..40_000).contains(&events), "two grains that rattle at intervals of about 1e-3: {events}");
        assert!(summary["faults"].as_array().unwrap().is_empty());
        let is_lifted = place.read("runs/scene/report.txt").contains("lifted by the TC model");
        assert_eq!(is_lifted, height == 0.0);
        assert_eq!(is_lifted, summary["events"]["tc_lifted"].as_u64().unwrap() > 0);
        let output = place.carom(&["verify", "scene.toml"]);
        assert_eq!(code(&output), 0, "{}", words(&output));
    }
}

#[test]
fn grains_at_rest_on_a_slope_and_on_each_other_are_proven() {
    let scene = at_rest(0.0, 0.0)
        .replace("gravity = [0.0, 0.0, -1.0]", "gravity = [0.313, -0.171, -0.987]")
        .replace("contact_time = 1e-3", "contact_time = 1.3e-3")
        .replace("mass = 1.0", "mass = 1.37")
        .replace("position = [4.0, 4.0, 3.5]", "position = [4.3, 4.2, 2.4327]")
        .replace("until_time = 10.0", "until_time = 0.7");
    let more = r#"
[[species]]
name = "fixed"
diameter = 1.0
static = true

[[interaction]]
species = ["ball", "fixed"]
potential = "hard-sphere"
restitution = 0.7

[[particle]]
species = "fixed"
position = [4.0, 4.0, 1.5]

[[particle]]
species = "ball"
position = [2.9, 2.4358, 0.5]
"#;
    let output = Place::with(&format!("separate_overlaps = 0.01\n{scene}{more}")).carom(&["verify", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}{}", words(&output), errors(&output));
}
