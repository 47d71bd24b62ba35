//! The isothermal-isobaric ensemble. The probability density of the volume is proportional to `Q(V) exp(-P V / T)`,
//! with the configuration integral `Q(V)` over all positions.

mod runs;

use std::f64::consts::PI;

use carom::Vector;
use carom::analysis::statistics::Estimate;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::model::{Barostat, MassRule, RunPlan, Scene, Thermostat, Until};
use carom::run::Finished;
use carom::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

use super::measure::{finish, hard};

const TEMPERATURE: f64 = 1.7;

fn bath(rate: f64) -> Option<Thermostat> {
    Some(Thermostat::Andersen { temperature: TEMPERATURE, rate, axes: [true; 3] })
}

fn plan(pressure: f64, interval: f64, amplitude: f64, moves: u32) -> RunPlan {
    let duration = interval * f64::from(moves);
    RunPlan {
        equilibration: Until::time(0.02 * duration),
        limit: Until::time(duration),
        thermostat: bath(1.0),
        barostat: Some(Barostat { pressure, interval, amplitude: Some(amplitude) }),
        ..RunPlan::default()
    }
}

fn space(edge: f64, dimensions: usize) -> Space {
    let mut space = Space::periodic_cube(edge);
    for axis in dimensions..3 {
        (space.size[axis], space.boundary[axis]) = (0.0, Boundary::Flat);
    }
    space
}

