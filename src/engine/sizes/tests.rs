use crate::Vector;
use crate::check::reference::Reference;
use crate::check::verify::{EventRange, verify};
use crate::engine::{Chosen, SetStateError, Simulation, Until};
use crate::model::potential::Potential;
use crate::model::random::{Purpose, Random};
use crate::model::space::{Boundary, Space, nearest_image};
use crate::model::{
    DiameterDistribution, Growth, GrowthTarget, MassRule, Particle, ParticleId, Scene, SpeciesId, Swap,
};
use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use std::ops::ControlFlow;

const WIDE: DiameterDistribution = DiameterDistribution::PowerLaw { exponent: 3.0, lower: 0.73, upper: 1.62 };

fn fluid(masses: MassRule, packing_fraction: f64, count: u64) -> SceneBuilder {
    SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(0.7).individual_diameters(masses).distributed(WIDE))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(count).packing_fraction(packing_fraction))
        .temperature(1.3)
}

/// The same particles, with a separate species for each particle.
fn species_of_one(scene: &Scene) -> Scene {
    let mut builder = SceneBuilder::new("species").space(scene.space().clone());
    let name = |k: usize| format!("S{k}");
    for (k, particle) in scene.particles().iter().enumerate() {
        let species = scene.own_species(particle);
        builder = builder.species(SpeciesDraft::new(&name(k)).mass(species.mass).diameter(species.diameter));
        for other in 0..=k {
            builder = builder.interaction(InteractionDraft::new(Model::HardSphere).between(&name(k), &name(other)));
        }
        builder = builder.particle(&name(k), particle.position, particle.velocity);
    }
    builder.build().unwrap()
}

#[test]
fn particles_with_their_own_diameters_move_like_species_of_one_particle() {
    for (masses, packing_fraction) in [(MassRule::Volume, 0.05), (MassRule::Volume, 0.35), (MassRule::Constant, 0.2)] {
        let scene = fluid(masses, packing_fraction, 60).build().unwrap();
        let mut sizes: Vec<f64> = scene.particles().iter().map(|particle| particle.diameter.unwrap()).collect();
        sizes.sort_by(f64::total_cmp);
        assert!(sizes.windows(2).all(|pair| pair[0] < pair[1]) && sizes[59] > 2.0 * sizes[0]);
        let mut runs = [scene.clone(), species_of_one(&scene)].map(|scene| Simulation::new(scene).unwrap());
        let ends = runs.each_mut().map(|simulation| {
            simulation.advance(Until::events(240)).unwrap();
            (simulation.time(), simulation.snapshot().positions, simulation.energy().kinetic)
        });
        // The neighbour searches differ, which changes when positions are rounded.
        assert!((ends[0].0 / ends[1].0 - 1.0).abs() < 1e-6, "{} {}", ends[0].0, ends[1].0);
        assert!((ends[0].2 / ends[1].2 - 1.0).abs() < 1e-12);
        for (one, other) in ends[0].1.iter().zip(&ends[1].1) {
            let apart = nearest_image(one - other, &scene.space().periods(), 0.0).norm();
            assert!(apart < 1e-5, "{apart}");
        }
    }
}

/// Sticky grains of all sizes that fall between walls onto static spheres of another species.
fn falling() -> Scene {
    let well = Model::SquareWell { lambda: 1.3, well_depth: 0.4 };
    let boundary = [Boundary::walls(0.9), Boundary::walls(0.9), Boundary::Periodic];
    let mut scene = SceneBuilder::new("falling")
        .gravity(Vector::new(0.0, -1.0, 0.0))
        .contact_time(0.01)
        .space(Space { lower: Vector::zeros(), size: Vector::new(8.0, 12.0, 8.0), boundary })
        .species(SpeciesDraft::new("grain").mass(1.3).diameter(0.8).individual_diameters(MassRule::Volume))
        .species(SpeciesDraft::new("floor").diameter(1.0).fixed())
        .interaction(InteractionDraft::new(well.clone()).between("grain", "grain").restitution(0.8).friction(0.4))
        .interaction(InteractionDraft::new(well).between("grain", "floor").restitution(0.8));
    for k in 0..40_u32 {
        let at = |n: u32| 0.8 + 1.6 * f64::from(n);
        let velocity = Vector::new(0.3 * f64::from(k % 7) - 0.9, 0.1, 0.2 * f64::from(k % 5) - 0.4);
        let place = Vector::new(at(k % 5), 3.0 + at(k / 25), at(k / 5 % 5));
        scene = scene.sized_particle("grain", 0.5 + 0.02 * f64::from(k * 7 % 40), place, velocity);
    }
    for k in 0..25 {
        let at = |n: u32| 0.8 + 1.6 * f64::from(n);
        scene = scene.particle("floor", Vector::new(at(k % 5), 0.7, at(k / 5)), Vector::zeros());
    }
    scene.build().unwrap()
}

