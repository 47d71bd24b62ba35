//! Runs in which particles enter and leave.

use std::collections::BTreeMap;

use super::place::{Place, errors, words};
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
    place.done(&["run", "scene.toml", "--out", "rain", "--quiet"]);
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
    place.done(&["run", "scene.toml", "--out", "rain", "--quiet"]);
    let verified = place.carom(&["verify", "rain"]);
    let told = words(&verified);
    assert!(told.contains("NOTHING PROVEN") && !told.contains("differ"), "{told}");
    assert!(errors(&verified).contains("inlets and outlets"), "{}", errors(&verified));
    let report = place.carom(&["report", "rain"]);
    assert!(report.status.success() && errors(&report).contains("particles enter or leave"), "{}", errors(&report));
    place.done(&["render", "rain", "--size", "120x160"]);
    place.refused(&["live", "scene.toml"], &["particles enter or leave"]);
}

#[test]
fn run_starts_from_the_end_of_a_flow() {
    let place = Place::with(RAIN);
    place.done(&["run", "scene.toml", "--out", "first", "--quiet", "--until-time", "20"]);
    place.done(&["run", "scene.toml", "--from", "first", "--out", "next", "--quiet", "--until-time", "20"]);
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
    let told = words(&run);
    assert!(told.contains("wait for a free place: the inlet cannot keep its rate"), "{told}{}", errors(&run));
    let inlet = &place.summary("rain")["inlets"][0];
    let of = |key: &str| inlet[key].as_f64().unwrap();
    assert_eq!(of("entered") + of("waiting"), (9.0_f64 * 9.0 * 3.0 / 2.9).floor() + 1.0);
    assert!(of("waiting") > 10.0 && of("blocked") > 10.0, "{inlet}");
}

/// The rain with grains that fall at the start, and return from the drain to the cloud.
fn circulating(region: &str) -> String {
    let inlet = "composition = { grain = 2, dust = 1 }\nregion = { lower = [0.0, 0.0, 20.0], upper = [8.0, 7.0, 29.0] }\nmass_rate = 9.0\n";
    assert!(RAIN.contains(inlet));
    let fill = "[[fill]]\ncomposition = { grain = 2, dust = 1 }\narrangement = \"random\"\ncount = 60\n\
        region = { lower = [0.0, 0.0, 3.0], upper = [8.0, 7.0, 19.0] }\n\n[run]";
    let circulating = RAIN.replace(inlet, &format!("{region}\nrecirculate = [\"drain\"]\n")).replace("[run]", fill);
    format!("{circulating}\n[measure]\nresidence_times = {{ bins = 20 }}\n")
}

#[test]
fn grains_that_leave_return_and_their_residence_times_are_measured() {
    let place = Place::with(&circulating("region = { lower = [0.0, 0.0, 20.0], upper = [8.0, 7.0, 29.0] }"));
    let check = place.carom(&["check", "scene.toml"]);
    let told = words(&check);
    assert!(told.contains("cloud: what leaves at drain in a box"), "{told}");
    place.done(&["run", "scene.toml", "--out", "mill", "--quiet"]);
    let number = |row: &BTreeMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
    let rows = place.thermo("mill");
    assert!(rows.iter().all(|row| number(row, "particles") == 60.0), "all grains return at once");
    let results = place.summary("mill");
    assert_eq!(results["faults"], Value::Array(Vec::new()));
    let inlet = &results["inlets"][0];
    assert_eq!((&inlet["returned"], &inlet["waiting"]), (&results["events"]["exit"], &Value::from(0)));
    assert_eq!(inlet["entered"], inlet["returned"]);
    let table = place.read("mill/report.txt");
    let returned = inlet["returned"].as_u64().unwrap();
    assert!(table.contains(&format!("{returned} entered in all, including {returned} that returned\n")), "{table}");
    let measured: Value = serde_json::from_str(&place.read("mill/measurements.json")).unwrap();
    let of = |name: &str| {
        let numbers = measured["numbers"].as_array().unwrap();
        numbers.iter().find(|number| number["name"] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    let mean = |name: &str| of(name)["mean"].as_f64().unwrap();
    assert_eq!(mean("residence_time_count") + mean("residence_time_from_start"), returned as f64);
    assert_eq!(mean("residence_time_unfinished") + mean("residence_time_count"), returned as f64);
    let by_species = ["grain", "dust"].map(|name| mean(&format!("residence_time_count_{name}")));
    assert_eq!(by_species[0] + by_species[1], mean("residence_time_count"));
    // A fall from the middle of the inlet takes a time of 7. Grains hold one another, but hardly slow down.
    assert!((6.0..8.5).contains(&mean("residence_time")) && mean("residence_time_deviation") < 2.0, "{measured}");
    for name in ["residence_times", "residence_times_grain", "residence_times_dust"] {
        assert_eq!(place.read(&format!("mill/measurements/{name}.csv")).lines().count(), 21, "{name}");
    }
    let verified = place.carom(&["verify", "mill"]);
    let told = words(&verified);
    assert!(told.contains("NOTHING PROVEN") && !told.contains("differ"), "{told}");
}

#[test]
fn grains_that_wait_are_reported_and_are_in_checkpoints() {
    let narrow =
        circulating("region = { lower = [3.0, 3.0, 20.0], upper = [4.2, 4.2, 21.2] }\nvelocity = [0.0, 0.0, -0.1]");
    let place = Place::with(&narrow);
    let whole = place.done(&["run", "scene.toml", "--out", "whole", "--quiet", "--until-time", "30"]);
    let waiting = |folder: &str| place.summary(folder)["inlets"][0]["waiting"].as_u64().unwrap();
    let last = place.thermo("whole").pop().unwrap();
    assert_eq!(last["particles"].parse::<u64>().unwrap() + waiting("whole"), 60, "{last:?}");
    assert!(waiting("whole") > 10, "{last:?}");
    let told = words(&whole);
    assert!(told.contains("that returned, and") && !told.contains("cannot keep its rate"), "{told}");
    // The first part ends while grains wait.
    let part = place.carom(&["run", "scene.toml", "--out", "parts", "--quiet", "--until-time", "11"]);
    assert!(part.status.success() && waiting("parts") > 10, "{}", errors(&part));
    place.done(&["run", "--resume", "parts", "--quiet", "--until-time", "30"]);
    for file in ["thermo.csv", "trajectory.xyz"] {
        assert_eq!(place.read(&format!("whole/{file}")), place.read(&format!("parts/{file}")), "{file}");
    }
    let numbers = |folder: &str| -> Value {
        let measured: Value = serde_json::from_str(&place.read(&format!("{folder}/measurements.json"))).unwrap();
        measured["numbers"].clone()
    };
    assert_eq!(numbers("whole"), numbers("parts"));
    assert_eq!(place.summary("whole")["inlets"], place.summary("parts")["inlets"]);
}
