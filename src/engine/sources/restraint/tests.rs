use super::*;
use crate::engine::{SingleThread, Until};
use crate::model::space::{Boundary, Space};
use crate::model::{Potential, Scene};
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn ids(groups: [&[u32]; 2]) -> [Vec<ParticleId>; 2] {
    groups.map(|group| group.iter().map(|id| ParticleId(*id)).collect())
}

/// Returns the distance between two groups. Members are in the image nearest to the first member.
fn distance(simulation: &Simulation, groups: [&[u32]; 2]) -> f64 {
    let (scene, snapshot) = (simulation.scene(), simulation.snapshot());
    let periods = scene.space().periods();
    let nearest = |apart: Vector| crate::model::space::minimum_image(apart, &periods);
    let centre = |group: &[u32]| {
        let place = |id: u32| snapshot.positions[id as usize];
        let mass = |id: u32| scene.species_of(ParticleId(id)).mass;
        let first = place(group[0]);
        let sum = group.iter().map(|id| nearest(place(*id) - first) * mass(*id)).sum::<Vector>();
        first + sum / group.iter().map(|id| mass(*id)).sum::<f64>()
    };
    nearest(centre(groups[0]) - centre(groups[1])).norm()
}

/// Six bonded pairs and six single particles, with three masses, in a periodic box. Bonds cross the sides of the box.
fn molecules() -> Scene {
    let bond = Potential::bond(0.9, 1.3).unwrap();
    let mut scene = SceneBuilder::new("molecules")
        .space(Space::periodic_cube(6.0))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(0.8))
        .species(SpeciesDraft::new("B").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("C").mass(2.1).diameter(0.6))
        .interaction(InteractionDraft::new(bond).named("bond"));
    for (a, b, range) in [("A", "A", 0.8), ("A", "B", 0.9), ("B", "B", 1.0), ("A", "C", 0.7), ("B", "C", 0.8)] {
        scene = scene.interaction(InteractionDraft::new(Potential::hard_sphere(range).unwrap()).between(a, b));
    }
    scene = scene.interaction(InteractionDraft::new(Model::HardSphere).between("C", "C"));
    let mut number = 0;
    for (x, y) in [(0.1, 0.2), (0.1, 3.1), (2.0, 1.5), (2.0, 4.4), (4.0, 0.3), (4.0, 3.2)] {
        for (name, z) in [("A", 5.8), ("B", 0.9), ("C", 3.0)] {
            number += 1;
            let velocity = Vector::new(1.0, 0.3, -0.7) * (f64::from(number * 7 % 11) - 5.0) / 4.0;
            scene = scene.particle(name, Vector::new(x, y, z), velocity);
        }
    }
    for pair in 0..6 {
        scene = scene.bond([3 * pair, 3 * pair + 1], "bond");
    }
    scene.build().unwrap()
}

#[test]
fn reflection_at_window_conserves_momentum_energy_and_inner_motion() {
    let groups: [&[u32]; 2] = [&[0, 1], &[8]];
    let mut simulation = Simulation::without_plan(molecules());
    simulation.advance(Until::time(0.3)).unwrap();
    let start = distance(&simulation, groups);
    simulation.restrain_distance(&ids(groups), [start - 0.01, start + 0.01]);
    assert!((simulation.restrained_distance().unwrap() - start).abs() < 1e-12);
    let masses: Vec<f64> = (0..18).map(|id| simulation.scene().species_of(ParticleId(id)).mass).collect();
    let mut reflections = 0;
    for _ in 0..400 {
        let before = simulation.snapshot();
        let counts = simulation.event_counts().physical();
        let next = with_engine!(&simulation.engine, engine => {
            engine.simulated(engine.sources.restraint.as_ref().unwrap().next_reflection())
        });
        let energy = simulation.energy().kinetic;
        // Because of round-off, the reflection may happen slightly before or after the predicted time.
        simulation.advance(Until::time(next + 1e-12)).unwrap();
        let after = simulation.snapshot();
        if simulation.event_counts().physical() > counts {
            continue;
        }
        reflections += 1;
        let changes: Vec<Vector> = after.velocities.iter().zip(&before.velocities).map(|(a, b)| a - b).collect();
        let momentum: Vector = changes.iter().zip(&masses).map(|(change, mass)| change * *mass).sum();
        assert!(momentum.norm() < 1e-13, "{momentum}");
        assert!((simulation.energy().kinetic - energy).abs() < 1e-13 * energy);
        let [one, other, alone] = [0, 1, 8].map(|id| changes[id]);
        assert!((one - other).norm() < 1e-14 && one.norm() > 0.0 && alone.norm() > 0.0, "{one} {other}");
        let others = (0..18).filter(|id| !groups.concat().contains(id));
        assert!(others.map(|id| changes[id as usize]).all(|change| change == Vector::zeros()));
    }
    assert!(reflections > 50, "{reflections}");
}

