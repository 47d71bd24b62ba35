//! The verifier proves runs with moving surfaces and changing gravity.

use std::f64::consts::TAU;

use carom::Vector;
use carom::check::verify::Verifier;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, MotionKind, Scene, SurfaceMotion, SurfaceShape, TriangleMesh, Until};
use carom::scene::{Arrangement, Fill, SceneBuilder, SurfaceDraft};

use super::{KINDS, MIDDLE, around, assert_surfaces, cuboid, grains, moving, turned};
use crate::scenes::assert_proven;
use crate::{Recording, config, prove};

pub const MOTIONS: usize = 6;

/// Returns a sequence of motions of a surface.
pub fn motions(number: usize) -> Vec<SurfaceMotion> {
    let for_ever = |kind| vec![SurfaceMotion { from: 0.0, until: f64::INFINITY, kind }];
    let drift = MotionKind::Translation { velocity: Vector::new(0.4, -0.3, 0.6), acceleration: Vector::zeros() };
    let push =
        MotionKind::Translation { velocity: Vector::new(-0.3, 0.1, 0.2), acceleration: Vector::new(0.5, 0.8, -0.4) };
    let shake = MotionKind::Oscillation { amplitude: Vector::new(0.2, -0.1, 0.3), frequency: 1.3, phase: 0.2 };
    let turn = MotionKind::Rotation {
        point: MIDDLE + Vector::new(0.3, -0.2, 0.1),
        axis: Vector::new(1.0, 0.4, -0.3),
        frequency: 0.21,
    };
    let piece = |from, until, kind| SurfaceMotion { from, until, kind };
    match number {
        0 => for_ever(drift),
        1 => for_ever(push),
        2 => for_ever(shake),
        3 => for_ever(turn),
        4 => vec![piece(0.3, 0.7, turn), piece(0.9, 1.4, push), piece(1.4, 2.3, shake), piece(2.5, 1e3, turn)],
        _ => vec![piece(0.2, 0.6, drift), piece(0.6, 0.9, shake), piece(0.9, 1.1, drift), piece(1.2, 1.9, turn)],
    }
}

#[test]
fn surfaces_of_every_kind_are_proven_in_every_motion() {
    for number in 0..MOTIONS {
        let (mut met, mut worst) = (0, 0.0_f64);
        for kind in 0..KINDS {
            let seed = u32::try_from(3 * number + kind).unwrap();
            let gravity = if kind % 2 == 0 { 0.0 } else { 0.8 };
            let gas = grains(seed, 18).gravity(Vector::new(0.1, -0.2, -1.0) * gravity);
            let gas = if seed % 3 == 0 { gas } else { gas.contact_time(1e-2) };
            let restitution = [1.0, 0.7, 0.3][seed as usize % 3];
            let name = format!("motions {number}, kind {kind}");
            let found = assert_surfaces(&name, moving(gas, around(kind), &motions(number), restitution), 300);
            met += found.counts.surface;
            let margins = found.margins;
            worst = worst.max(margins.distance).max(margins.overlap).max(margins.outcome);
        }
        println!("motions {number}: {met} contacts, at most {worst} of the bounds");
        assert!(met > 300, "motions {number}: {met}");
    }
}

#[test]
fn ball_carried_by_a_surface_is_proven() {
    for number in 0..MOTIONS {
        for (kind, contact_time) in [(0, 1e-3), (1, 0.1), (2, 1e-2), (3, 1e-2), (5, 0.1)] {
            let gas = grains(3, 1).gravity(Vector::new(0.1, -0.2, -1.0)).contact_time(contact_time);
            let found = assert_surfaces(
                &format!("motions {number}, kind {kind}"),
                moving(gas, around(kind), &motions(number), 0.4),
                200,
            );
            assert!(found.counts.surface > 20, "{number} {kind}: {:?}", found.counts);
        }
    }
}

#[test]
fn surfaces_that_move_through_each_other_are_proven() {
    let space = Space { boundary: [Boundary::walls(0.9); 3], ..Space::periodic_cube(20.0) };
    for seed in 0..4 {
        let gas = grains(seed, 27).space(space.clone()).gravity(Vector::new(0.0, 0.2, -0.5) * f64::from(seed % 2));
        let gas = if seed < 2 { gas } else { gas.contact_time(1e-2) };
        let shapes =
            [around(4).remove(2), around(4).remove(3), around(4).remove(4), turned(&cuboid(2.4)), around(1).remove(0)];
        let draft = |(k, shape): (usize, SurfaceShape)| {
            let draft = SurfaceDraft::new(&format!("surface {k}"), shape).restitution(0.9);
            motions((k + seed as usize) % MOTIONS).into_iter().fold(draft, SurfaceDraft::motion)
        };
        let scene = shapes.into_iter().enumerate().map(draft).fold(gas, SceneBuilder::surface).build().unwrap();
        let found = assert_surfaces(&format!("seed {seed}"), scene, 1500);
        assert!(found.counts.surface > 100, "{:?}", found.counts);
    }
}

