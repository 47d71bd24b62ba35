//! Replica exchange of a square-well pair and of a chain of four beads. All populations are known exactly.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use carom::Vector;
use carom::analysis::statistics::Estimate;
use carom::exchange::{Exchange, ExchangeResults, PotentialEnergies, ThermalCurves};
use carom::model::exchange_plan::{ExchangeEnsemble, ExchangePlan};
use carom::model::{MassRule, Potential, RunPlan, Scene, Space, Until};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

pub const TEMPERATURES: [f64; 4] = [0.3, 0.42, 0.63, 1.1];
const LENGTH: f64 = 4.0;
const LAMBDA: f64 = 1.5;
pub const DEPTH: f64 = 0.9;

fn scene(builder: SceneBuilder, seed: u64, temperatures: &[f64], interval: f64, attempts: u32) -> Scene {
    in_ensemble(ExchangeEnsemble::Canonical, builder.seed(seed), temperatures, interval, [50, attempts])
}

/// Returns a scene with replica exchange, with `attempts` swap attempts for the equilibration and for the measurement.
pub fn in_ensemble(
    ensemble: ExchangeEnsemble,
    builder: SceneBuilder,
    temperatures: &[f64],
    interval: f64,
    attempts: [u32; 2],
) -> Scene {
    let plan = ExchangePlan { temperatures: temperatures.to_vec(), interval, rate: 0.7, ensemble, umbrella: None };
    let [equilibration, limit] = attempts.map(|count| Until::time(f64::from(count) * interval));
    builder.exchange(plan).run(RunPlan { equilibration, limit, ..RunPlan::default() }).build().unwrap()
}

fn results(scene: Scene) -> ExchangeResults {
    results_and_curves(scene).0
}

pub fn results_and_curves(scene: Scene) -> (ExchangeResults, ThermalCurves) {
    let mut energies = PotentialEnergies::default();
    let watch = &mut |_| ControlFlow::Continue(());
    let exchange = Exchange::new(scene).unwrap().execute(2, &mut energies, watch).unwrap();
    let results = exchange.results();
    assert_eq!(results.faults, [""; 0]);
    (results, energies.curves(&exchange))
}

/// Returns the mean energy, the variance of the energy and the logarithm of the partition function. Level `k` has the
/// energy `-k DEPTH` and the volume `volumes[k]` in configuration space.
fn moments(volumes: &[f64], temperature: f64) -> [f64; 3] {
    let weights: Vec<f64> = (0..).zip(volumes).map(|(k, it)| it * (DEPTH * f64::from(k) / temperature).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let mean =
        |power: i32| (0..).zip(&weights).map(|(k, it)| it * (-DEPTH * f64::from(k)).powi(power)).sum::<f64>() / sum;
    [mean(1), mean(2) - mean(1) * mean(1), sum.ln()]
}

pub fn refuse_other_curves(curves: &ThermalCurves, particles: f64, volumes: &[f64]) -> f64 {
    let highest = curves.points.last().unwrap().temperature;
    let [top_mean, _, top_log] = moments(volumes, highest);
    let heat_capacity = |t: f64| 1.5 + moments(volumes, t)[1] / (particles * t * t);
    let mut largest: f64 = 0.0;
    for point in &curves.points {
        let t = point.temperature;
        let [mean, _, log] = moments(volumes, t);
        let log_ratio = (log - top_log) / particles + 1.5 * (t / highest).ln();
        let entropy = log_ratio + (mean / t - top_mean / highest) / particles;
        let expected = [mean / particles, heat_capacity(t), entropy, -log_ratio];
        for ((name, measured), expected) in point.quantities().into_iter().zip(expected) {
            // Free energy and entropy are relative to the highest temperature, so they are exactly zero there.
            if t == highest && expected == 0.0 {
                assert_eq!(measured.mean, 0.0, "{name}");
                continue;
            }
            let deviation = deviation(measured, expected);
            // With 80 seeds, one deviation for two particles was above 4 standard errors.
            assert!(deviation.abs() < 4.0, "{name} at {t}: {measured:?}, expected {expected}");
            largest = largest.max(deviation.abs());
        }
    }
    if let Some(peak) = curves.peak {
        let near = |k: u32| curves.points[0].temperature + f64::from(k) * 1e-4;
        let expected = (0..10_000).map(near).max_by(|a, b| heat_capacity(*a).total_cmp(&heat_capacity(*b))).unwrap();
        assert!(deviation(peak.temperature, expected).abs() < 3.0, "{peak:?}, expected {expected}");
        assert!(deviation(peak.heat_capacity_per_particle, heat_capacity(expected)).abs() < 3.0, "{peak:?}");
    }
    largest
}

pub fn pair() -> SceneBuilder {
    SceneBuilder::new("pair")
        .space(Space::periodic_cube(LENGTH))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.37).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, LAMBDA, DEPTH).unwrap()).between("A", "B"))
        .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .particle("B", Vector::new(2.7, 2.7, 2.7), Vector::zeros())
}