#[test]
fn system_with_a_restrained_distance_is_not_divided_into_domains() {
    let scene = SceneBuilder::new("two")
        .space(Space::periodic_cube(9.0))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .particle("A", Vector::new(3.0, 1.0, 1.0), Vector::zeros());
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let obstacle = |simulation: &Simulation| with_engine!(&simulation.engine, engine => engine.obstacle());
    assert_eq!(obstacle(&simulation), None);
    simulation.restrain_distance(&ids([&[0], &[1]]), [1.5, 3.0]);
    assert_eq!(obstacle(&simulation), Some(SingleThread::WholeSystem));
}

#[test]
fn restrained_distance_stays_in_its_window() {
    for (groups, half) in [([&[0, 1][..], &[9][..]], 0.4), ([&[2], &[5]], 0.02), ([&[0, 1], &[12, 13]], 1e-3)] {
        let mut simulation = Simulation::without_plan(molecules());
        let start = distance(&simulation, groups);
        let window = [start - half, (start + half).min(2.99)];
        simulation.restrain_distance(&ids(groups), window);
        simulation
            .set_thermostat(
                Some(&crate::model::Thermostat::Andersen { temperature: 1.7, rate: 0.5, axes: [true; 3] }),
                1,
            )
            .unwrap();
        let mut farthest: f64 = 0.0;
        for step in 1..=300 {
            simulation.advance(Until::time(0.1 * f64::from(step))).unwrap();
            let now = distance(&simulation, groups);
            farthest = farthest.max((now - start).abs() / half);
            assert!(window[0] - 1e-13 <= now && now <= window[1] + 1e-13, "{step}: {now} of {window:?}");
        }
        assert!(farthest > 0.9, "{farthest}");
        assert!(simulation.event_counts().physical() > 200);
        assert_eq!(simulation.real_overlaps(), []);
    }
}

#[test]
fn distance_of_two_fluid_spheres_is_restrained() {
    let scene = SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
        .temperature(1.0)
        .build()
        .unwrap();
    let free = {
        let mut simulation = Simulation::without_plan(scene.clone());
        simulation.advance(Until::time(20.0)).unwrap();
        (simulation.energy().kinetic, simulation.restrained_distance())
    };
    let mut simulation = Simulation::without_plan(scene);
    assert!(!simulation.engine().has_table);
    let start = distance(&simulation, [&[0], &[1]]);
    simulation.restrain_distance(&ids([&[0], &[1]]), [1.05, start + 0.1]);
    let mut nearest = start;
    for step in 1..=200 {
        simulation.advance(Until::time(0.1 * f64::from(step))).unwrap();
        nearest = nearest.min(simulation.restrained_distance().unwrap());
        let now = distance(&simulation, [&[0], &[1]]);
        assert!((1.05 - 1e-14..=start + 0.1 + 1e-14).contains(&now), "{now}");
    }
    assert!(nearest < 1.1);
    assert!((simulation.energy().kinetic / free.0 - 1.0).abs() < 1e-12 && free.1.is_none());
}

