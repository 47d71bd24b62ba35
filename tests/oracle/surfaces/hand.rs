//! Tests the exact oracle on motions with known events.

use super::feature::{Feature, State};
use super::place::{Place, falls, order};
use super::rounded::{Rounded, across, dot, triple};
use super::rule::{Exact, Kind, Overlap, ROOT, Verdict, next_event};
use crate::dyadic::Dyadic;
use crate::polynomial::Polynomial;
use crate::random::Random;
use carom::Vector;
use carom::physics::detection::feature;
use std::cmp::Ordering;

fn polynomial(coefficients: &[f64]) -> Polynomial {
    Polynomial::from_floats(coefficients)
}

fn value(overlap: &[f64], extents: &[[f64; 3]]) -> Exact {
    Exact { overlap: Overlap::Value(polynomial(overlap)), extents: extents.iter().map(|e| polynomial(e)).collect() }
}

fn height(height: [f64; 3], distance: f64, extents: &[[f64; 3]]) -> Exact {
    let overlap = Overlap::Height(polynomial(&height), Dyadic::from(distance));
    Exact { overlap, ..value(&[], extents) }
}

fn expect_later(exact: &Exact, kind: Kind, at: f64) {
    let Verdict::Later(found, crossing) = next_event(exact) else { panic!("{:?}", next_event(exact)) };
    assert_eq!(found, kind);
    let (lower, upper) = crossing.refine(100);
    let at = Dyadic::from(at);
    assert!(lower <= at && at <= upper, "{upper:?} is not {at:?}");
}

fn expect_none(exact: &Exact) {
    assert!(matches!(next_event(exact), Verdict::None), "{:?}", next_event(exact));
}

fn expect_now(exact: &Exact) {
    assert!(matches!(next_event(exact), Verdict::Now), "{:?}", next_event(exact));
}

const BELOW: Kind = Kind::Root { is_below: true };

#[test]
fn signs_at_roots_and_their_order_are_exact() {
    // The root is sqrt(2). The roots of the other parabolas are sqrt(2), or differ from it by about 2^-200.
    let root = &falls(&polynomial(&[2.0, 0.0, -1.0]))[0];
    let beside = |shift: &Dyadic| Polynomial::new(&[&Dyadic::from(-2.0) + shift, Dyadic::zero(), Dyadic::from(1.0)]);
    let tiny = Dyadic::power_of_two(-200);
    for (shift, sign) in [(-&tiny, -1), (Dyadic::zero(), 0), (tiny, 1)] {
        let place = Place::At(root);
        assert_eq!(place.sign(&beside(&shift)), sign);
        let other = &falls(&Polynomial::new(&[&Dyadic::from(2.0) + &shift, Dyadic::zero(), Dyadic::from(-1.0)]))[0];
        assert_eq!(order(root, other), 0.cmp(&sign));
    }
    // Three parabolas with a turning point at t = 3, where the values are positive, zero and negative.
    let turn = &falls(&polynomial(&[3.0, -1.0]))[0];
    for (lift, sign) in [(0.125, 1), (0.0, 0), (-0.125, -1)] {
        assert_eq!(Place::At(turn).sign(&polynomial(&[9.0 + lift, -6.0, 1.0])), sign);
        assert_eq!(Place::At(turn).sign_after(&polynomial(&[9.0, -6.0, 1.0])), 1);
    }
    assert_eq!(order(turn, &falls(&polynomial(&[9.0, 0.0, -1.0]))[0]), Ordering::Equal);
}

#[test]
fn an_event_is_the_first_root_with_its_foot_on_the_feature() {
    let twice = [-24.0, 50.0, -35.0, 10.0, -1.0].map(|c| -c); // roots 1 to 4: falls at 1 and at 3
    expect_later(&value(&twice, &[]), ROOT, 1.0);
    expect_later(&value(&twice, &[[-1.0, 1.0, 0.0]]), ROOT, 1.0);
    expect_later(&value(&twice, &[[-2.0, 1.0, 0.0]]), ROOT, 3.0);
    expect_later(&value(&twice, &[[-3.0, 1.0, 0.0]]), ROOT, 3.0);
    expect_none(&value(&twice, &[[-4.0, 1.0, 0.0]]));
    expect_none(&value(&twice, &[[-1.0, 0.0, 0.0]]));
    // The overlap function falls until t = 3.62. The foot arrives at t = 3.75, which is too late for an event.
    expect_later(&value(&twice, &[[-3.25, 1.0, 0.0]]), Kind::Entry(0), 3.25);
    expect_none(&value(&twice, &[[-3.75, 1.0, 0.0]]));
}

#[test]
fn event_needs_all_extents_positive_while_in_contact() {
    // The overlap function is negative from t = 1 and falls until t = 5.
    let f = [9.0, -10.0, 1.0];
    expect_later(&value(&f, &[[-2.0, 1.0, 0.0], [-3.0, 1.0, 0.0]]), Kind::Entry(1), 3.0);
    expect_later(&value(&f, &[[-2.0, 1.0, 0.0], [3.0, -1.0, 0.0]]), Kind::Entry(0), 2.0);
    expect_later(&value(&f, &[[-2.0, 1.0, 0.0], [2.0, -1.0, 0.0]]), Kind::Entry(0), 2.0);
    expect_none(&value(&f, &[[-3.0, 1.0, 0.0], [2.0, -1.0, 0.0]]));
    expect_none(&value(&f, &[[-5.0, 1.0, 0.0]]));
    // The extent is negative from t = 1/2 to t = 3, touches zero at t = 2, or just misses zero.
    expect_later(&value(&f, &[[1.5, -3.5, 1.0]]), Kind::Entry(0), 3.0);
    expect_later(&value(&f, &[[-4.0, 4.0, -1.0]]), Kind::Touch(0), 2.0);
    expect_none(&value(&f, &[[(-4.0_f64).next_down(), 4.0, -1.0]]));
}

