//! Replicas in umbrella windows, for particles with an exactly known potential of mean force.

use std::ops::ControlFlow;

use carom::Vector;
use carom::exchange::{Distances, Exchange, ExchangeResults, MeanForce, MeanForcePoint};
use carom::model::space::Boundary;
use carom::model::{ExchangeEnsemble, ExchangePlan, ParticleId, Potential, RunPlan, Scene, Space, UmbrellaPlan, Until};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

use super::exchange::{DEPTH, deviation, pair};

const TEMPERATURE: f64 = 0.6;

fn in_windows(builder: SceneBuilder, between: [&[u32]; 2], windows: &[[f64; 2]], attempts: [u32; 2]) -> Scene {
    let between = between.map(|group| group.iter().map(|id| ParticleId(*id)).collect());
    let umbrella = UmbrellaPlan { between, windows: windows.to_vec(), bins: 40 };
    let plan = ExchangePlan {
        temperatures: vec![TEMPERATURE],
        interval: 1.0,
        rate: 0.7,
        ensemble: ExchangeEnsemble::Umbrella,
        umbrella: Some(umbrella),
    };
    let [equilibration, limit] = attempts.map(|count| Until::time(f64::from(count)));
    builder.exchange(plan).run(RunPlan { equilibration, limit, ..RunPlan::default() }).build().unwrap()
}

fn results(scene: Scene) -> (ExchangeResults, MeanForce) {
    let mut distances = Distances::default();
    let watch = &mut |_| ControlFlow::Continue(());
    let exchange = Exchange::new(scene).unwrap().execute(2, &mut distances, watch).unwrap();
    let results = exchange.results();
    assert_eq!((&results.faults, &results.warnings()), (&Vec::new(), &Vec::new()));
    for (at, window) in results.temperatures.iter().zip(&exchange.plan().umbrella.as_ref().unwrap().windows) {
        let distance = at.observables["distance"];
        assert!(window[0] < distance.mean && distance.mean < window[1]);
        let kinetic = at.observables["temperature"];
        assert!(deviation(kinetic, TEMPERATURE).abs() < 4.0, "{kinetic:?}");
    }
    (results, distances.mean_force(&exchange))
}

/// Compares a potential of mean force with the expected values, and checks the mean difference between distances above
/// and below a limit.
fn refuse_other(
    found: &MeanForce,
    (bins, last_window, dimensions): (usize, [f64; 2], f64),
    expected: impl Fn(&MeanForcePoint) -> f64,
) {
    assert!(!found.is_torn && found.points.len() == bins, "{} bins", found.points.len());
    // The potential is zero at the mean density of the last window. Bins are weighted by the volumes of their shells.
    let volume = |point: &MeanForcePoint, dimensions: f64| {
        let [lower, upper] = [point.distance - 0.5 * point.width, point.distance + 0.5 * point.width];
        upper.powf(dimensions) - lower.powf(dimensions)
    };
    let last = found.points.iter().filter(|point| point.distance > last_window[0] && point.distance < last_window[1]);
    let (mut whole, mut weighted) = (0.0, 0.0);
    for point in last {
        let volume = volume(point, dimensions);
        whole += volume;
        weighted += volume * (-expected(point) / TEMPERATURE).exp();
    }
    let zero = -TEMPERATURE * (weighted / whole).ln();
    let mut sum = 0.0;
    for point in &found.points {
        let it = point.potential_of_mean_force;
        let deviation = deviation(it, expected(point) - zero);
        assert!(deviation.abs() < 4.5, "{point:?}, expected {}", expected(point) - zero);
        assert!(it.standard_error.unwrap() < 0.15 * TEMPERATURE, "{point:?}");
        sum += deviation * deviation;
    }
    let mean = sum / found.points.len() as f64;
    println!("mean square of deviations in errors: {mean:.2}");
    assert!(mean < 3.0, "{mean}");
}

fn square_well(point: &MeanForcePoint) -> f64 {
    if point.distance < 1.5 { -DEPTH } else { 0.0 }
}