#[test]
fn distances_are_restrained_in_one_two_and_three_dimensions() {
    let wall = Boundary::walls(1.0);
    for (size, boundary, gravity) in [
        (Vector::new(30.0, 0.0, 0.0), [Boundary::Periodic, Boundary::Flat, Boundary::Flat], Vector::zeros()),
        (Vector::new(9.0, 9.0, 0.0), [Boundary::Periodic, Boundary::Periodic, Boundary::Flat], Vector::zeros()),
        (Vector::new(9.0, 9.0, 9.0), [wall, Boundary::Periodic, wall], Vector::new(0.0, 0.0, -0.3)),
    ] {
        let is_free = |axis: usize| size[axis] > 0.0;
        let mut scene =
            SceneBuilder::new("few").space(Space { lower: Vector::zeros(), size, boundary }).gravity(gravity);
        for (name, mass) in [("A", 1.3), ("B", 0.7)] {
            scene.insert_species(SpeciesDraft::new(name).diameter(1.0).mass(mass));
        }
        for (a, b) in [("A", "A"), ("A", "B"), ("B", "B")] {
            scene =
                scene.interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 0.4).unwrap()).between(a, b));
        }
        for (name, x, v) in [("A", 1.0, 0.9), ("B", 3.1, -1.1), ("A", 5.2, 0.2), ("B", 7.1, -0.4)] {
            let keep = |v: Vector| Vector::from_fn(|axis, _| if is_free(axis) { v[axis] } else { 0.0 });
            scene = scene.particle(name, keep(Vector::new(x, 4.0, 4.0)), keep(Vector::new(v, 0.3 * v, -v)));
        }
        let mut simulation = Simulation::without_plan(scene.build().unwrap());
        simulation.restrain_distance(&ids([&[0], &[1]]), [1.9, 2.5]);
        let [mut least, mut most] = [f64::INFINITY, 0.0_f64];
        for step in 1..=400 {
            simulation.advance(Until::time(0.25 * f64::from(step))).unwrap();
            let now = distance(&simulation, [&[0], &[1]]);
            (least, most) = (least.min(now), most.max(now));
        }
        assert!((1.9 - 1e-13..1.95).contains(&least) && (2.45..=2.5 + 1e-13).contains(&most), "{least} {most}");
        let bytes = postcard::to_allocvec(&simulation).unwrap();
        let mut copy: Simulation = postcard::from_bytes(&bytes).unwrap();
        for simulation in [&mut simulation, &mut copy] {
            simulation.advance(Until::time(130.0)).unwrap();
        }
        assert_eq!(simulation.snapshot(), copy.snapshot());
    }
}

#[test]
fn a_distance_at_an_end_of_its_window_comes_back() {
    for (speed, is_lower) in [(0.7, false), (-0.7, true), (1e-200, false), (0.0, false)] {
        for offset in [-1, 0, 1_i64] {
            let scene = SceneBuilder::new("pair")
                .space(Space::periodic_cube(9.0))
                .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
                .species(SpeciesDraft::new("B").mass(0.7).diameter(1.0))
                .interaction(InteractionDraft::new(Model::None).between("A", "A"))
                .interaction(InteractionDraft::new(Model::None).between("A", "B"))
                .interaction(InteractionDraft::new(Model::None).between("B", "B"))
                .particle("A", Vector::new(1.0, 4.0, 4.0), Vector::new(0.2, 0.0, 0.0))
                .particle("B", Vector::new(3.1, 4.0, 4.0), Vector::new(0.2 + speed, 0.0, 0.0))
                .build()
                .unwrap();
            let mut simulation = Simulation::without_plan(scene);
            simulation.restrain_distance(&ids([&[0], &[1]]), [0.0, f64::INFINITY]);
            let end = simulation.restrained_distance().unwrap();
            let end = f64::from_bits(end.to_bits().wrapping_add_signed(offset));
            let window = if is_lower { [end, 4.0] } else { [1.5, end] };
            simulation.set_distance_window(window);
            simulation.advance(Until::time(0.2)).unwrap();
            let now = simulation.restrained_distance().unwrap();
            let expected = if is_lower { end + 0.2 * speed.abs() } else { end - 0.2 * speed };
            assert!((now - expected).abs() < 1e-12, "{now}, expected {expected}");
            simulation.advance(Until::time(50.0)).unwrap();
            let now = simulation.restrained_distance().unwrap();
            assert!((window[0] - 1e-13..=window[1] + 1e-13).contains(&now), "{now} of {window:?}");
        }
    }
}