#[test]
fn immediate_event_needs_the_foot_on_the_feature() {
    let f = [-1.0, -1.0, 1.0];
    expect_now(&value(&f, &[]));
    expect_now(&value(&f, &[[0.0, -1.0, 0.0]]));
    expect_later(&value(&f, &[[-0.25, 1.0, 0.0]]), Kind::Entry(0), 0.25);
    expect_none(&value(&f, &[[-0.5, 1.0, 0.0]]));
    // The overlap function turns at t = 1. In the second case, the foot reaches the feature at t = 2.
    let g = [-2.0, 2.0, -1.0];
    expect_later(&value(&g, &[]), Kind::TurningPoint, 1.0);
    expect_later(&value(&g, &[[-2.0, 1.0, 0.0]]), Kind::Entry(0), 2.0);
}

#[test]
fn a_face_is_met_from_both_sides_and_not_from_within_its_plane() {
    expect_later(&height([3.0, -1.0, 0.0], 1.0, &[]), ROOT, 2.0);
    expect_later(&height([-3.0, 1.0, 0.0], 1.0, &[]), BELOW, 2.0);
    expect_now(&height([0.5, -1.0, 0.0], 1.0, &[]));
    expect_none(&height([0.5, 1.0, 0.0], 1.0, &[]));
    expect_none(&height([0.0, 1.0, 0.0], 1.0, &[]));
    expect_none(&height([0.0, 0.0, 0.0], 1.0, &[]));
    // The height is zero at t = 3. The foot of the perpendicular reaches the face at t = 2.5 or t = 3.
    expect_later(&height([3.0, -1.0, 0.0], 1.0, &[[-2.5, 1.0, 0.0]]), Kind::Entry(0), 2.5);
    expect_none(&height([3.0, -1.0, 0.0], 1.0, &[[-3.0, 1.0, 0.0]]));
    // The sphere flies upwards through the plane and falls back.
    expect_now(&height([-0.5, 3.0, -1.0], 1.0, &[]));
    expect_later(&height([0.0, 2.5, -1.0], 1.0, &[]), ROOT, 2.0);
    expect_later(&height([-1.5, 4.0, -1.0], 1.5, &[[-1.0, 1.0, 0.0]]), ROOT, 3.0);
    expect_later(&height([0.5, 0.5, -0.5], 1.0, &[]), Kind::TurningPoint, 0.5);
    expect_later(&height([-0.5, -0.5, 0.5], 1.0, &[]), Kind::TurningPoint, 0.5);
}

#[test]
fn error_bounds_contain_the_floating_point_results() {
    let mut random = Random::new(3);
    let mut worst = 0.0_f64;
    for _ in 0..20_000 {
        let (direction, _) = random.directions();
        let vector = if random.chance(0.3) { direction * random.scale(-3.0, 3.0) } else { random.vector() };
        let exact = across(&triple(&direction), &triple(&vector));
        let floats = feature::across(&direction, &vector);
        let pairs = (0..3).map(|k| (exact[k].clone(), floats[k]));
        let length = (dot(&exact, &exact), floats.dot(&floats));
        for (exact, float) in pairs.chain([length]) {
            let Rounded { exact, error, .. } = exact;
            worst = worst.max((&Dyadic::from(float) - &exact).to_f64().abs() / error);
        }
    }
    assert!((0.2..=1.0).contains(&worst), "{worst}");
}

#[test]
fn wrong_answers_are_recognised() {
    use super::witness::witness;
    let state = State {
        feature: Feature::Segment(Vector::x(), 1.0),
        position: Vector::new(-1.0, 3.0, 0.0),
        velocity: Vector::new(0.75, -1.0, 0.0),
        acceleration: Vector::zeros(),
        contact: 1.0,
    };
    assert_eq!(state.ask(), Some(2.0));
    let question = state.question();
    assert_eq!(witness(&question, Some(2.0)), Some(0.0));
    for answer in [None, Some(0.0), Some(1.99), Some(2.0 + 1e-14)] {
        assert_eq!(witness(&question, answer), None, "{answer:?}");
    }
    // If the foot of the perpendicular is on the end, rounding allows both verdicts.
    let position = Vector::new(1.0, 3.0, 0.0);
    let on_end = State { position, velocity: Vector::new(-0.5, -1.0, 0.0), ..state };
    assert!(witness(&on_end.question(), None).is_some_and(|part| part < 1.0));
    assert_eq!(witness(&on_end.question(), Some(2.0)), Some(0.0));
    let beside = State { velocity: Vector::new(-0.5 - 1e-14, -1.0, 0.0), ..on_end };
    assert_eq!(witness(&beside.question(), None), Some(0.0));
    assert_eq!(witness(&beside.question(), Some(2.0)), None);
}
