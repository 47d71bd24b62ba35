//! Rough contacts: exact bounces, conservation, and equipartition with the spins.

use crate::measure::Mean;
use carom::Vector;
use carom::check::verify::{EventRange, verify};
use carom::engine::{Simulation, Until};
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, MotionKind, ParticleId, Roughness, Scene, SurfaceMotion, SurfaceShape};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

const OPEN: [Boundary; 3] = [Boundary::OPEN; 3];

fn hard() -> InteractionDraft {
    InteractionDraft::new(Model::HardSphere)
}

/// A ball of mass 1.3 and radius 0.7 above a rough floor, which is a wall or a surface.
fn ball(is_wall: bool, [restitution, tangential, friction]: [f64; 3], velocity: Vector, spin: Vector) -> Simulation {
    let roughness = Roughness { tangential_restitution: tangential, friction };
    let floor = Face::Wall(ContactLaw::rough(restitution, roughness));
    let mut boundary = OPEN;
    if is_wall {
        boundary[2] = Boundary::Bounded { lower: floor, upper: Face::Open };
    }
    let mut scene = SceneBuilder::new("ball")
        .species(SpeciesDraft::new("ball").mass(1.3).diameter(1.4))
        .interaction(hard().between("ball", "ball"))
        .space(Space { boundary, ..Space::periodic_cube(10.0) })
        .spinning_particle("ball", Vector::new(5.0, 5.0, 1.0), velocity, spin);
    if !is_wall {
        let plane = SurfaceShape::Plane { point: Vector::zeros(), normal: Vector::z() };
        let surface = SurfaceDraft::new("floor", plane).restitution(restitution);
        scene = scene.surface(surface.tangential_restitution(tangential).friction(friction));
    }
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    simulation.advance(Until::events(1)).unwrap();
    simulation
}

#[test]
fn a_ball_bounces_off_a_rough_floor_as_in_the_textbook() {
    let (e, radius, vn) = (0.6, 0.7, 0.8);
    for is_wall in [true, false] {
        for (b, mu, vt, slides) in [(0.25, 0.3, 3.0, true), (0.25, 0.3, 1.0, false), (0.0, f64::INFINITY, 3.0, false)] {
            assert_eq!(mu * (1.0 + e) * vn < (1.0 + b) * 2.0 / 7.0 * vt, slides);
            let simulation = ball(is_wall, [e, b, mu], Vector::new(vt, 0.0, -vn), Vector::zeros());
            let [v, w] = [simulation.snapshot().velocities[0], simulation.snapshot().spins[0]];
            let (expected, turned) = if slides {
                (vt - mu * (1.0 + e) * vn, 2.5 * mu * (1.0 + e) * vn / radius)
            } else {
                (vt * (1.0 - 2.0 / 7.0 * (1.0 + b)), 5.0 / 7.0 * (1.0 + b) * vt / radius)
            };
            assert!((v - Vector::new(expected, 0.0, e * vn)).norm() < 1e-15, "{v}");
            assert!((w - Vector::new(0.0, turned, 0.0)).norm() < 1e-14, "{w}");
            if b == 0.0 {
                assert!((v.x - radius * w.y).abs() < 1e-15, "the ball rolls");
            }
        }
        // A ball that rolls on the floor feels no tangential impulse.
        let simulation = ball(is_wall, [e, 0.5, 0.2], Vector::new(1.4, 0.0, -vn), Vector::new(0.0, 2.0, 0.0));
        let [v, w] = [simulation.snapshot().velocities[0], simulation.snapshot().spins[0]];
        assert!((v - Vector::new(1.4, 0.0, e * vn)).norm() < 1e-15 && (w.y - 2.0).abs() < 1e-15, "{v} {w}");
    }
}

