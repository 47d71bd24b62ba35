//! Standard errors against the scatter of runs with other seeds.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use carom::model::potential::Potential;
use carom::model::{Limit, RunPlan, Scene, Thermostat};
use carom::run;
use carom::scene::{Amount, Lattice, SceneBuilder};

/// Ratios of scatter to claimed error, by observable.
fn ratios(scene: impl Fn(u64) -> Scene, seeds: u64) -> BTreeMap<&'static str, f64> {
    let mut estimates: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for seed in 1..=seeds {
        let finished = run::run(scene(seed), &mut (), &mut |_| ControlFlow::Continue(())).unwrap();
        for (name, estimate) in finished.observables {
            // What the dynamics conserve has an error of rounding.
            let error = estimate.standard_error.filter(|error| *error > 1e-12 * estimate.mean.abs());
            estimates.entry(name).or_default().extend(error.map(|error| (estimate.mean, error)));
        }
    }
    let ratio = |runs: Vec<(f64, f64)>| {
        let count = runs.len() as f64;
        let mean = runs.iter().map(|run| run.0).sum::<f64>() / count;
        let scatter = runs.iter().map(|run| (run.0 - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let claimed = runs.iter().map(|run| run.1 * run.1).sum::<f64>() / count;
        (scatter / claimed).sqrt()
    };
    // Few of the runs may be too short for an error.
    let enough = estimates.into_iter().filter(|(_, runs)| 4 * runs.len() as u64 > 3 * seeds);
    enough.map(|(name, runs)| (name, ratio(runs))).collect()
}

fn spheres(seed: u64, potential: Potential, restitution: f64, count: u64, amount: Amount, run: RunPlan) -> Scene {
    SceneBuilder::new("errors")
        .seed(seed)
        .species("A", 1.0, 1.0)
        .interaction("A", "A", potential, restitution)
        .fill(Lattice::FaceCentredCubic, "A", count, amount)
        .temperature(1.0)
        .run(run)
        .build()
        .unwrap()
}

fn lasting(equilibration: f64, time: f64, bath: Option<(f64, f64)>) -> RunPlan {
    let andersen = |(temperature, rate)| Thermostat::Andersen { temperature, rate, axes: [true; 3] };
    RunPlan {
        equilibration: Limit::time(equilibration),
        limit: Limit::time(time),
        thermostat: bath.map(andersen),
        ..RunPlan::default()
    }
}

fn assert_honest(seeds: u64, range: std::ops::RangeInclusive<f64>) {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let well = || Potential::square_well(1.0, 1.5, 1.0).unwrap();
    let fluid = |seed| spheres(seed, hard(), 1.0, 108, Amount::PackingFraction(0.4), lasting(5.0, 20.0, None));
    // In a quarter of the time there are too few values: the errors that are claimed are then a quarter too large.
    let crystal = |seed| spheres(seed, hard(), 1.0, 256, Amount::PackingFraction(0.54), lasting(3.0, 40.0, None));
    let bath =
        |seed| spheres(seed, well(), 1.0, 108, Amount::NumberDensity(0.5), lasting(10.0, 40.0, Some((1.5, 1.0))));
    let driven =
        |seed| spheres(seed, hard(), 0.8, 108, Amount::PackingFraction(0.2), lasting(10.0, 40.0, Some((1.0, 0.5))));
    for (what, ratios) in [
        ("fluid", ratios(fluid, seeds)),
        ("crystal", ratios(crystal, seeds)),
        ("square wells in a heat bath", ratios(bath, seeds)),
        ("driven gas", ratios(driven, seeds)),
    ] {
        println!("{what}: {ratios:.3?}");
        assert!(ratios.contains_key("compressibility_factor") && ratios.contains_key("collision_rate"), "{what}");
        assert!(ratios.values().all(|ratio| range.contains(ratio)), "{what}: {ratios:?}");
    }
}

#[test]
fn claimed_errors_are_those_of_other_seeds() {
    // From 0.8 to 1.25; the scatter of 32 is known to 1 / sqrt(62) = 13 %, and one of fourteen may be off by 1.5 of that.
    assert_honest(32, 0.66..=1.5);
}

#[test]
#[ignore = "four minutes in a release build"]
fn claimed_errors_are_those_of_many_other_seeds() {
    // From 0.8 to 1.25; the scatter of 256 is known to 4.4 %, and one of fourteen may be off by two of that.
    assert_honest(256, 0.73..=1.36);
}