#[test]
fn surfaces_that_move_in_periodic_boxes_are_proven_in_all_images() {
    let wall = Face::Wall(ContactLaw::smooth(1.0));
    let between = Boundary::Bounded { lower: wall, upper: wall };
    let for_ever = |kind| [SurfaceMotion { from: 0.5, until: f64::INFINITY, kind }];
    // The box is periodic in x and y, with plates at both ends of z. A block across an edge of the box, a rod and a
    // ball move up and down between the plates.
    let block = TriangleMesh::cuboid(&Vector::new(-1.3, -0.9, 1.9), &Vector::new(1.1, 1.4, 3.2));
    let rod =
        SurfaceShape::Cylinder { point: Vector::new(0.0, 3.3, 5.0), axis: Vector::x(), radius: 0.5, is_inside: false };
    let ball = SurfaceShape::Sphere { centre: Vector::new(6.9, 3.0, 3.0), radius: 0.8, is_inside: false };
    let shakes = for_ever(MotionKind::Oscillation { amplitude: Vector::z() * 0.6, frequency: 0.7, phase: 0.0 });
    let sinks = [SurfaceMotion {
        from: 0.5,
        until: 4.0,
        kind: MotionKind::Translation { velocity: Vector::z() * 0.3, acceleration: Vector::z() * -0.2 },
    }];
    for (motions, count) in [(&shakes, 3), (&sinks, 3), (&shakes, 40), (&sinks, 40)] {
        let space = Space { boundary: [Boundary::Periodic, Boundary::Periodic, between], ..Space::periodic_cube(7.0) };
        let gas = grains(0, 0).space(space).gravity(Vector::z() * -0.3);
        let gas = gas.fill(Fill::new(Arrangement::Random, "A").count(count)).temperature(1.0);
        let shapes = vec![rod.clone(), ball.clone(), SurfaceShape::Mesh(block.clone())];
        let found = assert_surfaces("plates", moving(gas, shapes, motions, 1.0), 1500);
        assert!(found.counts.surface > 200, "{count}: {:?}", found.counts);
    }
    let space = Space { boundary: [Boundary::OPEN, Boundary::OPEN, Boundary::Periodic], ..Space::periodic_cube(7.0) };
    let turn = MotionKind::Rotation { point: Vector::new(3.5, 3.4, 0.0), axis: Vector::z(), frequency: 0.15 };
    let paddle = TriangleMesh::cuboid(&Vector::new(1.5, 3.2, 1.0), &Vector::new(5.5, 3.5, 5.0));
    let pipe =
        SurfaceShape::Cylinder { point: Vector::new(3.5, 3.5, 0.0), axis: Vector::z(), radius: 3.2, is_inside: true };
    for gravity in [0.0, 0.4] {
        let gas = grains(0, 0).space(space.clone()).gravity(Vector::new(-0.3, -1.0, 0.1) * gravity);
        let region = Fill::new(Arrangement::Random, "A").count(20);
        let region = region.region(Vector::new(1.5, 4.2, 0.0), Vector::new(5.5, 5.5, 7.0));
        let gas = gas.fill(region).temperature(1.0);
        let scene = moving(gas, vec![SurfaceShape::Mesh(paddle.clone()), pipe.clone()], &for_ever(turn), 0.95);
        let found = assert_surfaces("paddle", scene, 1500);
        assert!(found.counts.surface > 200, "{:?}", found.counts);
    }
}

#[test]
fn moving_surfaces_are_proven_after_a_late_start_time() {
    for number in 0..4 {
        for start in [1e4, 1e7] {
            let mut parts = moving(grains(1, 9).contact_time(1e-3), around(3), &[], 0.9).into_parts();
            let late = |motion: SurfaceMotion| SurfaceMotion { from: start + 0.25, ..motion };
            parts.surfaces[0].motions = motions(number).into_iter().map(late).collect();
            parts.start_time = start;
            let found = prove(Scene::new(parts).unwrap(), 0, 200);
            assert_proven(&format!("motions {number} from {start}"), &found, 200);
            assert!(found.counts.surface > 50, "{:?}", found.counts);
        }
    }
}

#[test]
fn scenes_of_configs_with_surfaces_that_move_are_proven() {
    let certificate = prove(config("vibrated_box"), 0, 3000);
    assert_proven("vibrated box", &certificate, 3000);
    let certificate = prove(config("vibrated_box"), 50_000, 1000);
    assert_proven("vibrated box", &certificate, 1000);
    assert!(certificate.counts.surface > 10, "{:?}", certificate.counts);
    // The piston starts early, so that the proof includes contacts with the moving piston.
    let mut parts = config("piston").into_parts();
    parts.surfaces[0].motions[0].from = 0.2;
    let certificate = prove(Scene::new(parts).unwrap(), 0, 2500);
    assert_proven("piston", &certificate, 2500);
    assert!(certificate.counts.surface > 10 && certificate.duration > 0.4, "{certificate:?}");
    let certificate = prove(config("rotating_drum"), 0, 4000);
    assert_proven("rotating drum", &certificate, 4000);
    assert!(certificate.counts.surface > 50, "{:?}", certificate.counts);
}

