//! The program, as its users meet it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

const FLUID: &str = r#"
[[species]]
name = "sphere"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["sphere", "sphere"]
potential = "hard-sphere"

[[fill]]
species = "sphere"
arrangement = "fcc"
count = 108
packing_fraction = 0.3
temperature = 1.0

[run]
equilibration_events = 500
until_events = 4000
"#;

/// A ball that collapses onto the floor: nothing makes its contacts elastic.
const COLLAPSE: &str = r#"
[space]
size = [4.0, 4.0, 4.0]
x = "open"
y = "open"
z = { lower = "wall", upper = "open", restitution = 0.5 }

[dynamics]
gravity = [0.0, 0.0, -1.0]

[[species]]
name = "ball"
mass = 1.0
diameter = 1.0

[[particle]]
species = "ball"
position = [2.0, 2.0, 1.5]

[run]
until_time = 10.0

[output]
thermo_interval = 0.5
"#;

struct Place(tempfile::TempDir);

impl Place {
    /// A folder of its own with a scene in it.
    fn with(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(arguments).current_dir(self.path()).env("NO_COLOR", "1");
        command
    }

    fn carom(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    fn summary(&self, folder: &str) -> Value {
        serde_json::from_str(&self.read(&format!("{folder}/summary.json"))).unwrap()
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn sorted(mut words: Vec<&str>) -> Vec<&str> {
    words.sort_unstable();
    words
}

#[test]
fn a_run_leaves_its_files_and_a_table() {
    let place = Place::with(FLUID);
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(words(&output).contains("compressibility factor"), "{}", words(&output));
    assert!(words(&output).contains("one hard-sphere species"));
    let files = fs::read_dir(place.path().join("runs/scene")).unwrap();
    let mut names: Vec<String> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["checkpoint", "report.txt", "scene.toml", "summary.json", "thermo.csv", "trajectory.xyz"]);

    let thermo = place.read("runs/scene/thermo.csv");
    let mut lines = thermo.lines();
    let columns = lines.next().unwrap().split(',').count();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!((100..=420).contains(&rows.len()), "{} rows", rows.len());
    assert!(rows.iter().all(|row| row.len() == columns));
    let times: Vec<f64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    let interval = times[1] - times[0];
    // All but the last row stand at even times.
    for pair in times[..times.len() - 1].windows(2) {
        assert!(((pair[1] - pair[0]) / interval - 1.0).abs() < 1e-9);
    }
    let frames = place.read("runs/scene/trajectory.xyz").matches("Lattice=").count();
    assert!((10..=42).contains(&frames), "{frames} frames");
}

#[test]
fn the_keys_of_the_summary_are_the_contract() {
    let place = Place::with(FLUID);
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--seed", "9"])), 0);
    let summary = place.summary("runs/scene");
    let top = "version scene seed engine particles diameter_factor time events energy momentum overlap faults observables speed";
    assert_eq!(keys(&summary), sorted(top.split(' ').collect()));
    for (key, contents) in [
        (
            "events",
            "total core capture release bounce wall transition turning_point in_invalid_state tc_contacts tc_altered",
        ),
        ("energy", "initial final kinetic potential dissipated supplied ledger_error_relative ledger_limit"),
        ("momentum", "drift limit"),
        ("overlap", "deepest_executed deepest_final limit initial final resolved_after"),
        ("observables", "temperature pressure compressibility_factor collision_rate"),
        ("speed", "wall_seconds events_per_second contacts_per_second peak_memory_bytes"),
    ] {
        assert_eq!(keys(&summary[key]), sorted(contents.split(' ').collect()), "{key}");
    }
    assert_eq!(summary["seed"], 9);
    assert_eq!(summary["particles"], 108);
    assert_eq!(summary["events"]["total"], 4000, "the equilibration is not counted");
    assert_eq!(summary["events"]["core"], 4000);
    let rate = &summary["observables"]["collision_rate"];
    assert!(rate["standard_error"].as_f64().unwrap() > 0.0);
    // The mean over all of the stretch is what the counts say.
    let thermo = place.read("runs/scene/thermo.csv");
    let times: Vec<f64> = thermo.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    let duration = times[times.len() - 1] - times[0];
    assert!((rate["mean"].as_f64().unwrap() / (2.0 * 4000.0 / (108.0 * duration)) - 1.0).abs() < 1e-12);
    assert!(summary["momentum"]["drift"].as_f64().unwrap() < 1e-12);
}

#[test]
fn a_run_is_a_function_of_its_scene_and_rows_do_not_change_it() {
    let place = Place::with(FLUID);
    for (folder, more) in [("a", "seed=1"), ("b", "seed=1"), ("c", "output.thermo_interval=0.001"), ("d", "seed=2")] {
        let output = place.carom(&["run", "scene.toml", "--out", folder, "--set", more]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
    }
    let last_frame = |folder: &str| {
        let text = place.read(&format!("{folder}/trajectory.xyz"));
        text[text.rfind("Lattice=").unwrap()..].to_owned()
    };
    assert_eq!(place.read("a/trajectory.xyz"), place.read("b/trajectory.xyz"));
    assert_eq!(place.read("a/thermo.csv"), place.read("b/thermo.csv"));
    assert_eq!(last_frame("a"), last_frame("c"));
    assert!(place.read("c/thermo.csv").len() > 5 * place.read("a/thermo.csv").len());
    assert_ne!(last_frame("a"), last_frame("d"));
}

#[test]
fn limits_on_the_command_line_replace_those_of_the_scene() {
    let place = Place::with(FLUID);
    let output = place.carom(&["run", "scene.toml", "--until-events", "1e3", "--out", "events"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(place.summary("events")["events"]["total"], 1000);
    let arguments =
        ["run", "scene.toml", "--until-time", "0.5", "--set", "run.equilibration_events=1", "--out", "time"];
    assert_eq!(code(&place.carom(&arguments)), 0);
    let thermo = place.read("time/thermo.csv");
    assert_eq!(thermo.lines().count(), 1 + 201, "rows at both ends and between them");
}

#[test]
fn bad_input_is_told_before_anything_is_written() {
    let place = Place::with(FLUID);
    fs::write(place.path().join("binary.toml"), [0xff, 0xfe, 0, 1]).unwrap();
    fs::create_dir(place.path().join("empty")).unwrap();
    for (arguments, expected) in [
        (vec!["run", "missing.toml"], "missing.toml"),
        (vec!["run", "binary.toml"], "UTF-8"),
        (vec!["run", "."], "cannot read"),
        (vec!["run", "scene.toml", "--set", "run.until_event=5"], "until_events"),
        (vec!["run", "scene.toml", "--set", "nonsense"], "KEY=VALUE"),
        (vec!["run", "scene.toml", "--set", "fill.0.packing_fraction=0.9"], "0.74"),
        (vec!["run", "scene.toml", "--until-time", "nan"], "positive finite"),
        (vec!["run", "scene.toml", "--until-events", "0"], "at least 1"),
        (vec!["run", "scene.toml", "--seed", "-1"], "--seed"),
        (vec!["run"], "SCENE"),
        (vec!["fly"], "unrecognized subcommand"),
        (vec!["check", "missing.toml"], "missing.toml"),
        (vec!["new", "soup"], "hopper"),
        (vec!["verify", "missing.toml"], "missing.toml"),
        (vec!["verify", "empty"], "no scene.toml"),
        (vec!["verify", "scene.toml", "--events", "0"], "at least 1"),
        (vec!["verify", "scene.toml", "-q", "--from-events", "1e5"], "only 4500 events"),
        (vec!["validate", "soup"], "validate --list"),
        (vec!["validate", "--seed", "-1"], "-1"),
        (vec!["picture", "missing"], "missing"),
        (vec!["picture", ".", "--size", "10"], "WIDTH"),
        (vec!["report", "missing"], "not the folder of a run"),
        (vec!["report", "empty"], "summary.json"),
    ] {
        let output = place.carom(&arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", errors(&output));
        assert!(errors(&output).contains(expected), "{arguments:?}: {}", errors(&output));
        assert!(!errors(&output).contains("panicked"), "{}", errors(&output));
        assert!(!place.path().join("runs").exists(), "{arguments:?}");
    }
}

#[test]
fn a_folder_is_only_replaced_if_it_is_a_run() {
    let place = Place::with(FLUID);
    let thesis = place.path().join("thesis");
    fs::create_dir(&thesis).unwrap();
    fs::write(thesis.join("chapter.tex"), "years of work").unwrap();
    let output = place.carom(&["run", "scene.toml", "--out", "thesis"]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("not a run of carom"), "{}", errors(&output));
    assert_eq!(fs::read_dir(&thesis).unwrap().count(), 1);
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--out", "scene.toml"])), 2);
    assert_eq!(place.read("scene.toml"), FLUID);

    fs::create_dir(place.path().join("empty")).unwrap();
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--out", "empty", "--set", "output.contacts=true"])), 0);
    assert!(place.path().join("empty/contacts.csv").exists());
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--out", "empty", "--seed", "2"])), 0);
    assert!(!place.path().join("empty/contacts.csv").exists(), "a file of the earlier run");
    assert_eq!(place.summary("empty")["seed"], 2);
}

#[test]
fn contacts_lists_every_physical_event() {
    let place = Place::with(FLUID);
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--set", "output.contacts=true"])), 0);
    let contacts = place.read("runs/scene/contacts.csv");
    assert_eq!(contacts.lines().count(), 1 + 4000);
    assert!(contacts.lines().skip(1).all(|line| line.split(',').count() == 7 && line.contains(",core,")));
    let times: Vec<f64> =
        contacts.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(times.is_sorted());
}

#[test]
fn counting_regions_and_heights_are_columns() {
    let counting =
        format!("{COLLAPSE}\n[[output.count]]\nname = \"floor\"\nlower = [0.0, 0.0, 0.0]\nupper = [4.0, 4.0, 1.0]\n");
    let place = Place::with(&counting);
    let arguments = ["run", "scene.toml", "--set", "space.z.restitution=1.0", "--until-time", "2"];
    let output = place.carom(&arguments);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let thermo = place.read("runs/scene/thermo.csv");
    assert!(thermo.starts_with("time [time],events [1],kinetic [energy]"), "{thermo}");
    assert!(thermo.lines().next().unwrap().ends_with("height [length],in floor [1]"), "{thermo}");
    // At t = 1 the ball has fallen by 1/2 to 1; it touches the floor at sqrt(2).
    let row: Vec<&str> = thermo.lines().nth(3).unwrap().split(',').collect();
    assert_eq!((row[0], row[row.len() - 1]), ("1", "0"));
    assert!((row[row.len() - 2].parse::<f64>().unwrap() - 1.0).abs() < 1e-14);
    let row: Vec<&str> = thermo.lines().nth(4).unwrap().split(',').collect();
    assert_eq!((row[0], row[row.len() - 1]), ("1.5", "1"));
    assert!(place.summary("runs/scene")["momentum"]["drift"].is_null());
}

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
fn a_run_over_a_limit_of_the_scene_says_which_one_failed() {
    let place = Place::with(FLUID);
    let output = place.carom(&["run", "scene.toml", "--set", "audit.overlap=1e-17"]);
    assert_eq!(code(&output), 1, "{}", words(&output));
    assert!(errors(&output).contains("1.0e-17"), "{}", errors(&output));
    let summary = place.summary("runs/scene");
    assert_eq!(summary["faults"].as_array().unwrap().len(), 1, "{summary}");
    assert_eq!(summary["overlap"]["limit"], 1e-17);
    assert!(place.read("runs/scene/report.txt").contains("FAILED"));
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", words(&output));
    assert!(place.summary("runs/scene")["faults"].as_array().unwrap().is_empty());
}

#[test]
fn a_run_from_overlaps_says_when_the_last_one_was_gone() {
    // Two more spheres in the middle of others of the lattice.
    let more = |x: f64| format!("[[particle]]\nspecies = \"sphere\"\nposition = [{x}, 0.2, 0.1]\n");
    let place = Place::with(&format!("allow_invalid_start = true\n{FLUID}\n{}{}", more(0.3), more(3.0)));
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", words(&output));
    let overlap = &place.summary("runs/scene")["overlap"];
    println!("{overlap}");
    assert!(overlap["initial"].as_u64().unwrap() > 0 && overlap["final"] == 0, "{overlap}");
    assert!(overlap["resolved_after"].as_f64().unwrap() > 0.0, "{overlap}");
    assert!(place.read("runs/scene/report.txt").contains("the last gone after a time of"));
}

#[test]
fn a_run_can_be_proven_from_its_folder() {
    let place = Place::with(FLUID);
    let arguments = ["run", "scene.toml", "--seed", "9", "--set", "fill.0.temperature=2.0", "--until-events", "700"];
    assert_eq!(code(&place.carom(&arguments)), 0);
    fs::remove_file(place.path().join("scene.toml")).unwrap();
    let kept = place.read("runs/scene/scene.toml");
    for line in ["name = \"scene\"", "seed = 9", "temperature = 2.0", "until_events = 700"] {
        assert!(kept.lines().any(|other| other == line), "{line}: {kept}");
    }
    let output = place.carom(&["verify", "runs/scene"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let text = words(&output);
    for expected in ["scene, seed 9", "over all 5778 pairs", "1200 (1200 core)", "PROVEN", "up to the end of the run"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let output = place.carom(&["verify", "runs/scene", "--events", "100", "--from-events", "900", "--quiet"]);
    assert!(words(&output).contains("event 901 to 1000"), "{}", words(&output));
    assert_eq!(errors(&output), "");
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
fn a_run_without_future_ends() {
    // Two spheres that fly apart: no number of events is ever reached.
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
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(words(&output).contains("nothing will happen any more"), "{}", words(&output));
    assert_eq!(place.summary("runs/scene")["events"]["total"], 1);
}

#[cfg(unix)]
#[test]
fn a_stopped_run_leaves_complete_files() {
    let place = Place::with(FLUID);
    let arguments = ["run", "scene.toml", "--until-time", "1e6", "--set", "output.thermo_interval=0.01"];
    let mut child = place.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let partial = place.path().join("runs/scene/thermo.csv.partial");
    // The table is written every two seconds; then the run is under way.
    for _ in 0..600 {
        if fs::metadata(&partial).is_ok_and(|metadata| metadata.len() > 1000) {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
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
fn whoever_reads_only_the_first_line_causes_no_error() {
    let place = Place::with(FLUID);
    let mut child = place.command(&["new", "hopper"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(errors(&output), "");
}

#[test]
fn every_kind_of_new_scene_is_valid() {
    let kinds = [
        "fluid",
        "equation-of-state",
        "well",
        "well-law",
        "lennard-jones",
        "hopper",
        "pendulum",
        "polymer",
        "granular",
        "shear",
        "packing",
        "ball",
    ];
    let place = Place::with(FLUID);
    for kind in kinds {
        let text = words(&place.carom(&["new", kind]));
        assert!(text.starts_with('#'), "{kind} begins with a comment");
        fs::write(place.path().join("new.toml"), text).unwrap();
        let output = place.carom(&["check", "new.toml"]);
        assert_eq!(code(&output), 0, "{kind}: {}", errors(&output));
        assert!(words(&output).contains("The scene is valid.\n"), "{kind}: {}", words(&output));
    }
}

#[test]
fn validate_lists_what_it_measures_and_prints_a_table() {
    let place = Place::with(FLUID);
    let list = words(&place.carom(&["validate", "--list"]));
    assert!(list.contains("hard_spheres/0.40") && list.contains("diffusion coefficient"), "{list}");
    let output = place.carom(&["validate", "--brief", "spheres"]);
    let table = words(&output);
    assert_eq!(code(&output), 0, "{table}{}", errors(&output));
    assert!(table.starts_with("quantity") && table.ends_with("PASSED: 10 of 10\n"), "{table}");
    assert!(table.contains("1.01") && table.contains("mKLM 2019") && !table.contains("FAIL"), "{table}");
    assert_eq!(words(&place.carom(&["validate", "--brief", "spheres"])), table, "the same seed gives the same table");
}

#[test]
fn check_says_what_will_be_simulated_and_writes_nothing() {
    let place = Place::with(FLUID);
    let text = words(&place.carom(&["check", "scene.toml"]));
    for expected in ["108 sphere", "packing fraction 0.3,", "hard spheres of contact distance 1", "for 4000 events"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
}

#[test]
fn a_picture_of_a_run_is_a_png() {
    let place = Place::with(FLUID);
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--until-events", "100"])), 0);
    let output = place.carom(&["picture", "runs/scene", "--size", "160x120", "--colour", "speed"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let png = fs::read(place.path().join("runs/scene/picture.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn a_page_about_a_run_is_one_file_and_names_what_is_missing() {
    let place = Place::with(FLUID);
    assert_eq!(code(&place.carom(&["run", "scene.toml", "--until-events", "100"])), 0);
    let output = place.carom(&["report", "runs/scene"]);
    assert_eq!((code(&output), errors(&output).as_str()), (0, ""));
    assert_eq!(words(&output).trim(), "runs/scene/report.html");
    assert!(place.read("runs/scene/report.html").contains("108 sphere"));
    fs::remove_file(place.path().join("runs/scene/thermo.csv")).unwrap();
    let output = place.carom(&["report", "runs/scene", "--out", "page.html"]);
    assert_eq!(code(&output), 0);
    assert!(errors(&output).contains("thermo.csv") && place.read("page.html").contains("thermo.csv: "));
    assert_eq!(code(&place.carom(&["report", "runs/scene", "--out", "nowhere/page.html"])), 1);
}
