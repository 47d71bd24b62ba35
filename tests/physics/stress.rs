//! Stress and dissipated power on grids.

use carom::analysis::instruments::Series;
use carom::model::Scene;
use carom::run::Finished;

use super::measure::finish;

fn finished(text: &str) -> Finished {
    finish(Scene::from_toml(text, "stress.toml").unwrap())
}

fn series<'f>(finished: &'f Finished, name: &str) -> &'f Series {
    let curve = finished.measured.curve("stress_s").unwrap();
    curve.series.iter().find(|series| series.name == name).unwrap()
}

/// Mean over cells with equal volumes, with the errors as if the cells were independent.
fn mean(series: &Series) -> (f64, f64) {
    let count = series.values.len() as f64;
    let sum: f64 = series.values.iter().map(|value| value.unwrap()).sum();
    let square: f64 = series.standard_errors.iter().map(|error| error.unwrap() * error.unwrap()).sum();
    (sum / count, square.sqrt() / count)
}

/// A mixture with unlike masses and diameters, and square wells between some of the particles.
const MIXTURE: &str = "
    seed = 3
    space = { size = [6.0, 7.0, 8.0] }
    species = [{ name = 'a', mass = 0.7, diameter = 0.8 }, { name = 'b', mass = 3.1, diameter = 1.3 }]
    interaction = [
        { species = ['a', 'a'], potential = 'hard-sphere', restitution = 1.0 },
        { species = ['a', 'b'], potential = 'hard-sphere', tangential_restitution = 1.0 },
        { species = ['b', 'b'], potential = 'square-well', diameter = 1.3, lambda = 1.3, well_depth = 0.6 },
    ]
    fill = [{ composition = { a = 60, b = 40 }, arrangement = 'random', count = 100, temperature = 1.3 }]
    run = { equilibration_events = 5000, until_time = 60.0 }
";

#[test]
fn mean_over_all_cells_is_the_pressure_tensor() {
    let text = MIXTURE.replace("equilibration_events = 5000, ", "");
    let finished = finished(&format!(
        "{text}
        [measure]
        pressure_tensor = {{ interval = 0.1 }}
        [[measure.stress]]
        name = 's'
        bins = [3, 1, 4]
        lower = [-1.0, 0.0, 0.3]
        upper = [5.0, 7.0, 8.3]
        interval = 0.1
        [[measure.stress]]
        name = 'whole'
        bins = [1, 1, 1]
        interval = 0.1
        "
    ));
    let whole = |name: &str| {
        let curve = finished.measured.curve("stress_whole").unwrap();
        curve.series.iter().find(|series| series.name == name).unwrap().values[0].unwrap()
    };
    for name in ["xx", "yy", "zz", "xy", "xz", "yz"] {
        let turned: String = name.chars().rev().collect();
        let stress = 0.5 * (whole(&format!("stress {name}")) + whole(&format!("stress {turned}")));
        let pressure = finished.measured.number(&format!("pressure_{name}")).unwrap().estimate().unwrap();
        println!("{name}: {stress}, {pressure:?}");
        // Collisions are the same. The kinetic part is sampled 600 times, instead of summed over all times.
        assert!(
            (stress - pressure.mean).abs() < 0.1 * pressure.standard_error.unwrap(),
            "{name}: {stress} {pressure:?}"
        );
    }
    // The parts of the lines in all cells add up to the lines.
    let diagonal = ["stress xx", "stress yy", "stress zz"];
    let parts = diagonal.map(|name| mean(series(&finished, name)).0).iter().sum::<f64>() / 3.0;
    let collisional = parts - mean(series(&finished, "kinetic pressure")).0;
    let expected = diagonal.map(whole).iter().sum::<f64>() / 3.0 - whole("kinetic pressure");
    assert!((collisional - expected).abs() < 1e-12, "{collisional} {expected}");
}

