use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use super::files::files;

/// Scenes for every kind of engine and driving, with numbers of events.
pub const SCENES: [(&str, &str); 12] = [
    ("hard_sphere_fluid", "300000"),
    ("polymer", "150000"),
    ("pendulum", "400000"),
    ("hopper", "60000"),
    ("granular_cooling", "150000"),
    ("heat_flux", "100000"),
    ("grown", "100000"),
    ("sheared", "60000"),
    ("isobaric", "60000"),
    ("circulating_silo", "60000"),
    ("heap", "60000"),
    ("swaps", "60000"),
];

pub const GROWN: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 0.7
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "random"
count = 500
packing_fraction = 0.2
temperature = 1.0
[[stage]]
name = "compress"
grow = { rate = 0.05, packing_fraction = 0.5 }
thermostat = { kind = "rescaling", temperature = 1.0, interval = 0.3 }
[[stage]]
name = "jam"
grow = { rate = 0.2, compressibility_factor = 14.0 }
thermostat = { kind = "rescaling", temperature = 1.0, interval = 0.1 }
[[stage]]
name = "heat"
measure = true
equilibration = "auto"
equilibration_events = 30_000
until_events = 60_000
thermostat = { kind = "andersen", temperature = 2.0, rate = 5.0 }
[run]
thermostat = { kind = "andersen", temperature = 2.0, rate = 0.5 }
equilibration = "auto"
equilibration_events = 150_000
until_events = 1000
[measure]
pressure_tensor = true
radial_distribution = true
diffusion = true
free_paths = true
speeds = true
bond_order = true
particle_stress = true
[[measure.stress]]
name = "cells"
bins = [2, 1, 3]
"#;

pub const SHEARED: &str = r#"
[space]
shear_rate = 0.5
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.3
well_depth = 0.5
[[fill]]
species = "A"
arrangement = "fcc"
count = 500
packing_fraction = 0.3
temperature = 1.0
[run]
thermostat = { kind = "rescaling", temperature = 1.0, interval = 0.2 }
until_events = 1000
[measure]
pressure_tensor = true
radial_distribution = true
structure_factor = true
diffusion = true
free_paths = true
speeds = true
bond_order = true
contacts = { duration = 0.3 }
[[measure.profile]]
name = "layers"
bins = [1, 10, 1]
"#;

pub const ISOBARIC: &str = r#"
[[species]]
name = "A"
mass = 1.3
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 0.4
[[interaction]]
name = "link"
potential = "bond"
shortest = 1.0
longest = 1.3
[space]
size = [7.0, 8.0, 7.5]
[[chain]]
species = "A"
bond = "link"
count = 4
length = 12
temperature = 1.0
[[fill]]
species = "A"
arrangement = "random"
count = 60
temperature = 1.0
[[stage]]
name = "press"
until_time = 8.0
thermostat = { kind = "andersen", temperature = 1.2, rate = 2.0 }
barostat = { pressure = 1.5, interval = 0.03 }
[run]
thermostat = { kind = "andersen", temperature = 1.2, rate = 0.5 }
barostat = { pressure = 0.8, interval = 0.02 }
until_events = 1000
[measure]
speeds = true
chains = true
"#;

/// Spheres of several sizes exchange their species.
pub const SWAPS: &str = r#"
seed = 3
[[species]]
name = "sphere"
mass = 1.3
diameter = { distribution = "uniform", lower = 0.6, upper = 1.6, classes = 7 }
[[interaction]]
species = ["sphere", "sphere"]
potential = "hard-sphere"
[[fill]]
species = "sphere"
arrangement = "random"
count = 120
packing_fraction = 0.30
temperature = 1.0
[[stage]]
name = "mix"
until_time = 6.0
swap = { interval = 0.03 }
[run]
swap = { interval = 0.02, largest_ratio = 1.5 }
until_events = 1000
[measure]
relaxation = { span = 0.5 }
radial_distribution = true
"#;

/// Grains rain onto a floor with a hole, and fall asleep there.
pub const HEAP: &str = r#"
[space]
size = [7.0, 6.0, 20.0]
x = "walls"
z = "open"
[dynamics]
gravity = [0.0, 0.0, -1.0]
contact_time = 0.01
sleep = { interval = 0.25, distance = 0.01, wake_speed = 0.2 }
[[species]]
name = "A"
mass = 1.3
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
restitution = 0.5
friction = 0.5
[[surface]]
name = "floor"
shape = "box"
lower = [0.0, -1.0, 1.0]
upper = [5.5, 7.0, 2.0]
restitution = 0.5
friction = 0.5
[[surface]]
name = "drain"
shape = "plane"
point = [0.0, 0.0, 0.5]
normal = [0.0, 0.0, 1.0]
outlet = true
[[inlet]]
name = "rain"
species = "A"
region = { lower = [0.5, 0.5, 15.0], upper = [6.5, 5.5, 19.0] }
rate = 3.0
[run]
until_events = 1000
"#;