pub fn bound(temperature: f64) -> f64 {
    let sphere = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    let weight = (sphere(LAMBDA) - sphere(1.0)) * (DEPTH / temperature).exp();
    weight / (weight + LENGTH.powi(3) - sphere(LAMBDA))
}

pub fn deviation(measured: Estimate, expected: f64) -> f64 {
    (measured.mean - expected) / measured.standard_error.expect("long enough for an error")
}

fn population(results: &ExchangeResults, place: usize, energy: f64) -> Estimate {
    let level = results.temperatures[place].populations.iter().find(|it| (it.energy - energy).abs() < 1e-12);
    let level = level.unwrap_or_else(|| panic!("no level {energy} in {:?}", results.temperatures[place].populations));
    assert_eq!(level.width, 0.0);
    level.population
}

#[test]
fn two_particles_in_a_well_have_their_exact_populations() {
    let (results, curves) = results_and_curves(scene(pair(), 1, &TEMPERATURES, 2.0, 20_000));
    let [bound_volume, free_volume] = [bound(1.0) * (-DEPTH).exp(), 1.0 - bound(1.0)];
    let largest = refuse_other_curves(&curves, 2.0, &[free_volume, bound_volume]);
    println!("a pair, the largest deviation of a curve: {largest:.2}");
    assert_eq!((curves.peak, results.warnings()), (None, Vec::<String>::new()));
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
        assert!(deviations.iter().all(|it| it.abs() < 3.0), "{temperature}: {deviations:?}");
    }
    // If only the colder replica is bound, the Metropolis criterion decides. Otherwise, the swap is always accepted.
    for (pair, neighbours) in TEMPERATURES.windows(2).zip(&results.neighbours) {
        let [cold, hot] = [bound(pair[0]), bound(pair[1])];
        let expected = 1.0 - cold * (1.0 - hot) * (1.0 - (-DEPTH * (1.0 / pair[0] - 1.0 / pair[1])).exp());
        let measured = neighbours.acceptance.unwrap();
        assert!(deviation(measured, expected).abs() < 3.0, "{pair:?}: {measured:?}, expected {expected}");
        assert_eq!(neighbours.attempts, 10_000);
    }
    assert!(results.round_trips.iter().all(|trips| *trips > 500), "{:?}", results.round_trips);
}

#[test]
fn two_particles_with_individual_diameters_have_their_exact_populations() {
    // The sum of the two radii is 1.
    let pair = SceneBuilder::new("pair")
        .space(Space::periodic_cube(LENGTH))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(0.9).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::SquareWell { lambda: LAMBDA, well_depth: DEPTH }).between("A", "A"))
        .sized_particle("A", 1.3, Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .sized_particle("A", 0.7, Vector::new(2.7, 2.7, 2.7), Vector::zeros());
    let results = results(scene(pair, 1, &TEMPERATURES, 2.0, 6_000));
    for (place, temperature) in TEMPERATURES.into_iter().enumerate() {
        let temperatures = results.temperatures[place].observables["temperature"];
        let bound = deviation(population(&results, place, -DEPTH), bound(temperature));
        let deviations = [bound, deviation(temperatures, temperature)];
        assert!(deviations.iter().all(|it| it.abs() < 3.5), "{temperature}: {deviations:?}");
    }
}

