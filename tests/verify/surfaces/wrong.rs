//! The verifier finds wrong contacts with surfaces, and engines with a wrong surface.

use carom::Vector;
use carom::check::verify::{Contact, Fault, Quantity};
use carom::engine::States;
use carom::engine::event::{Event, EventKind, Other};
use carom::model::space::Space;
use carom::model::{ParticleId, Scene, SurfaceLaw, SurfaceShape};
use carom::scene::SurfaceDraft;

use super::{KINDS, MIDDLE, around, cuboid, grains, turned, with, without};
use crate::{Recording, end_of};

const EVENTS: usize = 160;
pub const GRAVITY: Vector = Vector::new(0.1, -0.2, -0.5);

fn gas(kind: usize) -> Scene {
    with(grains(1, 18).gravity(GRAVITY), around(kind), 0.9)
}

/// Returns a recording, and the first contact with a surface from event `from` on.
fn recording(kind: usize, from: usize) -> (Recording, usize) {
    let recording = Recording::of(gas(kind), EVENTS);
    let is_at_surface = |at: &usize| recording.events[*at].0.kind == EventKind::Surface;
    let at = (from..recording.events.len()).find(is_at_surface).unwrap();
    (recording, at)
}

/// Asserts that a recorded contact is missed after its removal.
pub fn assert_dropped_is_found(mut recording: Recording, at: usize, name: &str) {
    let (event, _) = recording.events.remove(at);
    let fault = recording.fault();
    let Some((found, Fault::Missed { contact, due, .. })) = fault else { panic!("{name}: {fault:?}") };
    assert!(matches!(contact, Contact::Surface { .. }), "{name}: {contact:?}");
    assert_eq!((found, contact), (at, Contact::of(&event)), "{name}");
    assert!((due - event.time).abs() < 1e-10, "{name}: {due} {}", event.time);
}

/// Asserts that a contact 1e-10 too early or too late is found. The normal speed before the contact is `closing`.
pub fn assert_shifts_are_found(original: &Recording, at: usize, closing: f64, name: &str) {
    for (shift, is_early) in [(-1e-10, true), (1e-10, false)] {
        let mut recording = original.clone();
        let before = &original.events[at - 1].1;
        let states = &mut recording.events[at].1;
        let flown = states.elapsed.after(&before.elapsed);
        states.elapsed.since_epoch += shift;
        for i in 0..states.positions.len() {
            let velocity = before.velocities[i] + GRAVITY * flown;
            states.positions[i] += velocity * shift;
            states.velocities[i] += GRAVITY * shift;
        }
        match recording.fault() {
            Some((found, Fault::Early { gap, .. })) if is_early && found == at => {
                assert!((gap / (1e-10 * closing) - 1.0).abs() < 0.1, "{name}: {gap} {closing}");
            }
            Some((found, Fault::Missed { deeper, .. })) if !is_early && found == at => {
                assert!((deeper / (1e-10 * closing) - 1.0).abs() < 0.1, "{name}: {deeper} {closing}");
            }
            fault => panic!("{name}, {shift}: {fault:?}"),
        }
    }
}

/// Asserts that a second contact is found after a recorded one, with the same or with another particle.
pub fn assert_invented_are_found(original: &Recording, at: usize, name: &str) {
    let mut again = original.clone();
    again.events.insert(at + 1, original.events[at].clone());
    let fault = again.fault();
    assert!(matches!(fault, Some((found, Fault::NotClosing { .. })) if found == at + 1), "{name}: {fault:?}");
    // Another particle of the same species is not at the surface.
    let mut other = original.clone();
    let (mut event, states) = original.events[at].clone();
    let is_other = |i: &u32| *i != event.particle.0 && i.is_multiple_of(3) == event.particle.0.is_multiple_of(3);
    event.particle = ParticleId((0..18).find(is_other).unwrap());
    other.events.insert(at + 1, (event, states));
    let fault = other.fault();
    let is_found = matches!(fault, Some((found, Fault::Early { .. } | Fault::NotClosing { .. })) if found == at + 1);
    assert!(is_found, "{name}: {fault:?}");
}

#[test]
fn correct_events_are_proven_and_a_dropped_contact_is_found() {
    for kind in 0..KINDS {
        for from in [5, 20, 40, 60, 80, 100] {
            let (recording, at) = recording(kind, from);
            if from == 5 {
                assert_eq!(recording.fault(), None, "kind {kind}");
            }
            assert_dropped_is_found(recording, at, &format!("kind {kind}"));
        }
    }
}

#[test]
fn contacts_that_are_slightly_early_or_late_are_found() {
    for kind in 0..KINDS {
        let (recording, at) = recording(kind, 30);
        let event = &recording.events[at].0;
        let closing = -event.before[0].dot(&event.normal);
        assert!(closing > 0.01, "kind {kind}: {closing}");
        assert_shifts_are_found(&recording, at, closing, &format!("kind {kind}"));
    }
}

