//! Replicas in a multicanonical ensemble, for systems with an exactly known density of states.

use std::ops::ControlFlow;

use carom::exchange::{Exchange, PotentialEnergies};
use carom::model::ExchangeEnsemble;

use super::exchange::{
    DEPTH, TEMPERATURES, bound, chain_of_four, deviation, in_ensemble, pair, refuse_other_curves, results_and_curves,
    volumes,
};

#[test]
fn multicanonical_replicas_have_the_exact_density_of_states() {
    let of_pair = [1.0 - bound(1.0), bound(1.0) * (-DEPTH).exp()];
    let of_chain = volumes(10);
    for (builder, volumes, particles, temperatures) in [
        (pair(), of_pair.as_slice(), 2.0, TEMPERATURES),
        (chain_of_four(), of_chain.as_slice(), 4.0, [1.2, 0.7, 0.45, 0.2]),
    ] {
        let ensemble = ExchangeEnsemble::Multicanonical;
        let scene = in_ensemble(ensemble, builder.seed(2), &temperatures, 2.0, [4000, 12_000]);
        let mut energies = PotentialEnergies::default();
        let watch = &mut |_| ControlFlow::Continue(());
        let exchange = Exchange::new(scene).unwrap().execute(2, &mut energies, watch).unwrap();
        let (results, curves) = (exchange.results(), energies.curves(&exchange));
        assert_eq!((&results.faults, &results.warnings()), (&Vec::new(), &Vec::new()));
        let largest = refuse_other_curves(&curves, particles, volumes);
        println!("{particles} particles, the largest deviation of a curve: {largest:.2}");
        let highest = *temperatures.iter().max_by(|a, b| a.total_cmp(b)).unwrap();
        let weight = |k: usize| volumes[k] * (DEPTH * k as f64 / highest).exp();
        let sum: f64 = (0..volumes.len()).map(weight).sum();
        assert_eq!(curves.density_of_states.len(), volumes.len());
        for (level, (k, volume)) in curves.density_of_states.iter().rev().zip(volumes.iter().enumerate()) {
            assert!((level.energy + DEPTH * k as f64).abs() < 1e-12);
            let (it, expected) = (level.log_density_of_states, (volume / sum).ln());
            assert!(deviation(it, expected).abs() < 3.0, "{level:?}, expected {expected}");
        }
        // The histogram is flat. Without weights, the upper level would almost never occur.
        let rows = energies.rows();
        for k in 0..volumes.len() {
            let is_there = |energy: &&f64| (**energy + DEPTH * k as f64).abs() < 1e-9;
            let part = rows.iter().flatten().filter(is_there).count() as f64 / (rows.len() * temperatures.len()) as f64;
            let even = 1.0 / volumes.len() as f64;
            assert!((0.6 * even..1.6 * even).contains(&part), "level {k}: {part}");
        }
        for (place, temperature) in temperatures.into_iter().enumerate() {
            let weights: Vec<f64> =
                volumes.iter().enumerate().map(|(k, it)| it * (DEPTH * k as f64 / temperature).exp()).collect();
            for (found, weight) in curves.populations[place].iter().rev().zip(&weights) {
                let expected = weight / weights.iter().sum::<f64>();
                assert!(
                    deviation(found.population, expected).abs() < 3.0,
                    "{temperature}: {found:?}, expected {expected}"
                );
            }
        }
        assert!(results.round_trips.iter().all(|trips| *trips > 100), "{:?}", results.round_trips);
    }
}

#[test]
fn multicanonical_errors_match_the_scatter_over_seeds() {
    let expected = bound(1.1).ln() - DEPTH / 1.1;
    let mut sum = 0.0;
    let seeds = 24;
    for seed in 1..=seeds {
        let ensemble = ExchangeEnsemble::Multicanonical;
        let scene = in_ensemble(ensemble, pair().seed(seed), &TEMPERATURES, 2.0, [400, 500]);
        let (_, curves) = results_and_curves(scene);
        sum += deviation(curves.density_of_states[0].log_density_of_states, expected).powi(2);
    }
    // The mean square of 24 independent normal deviates would be 1 +- sqrt(2 / 24).
    let mean = sum / seeds as f64;
    println!("mean square of deviations in errors: {mean:.2}");
    assert!((0.4..1.9).contains(&mean), "{mean}");
}
