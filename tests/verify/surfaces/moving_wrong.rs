//! The verifier finds wrong or missing contacts with moving surfaces, and wrong motions of surfaces.

use carom::Vector;
use carom::check::verify::{Contact, Fault, Quantity};
use carom::engine::States;
use carom::engine::event::{Event, EventKind};
use carom::model::{MotionKind, Scene, SurfaceMotion, SurfaceShape};

use super::moving::{MOTIONS, motions};
use super::wrong::{GRAVITY, assert_dropped_is_found, assert_invented_are_found, assert_shifts_are_found};
use super::{MIDDLE, around, grains, moving};
use crate::{Recording, end_of};

const EVENTS: usize = 120;
const RESTITUTION: f64 = 0.9;
/// Planes, a hollow sphere, a pipe, a box, and obstacles in a hollow sphere.
const OF_KINDS: [usize; 5] = [0, 1, 2, 3, 4];

/// Returns the normal speed of an arriving particle relative to the surface.
fn closing(event: &Event) -> f64 {
    event.normal.dot(&(event.after[0] - event.before[0])) / (1.0 + RESTITUTION)
}

/// Returns a recording, and the first contact with a moving surface from event 20 on, if any.
fn recording(number: usize, kind: usize) -> Option<(Recording, usize)> {
    let gas = grains(1, 18).gravity(GRAVITY);
    let recording = Recording::of(moving(gas, around(kind), &motions(number), RESTITUTION), EVENTS);
    let is_one = |at: &usize| {
        let event = &recording.events[*at].0;
        event.kind == EventKind::Surface && event.energy_step.abs() > 1e-2 && closing(event) > 0.05
    };
    (20..recording.events.len()).find(is_one).map(|at| (recording, at))
}

fn for_each(mut check: impl FnMut(Recording, usize, &str)) {
    let mut kinds = 0;
    for number in 0..MOTIONS {
        let before = kinds;
        for kind in OF_KINDS {
            if let Some((recording, at)) = recording(number, kind) {
                check(recording, at, &format!("motions {number}, kind {kind}"));
                kinds += 1;
            }
        }
        assert!(kinds > before, "motions {number}: no contact");
    }
    assert!(kinds > 3 * MOTIONS, "{kinds}");
}

#[test]
fn correct_events_are_proven_and_a_dropped_contact_is_found() {
    for_each(|recording, at, name| {
        assert_eq!(recording.fault(), None, "{name}");
        assert_dropped_is_found(recording, at, name);
    });
}

#[test]
fn contacts_that_are_slightly_early_or_late_are_found() {
    for_each(|recording, at, name| {
        assert_shifts_are_found(&recording, at, closing(&recording.events[at].0), name);
    });
}

#[test]
fn invented_contacts_are_found() {
    for_each(|recording, at, name| assert_invented_are_found(&recording, at, name));
}

#[test]
fn wrong_quantities_of_a_contact_are_found() {
    let check = |quantities: &[Quantity], change: &dyn Fn(&mut Event, &mut States)| {
        for_each(|mut recording, at, name| {
            let (event, states) = &mut recording.events[at];
            change(event, states);
            let fault = recording.fault();
            let Some((found, Fault::WrongNumbers { quantity, .. })) = fault else { panic!("{name}: {fault:?}") };
            assert!(found == at && quantities.contains(&quantity), "{name}: {fault:?}");
        });
    };
    let velocity = |event: &Event| event.particle.0 as usize;
    check(&[Quantity::Velocity], &|event, states| {
        states.velocities[velocity(event)] += event.normal.cross(&Vector::new(0.3, 0.5, 0.7)) * 1e-9;
    });
    check(&[Quantity::Velocity], &|event, states| states.velocities[velocity(event)] += event.normal * 1e-9);
    check(&[Quantity::Normal], &|event, _| event.normal = -event.normal);
    check(&[Quantity::Energy], &|event, _| event.dissipated += 1e-9);
    check(&[Quantity::Energy], &|event, _| event.energy_step += 1e-9);
    check(&[Quantity::Energy], &|event, _| event.energy_step = 0.0);
    check(&[Quantity::Direction], &|event, states| states.velocities[velocity(event)] = event.before[0]);
    // This outcome is correct for a surface at rest.
    check(&[Quantity::Direction, Quantity::Energy, Quantity::Dissipation, Quantity::Impulse], &|event, states| {
        let arriving = event.before[0].dot(&event.normal);
        let mass = if event.particle.0.is_multiple_of(3) { 3.1 } else { 0.7 };
        let after = event.before[0] - event.normal * ((1.0 + RESTITUTION) * arriving);
        event.dissipated = 0.5 * mass * (1.0 - RESTITUTION * RESTITUTION) * arriving * arriving;
        (event.impulse, event.energy_step, event.after[0]) = ((after - event.before[0]) * mass, 0.0, after);
        states.velocities[velocity(event)] = after;
    });
    // The rebound is slightly too fast, with unchanged work and dissipation.
    check(&[Quantity::Direction, Quantity::Energy, Quantity::Dissipation], &|event, states| {
        let mass = if event.particle.0.is_multiple_of(3) { 3.1 } else { 0.7 };
        let more = event.normal * (1e-9 * closing(event));
        event.impulse += more * mass;
        event.after[0] += more;
        states.velocities[velocity(event)] += more;
    });
}

fn fault_of(kind: usize, right: &[SurfaceMotion], wrong: &[SurfaceMotion]) -> Fault {
    let scene = |motions| moving(grains(2, 18), around(kind), motions, 1.0);
    // All particles may leave before the first wrong event.
    Recording { scene: scene(right), ..Recording::of(scene(wrong), 600) }.fault_or_end()
}