pub fn carom(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn finish(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

pub fn start(scene: &str, events: &str, folder: &Path) -> Command {
    let text = match scene {
        "grown" => Some(GROWN),
        "sheared" => Some(SHEARED),
        "isobaric" => Some(ISOBARIC),
        "heap" => Some(HEAP),
        "swaps" => Some(SWAPS),
        _ => None,
    };
    let scene = text.map_or_else(
        || format!("{}/configs/{scene}.toml", env!("CARGO_MANIFEST_DIR")),
        |text| {
            let path = folder.with_file_name(format!("{scene}.toml"));
            fs::write(&path, text).unwrap();
            path.to_string_lossy().into_owned()
        },
    );
    let mut command = carom(&["run", &scene, "--quiet", "--until-events", events, "--checkpoint-every", "0.01"]);
    let equilibration = match () {
        () if scene.contains("hard_sphere") => "100000",
        // The equilibration must end by its own criterion, not at this limit.
        () if scene.ends_with("grown.toml") => "150000",
        () => "1000",
    };
    command.arg("--set").arg("output.events=true");
    command.arg("--set").arg(format!("run.equilibration_events={equilibration}"));
    command.arg("--set").arg("output.contacts=true").arg("--out").arg(folder);
    command
}

pub fn resume(folder: &Path) -> Command {
    let mut command = carom(&["run", "--quiet", "--checkpoint-every", "0.01", "--resume"]);
    command.arg(folder);
    command
}

/// Stops a run by SIGKILL, SIGTERM or SIGINT. Returns whether the run was still running.
pub fn stop(child: &mut Child, way: u32) -> bool {
    if child.try_wait().unwrap().is_some() {
        return false;
    }
    match way {
        0 => child.kill().unwrap(),
        _ => {
            let signal = if way == 1 { "-TERM" } else { "-INT" };
            let _ = Command::new("kill").arg(signal).arg(child.id().to_string()).status().unwrap();
        }
    }
    !child.wait().unwrap().success()
}

/// Returns the results that depend only on the scene and the seed.
pub fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut results = Vec::new();
    for name in ["thermo.csv", "trajectory.xyz", "contacts.csv", "scene.toml"] {
        results.push((name.to_owned(), fs::read(folder.join(name)).unwrap()));
    }
    for (sub, is_needed) in [("events", true), ("measurements", false)] {
        if !folder.join(sub).exists() {
            assert!(!is_needed, "{sub}");
            continue;
        }
        results.extend(files(&folder.join(sub)));
    }
    let summary = fs::read(folder.join("summary.json")).unwrap();
    let mut summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    summary.as_object_mut().unwrap().remove("speed");
    for stage in summary.get_mut("stages").and_then(|stages| stages.as_array_mut()).into_iter().flatten() {
        stage.as_object_mut().unwrap().remove("speed");
    }
    results.push(("summary.json".to_owned(), summary.to_string().into_bytes()));
    results
}

pub fn assert_same(one: &Path, other: &Path, what: &str) {
    let (one, other) = (results(one), results(other));
    assert_eq!(one.len(), other.len(), "{what}");
    for ((name, one), (_, other)) in one.into_iter().zip(other) {
        assert!(!one.is_empty(), "{what}: {name} is empty");
        assert!(one == other, "{what}: {name} differs");
    }
}

pub fn unwrapped(message: &[u8]) -> String {
    let message = String::from_utf8_lossy(message).replace('│', " ");
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub fn files_of(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// Makes a finished run look like a killed run. Files get temporary names and incomplete data.
pub fn unfinish(folder: &Path) {
    fs::remove_file(folder.join("summary.json")).unwrap();
    for name in ["thermo.csv", "trajectory.xyz", "contacts.csv", "scene.toml", "events/kind.npy"] {
        let partial = folder.join(format!("{name}.partial"));
        fs::rename(folder.join(name), &partial).unwrap();
        if name != "scene.toml" {
            let mut bytes = fs::read(&partial).unwrap();
            bytes.extend(b"half of a li");
            fs::write(&partial, bytes).unwrap();
        }
    }
}
