//! Runs in which particles enter and leave.

use std::collections::BTreeMap;

use super::place::{Place, code, errors};
use serde_json::Value;

/// A box with a floor that lets grains through, below an inlet. Its grains are captured by one another.
const RAIN: &str = r#"
seed = 4

[space]
size = [8.0, 7.0, 30.0]
x = "walls"
y = "walls"
z = "open"

[dynamics]
gravity = [0.0, 0.0, -1.0]

[[species]]
name = "grain"
mass = 1.3
diameter = 1.0

[[species]]
name = "dust"
mass = 0.3
diameter = 0.5

[[interaction]]
species = ["grain", "grain"]
potential = "square-well"
lambda = 1.3
well_depth = 0.2
restitution = 0.9

[[interaction]]
species = ["grain", "dust"]
potential = "hard-sphere"

[[interaction]]
species = ["dust", "dust"]
potential = "hard-sphere"

[[surface]]
name = "drain"
shape = "plane"
point = [0.0, 0.0, 1.0]
normal = [0.0, 0.0, 1.0]
outlet = true

[[inlet]]
name = "cloud"
composition = { grain = 2, dust = 1 }
region = { lower = [0.0, 0.0, 20.0], upper = [8.0, 7.0, 29.0] }
mass_rate = 9.0
temperature = 0.1

[run]
until_time = 40.0

[output]
thermo_interval = 0.5
frame_interval = 4.0
formats = ["gsd", "lammps", "vtk"]

[[measure.profile]]
name = "height"
bins = [1, 1, 15]
"#;

/// Numbers of particles in the frames of a trajectory.
fn counts(place: &Place, folder: &str) -> Vec<usize> {
    place.read(&format!("{folder}/trajectory.xyz")).lines().filter_map(|line| line.parse().ok()).collect()
}

#[test]
fn rows_frames_and_results_follow_the_number_of_particles() {
    let place = Place::with(RAIN);
    let run = place.carom(&["run", "scene.toml", "--out", "rain", "--quiet"]);
    assert!(run.status.success(), "{}", errors(&run));
    let number = |row: &BTreeMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
    let rows = place.thermo("rain");
    for row in &rows {
        assert_eq!(number(row, "particles"), number(row, "entered") - number(row, "left"), "{row:?}");
        let balance = number(row, "energy_and_dissipated");
        assert!(balance.abs() < 1e-9 * number(row, "supplied").abs().max(1.0), "{row:?}");
    }
    // The mean mass is 2.9 / 3, so that 9 * 3 / 2.9 particles are due in a unit of time.
    let entered = number(rows.last().unwrap(), "entered");
    assert_eq!(entered, (40.0_f64 * 9.0 * 3.0 / 2.9).floor() + 1.0);
    let of_rows: Vec<usize> = rows.iter().step_by(8).map(|row| row["particles"].parse().unwrap()).collect();
    assert_eq!(counts(&place, "rain"), of_rows);
    let results = place.summary("rain");
    assert_eq!(results["faults"], Value::Array(Vec::new()));
    assert_eq!(results["events"]["entry"].as_f64(), Some(entered));
    assert_eq!(results["inlets"][0]["entered"].as_f64(), Some(entered));
    let of = |name: &str| results["observables"][name]["mean"].as_f64().unwrap();
    assert!((of("entry_rate") - entered / 40.0).abs() < 1e-9 && of("exit_rate") > 5.0, "{results}");
    for other in ["temperature", "pressure", "collision_rate"] {
        assert!(results["observables"].get(other).is_none(), "{other}");
    }
    // Three quarters of the mass that is there has left the inlet, and moves faster the lower it is.
    let profile = place.read("rain/measurements/profile_height.csv");
    let speeds: Vec<f64> = profile.lines().skip(1).filter_map(|line| line.split(',').nth(7)?.parse().ok()).collect();
    assert!(speeds.len() > 10 && speeds[1] < -4.0 && speeds[speeds.len() - 1] > -2.0, "{profile}");
    for format in ["gsd", "lammps", "vtk"] {
        assert!(place.path().join("rain").read_dir().unwrap().any(|it| {
            it.unwrap().file_name().to_string_lossy().contains(if format == "lammps" { "lammpstrj" } else { format })
        }));
    }
    let arrays = place.carom(&["convert", "rain/trajectory.xyz", "--to", "npy"]);
    assert!(
        !arrays.status.success() && errors(&arrays).contains("arrays need the same particles"),
        "{}",
        errors(&arrays)
    );
}

#[test]
fn files_of_a_flow_are_equal_to_those_of_a_replay_and_nothing_is_proven() {
    let place = Place::with(&RAIN.replace("until_time = 40.0", "until_time = 15.0"));
    assert!(place.carom(&["run", "scene.toml", "--out", "rain", "--quiet"]).status.success());
    let verified = place.carom(&["verify", "rain"]);
    let told = String::from_utf8_lossy(&verified.stdout).into_owned();
    assert!(told.contains("NOTHING PROVEN") && !told.contains("differ"), "{told}");
    assert!(errors(&verified).contains("inlets and outlets"), "{}", errors(&verified));
    let report = place.carom(&["report", "rain"]);
    assert!(report.status.success() && errors(&report).contains("particles enter or leave"), "{}", errors(&report));
    let picture = place.carom(&["render", "rain", "--size", "120x160"]);
    assert!(picture.status.success(), "{}", errors(&picture));
    let live = place.carom(&["live", "scene.toml"]);
    assert_eq!(code(&live), 2);
    assert!(errors(&live).contains("particles enter or leave"), "{}", errors(&live));
}

#[test]
fn run_starts_from_the_end_of_a_flow() {
    let place = Place::with(RAIN);
    let first = place.carom(&["run", "scene.toml", "--out", "first", "--quiet", "--until-time", "20"]);
    assert!(first.status.success(), "{}", errors(&first));
    let next = place.carom(&["run", "scene.toml", "--from", "first", "--out", "next", "--quiet", "--until-time", "20"]);
    assert!(next.status.success(), "{}", errors(&next));
    let (last, first) = (place.thermo("first").pop().unwrap(), place.thermo("next").remove(0));
    for key in ["particles", "kinetic", "potential", "height"] {
        assert_eq!(last[key], first[key], "{key}");
    }
    assert_eq!((first["entered"].as_str(), first["left"].as_str()), ("0", "0"));
    let results = place.summary("next");
    assert_eq!(results["faults"], Value::Array(Vec::new()));
    assert!(results["events"]["exit"].as_f64().unwrap() > 100.0, "{results}");
}

#[test]
fn full_inlet_tells_how_many_particles_wait() {
    let full = RAIN
        .replace("upper = [8.0, 7.0, 29.0]", "upper = [1.2, 1.2, 21.2]")
        .replace("until_time = 40.0", "until_time = 9.0");
    let place = Place::with(&full);
    let run = place.carom(&["run", "scene.toml", "--out", "rain", "--quiet"]);
    let told = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(told.contains("wait for a free place: the inlet cannot keep its rate"), "{told}{}", errors(&run));
    let inlet = &place.summary("rain")["inlets"][0];
    let of = |key: &str| inlet[key].as_f64().unwrap();
    assert_eq!(of("entered") + of("waiting"), (9.0_f64 * 9.0 * 3.0 / 2.9).floor() + 1.0);
    assert!(of("waiting") > 10.0 && of("blocked") > 10.0, "{inlet}");
}
