use carom::Vector;
use carom::check::verify::{Contact, Fault, Quantity, Verifier};
use carom::engine::event::{EventKind, Other};
use carom::engine::{Simulation, Until};
use carom::model::ParticleId;
use carom::physics::response::Outcome;

use crate::FLUID;
use crate::Recording;
use crate::WELL;
use crate::scene;

const K: usize = 300;

const ROUGH: &str = "potential = \"hard-sphere\"\ntangential_restitution = 0.5\nfriction = 0.3";

fn fluid() -> Recording {
    Recording::of(scene(FLUID), 400)
}

fn rough() -> Recording {
    Recording::of(scene(&FLUID.replace("potential = \"hard-sphere\"", ROUGH)), 400)
}

fn well() -> Recording {
    Recording::of(scene(WELL), 1500)
}

/// Returns the first event with this outcome from event `K` on.
fn first(recording: &Recording, outcome: Outcome) -> usize {
    let is_it = |at: &usize| recording.events[*at].0.kind == EventKind::Pair(outcome);
    (K..recording.events.len()).find(is_it).unwrap()
}

fn bystander(recording: &Recording) -> ParticleId {
    let event = &recording.events[K].0;
    (0..256).rev().map(ParticleId).find(|id| *id != event.particle && Some(*id) != event.partner()).unwrap()
}

fn wrong_quantity(recording: &Recording, at: usize) -> Quantity {
    match recording.fault() {
        Some((found_at, Fault::WrongNumbers { quantity, .. })) if found_at == at => quantity,
        other => panic!("{other:?}"),
    }
}

#[test]
fn unchanged_events_are_proven() {
    assert_eq!(fluid().fault(), None);
    assert_eq!(well().fault(), None);
}

#[test]
fn dropped_event_is_reported_as_missed() {
    for mut recording in [fluid(), well()] {
        let (event, _) = recording.events.remove(K);
        let Some((K, Fault::Missed { contact, due, .. })) = recording.fault() else {
            panic!("{:?}", recording.fault())
        };
        assert_eq!(contact, Contact::of(&event));
        assert!((due - event.time).abs() < 1e-12);
    }
}

#[test]
fn swapped_events_are_found() {
    let mut recording = fluid();
    recording.events.swap(K, K + 1);
    let expected = Contact::of(&recording.events[K + 1].0);
    let Some((K, Fault::Missed { contact, .. })) = recording.fault() else { panic!("{:?}", recording.fault()) };
    assert_eq!(contact, expected);
    // If a later event replaces an event, the replaced event is missed.
    recording.events.remove(K);
    recording.events.insert(K, recording.events[K + 1].clone());
    assert!(matches!(recording.fault(), Some((K, Fault::Missed { .. }))));
    let mut recording = fluid();
    recording.events[K + 1].1.elapsed = recording.events[K - 1].1.elapsed;
    assert!(matches!(recording.fault(), Some((at, Fault::Backwards { .. })) if at == K + 1));
}

#[test]
fn invented_event_is_reported_as_early_or_not_closing() {
    let mut recording = fluid();
    let (mut event, states) = recording.events[K].clone();
    event.other = Other::Particle(bystander(&recording));
    recording.events.insert(K + 1, (event, states));
    assert!(matches!(recording.fault(), Some((at, Fault::Early { .. })) if at == K + 1), "{:?}", recording.fault());

    let mut recording = fluid();
    let again = recording.events[K].clone();
    recording.events.insert(K + 1, again);
    assert!(
        matches!(recording.fault(), Some((at, Fault::NotClosing { .. })) if at == K + 1),
        "{:?}",
        recording.fault()
    );
}

#[test]
fn early_event_is_reported_as_early_and_late_one_as_missed() {
    for (shift, is_early) in [(-1e-11, true), (1e-11, false)] {
        let mut recording = fluid();
        let before = recording.events[K - 1].1.velocities.clone();
        let states = &mut recording.events[K].1;
        states.elapsed.since_epoch += shift;
        for (position, velocity) in states.positions.iter_mut().zip(before) {
            *position += velocity * shift;
        }
        let fault = recording.fault();
        match fault {
            Some((K, Fault::Early { gap, .. })) if is_early => assert!((1e-13..1e-9).contains(&gap)),
            Some((K, Fault::Missed { deeper, .. })) if !is_early => assert!((1e-13..1e-9).contains(&deeper)),
            _ => panic!("{shift}: {fault:?}"),
        }
    }
}