#[test]
fn cells_of_a_fluid_have_the_same_stress_within_their_errors() {
    let finished = finished(&format!("{MIXTURE}\n[[measure.stress]]\nname = 's'\nbins = [1, 1, 6]\ninterval = 0.1"));
    let off_diagonal = series(&finished, "stress zx");
    let kinetic = series(&finished, "kinetic pressure");
    let is = |series: &Series, cell: usize, expected: f64| {
        let (value, error) = (series.values[cell].unwrap(), series.standard_errors[cell].unwrap());
        assert!((value - expected).abs() < 4.5 * error, "{} {cell}: {value} +- {error}, {expected}", series.name);
    };
    let (diagonal, _) = mean(series(&finished, "stress zz"));
    for cell in 0..6 {
        is(off_diagonal, cell, 0.0);
        is(series(&finished, "stress zz"), cell, diagonal);
        let temperature = finished.observable("temperature").unwrap().mean;
        is(kinetic, cell, temperature * 100.0 / 336.0);
    }
    assert!(series(&finished, "dissipated power").values.iter().all(|power| power.unwrap().abs() < 1e-13));
}

#[test]
fn shear_stress_is_the_same_at_all_heights_and_pulls_the_plates() {
    let finished = finished(
        "
        seed = 5
        space = { size = [5.0, 5.0, 6.0], z = 'open' }
        species = [{ name = 'a', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['a', 'a'], potential = 'hard-sphere' }]
        fill = [{ species = 'a', arrangement = 'random', count = 60, temperature = 1.0,
                  region = { lower = [0.0, 0.0, 0.1], upper = [5.0, 5.0, 5.9] } }]
        run = { equilibration_time = 50.0, until_time = 400.0 }
        [[surface]]
        name = 'lower'
        shape = 'plane'
        point = [0.0, 0.0, 0.0]
        normal = [0.0, 0.0, 1.0]
        temperature = 1.0
        surface_velocity = [-1.0, 0.0, 0.0]
        [[surface]]
        name = 'upper'
        shape = 'plane'
        point = [0.0, 0.0, 6.0]
        normal = [0.0, 0.0, -1.0]
        temperature = 1.0
        surface_velocity = [1.0, 0.0, 0.0]
        [measure]
        surface_forces = true
        [[measure.stress]]
        name = 's'
        bins = [1, 1, 6]
        interval = 0.1
        ",
    );
    for (stress, force) in [("stress zx", "force_upper_x"), ("stress zz", "force_upper_z")] {
        let of_plate = finished.measured.number(force).unwrap().estimate().unwrap().over(25.0);
        let stress = series(&finished, stress);
        for (value, error) in stress.values.iter().zip(&stress.standard_errors) {
            println!("{}: {value:?} +- {error:?}, {of_plate:?}", stress.name);
            let error = error.unwrap().max(of_plate.standard_error.unwrap());
            assert!((value.unwrap() - of_plate.mean).abs() < 5.0 * error, "{value:?} {of_plate:?}");
            assert!(error < 0.05 * of_plate.mean.abs());
        }
    }
}

#[test]
fn stress_in_grains_at_rest_is_the_weight_above() {
    let finished = finished(
        "
        seed = 2
        space = { size = [5.0, 5.0, 14.0], z = { lower = 'wall', upper = 'open', restitution = 0.5, friction = 0.3 } }
        dynamics = { gravity = [0.0, 0.0, -1.7], contact_time = 0.01 }
        species = [{ name = 'a', mass = 0.7, diameter = 0.9 }, { name = 'b', mass = 1.3, diameter = 1.1 }]
        interaction = [
            { species = ['a', 'a'], potential = 'hard-sphere', restitution = 0.5, friction = 0.3 },
            { species = ['a', 'b'], potential = 'hard-sphere', restitution = 0.5, friction = 0.3 },
            { species = ['b', 'b'], potential = 'hard-sphere', restitution = 0.5, friction = 0.3 },
        ]
        fill = [{ composition = { a = 50, b = 50 }, arrangement = 'random', count = 100,
                  region = { lower = [0.0, 0.0, 0.0], upper = [5.0, 5.0, 14.0] } }]
        run = { equilibration_time = 30.0, until_time = 10.0 }
        [[measure.stress]]
        name = 's'
        bins = [1, 1, 28]
        interval = 0.2
        [[measure.profile]]
        name = 'a'
        bins = [1, 1, 2800]
        species = 'a'
        interval = 0.2
        [[measure.profile]]
        name = 'b'
        bins = [1, 1, 2800]
        species = 'b'
        interval = 0.2
        ",
    );
    let density = |name: &str| finished.measured.curve(name).unwrap().series[0].values.clone();
    let [a, b] = [density("profile_a"), density("profile_b")];
    let layer: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (0.7 * a.unwrap() + 1.3 * b.unwrap()) * 0.005).collect();
    let stress = series(&finished, "stress zz");
    for cell in 0..6 {
        // The weight above a height, averaged over the heights in the cell. A layer inside the cell carries only over the
        // heights below it.
        let part = |k: usize| ((k as f64 + 0.5 - 100.0 * cell as f64) / 100.0).clamp(0.0, 1.0);
        let above: f64 = (0..2800).map(|k| 1.7 * layer[k] * part(k)).sum();
        let (value, error) = (stress.values[cell].unwrap(), stress.standard_errors[cell].unwrap());
        println!("{cell}: {value} +- {error}, {above}");
        // The layers are 0.005 thick, and the centres in them count as if they were in the middle.
        assert!((value - above).abs() < 5.0 * error + 0.002 * above, "{cell}: {value} +- {error}, {above}");
    }
    let weight = 1.7 * (50.0 * 0.7 + 50.0 * 1.3) / 25.0;
    assert!((stress.values[0].unwrap() - weight).abs() < 0.01 * weight, "{:?} {weight}", stress.values[0]);
}

