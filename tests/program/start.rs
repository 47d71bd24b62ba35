//! Runs that start from the end of another run.

use std::fs;

use super::place::{Place, code, errors, line, run, words};

const WELLS: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
"#;

const WELL_FLUID: &str = r#"
[[fill]]
species = "A"
arrangement = "fcc"
count = 108
packing_fraction = 0.2
temperature = 1.5
"#;

const CHAINS: &str = r#"
[space]
size = [8.0, 8.0, 8.0]
[[species]]
name = "bead"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["bead", "bead"]
potential = "square-well"
lambda = 1.4
well_depth = 0.5
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.6
longest = 1.2
"#;

const CHAIN: &str = "[[chain]]\nspecies = \"bead\"\nlength = 6\ncount = 8\nbond = \"link\"\ntemperature = 1.0\n";

const RAIN: &str = r#"
[space]
size = [6.0, 6.0, 20.0]
z = { lower = "wall", upper = "open", restitution = 0.8 }
[dynamics]
gravity = [0.0, 0.0, -1.0]
contact_time = 1e-3
[[species]]
name = "grain"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["grain", "grain"]
potential = "hard-sphere"
restitution = 0.8
"#;

const GRAINS: &str = "[[fill]]\nspecies = \"grain\"\narrangement = \"random\"\ncount = 60\ntemperature = 0.5\n\
    region = { lower = [0.0, 0.0, 0.0], upper = [6.0, 6.0, 12.0] }\n";

const SHEARED: &str = "[space]\nshear_rate = 0.7\n";

fn run_until(time: &str) -> String {
    // With this interval, rounding puts the 47th row and the last checkpoint slightly before 0.75.
    format!("[run]\nuntil_time = {time}\n[output]\nthermo_interval = 0.015957446808510637\nframe_interval = 0.25\n")
}

fn started(place: &Place, name: &str, text: &str) {
    fs::write(place.path().join(format!("{name}.toml")), text).unwrap();
}

fn last_frame(place: &Place, folder: &str) -> String {
    let text = place.read(&format!("{folder}/trajectory.xyz"));
    let count = text.lines().next().unwrap();
    let start = text.rfind(&format!("\n{count}\n")).map_or(0, |at| at + 1);
    text[start..].to_owned()
}

fn column(place: &Place, folder: &str, name: &str) -> Vec<f64> {
    place.thermo(folder).iter().map(|row| row[name].parse().unwrap()).collect()
}

fn refused(place: &Place, arguments: &[&str], expected: &[&str]) {
    let output = place.carom(arguments);
    let said = line(&output);
    assert_eq!(code(&output), 2, "{arguments:?}: {said}");
    // The message breaks long words, so spaces are ignored.
    let said = said.replace(' ', "");
    for words in expected {
        assert!(said.contains(&words.replace(' ', "")), "{arguments:?} lacks `{words}`: {said}");
    }
}

#[test]
fn consecutive_runs_have_the_bits_of_one_longer_run() {
    let sheared = format!("{SHEARED}{WELLS}");
    for (what, scene, particles) in [
        ("wells", WELLS, WELL_FLUID),
        ("chains", CHAINS, CHAIN),
        ("rain", RAIN, GRAINS),
        ("shear", &sheared, WELL_FLUID),
    ] {
        let place = Place::with(&format!("{scene}{particles}{}", run_until("2.25")));
        run(&place, &["scene.toml", "--out", "runs/whole"]);
        run(&place, &["scene.toml", "--until-time", "0.75", "--out", "runs/1"]);
        // The scene `again` lacks only the particles. The scene `short` contains only the limit of the run.
        started(&place, "again", &format!("start.from = \"runs/1\"\n{scene}{}", run_until("0.75")));
        started(&place, "short", &run_until("0.75"));
        run(&place, &["again.toml", "--out", "runs/2"]);
        run(&place, &["short.toml", "--from", "runs/2", "--out", "runs/3"]);
        assert_eq!(last_frame(&place, "runs/3"), last_frame(&place, "runs/whole"), "{what}");
        let times = column(&place, "runs/2", "time");
        assert_eq!((times[0], *times.last().unwrap()), (0.75, 1.5), "{what}");
        assert!(column(&place, "runs/2", "events")[0] == 0.0, "{what}: events are counted in each run");
    }
}

