//! All instruments in scenes in which almost nothing happens. Each run must end and report only finite numbers.

use std::ops::ControlFlow;

use carom::model::Scene;
use carom::run::Run;

const SPECIES: &str = "
    species = [
        { name = 'A', mass = 1.3, diameter = 1.0 },
        { name = 'B', mass = 2.0, diameter = 0.5 },
        { name = 'S', static = true, diameter = 1.0 },
    ]
    interaction = [
        { species = ['A', 'A'], potential = 'hard-sphere' },
        { species = ['A', 'B'], potential = 'hard-sphere' },
        { species = ['A', 'S'], potential = 'hard-sphere' },
        { name = 'spring', potential = 'bond', diameter = 1.0, lambda = 1.5 },
    ]
    ";

const MEASURE: &str = "
    [measure]
    diffusion = true
    transport = true
    free_paths = true
    speeds = true
    bond_order = true
    particle_stress = true
    radial_distribution = true
    structure_factor = true
    pressure_tensor = true
    chains = true
    profile = [{ name = 'all', bins = [2, 1, 1] }]
    flow = [{ name = 'through', axis = 'x', at = 0.0 }]
    ";

const BOXES: [&str; 5] = [
    "space = { size = [9.0, 9.0, 9.0] }",
    "space = { size = [9.0, 9.0, 9.0], x = 'open', y = 'open', z = 'open' }",
    "space = { size = [9.0, 9.0, 9.0], x = 'walls', y = 'walls', z = 'walls' }",
    "space = { size = [9.0, 9.0, 0.0], z = 'flat' }",
    "space = { size = [9.0, 9.0, 9.0], shear_rate = 0.1 }",
];

const PARTICLES: [&str; 6] = [
    "particle = [{ species = 'A', position = [1.0, 1.0, Z] }]",
    "particle = [{ species = 'A', position = [1.0, 1.0, Z], velocity = [1.0, 0.0, 0.0] }]",
    "particle = [{ species = 'A', position = [1.0, 1.0, Z] }, { species = 'A', position = [3.0, 3.0, Z] }]",
    "particle = [{ species = 'A', position = [1.0, 1.0, Z] }, { species = 'A', position = [3.0, 1.0, Z], velocity = [-1.0, 0.0, 0.0] }]",
    "particle = [{ species = 'A', position = [1.0, 1.0, Z] }, { species = 'B', position = [3.0, 3.0, Z] }, { species = 'S', position = [6.0, 6.0, Z] }]",
    "particle = [{ species = 'A', position = [1.0, 1.0, Z] }, { species = 'A', position = [2.2, 1.0, Z] }]\nbond = [{ particles = [0, 1], interaction = 'spring' }]",
];

const LIMITS: [&str; 5] = [
    "run = { until_events = 20 }",
    "run = { until_events = 1000 }",
    "run = { until_time = 1e-300 }",
    "run = { until_time = 3.0 }",
    "run = { until_time = 3.0, until_events = 1000 }",
];

/// Builds the scene without the instruments that are rejected in this scene.
fn without_refused(text: &str) -> Option<Scene> {
    let mut lines: Vec<&str> = text.lines().collect();
    loop {
        match Scene::from_toml(lines.join("\n"), "degenerate.toml") {
            Ok(scene) => return Some(scene),
            Err(error) => {
                let at = error.config_path().to_string();
                let key = at.strip_prefix("measure.")?.split(['.', '[']).next()?.to_owned();
                let line = lines.iter().position(|line| line.trim_start().starts_with(&key))?;
                lines.remove(line);
            }
        }
    }
}

#[test]
fn instruments_report_only_finite_numbers_without_events() {
    let mut runs = 0;
    for space in BOXES {
        for particles in PARTICLES {
            for limit in LIMITS {
                let particles = particles.replace('Z', if space.contains("flat") { "0.0" } else { "1.0" });
                let text = format!("{SPECIES}\n{space}\n{particles}\n{limit}\n{MEASURE}");
                let Some(scene) = without_refused(&text) else { continue };
                let what = format!("{space} {particles} {limit}");
                let finished = Run::new(scene).execute(&mut (), &mut |_| ControlFlow::Continue(()));
                let Ok(finished) = finished else { continue };
                runs += 1;
                for number in &finished.measured.numbers {
                    assert!(number.mean.is_none_or(f64::is_finite), "{what}: {number:?}");
                    assert!(number.standard_error.is_none_or(f64::is_finite), "{what}: {number:?}");
                }
                for curve in &finished.measured.curves {
                    let values = curve.variables.iter().flat_map(|variable| &variable.values);
                    assert!(values.clone().all(|value| value.is_finite()), "{what}: {} {values:?}", curve.name);
                }
            }
        }
    }
    assert!(runs > 60, "{runs}");
}