#[test]
fn population_errors_match_the_scatter_over_seeds() {
    let mut squares = Vec::new();
    for seed in 1..=16 {
        let results = results(scene(pair(), seed, &TEMPERATURES, 2.0, 500));
        for (place, temperature) in TEMPERATURES.into_iter().enumerate() {
            squares.push(deviation(population(&results, place, -DEPTH), bound(temperature)).powi(2));
        }
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    // For 64 independent deviations, the mean square would be 1 +- sqrt(2 / 64).
    assert!((mean - 1.0).abs() < 0.5, "{mean}");
}

/// Returns the nodes and weights of the Gauss-Legendre rule with `n` points on [0, 1].
fn gauss(n: u32) -> Vec<(f64, f64)> {
    let order = f64::from(n);
    let node = |k: u32| {
        let mut x = (PI * (f64::from(k) + 0.75) / (order + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..50 {
            let (mut p, mut before) = (x, 1.0);
            for degree in 2..=n {
                let j = f64::from(degree);
                (p, before) = (((2.0 * j - 1.0) * x * p - (j - 1.0) * before) / j, p);
            }
            slope = order * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// Longest bond. The cores of the beads have the diameter 1.
const BOND: f64 = 1.2;

/// Returns the configuration space volumes with 0, 1, 2 and 3 pairs in wells, in arbitrary units.
///
/// The bonds have the lengths `r_1`, `r_2`, `r_3`. The squared distances `s`, `t` between second neighbours are linear
/// in the cosines of the bond angles. The volume element is therefore `r_1 r_3 dr_1 dr_2 dr_3 ds dt dphi`. The squared
/// distance between the ends is `A + B cos(phi)`.
pub fn volumes(points: u32) -> [f64; 4] {
    let (rule, well) = (gauss(points), LAMBDA * LAMBDA);
    let on = |from: f64, to: f64| -> Vec<(f64, f64)> {
        rule.iter().map(|(x, weight)| (from + (to - from) * x, (to - from) * weight)).collect()
    };
    let mut volumes = [0.0; 4];
    let bonds = on(1.0, BOND);
    for &(r1, w1) in &bonds {
        for &(r2, w2) in &bonds {
            for &(r3, w3) in &bonds {
                let squares = |a: f64, b: f64| {
                    let inside = on(1.0, well).into_iter().map(|it| (it, 1));
                    inside.chain(on(well, (a + b) * (a + b)).into_iter().map(|it| (it, 0))).collect::<Vec<_>>()
                };
                for ((s, ws), in_s) in squares(r1, r2) {
                    for ((t, wt), in_t) in squares(r2, r3) {
                        let c1 = (s - r1 * r1 - r2 * r2) / (2.0 * r1 * r2);
                        let c2 = (t - r2 * r2 - r3 * r3) / (2.0 * r2 * r3);
                        let sines = ((1.0 - c1 * c1) * (1.0 - c2 * c2)).max(0.0).sqrt();
                        let (a, b) = (s + t - r2 * r2 + 2.0 * r1 * r3 * c1 * c2, 2.0 * r1 * r3 * sines);
                        let below = |limit: f64| 1.0 - ((limit - a) / b).clamp(-1.0, 1.0).acos() / PI;
                        let weight = r1 * r3 * w1 * w2 * w3 * ws * wt;
                        let (in_core, in_well) = (below(1.0), below(well));
                        volumes[in_s + in_t + 1] += weight * (in_well - in_core);
                        volumes[in_s + in_t] += weight * (1.0 - in_well);
                    }
                }
            }
        }
    }
    volumes
}

/// A chain along x in a periodic cube. The first bead is at `x`.
fn chain(beads: u32, edge: f64, x: f64) -> SceneBuilder {
    let builder = SceneBuilder::new("chain")
        .space(Space::periodic_cube(edge))
        .species(SpeciesDraft::new("bead").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, LAMBDA, DEPTH).unwrap()).between("bead", "bead"))
        .interaction(InteractionDraft::new(Potential::bond(1.0, BOND).unwrap()).named("bond"));
    (0..beads).fold(builder, |builder, bead| {
        let builder =
            builder.particle("bead", Vector::new((x + 1.1 * f64::from(bead)) % edge, 4.0, 4.0), Vector::zeros());
        if bead > 0 { builder.bond([bead - 1, bead], "bond") } else { builder }
    })
}

pub fn chain_of_four() -> SceneBuilder {
    chain(4, 9.0, 1.0)
}

/// Largest allowed deviation in standard errors. The largest two of 1,024 deviations were 4.2 and 5.9.
const LIMIT: f64 = 4.5;

#[test]
fn chain_of_four_has_the_exact_populations() {
    let (coarse, volumes) = (volumes(7), volumes(10));
    let total: f64 = volumes.iter().sum();
    for (coarse, fine) in coarse.iter().zip(&volumes) {
        assert!((coarse - fine).abs() < 1e-3 * total, "{coarse} {fine}");
    }
    let temperatures = [1.2, 0.7, 0.45, 0.35];
    let (results, curves) = results_and_curves(scene(chain_of_four(), 6, &temperatures, 2.0, 12_000));
    let largest = refuse_other_curves(&curves, 4.0, &volumes);
    println!("a chain of four, the largest deviation of a curve: {largest:.2}");
    for (place, temperature) in temperatures.into_iter().enumerate() {
        let depth = |wells: u32| DEPTH * f64::from(wells);
        let weights: Vec<f64> = (0..4).zip(&volumes).map(|(n, it)| it * (depth(n) / temperature).exp()).collect();
        let sum: f64 = weights.iter().sum();
        let compressibility = results.temperatures[place].observables["compressibility_factor"];
        assert!(deviation(compressibility, 0.25).abs() < LIMIT, "{temperature}: {compressibility:?}");
        for (wells, weight) in (0..4).zip(&weights) {
            let measured = population(&results, place, -depth(wells));
            assert!(
                deviation(measured, weight / sum).abs() < LIMIT,
                "{temperature}, {wells} wells: {measured:?}, expected {}",
                weight / sum
            );
        }
    }
}

#[test]
fn curve_errors_match_the_scatter_over_seeds() {
    let mut squares = [0.0; 2];
    let seeds = 24;
    for seed in 1..=seeds {
        let (_, curves) = results_and_curves(scene(pair(), seed, &TEMPERATURES, 2.0, 500));
        let point = curves.points.iter().find(|point| point.temperature > 0.5).unwrap();
        let t = point.temperature;
        let (p, n) = (bound(t), 2.0);
        let expected = [-DEPTH * p / n, 1.5 + DEPTH * DEPTH * p * (1.0 - p) / (n * t * t)];
        for ((square, (_, it)), expected) in squares.iter_mut().zip(point.quantities()).zip(expected) {
            *square += deviation(it, expected).powi(2);
        }
    }
    // For 24 independent deviations, the mean square would be 1 +- sqrt(2 / 24).
    let means = squares.map(|sum| sum / seeds as f64);
    assert!(means.iter().all(|mean| (0.4..1.9).contains(mean)), "{means:?}");
}

#[test]
fn temperature_without_energy_changes_gets_a_warning() {
    let results = results(scene(pair(), 1, &[0.02, 40.0], 0.5, 20));
    let warnings = results.warnings();
    assert!(
        warnings.iter().any(|it| it.starts_with("at T = 0.02: the potential energy never changed")),
        "{warnings:?}"
    );
    assert!(warnings.iter().any(|it| it.starts_with("equilibrium is not shown")), "{warnings:?}");
}

/// Returns the mean squared radius of gyration and end-to-end distance of three beads. The integration variables are
/// the bond lengths `r_1`, `r_2` and the squared distance `s` of the ends. The volume element is
/// `r_1 r_2 dr_1 dr_2 ds`.
fn squares_of_three(temperature: f64) -> [f64; 2] {
    let rule: Vec<(f64, f64)> = gauss(12).into_iter().map(|(x, w)| (1.0 + (BOND - 1.0) * x, w)).collect();
    let (well, boost) = (LAMBDA * LAMBDA, (DEPTH / temperature).exp());
    let mut sums = [0.0; 3];
    for &(r1, w1) in &rule {
        for &(r2, w2) in &rule {
            let most = (r1 + r2) * (r1 + r2);
            for (from, to, factor) in [(1.0, well, boost), (well, most, 1.0)] {
                let weight = r1 * r2 * w1 * w2 * factor;
                let (volume, first) = (weight * (to - from), weight * 0.5 * (to * to - from * from));
                sums[0] += volume;
                sums[1] += ((r1 * r1 + r2 * r2) * volume + first) / 9.0;
                sums[2] += first;
            }
        }
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

#[test]
fn chain_of_three_has_exact_gyration_and_end_to_end_distances() {
    let (results, curves) = results_and_curves(scene(chain(3, 7.0, 5.5), 3, &[0.35, 0.6, 1.2], 2.0, 8000));
    let names = ["mean_square_radius_of_gyration", "mean_square_end_to_end_distance"];
    for at in &results.temperatures {
        for (name, expected) in names.into_iter().zip(squares_of_three(at.temperature)) {
            assert!(deviation(at.observables[name], expected).abs() < 3.0, "{name} {at:?}, expected {expected}");
        }
    }
    for point in &curves.points {
        for (name, expected) in names.into_iter().zip(squares_of_three(point.temperature)) {
            assert!(deviation(point.others[name], expected).abs() < 3.0, "{name} {point:?}, expected {expected}");
        }
    }
}