#[test]
fn a_ball_takes_over_the_speed_of_a_rough_turning_drum() {
    // A ball inside a cylinder that turns about its axis. With b = 0, the surfaces have equal velocities after the
    // contact.
    let (frequency, radius) = (0.03, 0.5);
    let turn = MotionKind::Rotation { point: Vector::zeros(), axis: Vector::y(), frequency };
    let cylinder = SurfaceShape::Cylinder { point: Vector::zeros(), axis: Vector::y(), radius: 4.0, is_inside: true };
    let drum = SurfaceDraft::new("drum", cylinder).restitution(0.7).tangential_restitution(0.0).motion(SurfaceMotion {
        from: 0.0,
        until: f64::INFINITY,
        kind: turn,
    });
    let scene = SceneBuilder::new("drum")
        .species(SpeciesDraft::new("ball").mass(1.3).diameter(2.0 * radius))
        .interaction(hard().between("ball", "ball"))
        .space(Space { boundary: OPEN, ..Space::periodic_cube(10.0) })
        .spinning_particle("ball", Vector::new(0.1, 0.3, 0.2), Vector::new(0.4, 0.1, -1.0), Vector::new(0.3, -0.2, 0.5))
        .surface(drum)
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene.clone());
    let before = simulation.energy().total();
    let mut last = None;
    simulation.advance_with(Until::events(1), |event| last = Some(*event)).unwrap();
    let (event, snapshot) = (last.unwrap(), simulation.snapshot());
    let contact = snapshot.positions[0] - event.normal * radius;
    let of_drum = (Vector::y() * (TAU * frequency)).cross(&contact);
    let of_ball = snapshot.velocities[0] - snapshot.spins[0].cross(&(event.normal * radius));
    let slip = of_ball - of_drum;
    assert!((slip - event.normal * slip.dot(&event.normal)).norm() < 1e-14, "{slip}");
    assert!(event.torques[0].norm() > 0.05 && event.dissipated > 0.0);
    let gained = simulation.energy().total() - before;
    assert!((gained - event.energy_step + event.dissipated).abs() < 1e-14, "{gained} {event:?}");
    // Energy is conserved over many contacts, and the verifier accepts each contact.
    simulation.advance(Until::events(300)).unwrap();
    let counts = simulation.event_counts();
    let ledger = simulation.energy().total() + counts.dissipated.total() - counts.supplied.total();
    assert!((ledger - before).abs() < 1e-12, "{ledger} {before}");
    let proof = verify(scene, EventRange { from: 0, events: 200 }, &mut |_| ControlFlow::Continue(()));
    assert!(proof.is_proven(), "{:?}", proof.end);
}

/// A cluster of spinning spheres that fly at each other in open space.
fn cluster(law: impl Fn(InteractionDraft) -> InteractionDraft) -> Scene {
    let mut scene = SceneBuilder::new("cluster")
        .space(Space { boundary: OPEN, ..Space::periodic_cube(20.0) })
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.6).diameter(0.7).moment_of_inertia(0.041))
        .interaction(law(hard()).between("A", "A"))
        .interaction(law(hard()).between("A", "B"))
        // The contact distance differs from the mean of the diameters.
        .interaction(law(hard()).between("B", "B").diameter(0.9));
    for k in 0..27_u32 {
        let at = |n: u32| 6.0 + 2.2 * f64::from(n % 3);
        let place = Vector::new(at(k), at(k / 3), at(k / 9));
        let wobble = Vector::new((1.7 * f64::from(k)).sin(), (2.3 * f64::from(k)).cos(), (0.9 * f64::from(k)).sin());
        let inwards = (Vector::repeat(8.2) - place) * 0.5;
        scene =
            scene.spinning_particle(if k % 2 == 0 { "A" } else { "B" }, place, inwards + wobble * 0.4, wobble * 1.5);
    }
    scene.build().unwrap()
}

fn momenta(simulation: &Simulation) -> [Vector; 2] {
    let (scene, snapshot) = (simulation.scene(), simulation.snapshot());
    let mut sums = [Vector::zeros(); 2];
    for k in 0..snapshot.positions.len() {
        let species = scene.species_of(ParticleId(u32::try_from(k).unwrap()));
        let momentum = snapshot.velocities[k] * species.mass;
        sums[0] += momentum;
        sums[1] += snapshot.positions[k].cross(&momentum) + snapshot.spins[k] / species.inverse_inertia(3);
    }
    sums
}

#[test]
fn rough_contacts_conserve_momentum_and_angular_momentum() {
    let laws: [fn(InteractionDraft) -> InteractionDraft; 3] = [
        |draft| draft.tangential_restitution(1.0),
        |draft| draft.restitution(0.8).tangential_restitution(0.3).friction(0.2),
        |draft| draft.restitution(0.9).friction(0.5),
    ];
    for (which, law) in laws.into_iter().enumerate() {
        let mut simulation = Simulation::without_plan(cluster(law));
        let (before, energy) = (momenta(&simulation), simulation.energy().total());
        simulation.advance(Until::time(20.0)).unwrap();
        let events = simulation.event_counts().core;
        assert!(events > 40, "{events}");
        let after = momenta(&simulation);
        // Each of a hundred contacts rounds positions of about 100 and momenta of about 3.
        for (a, b) in before.iter().zip(&after) {
            assert!((a - b).norm() < 1e-11, "{which}: {a} {b}");
        }
        let (now, counts) = (simulation.energy().total(), simulation.event_counts());
        assert!((now + counts.dissipated.total() - energy).abs() < 1e-12 * energy, "{which}");
        assert_eq!(counts.dissipated.total() == 0.0 || counts.dissipated.total().abs() < 1e-12, which == 0);
    }
}

