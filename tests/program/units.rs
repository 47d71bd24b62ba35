//! Names of units in outputs.

use super::place::{FLUID, Place, code, errors, words};

const UNITS: &str = "\n[units]\nlength = 'mm'\nmass = 'g'\ntime = 'ms'\n";

#[test]
fn outputs_contain_the_names_of_units_and_the_same_numbers() {
    let scene = format!("{FLUID}\n[measure]\nradial_distribution = true\npressure_tensor = true\n");
    let runs = [scene.clone(), format!("{scene}{UNITS}")].map(|scene| {
        let place = Place::with(&scene);
        let output = place.done(&["run", "scene.toml"]);
        place.done(&["report", "runs/scene"]);
        (words(&output), place)
    });
    let [(_, plain), (shown, named)] = &runs;
    for text in ["[g mm^2 / ms^2]", "[g / (mm ms^2)]", "at t = ", " ms, "] {
        assert!(shown.contains(text), "{text}: {shown}");
    }
    let [before, after] = [plain, named].map(|place| place.read("runs/scene/thermo.csv"));
    assert!(before == after, "units change no number");
    let summary: serde_json::Value = serde_json::from_str(&named.read("runs/scene/summary.json")).unwrap();
    assert_eq!(summary["units"], serde_json::json!({ "length": "mm", "mass": "g", "time": "ms" }));
    let columns = summary["columns"]["thermo.csv"].as_array().unwrap();
    let unit = |name: &str| columns.iter().find(|column| column["name"] == name).unwrap()["unit"].clone();
    assert_eq!([unit("time"), unit("kinetic"), unit("collision_rate")], ["ms", "g mm^2 / ms^2", "1 / ms"]);
    for (file, is_html) in [("summary.json", false), ("measurements.json", false), ("report.html", true)] {
        let text = named.read(&format!("runs/scene/{file}"));
        for word in ["length", "mass", "time", "energy"] {
            let unit = if is_html { format!("[{word}") } else { format!("\"unit\": \"{word}") };
            assert!(!text.contains(&unit), "{file}: {unit}");
        }
        assert!(text.contains(if is_html { "mm²" } else { "ms^2" }), "{file}");
    }
    assert!(named.read("runs/scene/report.html").contains("time [ms]"));
    let summary: serde_json::Value = serde_json::from_str(&plain.read("runs/scene/summary.json")).unwrap();
    assert!(summary.get("units").is_none());
}

#[test]
fn next_run_has_the_units_of_the_run_from_which_it_starts() {
    let place = Place::with(&format!("{FLUID}{UNITS}"));
    place.done(&["run", "scene.toml"]);
    let next = |name: &str, units: &str| {
        place.write(name, &format!("[start]\nfrom = 'runs/scene'\n[run]\nuntil_events = 100\n{units}"));
        place.carom(&["run", name])
    };
    let inherited = next("next.toml", "");
    assert_eq!(code(&inherited), 0, "{}", errors(&inherited));
    assert!(words(&inherited).contains("[g mm^2 / ms^2]"), "{}", words(&inherited));
    let other = next("other.toml", &UNITS.replace("'g'", "'kg'"));
    assert_eq!(code(&other), 2);
    let expected = "expected the units of the earlier run, mm, g and ms: no number is converted";
    assert!(errors(&other).contains(expected), "{}", errors(&other));
}
