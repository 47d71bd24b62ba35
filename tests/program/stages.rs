use std::fs;

use serde_json::Value;

use super::place::{Place, code, line, run};

const FLUID: &str = r#"
[[species]]
name = "A"
mass = 1.3
diameter = 1.0
[[species]]
name = "B"
mass = 0.7
diameter = 0.8
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "random"
count = 60
packing_fraction = 0.2
temperature = 1.5
[[fill]]
species = "B"
arrangement = "random"
count = 40
temperature = 1.5
"#;

const MEASURED: &str = "[measure]\nradial_distribution = true\nspeeds = true\nfree_paths = true\npressure_tensor = true\n\
    [output]\nthermo_interval = 0.03125\nframe_interval = 0.25\n";

const TEMPERATURES: [&str; 5] = ["1.5", "1.25", "1.0", "0.75", "0.5"];

fn rows(place: &Place, folder: &str, stage: &str) -> Vec<Vec<String>> {
    let text = place.read(&format!("{folder}/thermo.csv"));
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let summed = ["events", "energy_and_dissipated", "supplied"];
    let is_kept = |at: usize| !summed.contains(&heads[at].split(' ').next().unwrap());
    let cells = |row: &str| {
        let cells = row.split(',').enumerate().filter(|(at, _)| is_kept(*at) && *at + 1 < heads.len());
        cells.map(|(_, cell)| cell.to_owned()).collect()
    };
    text.lines().skip(1).filter(|row| row.ends_with(&format!(",{stage}"))).map(cells).collect()
}

fn agree(a: &Value, b: &Value, at: &str) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{at}");
            a.iter().for_each(|(key, value)| agree(value, &b[key], &format!("{at}.{key}")));
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{at}");
            a.iter().zip(b).for_each(|(a, b)| agree(a, b, at));
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= 1e-10 * a.abs().max(b.abs()) + 1e-12, "{at}: {a} and {b}");
        }
        _ => assert_eq!(a, b, "{at}"),
    }
}

#[test]
fn measured_anneal_is_the_same_in_stages_and_in_runs() {
    let rescaling =
        |temperature: &str| format!("{{ kind = \"rescaling\", temperature = {temperature}, interval = 0.125 }}");
    let andersen = |temperature: &str| format!("{{ kind = \"andersen\", temperature = {temperature}, rate = 0.5 }}");
    let baths: [&dyn Fn(&str) -> String; 2] = [&rescaling, &andersen];
    for (what, bath) in [("rescaling", baths[0]), ("andersen", baths[1])] {
        let plan = |t: &str| format!("equilibration_time = 0.375\nuntil_time = 0.75\nthermostat = {}\n", bath(t));
        let stage = |t: &&str| format!("[[stage]]\nname = \"T{t}\"\nmeasure = true\n{}", plan(t));
        let stages: String = TEMPERATURES[..4].iter().map(stage).collect();
        let place = Place::with(&format!("{FLUID}{stages}[run]\n{}{MEASURED}", plan("0.5")));
        run(&place, &["scene.toml", "--out", "runs/whole"]);
        let whole = place.summary("runs/whole");
        let report = place.read("runs/whole/report.txt");
        let parts: Vec<&str> = report.split("\nstage T").collect();
        assert_eq!(parts.len(), 5, "{report}");
        for part in parts {
            for line in ["results of instruments", "Mean free path", "events by kind and species"] {
                assert!(part.contains(line), "{what}: {line} in {part}");
            }
        }
        let trajectory = place.read("runs/whole/trajectory.xyz");
        for (k, t) in TEMPERATURES.iter().enumerate() {
            let start = if k == 0 { FLUID.to_owned() } else { format!("start.from = \"runs/{}\"\n", k - 1) };
            fs::write(place.path().join("one.toml"), format!("{start}[run]\n{}{MEASURED}", plan(t))).unwrap();
            run(&place, &["one.toml", "--out", &format!("runs/{k}")]);
            let one = place.summary(&format!("runs/{k}"));
            let (name, all, tables) = match k {
                4 => ("measurement".to_owned(), &whole, "runs/whole/measurements".to_owned()),
                _ => (format!("T{t}"), &whole["stages"][k], format!("runs/whole/measurements/T{t}")),
            };
            for key in ["measured", "observables", "equilibrated", "rates", "published"] {
                agree(&all[key], &one[key], &format!("{what}, {t}, {key}"));
            }
            // The first row of the measurement has the number of all earlier events.
            let thermo = place.read("runs/whole/thermo.csv");
            let first = thermo.lines().find(|row| row.ends_with(&format!(",{name}"))).unwrap();
            assert_eq!(all["events"]["before"].to_string(), first.split(',').nth(1).unwrap(), "{what}, {t}");
            for kind in ["total", "core", "capture", "release", "bounce"] {
                assert_eq!(all["events"][kind], one["events"][kind], "{what}, {t}");
            }
            let rows = [("runs/whole".to_owned(), name.as_str()), (format!("runs/{k}"), "measurement")]
                .map(|(folder, stage)| rows(&place, &folder, stage));
            assert_eq!(rows[0].len(), 25, "{what}, {t}");
            for (a, b) in rows[0].iter().flatten().zip(rows[1].iter().flatten()) {
                let [a, b] = [a, b].map(|cell| cell.parse::<f64>().unwrap_or(f64::NEG_INFINITY));
                assert!(a == b || (a - b).abs() < 1e-11 * a.abs(), "{what}, {t}: {a} and {b}");
            }
            let curve = "radial_distribution.csv";
            let table = place.read(&format!("{tables}/{curve}"));
            assert_eq!(table, place.read(&format!("runs/{k}/measurements/{curve}")), "{what}, {t}");
            assert!(trajectory.contains(&place.read(&format!("runs/{k}/trajectory.xyz"))), "{what}, {t}");
        }
    }
}