#[test]
fn wrong_outcome_is_reported() {
    for (truth, lie) in [
        (Outcome::Capture, Outcome::Bounce),
        (Outcome::Capture, Outcome::Core),
        (Outcome::Release, Outcome::Bounce),
        (Outcome::Release, Outcome::Capture),
        (Outcome::Core, Outcome::Capture),
        (Outcome::Core, Outcome::Bounce),
        (Outcome::Bounce, Outcome::Release),
    ] {
        let mut recording = well();
        let at = first(&recording, truth);
        recording.events[at].0.kind = EventKind::Pair(lie);
        let expected =
            Fault::WrongOutcome { contact: Contact::of(&recording.events[at].0), expected: truth, found: lie };
        assert_eq!(recording.fault(), Some((at, expected)));
    }
}

#[test]
fn wrong_event_quantities_are_reported() {
    let reported = |outcome, change: &dyn Fn(&mut carom::engine::event::Event)| {
        let mut recording = well();
        let at = first(&recording, outcome);
        change(&mut recording.events[at].0);
        wrong_quantity(&recording, at)
    };
    assert_eq!(reported(Outcome::Capture, &|event| event.energy_step = 0.0), Quantity::EnergyStep);
    assert_eq!(reported(Outcome::Core, &|event| event.dissipated = 1e-9), Quantity::Energy);
    assert_eq!(reported(Outcome::Core, &|event| event.impulse *= 1.0 + 1e-9), Quantity::Velocity);
    assert_eq!(reported(Outcome::Core, &|event| event.normal = -event.normal), Quantity::Normal);
}

#[test]
fn wrong_torques_and_spins_are_reported() {
    assert_eq!(rough().fault(), None);
    let pair = |recording: &Recording| {
        let event = &recording.events[K].0;
        [event.particle, event.partner().unwrap()].map(|id| id.0 as usize)
    };
    for k in 0..2 {
        let mut recording = rough();
        recording.events[K].0.torques[k] *= 1.0 + 1e-9;
        assert_eq!(wrong_quantity(&recording, K), Quantity::Torque);
        let mut recording = rough();
        let particle = pair(&recording)[k];
        recording.events[K].1.spins[particle] *= 1.0 + 1e-9;
        assert_eq!(wrong_quantity(&recording, K), Quantity::Torque);
    }
    let mut recording = rough();
    let normal = recording.events[K].0.normal;
    let tangential = recording.events[K].0.impulse - normal * recording.events[K].0.normal_impulse();
    recording.events[K].0.impulse -= tangential;
    assert_eq!(wrong_quantity(&recording, K), Quantity::Impulse);
    let mut recording = rough();
    let other = bystander(&recording);
    recording.events[K].1.spins[other.0 as usize].x += 1e-15;
    assert_eq!(recording.fault(), Some((K, Fault::Turned { particle: other })));
}

#[test]
fn wrong_velocities_are_reported() {
    let moved = |change: &dyn Fn(&mut Vector, &mut Vector, &Vector)| {
        let mut recording = fluid();
        let (event, states) = &mut recording.events[K];
        let [i, j] = [event.particle, event.partner().unwrap()].map(|id| id.0 as usize);
        let (mut a, mut b) = (states.velocities[i], states.velocities[j]);
        change(&mut a, &mut b, &event.normal);
        (states.velocities[i], states.velocities[j]) = (a, b);
        wrong_quantity(&recording, K)
    };
    let across = |normal: &Vector| normal.cross(&Vector::new(0.3, 0.5, 0.7));
    assert_eq!(moved(&|a, _, normal| *a += normal * 1e-11), Quantity::Momentum);
    assert_eq!(moved(&|a, b, normal| (*a, *b) = (*a + normal * 1e-11, *b - normal * 1e-11)), Quantity::Velocity);
    let turn = |a: &mut Vector, b: &mut Vector, normal: &Vector| {
        *a += across(normal) * 1e-11;
        *b -= across(normal) * 1e-11;
    };
    assert_eq!(moved(&turn), Quantity::Velocity);
    assert_eq!(moved(&|a, b, _| std::mem::swap(a, b)), Quantity::Direction);
}

#[test]
fn disturbed_bystanders_and_jumps_are_reported() {
    let mut recording = fluid();
    let expected = bystander(&recording);
    let (other, taking_part) = (expected.0, recording.events[K].0.particle.0);
    let x = &mut recording.events[K].1.velocities[other as usize].x;
    *x = x.next_up();
    assert!(matches!(recording.fault(), Some((K, Fault::Disturbed { particle, .. })) if particle == expected));

    for particle in [other, taking_part] {
        let mut recording = fluid();
        recording.events[K].1.positions[particle as usize].y += 1e-12;
        let fault = recording.fault();
        assert!(matches!(fault, Some((K, Fault::Jumped { particle: who, .. })) if who.0 == particle), "{fault:?}");
    }
}