#[test]
fn potential_of_mean_force_of_a_pair_is_its_potential() {
    let windows = [[1.0, 1.5], [1.3, 1.8], [1.5, 1.98]];
    let (results, found) = results(in_windows(pair().seed(3), [&[0], &[1]], &windows, [200, 30_000]));
    refuse_other(&found, (found.points.len(), windows[2], 3.0), square_well);
    assert!(found.points.len() >= 39);
    // The free energy contains the volume of the shell, but the potential of mean force does not.
    for pair in found.points.windows(2).filter(|pair| square_well(&pair[0]) == square_well(&pair[1])) {
        let volume = |it: &MeanForcePoint| it.distance * it.distance + it.width * it.width / 12.0;
        let difference = |of: fn(&MeanForcePoint) -> f64| of(&pair[1]) - of(&pair[0]);
        let of_shells = TEMPERATURE * (volume(&pair[1]) / volume(&pair[0])).ln();
        let found = difference(|it| it.potential_of_mean_force.mean) - difference(|it| it.free_energy.mean);
        assert!((found - of_shells).abs() < 1e-9, "{found}, expected {of_shells}");
    }
    assert!(results.neighbours.iter().all(|it| it.acceptance.unwrap().mean > 0.05));
    assert!(results.round_trips.iter().all(|trips| *trips > 100), "{:?}", results.round_trips);
    // A swap is possible if both distances lie in the overlap of the two windows. The probability of each distance is
    // the weight of the overlap divided by the weight of the window. The expected acceptance is the product of the two.
    let weight = |from: f64, to: f64| {
        let cubes = |from: f64, to: f64| if to > from { to.powi(3) - from.powi(3) } else { 0.0 };
        cubes(from, to.min(1.5)) * (DEPTH / TEMPERATURE).exp() + cubes(from.max(1.5), to)
    };
    for (it, pair) in results.neighbours.iter().zip(windows.windows(2)) {
        let ([a, b], [c, d]) = (pair[0], pair[1]);
        let expected = weight(c, b) / weight(a, b) * (weight(c, b) / weight(c, d));
        // Successive distances are slightly correlated.
        let found = it.acceptance.unwrap();
        assert!(deviation(found, expected).abs() < 4.0, "{found:?}, expected {expected}");
    }
}

#[test]
fn potential_of_mean_force_is_exact_in_two_dimensions_and_in_one() {
    for (dimensions, size) in [(2, Vector::new(5.0, 6.0, 0.0)), (1, Vector::new(5.0, 0.0, 0.0))] {
        let boundary = std::array::from_fn(|axis| if axis < dimensions { Boundary::Periodic } else { Boundary::Flat });
        let y = if dimensions > 1 { 2.0 } else { 0.0 };
        let scene = SceneBuilder::new("pair")
            .space(Space { lower: Vector::zeros(), size, boundary })
            .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(0.37).diameter(1.0))
            .interaction(InteractionDraft::new(Model::None).between("A", "A"))
            .interaction(InteractionDraft::new(Model::None).between("B", "B"))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, DEPTH).unwrap()).between("A", "B"))
            .particle("A", Vector::new(1.0, y, 0.0), Vector::zeros())
            .particle("B", Vector::new(3.3, y, 0.0), Vector::zeros());
        let windows = [[1.0, 1.6], [1.4, 2.0], [1.5, 2.4]];
        let (_, found) = results(in_windows(scene, [&[1], &[0]], &windows, [200, 20_000]));
        refuse_other(&found, (found.points.len(), windows[2], dimensions as f64), square_well);
    }
}