/// Returns variants of a motion with small changes.
fn changed(motion: &SurfaceMotion) -> Vec<SurfaceMotion> {
    let kinds = match motion.kind {
        MotionKind::Translation { velocity, acceleration } => vec![
            MotionKind::Translation { velocity: velocity + Vector::new(1e-8, 1e-8, 0.0), acceleration },
            MotionKind::Translation { velocity, acceleration: acceleration + Vector::new(0.0, 1e-8, 1e-8) },
        ],
        MotionKind::Oscillation { amplitude, frequency, phase } => vec![
            MotionKind::Oscillation { amplitude: amplitude * (1.0 + 1e-7), frequency, phase },
            MotionKind::Oscillation { amplitude, frequency: frequency * (1.0 + 1e-7), phase },
            MotionKind::Oscillation { amplitude, frequency, phase: phase + 1e-8 },
        ],
        MotionKind::Rotation { point, axis, frequency } => vec![
            MotionKind::Rotation { point: point + Vector::new(1e-8, 1e-8, 1e-8), axis, frequency },
            MotionKind::Rotation { point, axis: axis + Vector::new(1e-7, 0.0, 1e-7), frequency },
            MotionKind::Rotation { point, axis, frequency: frequency * (1.0 + 1e-7) },
        ],
        _ => Vec::new(),
    };
    let others = kinds.into_iter().map(|kind| SurfaceMotion { kind, ..*motion });
    others.chain([SurfaceMotion { from: motion.from + 1e-8, ..*motion }]).collect()
}

#[test]
fn slightly_wrong_motions_are_found() {
    let mut told = 0;
    for number in 0..MOTIONS {
        let right = motions(number);
        for at in 0..right.len() {
            for other in changed(&right[at]) {
                let mut wrong = right.clone();
                wrong[at] = other;
                if (1..wrong.len()).any(|k| wrong[k].from < wrong[k - 1].until) {
                    continue;
                }
                let found = fault_of(3, &right, &wrong);
                let is_wrong = matches!(found, Fault::Missed { .. } | Fault::Early { .. } | Fault::WrongNumbers { .. });
                assert!(is_wrong, "motions {number}, {other:?}: {found:?}");
                told += 1;
            }
        }
    }
    assert!(told > 30, "{told}");
}

#[test]
fn missing_and_surplus_motions_are_found() {
    for number in 0..MOTIONS {
        for kind in OF_KINDS {
            for [right, wrong] in [[motions(number), Vec::new()], [Vec::new(), motions(number)]] {
                let found = fault_of(kind, &right, &wrong);
                let is_wrong = matches!(found, Fault::Missed { .. } | Fault::Early { .. } | Fault::WrongNumbers { .. });
                assert!(is_wrong, "motions {number}, kind {kind}: {found:?}");
            }
        }
    }
}

#[test]
fn end_is_proven_only_if_no_moving_surface_can_be_met() {
    let ball = |velocity: f64, motions: &[SurfaceMotion]| {
        let plate = SurfaceShape::Plane { point: MIDDLE, normal: Vector::z() };
        let gas = grains(1, 0).particle("A", MIDDLE + Vector::z() * 2.0, Vector::z() * velocity);
        moving(gas, vec![plate], motions, 1.0)
    };
    let by = |from, until, speed: f64, acceleration: f64| SurfaceMotion {
        from,
        until,
        kind: MotionKind::Translation { velocity: Vector::z() * speed, acceleration: Vector::z() * acceleration },
    };
    let shakes = |until| SurfaceMotion {
        from: 1.0,
        until,
        kind: MotionKind::Oscillation { amplitude: Vector::z() * 0.5, frequency: 0.7, phase: 0.0 },
    };
    let is_early = |scene: Scene, expected: f64| match end_of(&scene) {
        Err(Fault::EndedEarly { contact: Contact::Surface { .. }, due, .. }) => (due - expected).abs() < 1e-9,
        other => panic!("{other:?}"),
    };
    // The gap between the ball and the plate is 1.75. The plate may reach the ball, stop, or move away.
    assert!(is_early(ball(0.0, &[by(5.0, 9.0, 0.5, 0.0)]), 8.5));
    assert_eq!(end_of(&ball(0.0, &[by(5.0, 8.0, 0.5, 0.0)])), Ok(()));
    assert_eq!(end_of(&ball(0.0, &[by(5.0, 8.0, 0.5, 0.0), by(9.0, f64::INFINITY, -0.5, -0.1)])), Ok(()));
    assert!(is_early(
        ball(0.0, &[by(5.0, 8.0, 0.5, 0.0), by(9.0, f64::INFINITY, -0.5, 0.2)]),
        9.0 + 2.5 + 8.75_f64.sqrt()
    ));
    assert!(is_early(ball(0.2, &[by(0.0, f64::INFINITY, 0.3, 0.0)]), 17.5));
    assert_eq!(end_of(&ball(0.3, &[by(0.0, f64::INFINITY, 0.2, 0.0)])), Ok(()));
    // The verifier proves nothing for an endless or very long motion.
    assert_eq!(end_of(&ball(0.0, &[shakes(20.0)])), Ok(()));
    assert!(matches!(end_of(&ball(0.0, &[shakes(f64::INFINITY)])), Err(Fault::EndNotShown { .. })));
    assert!(matches!(end_of(&ball(0.0, &[shakes(1e9)])), Err(Fault::EndNotShown { .. })));
    assert!(matches!(end_of(&ball(-0.5, &[shakes(20.0)])), Err(Fault::EndedEarly { .. })));
}
