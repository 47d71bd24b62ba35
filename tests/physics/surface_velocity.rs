//! Surfaces whose material moves along them: belts, drums and moving thermal plates.

use carom::Vector;
use carom::check::verify::{EventRange, verify};
use carom::engine::{Simulation, Until};
use carom::model::space::{Boundary, Space};
use carom::model::{MotionKind, Scene, SurfaceMotion, SurfaceShape, SurfaceVelocity};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use std::ops::ControlFlow;

/// A spinning ball of mass 1.3 and radius 0.7 in open space, with a surface.
fn ball(place: Vector, velocity: Vector, spin: Vector, surface: SurfaceDraft) -> SceneBuilder {
    SceneBuilder::new("ball")
        .species(SpeciesDraft::new("ball").mass(1.3).diameter(1.4))
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "ball"))
        .space(Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(10.0) })
        .spinning_particle("ball", place, velocity, spin)
        .surface(surface)
}

fn floor() -> SurfaceDraft {
    SurfaceDraft::new("floor", SurfaceShape::Plane { point: Vector::zeros(), normal: Vector::z() })
}

#[test]
fn ball_on_a_belt_bounces_as_on_a_floor_seen_from_the_belt() {
    let (e, radius, vn, inertia) = (0.6, 0.7, 0.8, 0.4 * 1.3 * 0.7 * 0.7);
    let belt = Vector::new(1.7, 0.0, 0.0);
    // The velocity of the belt across its surface has no effect.
    let material = SurfaceVelocity::Translation { velocity: belt + Vector::z() * 5.0 };
    for (b, mu, vt, slides) in [(0.25, 0.3, 3.0, true), (0.25, 0.3, 1.0, false), (0.0, f64::INFINITY, 3.0, false)] {
        let surface = floor().restitution(e).tangential_restitution(b).friction(mu).surface_velocity(material);
        let before = belt + Vector::new(vt, 0.0, -vn);
        let scene = ball(Vector::new(5.0, 5.0, 1.0), before, Vector::zeros(), surface).build().unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let mut last = None;
        simulation.advance_with(Until::events(1), |event| last = Some(*event)).unwrap();
        let (event, [v, w]) = (last.unwrap(), [simulation.snapshot().velocities[0], simulation.snapshot().spins[0]]);
        let (seen, turned) = if slides {
            (vt - mu * (1.0 + e) * vn, 2.5 * mu * (1.0 + e) * vn / radius)
        } else {
            (vt * (1.0 - 2.0 / 7.0 * (1.0 + b)), 5.0 / 7.0 * (1.0 + b) * vt / radius)
        };
        assert!((v - belt - Vector::new(seen, 0.0, e * vn)).norm() < 1e-14, "{v}");
        assert!((w - Vector::new(0.0, turned, 0.0)).norm() < 1e-14, "{w}");
        // The belt does the work of its velocity and the impulse, and the lost energy is the same in both frames.
        assert!((event.energy_step - 1.3 * (v.x - before.x) * belt.x).abs() < 1e-14, "{event:?}");
        let energy =
            |seen: f64, normal: f64, spin: f64| 0.5 * (1.3 * (seen * seen + normal * normal) + inertia * spin * spin);
        assert!((event.dissipated - energy(vt, vn, 0.0) + energy(seen, e * vn, turned)).abs() < 1e-14, "{event:?}");
    }
}

#[test]
fn ball_at_rest_on_a_belt_ends_rolling_with_two_sevenths_of_its_speed() {
    let contact_time = 1e-3;
    let material = SurfaceVelocity::Translation { velocity: Vector::new(1.0, 0.0, 0.0) };
    let surface = floor().restitution(0.5).friction(0.3).surface_velocity(material);
    let scene = ball(Vector::new(2.0, 5.0, 0.7), Vector::zeros(), Vector::zeros(), surface)
        .gravity(-Vector::z())
        .contact_time(contact_time)
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    let before = simulation.energy().total();
    // It slides until the time 2 u / (7 mu g), which is 0.952.
    for (time, speed, rolls) in [(0.5, 0.15, false), (3.0, 2.0 / 7.0, true), (6.0, 2.0 / 7.0, true)] {
        simulation.advance(Until::time(time)).unwrap();
        let state = simulation.snapshot();
        assert!((state.velocities[0].x - speed).abs() < 2.0 * contact_time, "{}", state.velocities[0]);
        let slip = state.velocities[0].x - 0.7 * state.spins[0].y - 1.0;
        assert_eq!(slip.abs() < 4.0 * contact_time, rolls, "{slip}");
    }
    let counts = simulation.event_counts();
    let ledger = simulation.energy().total() + counts.dissipated.total() - counts.supplied.total();
    assert!((ledger - before).abs() < 1e-10, "{ledger} {before}");
}