#[test]
fn perfectly_rough_contacts_reverse_in_time() {
    let scene = cluster(|draft| draft.tangential_restitution(1.0));
    let mut simulation = Simulation::without_plan(scene.clone());
    simulation.advance(Until::events(25)).unwrap();
    let snapshot = simulation.snapshot();
    let mut parts = scene.clone().into_parts();
    for (k, particle) in parts.particles.iter_mut().enumerate() {
        particle.position = snapshot.positions[k];
        (particle.velocity, particle.spin) = (-snapshot.velocities[k], -snapshot.spins[k]);
    }
    let mut back = Simulation::without_plan(Scene::new(parts).unwrap());
    back.advance(Until::time(snapshot.time)).unwrap();
    let end = back.snapshot();
    for (k, particle) in scene.particles().iter().enumerate() {
        assert!((end.positions[k] - particle.position).norm() < 1e-8, "{k}");
        assert!((end.velocities[k] + particle.velocity).norm() < 1e-8, "{k}");
        assert!((end.spins[k] + particle.spin).norm() < 1e-8, "{k}");
    }
}

/// A periodic gas of unlike spheres or disks without spins at the start.
fn gas(is_flat: bool, seed: u64, law: impl Fn(InteractionDraft) -> InteractionDraft) -> Simulation {
    let mut scene = SceneBuilder::new("gas")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(law(hard()).between("A", "A"))
        .temperature(1.0)
        .seed(seed);
    if is_flat {
        let boundary = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
        let size = Vector::new(30.0, 30.0, 0.0);
        scene = scene.space(Space { boundary, size, ..Space::periodic_cube(1.0) });
        scene = scene.fill(Fill::new(Lattice::Square, "A").count(256));
    } else {
        scene = scene.fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.1));
    }
    Simulation::without_plan(scene.build().unwrap())
}

#[test]
fn a_perfectly_rough_gas_has_equal_energy_in_all_degrees_of_freedom() {
    // Particles have `f` translational and `g` rotational degrees of freedom. The mean ratio of the energies is `g /
    // f`, corrected for the `f` components of the conserved momentum.
    for (is_flat, count, f, g) in [(false, 500.0, 3.0, 3.0), (true, 256.0, 2.0, 1.0)] {
        let mut simulation = gas(is_flat, 11, |draft| draft.tangential_restitution(1.0));
        let energy = simulation.energy().total();
        simulation.advance(Until::events(40 * 500)).unwrap();
        let shares: Vec<f64> = (0..60)
            .map(|block| {
                simulation.advance(Until::events(40 * 500 + (block + 1) * 10 * 500)).unwrap();
                simulation.energy().rotational / energy
            })
            .collect();
        let expected = g * count / (g * count + f * (count - 1.0));
        Mean::of(shares).assert_is(expected, 0.01, &format!("share of rotation, flat: {is_flat}"));
        assert!((simulation.energy().total() / energy - 1.0).abs() < 1e-12);
    }
}

#[test]
fn sheared_rough_spheres_keep_the_energy_balance() {
    let scene = SceneBuilder::new("sheared")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(hard().between("A", "A").restitution(0.9).tangential_restitution(0.4).friction(0.3))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(256).packing_fraction(0.3))
        .temperature(1.0)
        .shear(0.4)
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    let before = simulation.energy().total();
    simulation.advance(Until::events(50_000)).unwrap();
    let counts = simulation.event_counts();
    assert!(simulation.energy().rotational > 1.0 && counts.supplied.total() > 10.0);
    let ledger = simulation.energy().total() + counts.dissipated.total() - counts.supplied.total();
    assert!((ledger / before - 1.0).abs() < 1e-11, "{ledger} {before}");
}

#[test]
fn a_static_rough_sphere_and_a_wall_of_rough_law_agree() {
    // A huge static sphere is nearly a plane. The error of the spin is of the order of the ratio of the radii.
    let scene = SceneBuilder::new("ball")
        .space(Space { boundary: OPEN, ..Space::periodic_cube(10.0) })
        .species(SpeciesDraft::new("ball").mass(1.3).diameter(1.4))
        .species(SpeciesDraft::new("earth").diameter(2e6).fixed())
        .interaction(hard().between("ball", "ball"))
        .interaction(hard().between("ball", "earth").restitution(0.6).tangential_restitution(0.25).friction(0.3))
        .particle("ball", Vector::new(5.0, 5.0, 1.0), Vector::new(3.0, 0.0, -0.8))
        .particle("earth", Vector::new(5.0, 5.0, -1e6), Vector::zeros())
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::events(1)).unwrap();
    let spin = simulation.snapshot().spins[0];
    let floor = ball(true, [0.6, 0.25, 0.3], Vector::new(3.0, 0.0, -0.8), Vector::zeros()).snapshot().spins[0];
    assert!((spin - floor).norm() < 1e-4, "{spin} {floor}");
    assert_eq!(simulation.snapshot().spins[1], Vector::zeros(), "static spheres do not turn");
}