#[test]
fn wrong_pair_state_is_reported() {
    let mut simulation = Simulation::without_plan(scene(WELL));
    simulation.advance(Until::events(1000)).unwrap();
    let captured = simulation.captured_pairs();
    let mut recording = Recording::of(scene(WELL), 4000);
    let later = recording.events.split_off(1000);
    recording.start = recording.events[999].1.clone();
    recording.events = later;
    let mut verifier = Verifier::resume(&recording.scene, &recording.start, &captured).unwrap();
    assert_eq!(recording.fault_for(&mut verifier), None);

    // The list of captured pairs lacks the first released pair. At this distance, an uncaptured pair has no event while
    // it separates.
    let release =
        recording.events.iter().position(|(event, _)| event.kind == EventKind::Pair(Outcome::Release)).unwrap();
    let pair = Contact::of(&recording.events[release].0);
    let is_other = |known: &&([ParticleId; 2], u16)| Contact::Pair(known.0) != pair;
    let forgotten: Vec<_> = captured.iter().filter(is_other).copied().collect();
    assert_eq!(forgotten.len() + 1, captured.len());
    let mut verifier = Verifier::resume(&recording.scene, &recording.start, &forgotten).unwrap();
    let fault = recording.fault_for(&mut verifier);
    let Some((_, Fault::NotClosing { contact, .. })) = fault else { panic!("{fault:?}") };
    assert_eq!(contact, pair);
}

#[test]
fn captured_pair_missing_in_the_engine_is_reported() {
    let recording = well();
    let mut simulation = Simulation::without_plan(recording.scene.clone());
    simulation.advance(Until::events(recording.events.len() as u64)).unwrap();
    let mut captured = simulation.captured_pairs();
    let mut verifier = Verifier::new(&recording.scene, &recording.start).unwrap();
    assert_eq!(recording.fault_for(&mut verifier), None);
    assert_eq!(verifier.compare_pairs(&captured), Ok(()));
    let (pair, _) = captured.remove(7);
    assert_eq!(verifier.compare_pairs(&captured), Err(Fault::PairState { pair, events: 1, engine: 0 }));
}

#[test]
fn nonsensical_events_are_reported_without_a_panic() {
    let truth = well();
    let refused = |change: &dyn Fn(&mut Recording)| {
        let mut recording = Recording { events: truth.events[..9].to_vec(), ..truth.clone() };
        change(&mut recording);
        recording.fault().unwrap().1
    };
    assert!(matches!(refused(&|r| r.events[5].0.particle = ParticleId(256)), Fault::Unknown { .. }));
    assert!(matches!(refused(&|r| r.events[5].0.other = Other::Bath), Fault::Unknown { .. }));
    assert!(matches!(refused(&|r| r.events[5].0.distance = 1.25), Fault::Unknown { .. }));
    let surface = |r: &mut Recording, surface| {
        (r.events[5].0.kind, r.events[5].0.other) = (EventKind::Surface, Other::Surface { surface, feature: 0 });
    };
    assert!(matches!(refused(&|r| surface(r, 14)), Fault::Unknown { .. }), "no wall of a box");
    assert!(matches!(refused(&|r| surface(r, 3)), Fault::Unknown { .. }));
    assert!(matches!(refused(&|r| r.events[5].1.positions.truncate(255)), Fault::Incomplete { .. }));
    assert!(matches!(refused(&|r| r.events[5].1.elapsed.epoch = f64::NAN), Fault::Backwards { .. }));
    assert!(matches!(refused(&|r| r.events[5].1.elapsed.epoch = f64::INFINITY), Fault::Backwards { .. }));
    let i = truth.events[5].0.particle.0 as usize;
    assert!(matches!(refused(&|r| r.events[5].1.velocities[i].x = f64::NAN), Fault::WrongNumbers { .. }));
    assert!(matches!(refused(&|r| r.events[5].1.positions[i].x = f64::NAN), Fault::Jumped { .. }));
    let mut start = truth.start.clone();
    start.velocities.pop();
    assert!(Verifier::new(&truth.scene, &start).is_err());
    for nonsense in [([ParticleId(0), ParticleId(999)], 1), ([ParticleId(0), ParticleId(1)], 9)] {
        assert!(Verifier::resume(&truth.scene, &truth.start, &[nonsense]).is_err());
    }
}