#[test]
fn ball_that_moves_with_its_belt_rattles_as_on_a_floor_at_rest() {
    let events = |velocity: Vector, sliding: Vector| {
        let surface = floor().restitution(0.5).friction(0.3);
        let surface = surface.surface_velocity(SurfaceVelocity::Translation { velocity: sliding });
        let scene = ball(Vector::new(4.0, 5.0, 0.7), velocity, Vector::zeros(), surface)
            .gravity(-Vector::z())
            .contact_time(0.013)
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene.clone());
        simulation.advance(Until::time(2.0)).unwrap();
        let counts = *simulation.event_counts();
        let proof = verify(scene, EventRange { from: 0, events: 400 }, &mut |_| ControlFlow::Continue(()));
        assert!(proof.is_proven(), "{:?}", proof.end);
        counts.physical()
    };
    let sliding = Vector::new(1.7, 0.3, 0.0);
    let at_rest = events(Vector::zeros(), Vector::zeros());
    // A ball at rest bounces once in a contact time.
    assert_eq!(at_rest, 154);
    assert!(events(sliding, sliding).abs_diff(at_rest) <= 1);
    // A ball that starts without a normal speed slides first.
    assert!(events(Vector::new(0.7, 0.0, 0.0), sliding) < 40 * at_rest);
}

/// A ball inside a cylinder that turns about its axis, by a motion of its shape or of its material.
fn drum(with: impl Fn(SurfaceDraft, Vector, Vector, f64) -> SurfaceDraft) -> Scene {
    let (point, axis) = (Vector::new(0.2, 0.0, -0.1), Vector::new(0.1, 1.0, 0.2));
    let shape = SurfaceShape::Cylinder { point, axis, radius: 4.0, is_inside: true };
    let surface = SurfaceDraft::new("drum", shape).tangential_restitution(0.3).friction(0.4);
    let (velocity, spin) = (Vector::new(0.4, 0.1, -1.0), Vector::new(0.3, -0.2, 0.5));
    ball(Vector::new(0.1, 0.3, 0.2), velocity, spin, with(surface, point, axis, 0.03)).build().unwrap()
}

#[test]
fn turning_material_acts_like_a_turning_cylinder() {
    let by_motion = drum(|surface, point, axis, frequency| {
        let kind = MotionKind::Rotation { point, axis, frequency };
        surface.motion(SurfaceMotion { from: 0.0, until: f64::INFINITY, kind })
    });
    let by_material = drum(|surface, point, axis, frequency| {
        surface.surface_velocity(SurfaceVelocity::Rotation { point, axis, frequency })
    });
    let events = |scene: &Scene| {
        let (mut simulation, mut events) = (Simulation::without_plan(scene.clone()), Vec::new());
        simulation.advance_with(Until::events(40), |event| events.push(*event)).unwrap();
        events
    };
    let [motion, material] = [&by_motion, &by_material].map(events);
    assert_eq!(material.len(), 40);
    for (one, other) in motion.iter().zip(&material) {
        assert!((one.time - other.time).abs() < 1e-9, "{one:?} {other:?}");
        assert!((one.impulse - other.impulse).norm() < 1e-9 && (one.torques[0] - other.torques[0]).norm() < 1e-9);
        assert!((one.energy_step - other.energy_step).abs() < 1e-9, "{one:?} {other:?}");
        assert!((one.dissipated - other.dissipated).abs() < 1e-9, "{one:?} {other:?}");
    }
    let proof = verify(by_material, EventRange { from: 0, events: 200 }, &mut |_| ControlFlow::Continue(()));
    assert!(proof.is_proven(), "{:?}", proof.end);
}

#[test]
fn thermal_plate_gives_particles_its_velocity_and_its_temperature() {
    let (temperature, mass, plate) = (0.8, 1.3, Vector::new(0.9, -0.4, 0.0));
    let of_plate = SurfaceVelocity::Translation { velocity: plate };
    let lower = floor().temperature(temperature).surface_velocity(of_plate);
    let upper = SurfaceShape::Plane { point: Vector::z() * 3.0, normal: -Vector::z() };
    let upper = SurfaceDraft::new("upper", upper).temperature(temperature);
    let start = ball(Vector::new(5.0, 5.0, 1.0), Vector::new(0.2, 0.0, -1.0), Vector::zeros(), lower);
    let mut simulation = Simulation::without_plan(start.surface(upper).seed(4).build().unwrap());
    let before = simulation.energy().total();
    let mut left = Vec::new();
    let note = |event: &carom::engine::event::Event| {
        if event.normal.z > 0.0 {
            left.push(event.after[0] - plate);
        }
    };
    simulation.advance_with(Until::events(20_000), note).unwrap();
    let count = left.len() as f64;
    let spread = (temperature / mass).sqrt();
    for axis in 0..2 {
        let mean = left.iter().map(|velocity| velocity[axis]).sum::<f64>() / count;
        assert!(mean.abs() < 5.0 * spread / count.sqrt(), "{mean}");
        let square = left.iter().map(|velocity| velocity[axis] * velocity[axis]).sum::<f64>() / count;
        assert!((square - temperature / mass).abs() < 5.0 * 2.0_f64.sqrt() * temperature / mass / count.sqrt());
    }
    let gained = simulation.energy().total() - before;
    assert!((gained - simulation.event_counts().supplied.total()).abs() < 1e-9);
}