#[test]
fn dissipated_power_adds_up_to_the_dissipated_energy() {
    // The second run lasts longer than expected, so that its intervals become longer while it cools.
    for (limit, interval) in [("until_time = 4.0", "interval = 0.1"), ("until_events = 9000", "")] {
        let finished = finished(&format!(
            "
            seed = 4
            space = {{ size = [6.0, 6.0, 6.0], z = {{ lower = 'wall', upper = 'wall', restitution = 0.8 }} }}
            species = [{{ name = 'a', mass = 1.3, diameter = 1.0 }}]
            interaction = [{{ species = ['a', 'a'], potential = 'hard-sphere', restitution = 0.9, friction = 0.2 }}]
            fill = [{{ species = 'a', arrangement = 'random', count = 60, temperature = 1.0 }}]
            run = {{ {limit} }}
            [[measure.stress]]
            name = 's'
            bins = [2, 3, 2]
            {interval}
            "
        ));
        let power: f64 = series(&finished, "dissipated power").values.iter().map(|power| power.unwrap()).sum();
        let (lost, time) = (finished.simulation.event_counts().dissipated.total(), finished.simulation.time());
        assert!((power * 18.0 * time - lost).abs() < 1e-9 * lost, "{limit}: {power} {lost}");
    }
}

#[test]
fn flux_between_two_unlike_balls_is_the_same_everywhere() {
    // Balls on a line exchange momentum at a constant rate. The total momentum is zero, and N / (N - 1) is 2.
    let finished = finished(
        "
        space = { size = [6.0, 0.0, 0.0], y = 'flat', z = 'flat' }
        species = [{ name = 'a', mass = 1.3, diameter = 1.0 }, { name = 'b', mass = 0.7, diameter = 0.6 }]
        interaction = [{ species = ['a', 'b'], potential = 'hard-sphere' },
                       { species = ['a', 'a'], potential = 'hard-sphere' }, { species = ['b', 'b'], potential = 'hard-sphere' }]
        particle = [{ species = 'a', position = [1.0, 0.0, 0.0], velocity = [0.7, 0.0, 0.0] },
                    { species = 'b', position = [4.0, 0.0, 0.0], velocity = [-1.3, 0.0, 0.0] }]
        run = { until_time = 2000.0 }
        [[measure.stress]]
        name = 's'
        bins = [6, 1, 1]
        interval = 0.0317
        ",
    );
    let mean = mean(series(&finished, "stress xx")).0;
    // Twice the kinetic energy is 1.82. The balls collide after 4.4 at the relative speed 2, with the impulse 1.82.
    let expected = (2.0 * 1.82 + 0.8 * 1.82 * 2.0 / 4.4) / 6.0;
    assert!((mean - expected).abs() < 0.02 * expected, "{mean} {expected}");
}