/// The windows restrain the distance of a particle from the centre of mass of a dimer with unequal masses. One bead of
/// the dimer has a square well for the particle.
#[test]
fn potential_between_centres_of_mass_averages_over_the_bond() {
    let masses = [1.3, 0.7];
    let (shortest, longest) = (0.9, 1.3);
    let scene = SceneBuilder::new("molecules")
        .space(Space::periodic_cube(8.0))
        .species(SpeciesDraft::new("A").mass(masses[0]).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(masses[1]).diameter(1.0))
        .species(SpeciesDraft::new("C").mass(0.45).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(0.8, 1.5 / 0.8, DEPTH).unwrap()).between("A", "C"))
        .interaction(InteractionDraft::new(Potential::bond(shortest, longest).unwrap()).named("bond"));
    let scene = [("A", "A"), ("A", "B"), ("B", "B"), ("B", "C"), ("C", "C")]
        .into_iter()
        .fold(scene, |scene, (a, b)| scene.interaction(InteractionDraft::new(Model::None).between(a, b)))
        .particle("A", Vector::new(7.8, 4.0, 4.0), Vector::zeros())
        .particle("B", Vector::new(0.8, 4.0, 4.0), Vector::zeros())
        .particle("C", Vector::new(1.8, 5.5, 4.0), Vector::zeros())
        .bond([0, 1], "bond");
    let windows = [[0.6, 1.2], [0.9, 2.0], [1.7, 2.8]];
    let (_, found) = results(in_windows(scene, [&[1, 0], &[2]], &windows, [400, 20_000]));
    let weight = |distance: f64| -> f64 {
        if distance < 0.8 {
            0.0
        } else if distance < 1.5 {
            (DEPTH / TEMPERATURE).exp()
        } else {
            1.0
        }
    };
    let at = |r: f64| {
        let (mut sum, mut norm) = (0.0, 0.0);
        for i in 0..60 {
            let bond = shortest + (longest - shortest) * (f64::from(i) + 0.5) / 60.0;
            let arm = bond * masses[1] / (masses[0] + masses[1]);
            for k in 0..400 {
                let cosine = -1.0 + (f64::from(k) + 0.5) / 200.0;
                sum += bond * bond * weight((r * r + arm * arm - 2.0 * r * arm * cosine).sqrt());
                norm += bond * bond;
            }
        }
        sum / norm
    };
    // The mean over ten thin shells in a bin, weighted by their volumes.
    let expected = |point: &MeanForcePoint| {
        let thin = |k: u32| point.distance + point.width * ((f64::from(k) + 0.5) / 10.0 - 0.5);
        let volume: f64 = (0..10).map(|k| thin(k).powi(2)).sum();
        -TEMPERATURE * ((0..10).map(|k| thin(k).powi(2) * at(thin(k))).sum::<f64>() / volume).ln()
    };
    refuse_other(&found, (found.points.len(), windows[2], 3.0), expected);
    let all = || found.points.iter().map(|point| point.potential_of_mean_force.mean);
    let depth = all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min);
    assert!(depth > 0.8, "{depth}");
}

/// The small spheres pass through each other. They have more room if the large spheres are close.
#[test]
fn large_spheres_have_the_exact_depletion_potential() {
    let (length, count, radius) = (6.6_f64, 70, 1.5_f64);
    let mut scene = SceneBuilder::new("depletion")
        .seed(4)
        .space(Space::periodic_cube(length))
        .species(SpeciesDraft::new("large").mass(5.3).diameter(2.0))
        .species(SpeciesDraft::new("small").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("large", "large"))
        .interaction(InteractionDraft::new(Potential::hard_sphere(radius).unwrap()).between("large", "small"))
        .interaction(InteractionDraft::new(Model::None).between("small", "small"))
        .particle("large", Vector::new(2.0, 3.3, 3.3), Vector::zeros())
        .particle("large", Vector::new(4.7, 3.3, 3.3), Vector::zeros());
    let places = (0..216).map(|k| Vector::new(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36)) * 1.1);
    let is_free = |place: &Vector| [2.0, 4.7].iter().all(|x| (place - Vector::new(*x, 3.3, 3.3)).norm() > radius);
    for place in places.filter(is_free).step_by(2).take(count) {
        scene = scene.particle("small", place, Vector::zeros());
    }
    let windows = [[2.0, 2.6], [2.3, 2.9], [2.6, 3.2]];
    let (_, found) = results(in_windows(scene, [&[0], &[1]], &windows, [200, 4000]));
    let sphere = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let overlap = |r: f64| {
        let depth = (2.0 * radius - r).max(0.0);
        std::f64::consts::PI * (4.0 * radius + r) * depth * depth / 12.0
    };
    let potential = |r: f64| -TEMPERATURE * count as f64 * (length.powi(3) - 2.0 * sphere + overlap(r)).ln();
    refuse_other(&found, (found.points.len(), windows[2], 3.0), |point| potential(point.distance));
    assert!(potential(3.2) - potential(2.0) > 0.5 * TEMPERATURE);
}