fn changed(kind: usize, change: &dyn Fn(&mut Event, &mut States)) -> Fault {
    let (mut recording, at) = recording(kind, 30);
    let (event, states) = &mut recording.events[at];
    change(event, states);
    let (found, fault) = recording.fault().unwrap();
    assert_eq!(found, at, "{fault}");
    fault
}

#[test]
fn wrong_quantities_of_a_contact_are_found() {
    let quantity = |kind, change: &dyn Fn(&mut Event, &mut States)| match changed(kind, change) {
        Fault::WrongNumbers { quantity, contact: Contact::Surface { .. }, .. } => quantity,
        other => panic!("{other:?}"),
    };
    for kind in 0..KINDS {
        let kick = |by: f64| {
            move |event: &mut Event, states: &mut States| {
                let velocity = &mut states.velocities[event.particle.0 as usize];
                *velocity += event.normal.cross(&Vector::new(0.3, 0.5, 0.7)) * by;
            }
        };
        assert_eq!(quantity(kind, &kick(1e-10)), Quantity::Velocity);
        let faster = |event: &mut Event, states: &mut States| {
            states.velocities[event.particle.0 as usize] += event.normal * 1e-10;
        };
        assert_eq!(quantity(kind, &faster), Quantity::Velocity);
        assert_eq!(quantity(kind, &|event, _| event.normal = -event.normal), Quantity::Normal);
        assert_eq!(quantity(kind, &|event, _| event.dissipated *= 1.0 + 1e-9), Quantity::Energy);
        let turned_back = |event: &mut Event, states: &mut States| {
            states.velocities[event.particle.0 as usize] = event.before[0];
        };
        assert_eq!(quantity(kind, &turned_back), Quantity::Direction);
    }
}

#[test]
fn contacts_with_a_wrong_surface_or_particle_are_found() {
    for kind in 0..KINDS {
        let found = changed(kind, &|event, _| event.other = Other::Surface { surface: 77, feature: 0 });
        assert!(matches!(found, Fault::Missed { .. } | Fault::Unknown { .. }), "{found:?}");
        let found = changed(kind, &|event, _| event.distance *= 1.0 + 1e-12);
        assert!(matches!(found, Fault::Unknown { .. }), "{found:?}");
        let (recording, at) = recording(kind, 30);
        assert_invented_are_found(&recording, at, &format!("kind {kind}"));
    }
}

fn fault_of(right: Vec<SurfaceShape>, wrong: Vec<SurfaceShape>) -> Fault {
    let scene = |shapes| with(grains(2, 18), shapes, 1.0);
    // All particles may leave before the first wrong event.
    Recording { scene: scene(right), ..Recording::of(scene(wrong), 1500) }.fault_or_end()
}

#[test]
fn slightly_displaced_surfaces_are_found() {
    for kind in 0..KINDS {
        let moved = |shape: &SurfaceShape| {
            let by = Vector::new(1e-9, 2e-9, -1e-9);
            match shape.clone() {
                SurfaceShape::Plane { point, normal } => SurfaceShape::Plane { point: point + by, normal },
                SurfaceShape::Sphere { centre, radius, is_inside } => {
                    SurfaceShape::Sphere { centre: centre + by, radius, is_inside }
                }
                SurfaceShape::Cylinder { point, axis, radius, is_inside } => {
                    SurfaceShape::Cylinder { point: point + by, axis, radius, is_inside }
                }
                SurfaceShape::Capsule { ends, radius } => {
                    SurfaceShape::Capsule { ends: ends.map(|end| end + by), radius }
                }
                SurfaceShape::Mesh(mesh) => {
                    let none = carom::nalgebra::Rotation3::identity();
                    SurfaceShape::Mesh(mesh.transformed(1.0, &none, &by))
                }
                other => other,
            }
        };
        let found = fault_of(around(kind), around(kind).iter().map(moved).collect());
        assert!(matches!(found, Fault::Missed { .. } | Fault::Early { .. } | Fault::WrongNumbers { .. }), "{found:?}");
    }
}

#[test]
fn missing_and_surplus_surfaces_and_triangles_are_found() {
    let is_missed = |fault: &Fault| {
        matches!(
            fault,
            Fault::Missed { contact: Contact::Surface { .. }, .. }
                | Fault::EndedEarly { contact: Contact::Surface { .. }, .. }
        )
    };
    for triangle in 0..12 {
        let (closed, open) = (turned(&cuboid(2.4)), turned(&without(cuboid(2.4), triangle)));
        let found = fault_of(vec![closed.clone()], vec![open.clone()]);
        assert!(is_missed(&found), "{found:?}");
        let found = fault_of(vec![open], vec![closed]);
        assert!(matches!(found, Fault::Early { .. } | Fault::Unknown { .. }), "{found:?}");
    }
    for kind in 0..KINDS {
        let found = fault_of(around(kind), Vec::new());
        assert!(is_missed(&found), "{found:?}");
        let found = fault_of(Vec::new(), around(kind));
        assert!(matches!(found, Fault::Unknown { .. }), "{found:?}");
    }
}

