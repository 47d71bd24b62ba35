use super::*;
use crate::analysis::instruments::test_system::{Recorded, estimate, instrument, mean, measure, number, report, start};
use crate::engine::Simulation;
use crate::model::Scene;
use crate::model::random::{Purpose, Random};

fn scene(text: &str) -> (SystemDescription, Simulation) {
    start(Scene::from_toml(text, "residence.toml").unwrap())
}

fn residence_times(simulation: &Simulation, system: &SystemDescription, plan: &Plan) -> Recorded<ResidenceTimes> {
    Recorded::new(instrument(simulation, system, 1.0, |setup| ResidenceTimes::new(plan, setup)))
}

/// Two kinds of grains that fall freely, one after the other, from points at which they enter at rest.
const FALL: &str = "
    space = { size = [9.0, 9.0, 40.0], x = 'walls', y = 'walls', z = 'open' }
    dynamics = { gravity = [0.0, 0.0, -0.7] }
    species = [{ name = 'large', mass = 1.3, diameter = 1.0 }, { name = 'small', mass = 0.4, diameter = 0.5 }]
    interaction = [
        { species = ['large', 'large'], potential = 'hard-sphere' },
        { species = ['large', 'small'], potential = 'hard-sphere' },
        { species = ['small', 'small'], potential = 'hard-sphere' },
    ]
    surface = [{ name = 'drain', shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }]
    inlet = [
        { name = 'a', species = 'large', region = { shape = 'sphere', centre = [2.0, 2.0, 30.0], radius = 0.5 }, rate = 0.25 },
        { name = 'b', species = 'small', region = { shape = 'sphere', centre = [7.0, 7.0, 20.0], radius = 0.25 }, rate = 0.2 },
    ]
    particle = [{ species = 'large', position = [5.0, 5.0, 11.0] }]
    run = { until_time = 100 }";

#[test]
fn times_of_free_falls_are_exact() {
    let (system, mut simulation) = scene(FALL);
    let mut instrument = residence_times(&simulation, &system, &Plan { bins: Some(4), longest: Some(10.0) });
    // The copy in `instrument` is saved and restored after each of these parts.
    (0..8).for_each(|_| measure(&mut simulation, &system, &mut instrument, 12.5));
    let measured = report(&instrument, &system);
    // A grain falls until its centre is one radius above the drain.
    let fall = |height: f64| (2.0 * height / 0.7_f64).sqrt();
    let [large, small] = [fall(30.0 - 1.5), fall(20.0 - 1.25)];
    // Times are differences of simulated times up to 100, which are exact within a few units in the last place.
    let round_off = 100.0 * 16.0 * f64::EPSILON;
    assert!((mean(&measured, "residence_time_large") - large).abs() < round_off, "{measured:?} {large}");
    assert!((mean(&measured, "residence_time_small") - small).abs() < round_off, "{measured:?} {small}");
    assert!(mean(&measured, "residence_time_deviation_small") < round_off);
    // Grains enter at 0, 4, 8, ... 100 and at 0, 5, 10, ... 100. Those of the last 9.02 and 7.32 are still falling.
    let counts = ["residence_time_count_large", "residence_time_count_small", "residence_time_unfinished"];
    assert_eq!(counts.map(|name| mean(&measured, name)), [23.0, 19.0, 3.0 + 2.0]);
    assert_eq!(mean(&measured, "residence_time_from_start"), 1.0);
    let all = (23.0 * large + 19.0 * small) / 42.0;
    assert!((mean(&measured, "residence_time") - all).abs() < round_off);
    let deviation = (23.0 * 19.0_f64).sqrt() / 42.0 * (large - small);
    assert!((mean(&measured, "residence_time_deviation") - deviation).abs() < round_off, "{deviation}");
    // Bins end at 2.5, 5, 7.5 and 10.
    let names: Vec<&str> = measured.curves.iter().map(|curve| curve.name.as_str()).collect();
    assert_eq!(names, ["residence_times", "residence_times_large", "residence_times_small"]);
    for (curve, counts) in
        measured.curves.iter().zip([[0.0, 0.0, 19.0, 23.0], [0.0, 0.0, 0.0, 23.0], [0.0, 0.0, 19.0, 0.0]])
    {
        let total: f64 = counts.iter().sum();
        for (density, count) in curve.series[0].values.iter().zip(counts) {
            assert!((density.unwrap() - count / total / 2.5).abs() < f64::EPSILON, "{curve:?}");
        }
    }
    assert_eq!(instrument.again, instrument.instrument);
}