/// Sticky beads of all sizes in chains of four.
fn beads() -> SceneBuilder {
    let mut scene = SceneBuilder::new("beads")
        .space(Space::periodic_cube(8.0))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.8).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::SquareWell { lambda: 1.4, well_depth: 0.6 }).between("A", "A"))
        .interaction(InteractionDraft::new(Potential::bond(0.72, 1.12).unwrap()).named("link"));
    let mut last = (0.0, 0.0);
    for k in 0..32_u32 {
        let at = |n: u32| 0.7 + 1.7 * f64::from(n);
        let diameter = 0.6 + 0.02 * f64::from(k * 11 % 32);
        // The next bead of a chain is in the middle of the range of its bond.
        let along = if k % 4 == 0 { 0.7 } else { last.0 + 0.575 * (diameter + last.1) };
        last = (along, diameter);
        let place = Vector::new(along, at(k / 4 % 4), 1.5 + 2.0 * at(k / 16));
        let velocity = Vector::new(0.3 * f64::from(k % 7) - 0.9, 0.1, 0.2 * f64::from(k % 5) - 0.4);
        scene = scene.sized_particle("A", diameter, place, velocity);
    }
    (0..32_u32).filter(|k| k % 4 != 3).fold(scene, |scene, k| scene.bond([ParticleId(k), ParticleId(k + 1)], "link"))
}

#[test]
fn runs_with_individual_diameters_are_proven() {
    let scenes = [falling(), fluid(MassRule::Volume, 0.4, 80).build().unwrap(), beads().build().unwrap()];
    for (scene, events) in scenes.into_iter().zip([1_500, 1_500, 1_000]) {
        let name = scene.name().to_owned();
        let certificate = verify(scene, EventRange { from: 0, events }, &mut |_| ControlFlow::Continue(()));
        assert!(certificate.is_proven(), "{name}: {certificate:?}");
        assert_eq!(certificate.counts.events(), events);
    }
}

#[test]
fn bonds_scale_with_the_diameters_of_their_particles() {
    let scene = beads().build().unwrap();
    let radius = |id: ParticleId| 0.5 * scene.particles()[id.0 as usize].diameter.unwrap();
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    let mut ends = [f64::INFINITY, 0.0];
    for part in 1..=40 {
        simulation.advance(Until::events(100 * part)).unwrap();
        let now = simulation.snapshot();
        for bond in scene.bonds() {
            let [a, b] = bond.pair.map(|id| now.positions[id.0 as usize]);
            let scaled = nearest_image(a - b, &scene.space().periods(), 0.0).norm() * 0.8
                / (radius(bond.pair[0]) + radius(bond.pair[1]));
            assert!((0.72 - 1e-13..1.12 + 1e-13).contains(&scaled), "{scaled}");
            ends = [ends[0].min(scaled), ends[1].max(scaled)];
        }
    }
    assert!(ends[0] < 0.74 && ends[1] > 1.1, "{ends:?}");
}