/// Returns the mean and the variance of a volume by Simpson's rule. The integrals start at the volume `least`.
fn moments(least: f64, width: f64, density: impl Fn(f64) -> f64) -> [f64; 2] {
    const STEPS: u32 = 40_000;
    let sums = (0..=STEPS).fold([0.0; 3], |sums, k| {
        let volume = least + width * f64::from(k) / f64::from(STEPS);
        let factor = if k == 0 || k == STEPS { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        let weight = factor * density(volume);
        [sums[0] + weight, sums[1] + weight * volume, sums[2] + weight * volume * volume]
    });
    let mean = sums[1] / sums[0];
    [mean, sums[2] / sums[0] - mean * mean]
}

fn observable(finished: &Finished, name: &str) -> (f64, f64) {
    let Estimate { mean, standard_error, .. } = finished.observable(name).unwrap();
    (mean, standard_error.unwrap())
}

fn compare(finished: &Finished, [mean, variance]: [f64; 2]) {
    let (volume, error) = observable(finished, "volume");
    let (compressibility, error_of_it) = observable(finished, "isothermal_compressibility");
    let (found, error_of_variance) = (compressibility * volume * TEMPERATURE, error_of_it * volume * TEMPERATURE);
    let acceptance = finished.volume_moves.unwrap().acceptance().unwrap();
    println!(
        "volume {volume} +- {error}, exact {mean}; variance {found} +- {error_of_variance}, exact {variance}; {acceptance} accepted"
    );
    assert!((volume - mean).abs() < 4.0 * error && error < 0.02 * mean, "volume {volume} +- {error}, exact {mean}");
    let text = format!("variance {found} +- {error_of_variance}, exact {variance}");
    assert!((found - variance).abs() < 4.0 * error_of_variance && error_of_variance < 0.06 * variance, "{text}");
}

fn rods(rods: &[(f64, f64)], pressure: f64, moves: u32) -> Scene {
    let names = ["A", "B", "C"];
    let length: f64 = 2.0 * rods.iter().map(|(_, length)| length).sum::<f64>();
    let mut scene = SceneBuilder::new("rods").seed(5).space(space(length, 1));
    for (name, (mass, length)) in names.iter().zip(rods) {
        scene = scene.species(SpeciesDraft::new(name).mass(*mass).diameter(*length));
    }
    for (index, (name, (_, length))) in names.iter().zip(rods).enumerate() {
        for (other, (_, other_length)) in names.iter().zip(rods).skip(index) {
            let contact = hard(0.5 * (length + other_length));
            scene = scene.interaction(InteractionDraft::new(contact).between(name, other));
        }
        let x = 1.5 * index as f64 + 0.5;
        scene.insert_particle(name, Vector::new(x, 0.0, 0.0), Vector::new(0.3 - 0.4 * index as f64, 0.0, 0.0));
    }
    scene.run(plan(pressure, 0.4, 1.1, moves)).build().unwrap()
}

/// Like [`rods`], with one species of individual lengths.
fn unlike_rods(rods: &[(f64, f64)], pressure: f64, moves: u32) -> Scene {
    let length: f64 = 2.0 * rods.iter().map(|(_, length)| length).sum::<f64>();
    let mut scene = SceneBuilder::new("rods")
        .seed(5)
        .space(space(length, 1))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(0.7).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
    for (index, (_, length)) in rods.iter().enumerate() {
        let (x, speed) = (1.5 * index as f64 + 0.5, 0.3 - 0.4 * index as f64);
        scene = scene.sized_particle("A", *length, Vector::new(x, 0.0, 0.0), Vector::new(speed, 0.0, 0.0));
    }
    scene.run(plan(pressure, 0.4, 1.1, moves)).build().unwrap()
}

#[test]
fn ring_of_rods_has_the_exact_mean_length_and_variance() {
    // The configuration integral is Q = L (L - a)^(N - 1), with the sum `a` of all contact distances. One of the N rods
    // may be anywhere on the ring of length L. The others share the free length x = L - a in a fixed order.
    let cases = [
        (rods as fn(&[(f64, f64)], f64, u32) -> Scene, &[(1.3, 1.0), (0.7, 0.6)][..], 0.9),
        (rods, &[(1.3, 1.0), (0.7, 0.6), (2.9, 0.8)], 1.4),
        (unlike_rods, &[(1.3, 1.0), (0.7, 0.6), (2.9, 0.8)], 1.4),
    ];
    for (scene, all, pressure) in cases {
        let (n, a) = (i32::try_from(all.len()).unwrap(), all.iter().map(|(_, length)| length).sum::<f64>());
        let b = pressure / TEMPERATURE;
        // The integral of x^(k - 1) exp(-b x).
        let gamma = |k: i32| (1..k).map(f64::from).product::<f64>() / b.powi(k);
        let of = |k: i32| gamma(n + 1 + k) + a * gamma(n + k);
        let (mean, square) = (of(1) / of(0), of(2) / of(0));
        let finished = finish(scene(all, pressure, 60_000));
        compare(&finished, [a + mean, square - mean * mean]);
        // The mean of d/dV ln Q is P / T, so the virial gives the pressure P.
        let (virial, error) = observable(&finished, "pressure");
        println!("pressure {virial} +- {error}, {pressure}");
        assert!((virial - pressure).abs() < 4.0 * error && error < 0.02 * pressure, "{virial} +- {error}");
    }
}

#[test]
fn two_disks_have_exact_volumes_down_to_the_smallest_box() {
    // The configuration integral is Q = V (V - pi), because each disk excludes the other from the area pi.
    let pressure = 0.4;
    let scene = SceneBuilder::new("disks")
        .seed(2)
        .space(space(3.0, 2))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .particle("A", Vector::new(0.5, 0.5, 0.0), Vector::new(0.4, 0.3, 0.0))
        .particle("A", Vector::new(2.0, 2.1, 0.0), Vector::new(-0.2, 0.9, 0.0))
        .run(plan(pressure, 0.4, 1.2, 50_000));
    let density = |volume: f64| volume * (volume - PI) * libm::exp(-pressure * volume / TEMPERATURE);
    let finished = finish(scene.build().unwrap());
    compare(&finished, moments(4.0, 150.0, density));
    let moves = finished.volume_moves.unwrap();
    assert!(moves.too_small > 1_000 && moves.too_small < moves.attempted - moves.accepted, "{moves:?}");
}

#[test]
fn a_square_well_pair_has_its_exact_volume_and_energy() {
    let (pressure, depth, lambda): (f64, f64, f64) = (0.06, 2.3, 1.5);
    let (places, velocities) = (
        [Vector::new(0.5, 0.5, 0.5), Vector::new(2.0, 2.1, 1.9)],
        [Vector::new(0.4, 0.3, 0.1), Vector::new(-0.2, 0.9, 0.2)],
    );
    let pair = SceneBuilder::new("pair").seed(4).space(space(3.5, 3));
    let equal = pair
        .clone()
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, lambda, depth).unwrap()).between("A", "A"))
        .particle("A", places[0], velocities[0])
        .particle("A", places[1], velocities[1]);
    // The sum of the two radii is 1.
    let unlike = pair
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.9).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::SquareWell { lambda, well_depth: depth }).between("A", "A"))
        .sized_particle("A", 1.1, places[0], velocities[0])
        .sized_particle("A", 0.9, places[1], velocities[1]);
    // The box must have room for two particles of the largest diameter.
    for (scene, largest) in [(equal, 1.0), (unlike, 1.1_f64)] {
        let least = (2.0 * lambda * largest).powi(3);
        check_square_well_pair(scene.run(plan(pressure, 0.4, 1.2, 60_000)), [pressure, depth, lambda, least]);
    }
}

