//! Normalisation of curves as stated in `measurements.json`.

use serde_json::Value;

use super::place::{FLUID, Place, run};

const MEASURED: &str = r#"
[measure]
radial_distribution = true
structure_factor = true
diffusion = true
transport = true
free_paths = true
speeds = true
bond_order = true
particle_stress = true
profile = [{ name = "z", bins = [1, 1, 5] }]
flow = [{ name = "up", axis = "z", at = 0.1 }]
"#;

fn undone(series: &Value) -> Vec<Option<f64>> {
    let divisors = series["normalisation"]["divisors"].as_array().unwrap();
    let values = series["values"].as_array().unwrap();
    let by = |divisor: &Value, row: usize| {
        let all = divisor["values"].as_array().unwrap();
        assert!(all.len() == 1 || all.len() == values.len(), "{divisor}");
        assert!(divisor["name"].is_string() && divisor["unit"].is_string(), "{divisor}");
        all[if all.len() == 1 { 0 } else { row }].as_f64().unwrap()
    };
    let product = |row: usize| divisors.iter().map(|divisor| by(divisor, row)).product::<f64>();
    values.iter().enumerate().map(|(row, value)| Some(value.as_f64()? * product(row))).collect()
}

fn divisor(series: &Value, name: &str) -> f64 {
    let divisors = series["normalisation"]["divisors"].as_array().unwrap();
    divisors.iter().find(|divisor| divisor["name"] == name).unwrap()["values"][0].as_f64().unwrap()
}

#[test]
fn curves_times_their_normalisation_are_whole_counts() {
    let place = Place::with(&format!("{FLUID}{MEASURED}"));
    run(&place, &["scene.toml"]);
    let text = place.read("runs/scene/measurements.json");
    let measurements: Value = serde_json::from_str(&text).unwrap();
    let curves = measurements["curves"].as_array().unwrap();
    assert!(curves.len() >= 12, "{} curves", curves.len());
    for curve in curves {
        for series in curve["series"].as_array().unwrap() {
            assert!(series["normalisation"]["sum"].is_string(), "{}: {}", curve["name"], series["name"]);
            undone(series);
        }
    }
    let series = |name: &str| &curves.iter().find(|curve| curve["name"] == name).unwrap()["series"][0];
    for (name, least) in
        [("radial_distribution", 1000.0), ("speeds", 1000.0), ("profile_z", 1000.0), ("free_times", 1000.0)]
    {
        let counts: Vec<f64> = undone(series(name)).into_iter().flatten().collect();
        for count in &counts {
            assert!((count - count.round()).abs() < 1e-9 * count.max(1.0), "{name}: {count}");
        }
        assert!(counts.iter().sum::<f64>() > least, "{name}");
    }
    // Every sample counts each particle once, by speed and by cell.
    for (name, particles) in [("speeds", divisor(series("speeds"), "particles")), ("profile_z", 108.0)] {
        let all = undone(series(name)).into_iter().flatten().sum::<f64>();
        assert!((all / (divisor(series(name), "samples") * particles) - 1.0).abs() < 1e-9, "{name}: {all}");
        assert_eq!(particles, 108.0);
    }
    let squares: Vec<f64> = undone(series("mean_squared_displacement")).into_iter().flatten().collect();
    assert!(squares[0] == 0.0 && squares[1..].iter().all(|square| *square > 0.0), "{squares:?}");
}