#[test]
fn a_bond_that_is_too_long_for_its_particles_is_refused() {
    // The bond of particles with diameters of 0.6 and 0.7 is between 0.585 and 0.91 long, within round-off.
    let pair = |distance: f64| {
        SceneBuilder::new("pair")
            .space(Space::periodic_cube(4.0))
            .species(SpeciesDraft::new("A").mass(0.7).diameter(0.8).individual_diameters(MassRule::Volume))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Potential::bond(0.72, 1.12).unwrap()).named("link"))
            .sized_particle("A", 0.6, Vector::new(1.0, 1.0, 1.0), Vector::zeros())
            .sized_particle("A", 0.7, Vector::new(1.0 + distance, 1.0, 1.0), Vector::zeros())
            .bond([ParticleId(0), ParticleId(1)], "link")
            .build()
    };
    assert!(pair(0.59).is_ok() && pair(0.905).is_ok());
    for distance in [0.58, 0.92] {
        let error = pair(distance).unwrap_err().to_string();
        assert!(error.contains("0.58499") && error.contains("0.90999"), "{error}");
    }
}

#[test]
fn individual_diameters_have_the_events_of_the_reference_engine() {
    for scene in [falling(), fluid(MassRule::Volume, 0.3, 40).build().unwrap(), beads().build().unwrap()] {
        let mut reference = Reference::new(&scene).unwrap();
        let mut events = Vec::new();
        let mut simulation = Simulation::new(scene.clone()).unwrap();
        simulation
            .advance_with(Until::events(200), |event| events.push((event.time, event.particle, event.partner())))
            .unwrap();
        for (time, particle, partner) in events {
            let expected = reference.step_before(f64::INFINITY).unwrap();
            assert!((time - expected.time).abs() < 1e-9 * (1.0 + time), "{time} {expected:?}");
            let sorted = |a: ParticleId, b: Option<ParticleId>| b.map_or([a, a], |b| [a.min(b), a.max(b)]);
            assert_eq!(sorted(particle, partner), sorted(expected.particle, expected.partner));
        }
    }
}

#[test]
fn swap_moves_exchange_individual_diameters() {
    let scene = fluid(MassRule::Volume, 0.45, 200).build().unwrap();
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    let sorted = |simulation: &Simulation| {
        let mut diameters = simulation.snapshot().diameters;
        diameters.sort_by(f64::total_cmp);
        diameters
    };
    let (first, before, energy) = (sorted(&simulation), simulation.snapshot().diameters, simulation.energy().kinetic);
    let mut random = Random::new(5, Purpose::Swap, 0);
    let mut accepted = 0;
    for _ in 0..5 {
        let moves = simulation.swap(&Swap { interval: 1.0, attempts: None, largest_ratio: None }, &mut random);
        accepted += moves.accepted;
        assert_eq!(moves.alike, 0);
        simulation.advance(Until::events(simulation.event_counts().physical() + 1_000)).unwrap();
        assert_eq!(simulation.real_overlaps(), []);
    }
    assert!(accepted > 20, "{accepted}");
    assert_eq!(sorted(&simulation), first);
    assert_ne!(simulation.snapshot().diameters, before);
    assert!((simulation.energy().kinetic / energy - 1.0).abs() < 1e-12);
    let Chosen::FreeTable(engine) = &simulation.engine else { panic!("an engine with a table") };
    let rows = &engine.pairs.rules.rows;
    for particle in engine.particles() {
        let own = Particle::new(SpeciesId(0), Vector::zeros(), Vector::zeros());
        assert_eq!(engine.row(particle), rows.row_of(&own.diameter(2.0 * engine.radius(particle))));
    }
}