#[test]
fn mean_residence_time_is_the_number_of_particles_divided_by_the_rate() {
    // A gas in a box with a hole in its side, through which atoms leave, and enter again in the middle of the box.
    let (system, mut simulation) = scene(
        "seed = 3
        space = { size = [8.0, 8.0, 8.0], x = 'walls', y = 'walls', z = 'walls' }
        species = [{ name = 'atom', mass = 1.0, diameter = 0.5 }]
        interaction = [{ species = ['atom', 'atom'], potential = 'hard-sphere' }]
        surface = [{ name = 'hole', shape = 'sphere', centre = [0.0, 4.0, 4.0], radius = 2.5, outlet = true }]
        inlet = [{ region = { lower = [3.0, 0.0, 0.0], upper = [8.0, 8.0, 8.0] }, temperature = 1.0, recirculate = ['hole'] }]
        fill = [{ species = 'atom', arrangement = 'random', count = 60, region = { lower = [3.0, 0.0, 0.0], upper = [8.0, 8.0, 8.0] }, temperature = 1.0 }]
        run = { until_time = 4000 }",
    );
    let mut instrument = residence_times(&simulation, &system, &Plan::default());
    let duration = 4000.0;
    (0..4).for_each(|_| measure(&mut simulation, &system, &mut instrument, 0.25 * duration));
    let counts = simulation.event_counts();
    let inlet = simulation.inlets()[0];
    assert_eq!((counts.exit, inlet.returned, simulation.moving()), (counts.entry, counts.entry, 60));
    assert_eq!((inlet.waiting, inlet.blocked), (0, 0), "all atoms return at once, so that 60 are always in the box");
    let measured = report(&instrument, &system);
    let (time, error) = estimate(&measured, "residence_time");
    let expected = 60.0 * duration / counts.exit as f64;
    // In a measurement of the duration t, the N atoms in the box spend the time N t there. Two parts of it are not
    // measured: the times of the first N atoms, and the times of the last N atoms. In a steady flow, each part is
    // N <t^2> / (2 tau) on average. The mean is therefore too small by s^2 / t. The standard deviation s is about tau.
    let left_out = expected * expected / duration;
    println!("{time} +- {error}, expected {expected}, {} exits", counts.exit);
    assert!((time + left_out - expected).abs() < 4.0 * error, "{time} +- {error}, {expected}");
    assert!(error < 0.02 * time && left_out < 0.02 * time, "{time} +- {error}, {left_out}");
    // Without memory, the times would have an exponential distribution, whose standard deviation is the mean.
    let (deviation, error) = estimate(&measured, "residence_time_deviation");
    assert!((0.8..1.2).contains(&(deviation / time)) && error < 0.1 * time, "{deviation} +- {error}");
    let total = [counts.exit as f64 - mean(&measured, "residence_time_from_start"), 60.0];
    assert_eq!(mean(&measured, "residence_time_count"), total[0]);
    assert!(mean(&measured, "residence_time_unfinished") <= total[1]);
    assert_eq!(instrument.again, instrument.instrument);
}

#[test]
fn nothing_is_measured_before_the_first_particle_has_entered_and_left() {
    let (system, mut simulation) = scene(FALL);
    let mut instrument = residence_times(&simulation, &system, &Plan::default());
    measure(&mut simulation, &system, &mut instrument, 3.0);
    let measured = report(&instrument, &system);
    for name in ["residence_time", "residence_time_deviation", "residence_time_small"] {
        assert_eq!(number(&measured, name).mean, None, "{name}");
    }
    assert_eq!(mean(&measured, "residence_time_count"), 0.0);
    assert_eq!(mean(&measured, "residence_time_unfinished"), 2.0);
    assert!(measured.curves.iter().all(|curve| curve.variables[0].values.is_empty()));
}

#[test]
fn error_of_the_standard_deviation_is_that_of_independent_times() {
    // Uniform from 0 to 1: the variance is 1 / 12, and the mean fourth power of the deviation from the mean is 1 / 80.
    let (count, seeds) = (4_000, 100);
    let exact = (1.0 / 12.0_f64).sqrt();
    let error = (1.0 / 80.0 - 1.0 / 144.0_f64).sqrt() / f64::from(count).sqrt() / (2.0 * exact);
    let (mut ratios, mut squares) = (0.0, 0.0);
    for seed in 0..seeds {
        let mut times = Times::new(&Plan::default());
        let mut random = Random::new(seed, Purpose::Placement, 0);
        (0..count).for_each(|_| times.add(random.uniform()));
        let Estimate { mean, standard_error } = times.standard_deviation().unwrap();
        ratios += standard_error.unwrap() / error / seeds as f64;
        squares += (mean - exact) * (mean - exact) / (error * error) / seeds as f64;
    }
    // The estimate finds correlations by chance, which enlarge the error: on average by 9 %, rarely by a factor of 2.
    assert!((1.0..1.2).contains(&ratios), "{ratios}");
    // The mean square of a hundred normal deviates has the standard deviation sqrt(2 / 100).
    assert!((squares - 1.0).abs() < 5.0 * 0.141, "{squares}");
    let mut equal = Times::new(&Plan::default());
    (0..100).for_each(|_| equal.add(0.7));
    assert_eq!(equal.standard_deviation().map(|estimate| estimate.mean), Some(0.0));
}
