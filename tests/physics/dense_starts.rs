//! Starts that are too dense for random insertion.

use carom::Vector;
use carom::analysis::instruments::bond_order::per_particle;
use carom::analysis::instruments::{Sample, SystemDescription};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::{
    Arrangement, Fill, InteractionDraft, Lattice, SceneBuilder, SceneError, SceneErrorKind, SpeciesDraft,
};

use super::measure::hard;

fn equal(count: u64, fraction: f64, arrangement: impl Into<Arrangement>) -> SceneBuilder {
    SceneBuilder::new("equal")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(arrangement, "A").count(count).packing_fraction(fraction))
}

fn mixture(count: u64, fraction: f64) -> SceneBuilder {
    let fill = Fill {
        composition: vec![("A".into(), 0.5), ("B".into(), 0.5)],
        ..Fill::new(Arrangement::Random, "A").count(count).packing_fraction(fraction)
    };
    two_sizes().fill(fill)
}

fn two_sizes() -> SceneBuilder {
    SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(2.0).diameter(1.4))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(hard(1.2)).between("A", "B"))
        .interaction(InteractionDraft::new(hard(1.4)).between("B", "B"))
}

const DISKS: [Boundary; 3] = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];

fn closest(scene: &Scene) -> f64 {
    let size = scene.space().size;
    let mut closest = f64::INFINITY;
    for (i, a) in scene.particles().iter().enumerate() {
        for b in &scene.particles()[..i] {
            let mut apart: Vector = a.position - b.position;
            for k in (0..3).filter(|&k| size[k] > 0.0) {
                apart[k] -= size[k] * (apart[k] / size[k]).round();
            }
            let Some(id) = scene.interaction_of(a.species, b.species) else { continue };
            let Some(core) = scene.interactions()[id.0 as usize].potential.core() else { continue };
            closest = closest.min(apart.norm() / core);
        }
    }
    closest
}

fn assert_valid(scene: &Scene, fraction: f64) {
    assert!(closest(scene) >= 1.0, "{}", closest(scene));
    assert!((scene.packing_fraction() / fraction - 1.0).abs() < 1e-12, "{}", scene.packing_fraction());
    let (lower, upper) = (scene.space().lower, scene.space().upper());
    for particle in scene.particles() {
        let position = particle.position;
        assert!((0..3).all(|k| position[k] >= lower[k] && (position[k] < upper[k] || lower[k] == upper[k])));
    }
}

fn mean_q6(scene: &Scene) -> f64 {
    let positions: Vec<Vector> = scene.particles().iter().map(|particle| particle.position).collect();
    let images = vec![[0; 3]; positions.len()];
    let sample = Sample { positions: &positions, velocities: &positions, images: &images, ..Sample::default() };
    let values = per_particle(&SystemDescription::of(scene), &sample, 1.4, 6);
    values.iter().sum::<f64>() / values.len() as f64
}

/// Returns the pair correlation function in ten bins between distances of 3 and 4 diameters.
fn far_pairs(scene: &Scene) -> [f64; 10] {
    let (size, count) = (scene.space().size, scene.particles().len() as f64);
    let mut bins = [0.0; 10];
    for (i, a) in scene.particles().iter().enumerate() {
        for b in &scene.particles()[..i] {
            let apart = (a.position - b.position).zip_map(&size, |x, period| x - period * (x / period).round());
            let bin = (apart.norm() - 3.0) * 10.0;
            if (0.0..10.0).contains(&bin) {
                #[expect(clippy::cast_possible_truncation, reason = "one of ten bins")]
                let bin = bin as usize;
                bins[bin] += 1.0;
            }
        }
    }
    let pairs = 0.5 * count * (count - 1.0) / scene.space().volume();
    std::array::from_fn(|bin| {
        let (inner, outer) = (3.0 + 0.1 * bin as f64, 3.1 + 0.1 * bin as f64);
        bins[bin] / (pairs * 4.0 / 3.0 * std::f64::consts::PI * (outer.powi(3) - inner.powi(3)))
    })
}

#[test]
fn equal_spheres_start_dense_and_disordered() {
    let scene = equal(1000, 0.62, Arrangement::Random).temperature(1.0).build().unwrap();
    assert_valid(&scene, 0.62);
    // The mean of q6 is 0.575 on the lattice, and about 0.4 in a random packing.
    let lattice = equal(864, 0.62, Lattice::FaceCentredCubic).build().unwrap();
    assert!((mean_q6(&lattice) - 0.575).abs() < 0.001, "{}", mean_q6(&lattice));
    assert!(mean_q6(&scene) < 0.45, "{}", mean_q6(&scene));
    // A lattice has peaks in the pair correlation function, with zeros between them.
    let shells = far_pairs(&lattice);
    assert!(shells.contains(&0.0) && shells.iter().any(|&value| value > 2.0), "{shells:?}");
    let fluid = far_pairs(&scene);
    assert!(fluid.iter().all(|value| (0.8..1.25).contains(value)), "{fluid:?}");
    let momentum: Vector = scene.particles().iter().map(|particle| particle.velocity).sum();
    assert!(momentum.norm() < 1e-11);
}

#[test]
fn a_dense_start_follows_from_the_seed() {
    let scene = |seed| mixture(200, 0.6).seed(seed).build().unwrap().into_parts().particles;
    assert_eq!(scene(1), scene(1));
    let (one, two) = (scene(1), scene(2));
    assert!(one.iter().zip(&two).all(|(a, b)| a.position != b.position));
}