fn check_square_well_pair(scene: SceneBuilder, [pressure, depth, lambda, least]: [f64; 4]) {
    let finished = finish(scene.build().unwrap());
    let core = 4.0 * PI / 3.0;
    let shell = core * (lambda.powi(3) - 1.0);
    let bound = shell * libm::exp(depth / TEMPERATURE);
    let weight = |volume: f64| libm::exp(-pressure * volume / TEMPERATURE);
    let density = |volume: f64| volume * (volume - core - shell + bound) * weight(volume);
    let width = 900.0;
    compare(&finished, moments(least, width, density));
    let sum = |of: &dyn Fn(f64) -> f64| {
        let steps = 100_000;
        (0..steps).map(|k| of(least + width * (f64::from(k) + 0.5) / f64::from(steps))).sum::<f64>()
    };
    let exact = -0.5 * depth * sum(&|volume| volume * bound * weight(volume)) / sum(&density);
    let (energy, error) = observable(&finished, "potential_energy_per_particle");
    println!("energy {energy} +- {error}, exact {exact}");
    assert!((energy - exact).abs() < 4.0 * error && error < 0.05 * exact.abs(), "{energy} +- {error}, exact {exact}");
}

#[test]
fn ideal_gas_has_the_volume_of_one_particle_more() {
    // The configuration integral is Q = V^N. The volume has the mean (N + 1) T / P and the variance (N + 1) (T / P)^2.
    let (count, pressure) = (5, 0.8);
    let mut scene = SceneBuilder::new("gas")
        .space(space(3.0, 2))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"));
    for index in 0..count {
        let x = f64::from(index);
        scene.insert_particle("A", Vector::new(0.5 * x, 0.3 * x, 0.0), Vector::new(0.2, 0.1 * x, 0.0));
    }
    let finished = finish(scene.run(plan(pressure, 0.4, 1.0, 40_000)).build().unwrap());
    assert_eq!(finished.volume_moves.unwrap().too_small, 0);
    let unit = TEMPERATURE / pressure;
    compare(&finished, [6.0 * unit, 6.0 * unit * unit]);
    let (temperature, error) = observable(&finished, "temperature");
    assert!((temperature - TEMPERATURE).abs() < 4.0 * error, "{temperature} +- {error}");
}

#[test]
fn too_few_volume_samples_give_an_error_for_temperature_only() {
    let scene = SceneBuilder::new("spheres")
        .seed(4)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
        .temperature(TEMPERATURE)
        .run(plan(3.4, 0.02, 0.02, 2_000));
    let finished = finish(scene.build().unwrap());
    let has_error = |name: &str| finished.observable(name).unwrap().standard_error.is_some();
    assert!(has_error("temperature"));
    for name in [
        "volume",
        "pressure",
        "compressibility_factor",
        "collision_rate",
        "number_density",
        "isothermal_compressibility",
    ] {
        assert!(!has_error(name), "{name}");
    }
}

/// Returns the area covered by two disks of equal radius at the distance `apart`.
fn union(radius: f64, apart: f64) -> f64 {
    let half = 0.5 * apart / radius;
    let lens = 2.0 * radius * radius * (half.acos() - half * (1.0 - half * half).sqrt());
    2.0 * PI * radius * radius - lens
}