#[test]
fn gravity_that_turns_is_proven() {
    let shorter = |time: f64| {
        let mut parts = config("tilting_box").into_parts();
        parts.run.stages.iter_mut().for_each(|stage| stage.limit = Until::time(time));
        parts.run.limit = Until::time(time);
        Scene::new(parts).unwrap()
    };
    let certificate = prove(shorter(1.0), 0, 2500);
    assert_proven("tilting box", &certificate, 2500);
    assert!(certificate.duration > 1.2, "{certificate:?}");
    // The proof starts in a later stage, or stages end after a number of events.
    let certificate = prove(shorter(0.7), 2500, 1000);
    assert_proven("tilting box", &certificate, 1000);
    let mut parts = shorter(1.0).into_parts();
    parts.run.stages.iter_mut().for_each(|stage| stage.limit = Until::events(400));
    assert_proven("tilting box", &prove(Scene::new(parts).unwrap(), 0, 1500), 1500);
}

/// Returns a recording in which gravity changes once, and the number of events before this change.
fn turning() -> (Recording, usize) {
    let down = grains(2, 18).gravity(Vector::new(0.0, 0.0, -1.0));
    let aside = Vector::new(0.8, -0.3, 0.4);
    let first = moving(down, around(1), &[], 0.9);
    let mut recording = Recording::of(first.clone(), 60);
    let (_, states) = recording.events[59].clone();
    let mut parts = first.into_parts();
    for (k, particle) in parts.particles.iter_mut().enumerate() {
        (particle.position, particle.velocity) = (states.positions[k], states.velocities[k]);
    }
    parts.species.iter_mut().for_each(|species| species.acceleration = aside);
    let later = Recording::of(Scene::new(parts).unwrap(), 60);
    recording.events.extend(later.events.into_iter().map(|(event, mut at)| {
        at.elapsed.since_epoch += states.elapsed.total();
        (event, at)
    }));
    (recording, 60)
}

#[test]
fn verifier_with_outdated_gravity_finds_a_fault() {
    let (mut recording, turn) = turning();
    let later = recording.events.split_off(turn);
    let (_, states) = recording.events[turn - 1].clone();
    let aside = Vector::new(0.8, -0.3, 0.4);
    for (gravity, is_right) in [(None, false), (Some(aside), true), (Some(aside * (1.0 + 1e-9)), false)] {
        let mut verifier = Verifier::new(&recording.scene, &recording.start).unwrap();
        assert_eq!(recording.fault_for(&mut verifier), None);
        if let Some(gravity) = gravity {
            verifier.turn_gravity(&gravity, &states).unwrap();
        }
        let fault = later.iter().find_map(|(event, states)| verifier.witness(event, states).err());
        assert_eq!(fault.is_none(), is_right, "{gravity:?}: {fault:?}");
    }
    let mut verifier = Verifier::new(&recording.scene, &recording.start).unwrap();
    assert_eq!(recording.fault_for(&mut verifier), None);
    let mut elsewhere = states.clone();
    elsewhere.positions[3].x += 1e-9;
    assert!(verifier.turn_gravity(&aside, &elsewhere).is_err());
}

#[test]
fn a_ball_on_a_floor_that_shakes_gently_is_proven_for_many_periods() {
    let frequency = 2.0;
    let amplitude = 0.3 / (TAU * frequency * TAU * frequency);
    let kind = MotionKind::Oscillation { amplitude: Vector::z() * amplitude, frequency, phase: 0.0 };
    let floor = SurfaceShape::Plane { point: MIDDLE - Vector::z() * 2.0, normal: Vector::z() };
    let gas = grains(3, 1).gravity(Vector::new(0.0, 0.0, -1.0)).contact_time(1e-2);
    let scene = moving(gas, vec![floor], &[SurfaceMotion { from: 0.0, until: f64::INFINITY, kind }], 0.5);
    let certificate = prove(scene, 0, 2000);
    assert_proven("floor", &certificate, 2000);
    assert!(certificate.duration > 5.0 && certificate.counts.surface == 2000, "{certificate:?}");
}

#[test]
fn a_surface_of_frequency_zero_is_proven_as_one_at_rest() {
    let forever = |kind| SurfaceMotion { from: 0.0, until: f64::INFINITY, kind };
    let sway = MotionKind::Oscillation { amplitude: Vector::repeat(0.3), frequency: 0.0, phase: 0.2 };
    let turn = MotionKind::Rotation { point: MIDDLE, axis: Vector::x(), frequency: 0.0 };
    for kind in [sway, turn] {
        let scene = moving(grains(2, 9), around(3), &[forever(kind)], 1.0);
        let certificate = prove(scene, 0, 300);
        assert_proven("frequency 0", &certificate, 300);
        assert!(certificate.counts.surface > 20, "{certificate:?}");
    }
}