#[test]
fn mixtures_and_disks_start_dense() {
    assert_valid(&mixture(500, 0.62).build().unwrap(), 0.62);
    let disks = mixture(500, 0.7).boundary(DISKS).build().unwrap();
    assert_valid(&disks, 0.7);
    assert!(disks.particles().iter().all(|particle| particle.position.z == 0.0));
    let rods = [Boundary::Periodic, Boundary::Flat, Boundary::Flat];
    assert_valid(&mixture(100, 0.9).boundary(rods).build().unwrap(), 0.9);
}

#[test]
fn dense_start_depends_on_cores_not_on_diameters() {
    // Core diameters are 0.8 for A and A, and 1.05 for A and B. Pairs of B have no core.
    let well = |core| Potential::square_well(core, 1.5, 1.0).unwrap();
    let fill = Fill {
        composition: vec![("A".into(), 0.5), ("B".into(), 0.5)],
        ..Fill::new(Arrangement::Random, "A").count(500).number_density(0.8)
    };
    let scene = SceneBuilder::new("wells")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(well(0.8)).between("A", "A"))
        .interaction(InteractionDraft::new(well(1.05)).between("A", "B"))
        .interaction(InteractionDraft::new(Potential::penetrable(1.0, 2.0).unwrap()).between("B", "B"))
        .fill(fill)
        .build()
        .unwrap();
    assert!(closest(&scene) >= 1.0);
}

fn reached(result: Result<Scene, SceneError>) -> f64 {
    let error = result.unwrap_err();
    assert_eq!(error.config_path().to_string(), "fill[0]");
    match error.kind() {
        SceneErrorKind::Jammed { reached, .. } => *reached,
        _ => panic!("{error}"),
    }
}

#[test]
fn packing_fractions_beyond_random_packing_are_rejected() {
    assert_eq!(reached(equal(1000, 0.70, Arrangement::Random).build()), 0.66);
    // Random close packing of a mixture with diameters 1 and 1.4 is at about 0.645 for spheres, and 0.84 for disks.
    let fraction = reached(mixture(200, 0.9).build());
    assert!((0.60..0.67).contains(&fraction), "{fraction}");
    let fraction = reached(mixture(200, 0.95).boundary(DISKS).build());
    assert!((0.80..0.87).contains(&fraction), "{fraction}");
}

#[test]
fn starts_with_walls_or_other_particles_are_filled_one_by_one() {
    let walls = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic];
    let refused = |scene: SceneBuilder| {
        let error = scene.build().unwrap_err();
        assert!(matches!(error.kind(), SceneErrorKind::NoRoom { .. }), "{error}");
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        assert!(help.contains("a fully periodic box that contains only one fill"), "{help}");
    };
    refused(equal(100, 0.5, Arrangement::Random).boundary(walls));
    refused(equal(100, 0.5, Arrangement::Random).particle("A", Vector::zeros(), Vector::zeros()));
    assert!(equal(100, 0.3, Arrangement::Random).boundary(walls).build().is_ok());
}

#[test]
fn as_many_as_fit_places_the_count_that_the_error_reports() {
    let walls = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic];
    let edge = libm::cbrt(100.0 * std::f64::consts::PI / 6.0 / 0.5);
    let scene = |fill: Fill| {
        SceneBuilder::new("packed")
            .space(Space { boundary: walls, ..Space::periodic_cube(edge) })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
            .fill(fill)
    };
    let random = || Fill::new(Arrangement::Random, "A");
    let error = scene(random().count(100)).build().unwrap_err();
    let SceneErrorKind::NoRoom { placed, .. } = *error.kind() else { panic!("{error}") };
    assert!(miette::Diagnostic::help(&error).unwrap().to_string().contains("as_many_as_fit"));
    let fitted = scene(random().count(100).as_many_as_fit()).build().unwrap();
    assert_eq!(fitted.particles().len(), placed);
    assert!(closest(&fitted) >= 1.0);
    // Random insertion stops at a packing fraction of about 0.38, and slightly earlier between walls.
    assert!((50..76).contains(&placed), "{placed}");
    let all = scene(random().as_many_as_fit()).build().unwrap();
    assert_eq!(all.particles(), fitted.particles());
    assert_eq!(scene(random().count(20).as_many_as_fit()).build().unwrap().particles().len(), 20);
    // The first fill places 30 particles.
    let two = scene(random().count(30)).fill(random().as_many_as_fit()).build().unwrap();
    assert!((50..76).contains(&two.particles().len()) && closest(&two) >= 1.0);
    let small = SceneBuilder::new("cores")
        .space(Space::periodic_cube(6.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(0.5, 1.5, 1.0).unwrap()).between("A", "A"))
        .fill(random().as_many_as_fit())
        .build()
        .unwrap();
    // The packing fraction is between 0.3 and 0.385.
    assert!((990..1271).contains(&small.particles().len()), "{}", small.particles().len());
}

#[test]
fn as_many_as_fit_keeps_the_composition_of_a_mixture() {
    let fill = Fill { composition: vec![("A".into(), 1.0), ("B".into(), 3.0)], ..Fill::new(Arrangement::Random, "A") };
    let scene = two_sizes().space(Space::periodic_cube(12.0)).fill(fill.as_many_as_fit()).build().unwrap();
    assert!((0.3..0.42).contains(&scene.packing_fraction()), "{}", scene.packing_fraction());
    let all = scene.particles().len() as f64;
    let small = scene.particles().iter().filter(|particle| particle.species.0 == 0).count() as f64;
    // The tolerance is four standard deviations of independent random species.
    assert!((small / all - 0.25).abs() < 4.0 * (0.25_f64 * 0.75 / all).sqrt(), "{small} of {all}");
}