#[test]
fn next_run_continues_from_the_last_event() {
    let plan = |events: u32| format!("[run]\nuntil_events = {events}\n");
    let place = Place::with(&format!("{CHAINS}{CHAIN}{}", plan(3000)));
    run(&place, &["scene.toml", "--out", "runs/whole"]);
    run(&place, &["scene.toml", "--until-events", "1000", "--out", "runs/1"]);
    started(&place, "next", &plan(2000));
    run(&place, &["next.toml", "--from", "runs/1", "--out", "runs/2"]);
    assert_eq!(last_frame(&place, "runs/2"), last_frame(&place, "runs/whole"));
    // Gravity needs another engine. The run starts with a pair in contact.
    started(&place, "fall", &format!("[dynamics]\ngravity = [0.3, 0.0, 0.0]\n{}", plan(500)));
    run(&place, &["fall.toml", "--from", "runs/1", "--out", "runs/fall"]);
    place.done(&["verify", "runs/fall"]);
}

#[test]
fn an_anneal_in_stages_and_in_runs_has_the_same_bits() {
    let bath = |temperature: &str| {
        format!(
            "until_time = 0.75\nthermostat = {{ kind = \"rescaling\", temperature = {temperature}, interval = 0.125 }}\n"
        )
    };
    let temperatures = ["1.5", "1.25", "1.0", "0.75", "0.5"];
    let stage = |temperature: &&str| format!("[[stage]]\nname = \"T {temperature}\"\n{}", bath(temperature));
    let stages: String = temperatures[..4].iter().map(stage).collect();
    let place = Place::with(&format!("{WELLS}{WELL_FLUID}{stages}[run]\n{}", bath("0.5")));
    run(&place, &["scene.toml", "--out", "runs/whole"]);
    started(&place, "0", &format!("{WELLS}{WELL_FLUID}[run]\n{}", bath("1.5")));
    run(&place, &["0.toml", "--out", "runs/0"]);
    for (k, temperature) in temperatures.iter().enumerate().skip(1) {
        started(&place, &k.to_string(), &format!("start.from = \"runs/{}\"\n[run]\n{}", k - 1, bath(temperature)));
        run(&place, &[&format!("{k}.toml"), "--out", &format!("runs/{k}")]);
    }
    assert_eq!(last_frame(&place, "runs/4"), last_frame(&place, "runs/whole"));
}

#[test]
fn heat_baths_of_consecutive_runs_have_different_random_numbers() {
    let bath = "[run]\nuntil_time = 0.75\nthermostat = { kind = \"andersen\", temperature = 1.0, rate = 1.0 }\n";
    let place = Place::with(&format!("{WELLS}{WELL_FLUID}{bath}[output]\nevents = true\n"));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    started(&place, "next", &format!("{bath}[output]\nevents = true\n"));
    run(&place, &["next.toml", "--from", "runs/a", "--out", "runs/b"]);
    let [a, b] = ["runs/a", "runs/b"].map(|folder| column(&place, folder, "temperature"));
    assert!(a.last() == b.first() && a.last() != b.last());
    let hit = |folder: &str| {
        let summary = place.summary(folder);
        summary["rates"].as_array().unwrap().iter().find(|rate| rate["kind"] == "thermostat").unwrap()["events"].clone()
    };
    assert_ne!(hit("runs/a"), hit("runs/b"), "two streams of Poisson events");
    run(&place, &["--resume", "runs/b", "--until-time", "1.5"]);
    run(&place, &["next.toml", "--from", "runs/a", "--until-time", "1.5", "--out", "runs/c"]);
    assert_eq!(last_frame(&place, "runs/b"), last_frame(&place, "runs/c"));
}