#[test]
fn wrong_surface_law_and_wrong_species_are_found() {
    let scene = |surface: SurfaceDraft| grains(2, 18).surface(surface).build().unwrap();
    let draft = || SurfaceDraft::new("box", turned(&cuboid(2.4)));
    let fault = |right, wrong| Recording { scene: scene(right), ..Recording::of(scene(wrong), 400) }.fault().unwrap().1;
    let lossy = || draft().restitution(1.0 - 1e-9);
    let is_lost = |fault: Fault| matches!(fault, Fault::WrongNumbers { quantity: Quantity::Dissipation, .. });
    assert!(is_lost(fault(draft(), lossy())) && is_lost(fault(lossy(), draft())));
    assert!(matches!(fault(draft().only("A"), draft()), Fault::Unknown { .. }));
    assert!(matches!(fault(draft(), draft().only("A")), Fault::Missed { contact: Contact::Surface { .. }, .. }));
    let thermal = Scene::new({
        let mut parts = scene(draft()).into_parts();
        parts.surfaces[0].law = SurfaceLaw::Thermal { temperature: 1.0 };
        parts
    });
    let mut recording = Recording::of(scene(draft()), 100);
    recording.scene = thermal.unwrap();
    assert!(matches!(recording.fault(), Some((_, Fault::Unknown { .. }))));
}

#[test]
fn end_is_proven_only_if_no_surface_can_be_met() {
    let ball = |position: [f64; 3], velocity: [f64; 3], gravity: f64, shape: SurfaceShape| {
        let scene = grains(1, 0).gravity(Vector::new(0.0, 0.0, -gravity));
        with(scene.particle("A", Vector::from(position) + MIDDLE, Vector::from(velocity)), vec![shape], 1.0)
    };
    let cube = || SurfaceShape::Mesh(cuboid(1.0));
    let is_early = |scene| matches!(end_of(&scene), Err(Fault::EndedEarly { contact: Contact::Surface { .. }, .. }));
    // The ball flies away from the cube, towards it or past it, or starts inside it.
    assert_eq!(end_of(&ball([3.0, 0.0, 0.0], [1.0, 0.1, 0.0], 0.0, cube())), Ok(()));
    assert!(is_early(ball([3.0, 0.0, 0.0], [-1.0, 0.1, 0.0], 0.0, cube())));
    assert_eq!(end_of(&ball([3.0, 2.0, 0.0], [-1.0, 0.0, 0.0], 0.0, cube())), Ok(()));
    assert_eq!(end_of(&ball([3.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.0, cube())), Ok(()));
    assert!(is_early(ball([0.0, 0.0, 0.0], [1e-9, 0.0, 0.0], 0.0, cube())));
    assert_eq!(end_of(&ball([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0, cube())), Ok(()));
    // Under gravity, the ball falls onto the cube, falls beside it, or starts below it.
    assert!(is_early(ball([0.0, 0.0, 3.0], [0.0, 0.0, 2.0], 1.0, cube())));
    assert_eq!(end_of(&ball([1.6, 0.0, 3.0], [0.2, 0.0, 2.0], 1.0, cube())), Ok(()));
    assert_eq!(end_of(&ball([0.0, 0.0, -3.0], [0.0, 0.0, 1.0], 1.0, cube())), Ok(()));
    let pipe = |is_inside| SurfaceShape::Cylinder { point: MIDDLE, axis: Vector::z(), radius: 1.0, is_inside };
    assert_eq!(end_of(&ball([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, pipe(true))), Ok(()));
    assert_eq!(end_of(&ball([2.0, 0.0, 0.0], [0.1, 0.0, 1.0], 1.0, pipe(false))), Ok(()));
    assert!(is_early(ball([0.0, 0.0, 0.0], [0.1, 0.0, 1.0], 1.0, pipe(true))));
    let rod = SurfaceShape::Capsule { ends: [MIDDLE, MIDDLE + Vector::x()], radius: 0.2 };
    assert_eq!(end_of(&ball([3.0, 0.5, 0.0], [-1.0, 0.0, 0.0], 0.0, rod.clone())), Ok(()));
    assert!(is_early(ball([3.0, 0.4, 0.0], [-1.0, 0.0, 0.0], 0.0, rod)));
}

#[test]
fn end_among_periodic_images_of_a_surface_is_not_proven() {
    let ball = SurfaceShape::Sphere { centre: Vector::new(1.0, 1.0, 1.0), radius: 0.5, is_inside: false };
    let gas = grains(1, 0).space(Space::periodic_cube(20.0));
    let flies = |velocity: Vector| with(gas.clone().particle("A", MIDDLE, velocity), vec![ball.clone()], 1.0);
    let found = end_of(&flies(Vector::new(1.0, 0.37, 0.11)));
    assert!(matches!(found, Err(Fault::EndNotShown { .. } | Fault::EndedEarly { .. })), "{found:?}");
    assert_eq!(end_of(&flies(Vector::x())), Ok(()), "past all of them");
    assert_eq!(end_of(&flies(Vector::zeros())), Ok(()));
}