#[test]
fn dimer_and_disk_have_the_exact_volume_of_two_molecules() {
    // The configuration integral is Q = V (V - A). The dimer may be anywhere in the area V, and excludes the disk from
    // the mean area A. In the plane, the probability density of a bond length is proportional to the length.
    let (pressure, contact) = (0.5, 0.6);
    let [shortest, longest]: [f64; 2] = [0.5, 1.15];
    let scene = SceneBuilder::new("dimer")
        .seed(6)
        .space(space(4.0, 2))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .species(SpeciesDraft::new("B").mass(1.9).diameter(0.7))
        .species(SpeciesDraft::new("C").mass(1.1).diameter(0.6))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .interaction(InteractionDraft::new(Model::None).between("C", "C"))
        .interaction(InteractionDraft::new(Model::None).between("A", "B"))
        .interaction(InteractionDraft::new(hard(contact)).between("A", "C"))
        .interaction(InteractionDraft::new(hard(contact)).between("B", "C"))
        .interaction(InteractionDraft::new(Potential::bond(shortest, longest).unwrap()).named("link"))
        .particle("A", Vector::new(0.2, 0.5, 0.0), Vector::new(0.4, 0.3, 0.0))
        .particle("B", Vector::new(3.5, 0.4, 0.0), Vector::new(0.1, -0.3, 0.0))
        .particle("C", Vector::new(2.0, 2.1, 0.0), Vector::new(-0.2, 0.9, 0.0))
        .bond([0, 1], "link")
        .run(plan(pressure, 0.4, 1.1, 50_000));
    let finished = finish(scene.build().unwrap());
    let steps = 2_000;
    let (mut area, mut all) = (0.0, 0.0);
    for k in 0..steps {
        let length = shortest + (longest - shortest) * (f64::from(k) + 0.5) / f64::from(steps);
        (area, all) = (area + length * union(contact, length), all + length);
    }
    let excluded = area / all;
    let density = |volume: f64| volume * (volume - excluded) * libm::exp(-pressure * volume / TEMPERATURE);
    // The box must be at least twice as long as the longest bond.
    compare(&finished, moments(4.0 * longest * longest, 150.0, density));
}

#[test]
fn virial_pressure_equals_the_barostat_pressure() {
    let pressure = 3.0;
    let mut run = plan(pressure, 0.05, 0.05, 12_000);
    run.barostat = Some(Barostat { amplitude: None, ..run.barostat.unwrap() });
    run.equilibration = Until::time(60.0);
    let mixture = Fill {
        composition: vec![("A".to_owned(), 0.5), ("B".to_owned(), 0.5)],
        temperature: Some(TEMPERATURE),
        ..Fill::new(Arrangement::Random, "A").count(40).packing_fraction(0.2)
    };
    let between = |a: f64, b: f64| Potential::square_well(0.5 * (a + b), 1.3, 0.4).unwrap();
    let scene = SceneBuilder::new("mixture")
        .seed(8)
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.6).diameter(0.8))
        .interaction(InteractionDraft::new(between(1.0, 1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(between(1.0, 0.8)).between("A", "B"))
        .interaction(InteractionDraft::new(between(0.8, 0.8)).between("B", "B"))
        .fill(mixture)
        .run(run);
    let finished = finish(scene.build().unwrap());
    let (virial, error) = observable(&finished, "pressure");
    assert!((virial - pressure).abs() < 4.0 * error && error < 0.03 * pressure, "{virial} +- {error}");
    let (volume, _) = observable(&finished, "volume");
    let (factor, _) = observable(&finished, "compressibility_factor");
    assert!((factor * 40.0 * TEMPERATURE - pressure * volume).abs() < 1e-9 * pressure * volume);
    let (density, _) = observable(&finished, "number_density");
    let (filled, _) = observable(&finished, "packing_fraction");
    assert!(density > 40.0 / volume && density < 1.02 * 40.0 / volume, "{density}, {volume}");
    assert!((filled / density - PI / 12.0 * (1.0 + 0.512)).abs() < 1e-12);
    let moves = finished.volume_moves.unwrap();
    assert!((0.3..0.5).contains(&moves.acceptance().unwrap()) && moves.attempted == 12_000, "{moves:?}");
}
