//! Replica exchange of systems whose populations are known exactly: two particles in a square well, and a chain of four.

use std::f64::consts::PI;

use carom::Vector;
use carom::exchange::{Exchange, ExchangeResults, Measured};
use carom::model::exchange_plan::ExchangePlan;
use carom::model::{Limit, Potential, RunPlan, Scene, Space};
use carom::scene::SceneBuilder;

const TEMPERATURES: [f64; 4] = [0.3, 0.42, 0.63, 1.1];
const LENGTH: f64 = 4.0;
const LAMBDA: f64 = 1.5;
const DEPTH: f64 = 0.9;

fn scene(builder: SceneBuilder, seed: u64, temperatures: &[f64], interval: f64, attempts: u32) -> Scene {
    let plan = ExchangePlan { temperatures: temperatures.to_vec(), interval, rate: 0.7 };
    let [equilibration, limit] = [50, attempts].map(|count| Limit::time(f64::from(count) * interval));
    builder.seed(seed).exchange(plan).run(RunPlan { equilibration, limit, ..RunPlan::default() }).build().unwrap()
}

fn results(scene: Scene) -> ExchangeResults {
    let results = Exchange::new(scene).unwrap().finish().unwrap().results();
    assert_eq!(results.faults, [""; 0]);
    results
}

/// Two particles of unequal masses with a square well.
fn pair() -> SceneBuilder {
    SceneBuilder::new("pair")
        .space(Space::periodic_cube(LENGTH))
        .species("A", 1.3, 1.0)
        .species("B", 0.37, 1.0)
        .no_interaction("A", "A")
        .no_interaction("B", "B")
        .interaction("A", "B", Potential::square_well(1.0, LAMBDA, DEPTH).unwrap(), 1.0)
        .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .particle("B", Vector::new(2.7, 2.7, 2.7), Vector::zeros())
}

/// The part of the time that the two are bound.
fn bound(temperature: f64) -> f64 {
    let sphere = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    let weight = (sphere(LAMBDA) - sphere(1.0)) * (DEPTH / temperature).exp();
    weight / (weight + LENGTH.powi(3) - sphere(LAMBDA))
}

fn deviation(measured: Measured, expected: f64) -> f64 {
    (measured.mean - expected) / measured.standard_error.expect("long enough for an error")
}

/// The population of an exact level at a temperature.
fn population(results: &ExchangeResults, place: usize, energy: f64) -> Measured {
    let level = results.temperatures[place].populations.iter().find(|it| (it.energy - energy).abs() < 1e-12);
    let level = level.unwrap_or_else(|| panic!("no level {energy} in {:?}", results.temperatures[place].populations));
    assert_eq!(level.width, 0.0);
    level.population
}

#[test]
fn two_particles_in_a_well_have_their_exact_populations() {
    let results = results(scene(pair(), 1, &TEMPERATURES, 2.0, 20_000));
    for (place, temperature) in TEMPERATURES.into_iter().enumerate() {
        let p = bound(temperature);
        let of = |name: &str| results.temperatures[place].observables[name];
        let heat_capacity = 1.5 + DEPTH * DEPTH * p * (1.0 - p) / (2.0 * temperature * temperature);
        let deviations = [
            deviation(population(&results, place, -DEPTH), p),
            deviation(population(&results, place, 0.0), 1.0 - p),
            deviation(of("potential_energy_per_particle"), -0.5 * DEPTH * p),
            deviation(of("heat_capacity_per_particle"), heat_capacity),
            deviation(of("temperature"), temperature),
        ];
        println!("{temperature} {p} {deviations:?} {:?}", of("temperature"));
        assert!(deviations.iter().all(|it| it.abs() < 3.0), "{temperature}: {deviations:?}");
    }
    // Of two independent replicas: both bound, both unbound, or the one at the lower temperature bound and the other not.
    for (pair, neighbours) in TEMPERATURES.windows(2).zip(&results.neighbours) {
        let [cold, hot] = [bound(pair[0]), bound(pair[1])];
        let expected = 1.0 - cold * (1.0 - hot) * (1.0 - (-DEPTH * (1.0 / pair[0] - 1.0 / pair[1])).exp());
        let measured = neighbours.acceptance.unwrap();
        println!("{pair:?} {expected} {measured:?}");
        assert!(deviation(measured, expected).abs() < 3.0, "{pair:?}: {measured:?}, expected {expected}");
        assert_eq!(neighbours.attempts, 10_000);
    }
    assert!(results.round_trips.iter().all(|trips| *trips > 500), "{:?}", results.round_trips);
}