#[test]
fn particles_that_are_inserted_have_diameters_within_the_range_of_their_species() {
    let scene = fluid(MassRule::Volume, 0.02, 30).build().unwrap();
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    simulation.remove(&[ParticleId(3), ParticleId(17)]).unwrap();
    let place = scene.particles()[3].position;
    let new = |diameter: Option<f64>| Particle { diameter, ..Particle::new(SpeciesId(0), place, Vector::x()) };
    for wrong in [None, Some(0.1), Some(2.0), Some(f64::NAN)] {
        let error = simulation.insert(&[new(wrong)]).unwrap_err();
        let SetStateError::Diameter { range: Some([smallest, largest]), .. } = error else { panic!("{error}") };
        assert!(smallest < 0.74 && largest > 1.55, "{error}");
    }
    let id = simulation.insert(&[new(Some(1.1))]).unwrap()[0];
    simulation.advance(Until::events(2_000)).unwrap();
    let snapshot = simulation.snapshot();
    assert_eq!(snapshot.diameters[snapshot.index(id).unwrap()], 1.1);
    assert_eq!(snapshot.diameters.len(), 29);
    assert_eq!(simulation.real_overlaps(), []);
}

#[test]
fn a_box_without_particles_takes_particles_with_diameters_again() {
    let scene = fluid(MassRule::Volume, 0.02, 30).build().unwrap();
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    let all: Vec<ParticleId> = (0..30).map(ParticleId).collect();
    simulation.remove(&all).unwrap();
    let places = [Vector::zeros(), 2.0 * Vector::x()];
    let sized = |k: usize| Particle::new(SpeciesId(0), places[k], Vector::zeros()).diameter([1.1, 0.9][k]);
    simulation.insert(&[sized(0), sized(1)]).unwrap();
    assert_eq!(simulation.snapshot().diameters, [1.1, 0.9]);
    simulation.advance(Until::time(1.0)).unwrap();
    assert_eq!((simulation.event_counts().physical(), simulation.real_overlaps()), (0, vec![]));
}

#[test]
fn growth_keeps_the_diameters_that_swap_moves_have_exchanged() {
    let mixture = SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(1.3).diameter(0.8))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "B"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
        .fill(Fill::new(Arrangement::Random, "A").count(50).packing_fraction(0.15))
        .fill(Fill::new(Arrangement::Random, "B").count(50))
        .temperature(1.0);
    for scene in [fluid(MassRule::Volume, 0.3, 100), mixture] {
        let mut simulation = Simulation::new(scene.build().unwrap()).unwrap();
        let mut random = Random::new(5, Purpose::Swap, 0);
        let moves = simulation.swap(&Swap { interval: 1.0, attempts: None, largest_ratio: None }, &mut random);
        assert!(moves.accepted > 5, "{}", moves.accepted);
        let before = simulation.snapshot();
        simulation.grow(&Growth { rate: 0.1, until: GrowthTarget::PackingFraction(0.35) }, 1.05);
        simulation.advance(Until::time(0.3)).unwrap();
        let scale = simulation.snapshot().scale;
        assert!(scale > 1.02);
        simulation.end_growth();
        let after = simulation.snapshot();
        assert_eq!(after.species, before.species);
        for (before, after) in before.diameters.iter().zip(&after.diameters) {
            assert!((after / (scale * before) - 1.0).abs() < 1e-14, "{after} {before}");
        }
        simulation.advance(Until::events(simulation.event_counts().physical() + 1_000)).unwrap();
        assert_eq!(simulation.real_overlaps(), []);
    }
}

/// The contact distance of an individual and an equal particle is the mean of their diameters while they grow, too.
#[test]
fn dense_fills_may_mix_individual_and_equal_diameters() {
    let mut fill = Fill::new(Arrangement::Random, "A").count(300).packing_fraction(0.56);
    fill.composition = vec![("A".to_owned(), 0.5), ("B".to_owned(), 0.5)];
    let pair = |a, b| InteractionDraft::new(Model::HardSphere).between(a, b);
    let scene = SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("A").mass(0.7).distributed(WIDE))
        .species(SpeciesDraft::new("B").mass(1.3).diameter(0.5))
        .interaction(pair("A", "A"))
        .interaction(pair("A", "B"))
        .interaction(pair("B", "B"))
        .fill(fill)
        .temperature(1.0)
        .build()
        .unwrap();
    assert!((scene.packing_fraction() - 0.56).abs() < 1e-12, "{}", scene.packing_fraction());
    let simulation = Simulation::new(scene).unwrap();
    assert_eq!(simulation.real_overlaps(), []);
}