#[test]
fn stage_before_growth_has_published_values_of_its_own_diameters() {
    let spheres = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "fcc"
count = 108
packing_fraction = 0.2
temperature = 1.0
"#;
    let stages = "[[stage]]\nname = \"dilute\"\nmeasure = true\nuntil_events = 2000\n\
        [[stage]]\nname = \"grow\"\ngrow = { rate = 0.1, packing_fraction = 0.3 }\n";
    let place = Place::with(&format!("{spheres}{stages}[run]\nuntil_events = 2000\n"));
    run(&place, &["scene.toml", "--out", "runs/whole"]);
    fs::write(place.path().join("one.toml"), format!("{spheres}[run]\nuntil_events = 2000\n")).unwrap();
    run(&place, &["one.toml", "--out", "runs/one"]);
    let (whole, one) = (place.summary("runs/whole"), place.summary("runs/one"));
    assert!(one["published"].as_array().is_some_and(|all| all.len() > 1));
    agree(&whole["stages"][0]["published"], &one["published"], "published");
    assert_ne!(whole["published"], one["published"]);
    assert_eq!(whole["stages"][0]["diameter_factor"], 1.0);
}

#[test]
fn heat_bath_changes_degrees_of_freedom_only_in_its_stage() {
    let scene = r#"
[space]
size = [6.0, 6.0, 6.0]
[[species]]
name = "A"
mass = 2.7
diameter = 1.0
[[species]]
name = "B"
mass = 0.6
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[particle]]
species = "A"
position = [1.0, 3.0, 3.0]
velocity = [1.0, 0.2, 0.0]
[[particle]]
species = "B"
position = [4.0, 3.0, 3.0]
velocity = [-2.0, 0.0, 0.3]
[[stage]]
name = "free"
measure = true
until_time = 10.0
[[stage]]
name = "bath"
measure = true
until_time = 20000.0
thermostat = { kind = "andersen", temperature = 1.5, rate = 1.0 }
[run]
until_time = 10.0
thermostat = { kind = "andersen", temperature = 1.5, rate = 1.0 }
[output]
frame_interval = 10000.0
thermo_interval = 10.0
"#;
    let place = Place::with(scene);
    run(&place, &["scene.toml", "--out", "runs/a"]);
    let summary = place.summary("runs/a");
    let of = |value: &Value| value["observables"]["temperature"]["mean"].as_f64().unwrap();
    // With the reduced mass mu and the relative velocity v, the kinetic energy without the centre of mass is K' = 0.5
    // mu |v|^2. The expected temperature is 2 K' / 3.
    let free = 2.7 * 0.6 / 3.3 * (3.0_f64.powi(2) + 0.2_f64.powi(2) + 0.3_f64.powi(2)) / 3.0;
    let measured = of(&summary["stages"][0]);
    assert!((measured - free).abs() < 1e-12 * free, "{measured} and {free}");
    // The heat bath drives the centre of mass, too.
    let stage = &summary["stages"][1];
    let error = stage["observables"]["temperature"]["standard_error"].as_f64().unwrap();
    assert!((of(stage) - 1.5).abs() < 4.0 * error && error < 0.03, "{} +- {error}", of(stage));
}

fn gate_at(height: f64) -> String {
    format!(
        r#"
[space]
size = [6.0, 6.0, 6.0]
x = "walls"
y = "walls"
z = "walls"

[[species]]
name = "ball"
mass = 1.3
diameter = 1.0

[[interaction]]
species = ["ball", "ball"]
potential = "hard-sphere"

[[particle]]
species = "ball"
position = [2.0, 2.0, 3.0]

[[particle]]
species = "ball"
position = [4.0, 4.0, 1.5]
velocity = [0.0, 0.0, 0.25]

[[surface]]
name = "gate"
shape = "parallelogram"
corner = [0.0, 0.0, {height:?}]
edge_1 = [6.0, 0.0, 0.0]
edge_2 = [0.0, 6.0, 0.0]
stages = ["closed"]

[[stage]]
name = "open"
until_time = 4.0

[[stage]]
name = "closed"
until_time = 1.0

[run]
until_time = 1.0
"#
    )
}

#[test]
fn surface_that_appears_inside_a_grain_is_named_in_the_error() {
    // At time 4, the gate appears and the second ball is at a height of 2.5.
    let place = Place::with(&gate_at(2.75));
    let output = place.carom(&["run", "scene.toml", "-q"]);
    let told = line(&output);
    assert_eq!(code(&output), 1, "{told}");
    for expected in [
        "surface `gate` appears with the stage `closed` at time 4, but particle",
        "it extends 0.25 through the surface",
        "help: let the surface exist from the start",
    ] {
        assert!(told.contains(expected), "{expected}: {told}");
    }
    assert!(!told.contains("bug in Carom"), "it is the scene's fault: {told}");
    let summary = place.summary("runs/scene");
    assert_eq!((&summary["ending"], &summary["time"]), (&"blocked".into(), &4.0.into()));
    // Between the balls, there is room for the gate.
    let place = Place::with(&gate_at(2.5).replace("[4.0, 4.0, 1.5]", "[4.0, 4.0, 0.75]"));
    place.done(&["run", "scene.toml", "-q"]);
}