#[test]
fn changes_of_the_scene_apply_to_the_exact_final_state() {
    let place = Place::with(&format!("{WELLS}{WELL_FLUID}{}", run_until("1.0")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    let deeper = WELLS.replace("well_depth = 1.0", "well_depth = 2.0");
    started(&place, "deeper", &format!("{deeper}{}", run_until("1.0")));
    run(&place, &["deeper.toml", "--from", "runs/a", "--out", "runs/b"]);
    let [before, after] = ["runs/a", "runs/b"].map(|folder| column(&place, folder, "potential"));
    assert_eq!(after[0], 2.0 * before.last().unwrap(), "all pairs keep their states");
    let images = |folder: &str, is_first: bool| {
        let text = place.read(&format!("{folder}/trajectory.xyz"));
        let frame = if is_first {
            text.lines().skip(2).take(108).collect::<Vec<_>>().join("\n")
        } else {
            last_frame(&place, folder)
        };
        frame.lines().filter(|line| line.starts_with('A')).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(images("runs/a", false), images("runs/b", true));
    let output = place.done(&["verify", "runs/b", "--events", "2000"]);
    assert!(words(&output).contains("from the end of the run in [start]"), "{}", words(&output));
    let output = place.carom(&["check", "deeper.toml", "--from", "runs/a"]);
    assert!(
        words(&output).contains("a new engine begins there, because these differ: interactions"),
        "{}",
        words(&output)
    );
    started(&place, "next", &run_until("0.5"));
    run(&place, &["next.toml", "--from", "runs/b", "--out", "runs/c"]);
    let output = place.done(&["verify", "runs/c", "--events", "1e6"]);
    assert!(words(&output).contains("number of events and final time agree with summary.json"), "{}", words(&output));
    run(&place, &["runs/c/scene.toml", "--out", "runs/d"]);
    assert_eq!(place.read("runs/c/thermo.csv"), place.read("runs/d/thermo.csv"));
    let output = place.carom(&["check", "runs/c/scene.toml"]);
    assert!(
        words(&output)
            .contains("its engine continues: the results are equal, bit for bit, to the results of one longer run"),
        "{}",
        words(&output)
    );
    place.done(&["report", "runs/c"]);
}

#[test]
fn gravity_and_walls_come_from_the_new_scene() {
    let place = Place::with(&format!("{RAIN}{GRAINS}{}", run_until("1.0")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    started(&place, "up", &format!("[dynamics]\ngravity = [0.0, 0.0, 1.0]\n{}", run_until("4.0")));
    run(&place, &["up.toml", "--from", "runs/a", "--out", "runs/up"]);
    let heights = column(&place, "runs/up", "potential");
    assert!(heights[0] < 0.0 && heights.last().unwrap() < &heights[0], "they fall upwards");
    // A scene without [space] has the box of the run.
    place.done(&["verify", "runs/up", "--events", "500"]);
    started(&place, "walls", &format!("[space]\nx = \"walls\"\nz = \"walls\"\n{}", run_until("0.5")));
    refused(&place, &["run", "walls.toml", "--from", "runs/a"], &["start.from", "wall of"]);
    let open = format!("[space]\nx = \"open\"\ny = \"open\"\nz = \"open\"\n{}", run_until("0.5"));
    started(&place, "open", &open);
    run(&place, &["open.toml", "--from", "runs/a", "--out", "runs/open"]);
    place.done(&["verify", "runs/open"]);
}

#[test]
fn new_contact_time_counts_from_the_start_of_the_run() {
    let place = Place::with(&format!("{RAIN}{GRAINS}{}", run_until("4.0")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    let dissipated = |name: &str, contact_time: &str| {
        let dynamics = format!("[dynamics]\ngravity = [0.0, 0.0, -1.0]\ncontact_time = {contact_time}\n");
        started(&place, name, &format!("{dynamics}{}", run_until("2.0")));
        run(&place, &[&format!("{name}.toml"), "--from", "runs/a", "--out", &format!("runs/{name}")]);
        place.summary(&format!("runs/{name}"))["energy"]["dissipated"].as_f64().unwrap()
    };
    // With the long contact time, nearly all contacts are elastic.
    let (short, long) = (dissipated("short", "1e-3"), dissipated("long", "100.0"));
    assert!(long < 0.2 * short, "{long} and {short}");
}

#[test]
fn grown_spheres_keep_their_size_in_the_next_run() {
    let grow = "[[stage]]\nname = \"grow\"\ngrow = { rate = 0.1, packing_fraction = 0.4 }\n";
    let hard = WELLS.replace("square-well", "hard-sphere").replace("lambda = 1.5\nwell_depth = 1.0\n", "");
    let place = Place::with(&format!("{hard}{WELL_FLUID}{grow}{}", run_until("0.5")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    started(&place, "next", &run_until("0.5"));
    run(&place, &["next.toml", "--from", "runs/a", "--out", "runs/b"]);
    run(&place, &["scene.toml", "--until-time", "1.0", "--out", "runs/whole"]);
    assert_eq!(last_frame(&place, "runs/b"), last_frame(&place, "runs/whole"));
    assert_eq!(place.summary("runs/b")["diameter_factor"], 1.0);
    started(&place, "large", &format!("{}{}", hard.replace("diameter = 1.0", "diameter = 1.3"), run_until("0.5")));
    refused(&place, &["run", "large.toml", "--from", "runs/a"], &["start.from", "overlap at the start"]);
}

#[test]
fn a_run_that_started_from_another_is_resumed_without_it() {
    let place = Place::with(&format!("{CHAINS}{CHAIN}{}", run_until("1.0")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    started(&place, "next", &run_until("2.0"));
    run(&place, &["next.toml", "--from", "runs/a", "--out", "runs/whole"]);
    run(&place, &["next.toml", "--from", "runs/a", "--until-time", "1.0", "--out", "runs/parts"]);
    fs::rename(place.path().join("runs/a"), place.path().join("runs/away")).unwrap();
    run(&place, &["--resume", "runs/parts", "--until-time", "2.0"]);
    for file in ["thermo.csv", "trajectory.xyz", "scene.toml"] {
        assert_eq!(place.read(&format!("runs/parts/{file}")), place.read(&format!("runs/whole/{file}")), "{file}");
    }
    refused(&place, &["verify", "runs/whole"], &["nothing can start from", "no such folder"]);
    fs::rename(place.path().join("runs/away"), place.path().join("runs/a")).unwrap();
    place.done(&["verify", "runs/whole", "--events", "300"]);
    run(&place, &["--resume", "runs/a", "--until-time", "1.5"]);
    let expected = ["has changed: the checksum of its checkpoint", "without `checksum` any state is accepted"];
    refused(&place, &["verify", "runs/whole"], &expected);
    refused(&place, &["run", "runs/whole/scene.toml", "--out", "runs/b"], &expected);
    run(&place, &["--resume", "runs/whole", "--until-time", "2.5"]);
    refused(&place, &["run", "next.toml", "--from", "runs/a", "--out", "runs/a", "--force"], &["--out"]);
}

#[test]
fn rerun_scene_starts_from_the_end_of_its_run() {
    let place = Place::with(&format!("start_time = 2.0\n{CHAINS}{CHAIN}{}", run_until("0.5")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    started(&place, "next", &format!("{CHAINS}{}", run_until("0.5")));
    run(&place, &["next.toml", "--from", "runs/a", "--out", "runs/next"]);
    let output = place.carom(&["run", "scene.toml", "--from", "runs/a", "--out", "runs/same", "--quiet"]);
    assert!(output.status.success(), "{}", words(&output));
    let note = "left out of the scene: [[chain]], start_time; its start is the end of the run";
    assert!(errors(&output).contains(note), "{}", errors(&output));
    assert_eq!(place.read("runs/same/trajectory.xyz"), place.read("runs/next/trajectory.xyz"));
    let record = place.read("runs/same/scene.toml");
    assert!(record.contains("[start]") && !record.contains("[[chain]]") && !record.contains("start_time"), "{record}");
    run(&place, &["runs/same/scene.toml", "--out", "runs/again"]);
    assert_eq!(place.read("runs/same/trajectory.xyz"), place.read("runs/again/trajectory.xyz"));
}

#[test]
fn invalid_starting_points_are_rejected() {
    let place = Place::with(&format!("{CHAINS}{CHAIN}{}", run_until("0.5")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    started(&place, "next", &run_until("0.5"));
    let next = |text: String| started(&place, "bad", &text);
    let from = |folder: &'static str| ["run", "next.toml", "--from", folder, "--out", "runs/b"];
    refused(&place, &from("runs/none"), &["there is no such folder", "name the folder of a finished run"]);
    fs::create_dir(place.path().join("empty")).unwrap();
    refused(&place, &from("empty"), &["is not the folder of a run"]);
    let bad = ["run", "bad.toml", "--from", "runs/a", "--out", "runs/b"];
    let start = "[start]\nfrom = \"runs/a\"\n";
    let check = ["check", "bad.toml"];
    next(format!("{CHAINS}{CHAIN}{start}{}", run_until("0.5")));
    refused(&place, &check, &["chain[0]", "expected none: particles and bonds come from the run"]);
    next(format!("start_time = 3.0\n{start}{}", run_until("0.5")));
    refused(&place, &check, &["start_time", "time continues"]);
    let set = ["check", "scene.toml", "--from", "runs/a", "--set", "chain.0.count=3"];
    refused(&place, &set, &["chain.0.count", "particles, bonds and time come from the run in [start]"]);
    next(format!("{}{}", CHAINS.replace("bead", "other"), run_until("0.5")));
    refused(&place, &bad, &["48 particles of species `bead`", "expected only species of the scene: other"]);
    next(format!("{}{}", CHAINS.replace("\"link\"", "\"rope\""), run_until("0.5")));
    refused(&place, &bad, &["start.from", "unknown interaction `link`", "`rope`"]);
    next(format!("{}{}", CHAINS.replace("longest = 1.2", "longest = 0.7"), run_until("0.5")));
    refused(&place, &bad, &["start.from", "but their bond allows 0.6 to 0.7"]);
    next(format!("{}{}", CHAINS.replace("8.0, 8.0, 8.0", "9.0, 8.0, 8.0"), run_until("0.5")));
    refused(&place, &bad, &["space.size[0]", "is 9, expected 8, as in the run given by [start]"]);
    next(format!("[space]\nz = \"flat\"\n{}", run_until("0.5")));
    refused(&place, &bad, &["space.z", "is flat, expected not flat, as in the run"]);
    let (species, _) = CHAINS.split_once("[[interaction]]").unwrap();
    next(format!("{species}{}", run_until("0.5")));
    refused(&place, &bad, &["`interaction` is missing"]);
    // Without the summary, the run looks as if it was killed.
    fs::rename(place.path().join("runs/a/summary.json"), place.path().join("runs/a/aside")).unwrap();
    refused(&place, &from("runs/a"), &["the run is not finished", "carom run --resume"]);
    fs::rename(place.path().join("runs/a/aside"), place.path().join("runs/a/summary.json")).unwrap();
    let checkpoint = place.path().join("runs/a/checkpoint");
    let good = fs::read(&checkpoint).unwrap();
    let mut damaged = good.clone();
    damaged[good.len() / 2] ^= 1;
    fs::write(&checkpoint, &damaged).unwrap();
    refused(&place, &from("runs/a"), &["is damaged", "repeat that run"]);
    fs::write(&checkpoint, &good).unwrap();
    assert!(!place.path().join("runs/b").exists());
}

#[test]
fn negative_frame_numbers_count_from_the_end() {
    let place = Place::with(&format!("{CHAINS}{CHAIN}{}", run_until("1.0")));
    run(&place, &["scene.toml", "--out", "runs/a"]);
    let scene = |frame: i32| {
        let file = format!("[[file]]\npath = \"runs/a/trajectory.xyz\"\nframe = {frame}\n");
        started(&place, "next", &format!("{CHAINS}{file}{}", run_until("0.1")));
    };
    scene(-1);
    run(&place, &["next.toml", "--out", "runs/last"]);
    scene(4);
    run(&place, &["next.toml", "--out", "runs/fourth"]);
    assert_eq!(place.read("runs/last/trajectory.xyz"), place.read("runs/fourth/trajectory.xyz"));
    assert!(place.read("runs/last/trajectory.xyz").contains("bonds="), "with the bonds that Carom wrote");
    scene(-6);
    refused(&place, &["check", "next.toml"], &["the file ends after 5 frames, expected frame -6"]);
}
