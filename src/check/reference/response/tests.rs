//! Compares outcomes and the TC model with values computed by hand, and with the functions of the engine.

use super::*;
use crate::engine::pairs::contacts::ContactTimes;
use crate::model::{ContactLaw, TcRule};
use crate::physics::{overlap, response};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::RefCell;
use std::collections::BTreeMap;

const EPS: f64 = f64::EPSILON;

const CASES: u32 = 4000;
/// Minimum number of random cases of each outcome. More than a hundred are expected.
const FEWEST: u32 = 50;

fn at(energy_step: f64) -> Discontinuity {
    Discontinuity { distance: 2.0, energy_step }
}

#[test]
fn outcome_switches_one_float_around_the_energy_limit() {
    // The radial kinetic energy is mu/2 vn^2 = 1/4 * 4 = 1.
    let (up, down) = (1.0_f64.next_up(), 1.0_f64.next_down());
    for (side, vn, [over, off]) in [
        (Side::Positive, -2.0, [Outcome::Capture, Outcome::Bounce]),
        (Side::Negative, 2.0, [Outcome::Release, Outcome::Bounce]),
    ] {
        for (step, expected) in [(up, off), (1.0, off), (down, over), (0.0, over), (-1.25, over)] {
            let (outcome, after) = respond(&at(step), side, vn, 0.5, &ContactLaw::smooth(0.25));
            assert_eq!(outcome, expected, "{side:?} {step}");
            // After the pair has crossed a step dU, its squared normal velocity is 4 - 4 dU.
            let crossed = 4.0 - 4.0 * step;
            assert_eq!(after, if outcome == off { -vn } else { vn.signum() * crossed.sqrt() }, "{side:?} {step}");
        }
    }
    assert_eq!(respond(&at(f64::INFINITY), Side::Positive, -2.0, 0.5, &ContactLaw::smooth(0.25)), (Outcome::Core, 0.5));
    assert_eq!(
        respond(&at(f64::INFINITY), Side::Negative, 2.0, 0.5, &ContactLaw::smooth(0.25)),
        (Outcome::Bounce, -0.5)
    );
}

#[test]
fn at_a_turning_point_barriers_do_nothing_and_wells_are_entered() {
    for step in [1.0, f64::INFINITY] {
        assert_eq!(respond(&at(step), Side::Positive, 0.0, 0.5, &ContactLaw::smooth(0.25)).1, 0.0);
        assert_eq!(respond(&at(step), Side::Positive, 1e-17, 0.5, &ContactLaw::smooth(0.25)).1, 1e-17, "as it recedes");
        assert_eq!(
            respond(&at(step), Side::Negative, -1e-17, 0.5, &ContactLaw::smooth(0.25)).1,
            -1e-17,
            "as it recedes"
        );
    }
    assert_eq!(
        respond(&at(0.0), Side::Positive, 0.0, 0.5, &ContactLaw::smooth(0.25)),
        (Outcome::Bounce, 0.0),
        "no more than nothing"
    );
    assert_eq!(respond(&at(-1.0), Side::Positive, 0.0, 0.5, &ContactLaw::smooth(0.25)), (Outcome::Capture, -2.0));
    assert_eq!(respond(&at(-1.0), Side::Negative, 0.0, 0.5, &ContactLaw::smooth(0.25)), (Outcome::Release, 2.0));
}

#[test]
fn tc_model_is_elastic_for_frequent_contacts_and_keeps_a_least_speed() {
    let arrival = Arrival { restitution: 0.25, approach: 2.0, tangential: 0.0, closing: 0.0, closing_at_rest: 0.0 };
    let mut model = TcModel::new(0.5, 3);
    assert_eq!(model.contact(&[0, 1], 1.0, &arrival), (0.5, 1.0), "the first");
    assert_eq!(model.contact(&[1, 2], 1.25, &arrival), (2.0, 1.0), "the second of one of them");
    assert_eq!(model.contact(&[2], 1.75, &arrival), (0.5, 1.0), "the contact time is not less than itself");
    // The particle leaves at a speed of 0.25 against an acceleration of 1, so it returns after the contact time, 0.5.
    let dead = Arrival { restitution: 0.0, closing: 1.0, ..arrival };
    assert_eq!(model.contact(&[0], 3.0, &dead), (0.25, 1.0));
    assert_eq!(model.contact(&[0], 4.0, &Arrival { approach: 0.125, ..dead }), (0.125, 1.0), "never more than it had");
    let slides = Arrival { approach: 0.0, tangential: 2.0, closing: 1.0, closing_at_rest: 1.0, restitution: 0.0 };
    let (speed, scale) = model.contact(&[0], 5.0, &slides);
    assert_eq!(speed, 0.25 / 32.0);
    assert!((speed * speed + 4.0 * scale * scale - 4.0).abs() < 8.0 * EPS, "at constant energy");
    assert_eq!(model.contact(&[0], 6.0, &Arrival { tangential: 0.0, ..slides }), (0.25, 1.0), "at rest");
    let around = Arrival { tangential: 0.001, closing_at_rest: 0.0, ..slides };
    assert_eq!(model.contact(&[0], 7.0, &around), (0.001, 0.0), "only the curvature drives it back");
}

/// Upper bound for the difference of two square roots `a` and `b`, where `root = a` and `square = |a^2 - b^2|`.
fn of_root(square: f64, root: f64) -> f64 {
    if root * root > square { square / root.abs() } else { square.sqrt() }
}

fn mass() -> impl Strategy<Value = f64> {
    (-7.0..7.0_f64).prop_map(f64::exp)
}

fn restitution() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), Just(0.0), 0.0..1.0_f64]
}

fn speed() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 9 => (-9.0..9.0_f64).prop_map(f64::exp)]
}

/// Energy step in units of the radial kinetic energy, `2 dU / (mu vn^2)`. An infinite step is a barrier.
fn step() -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(f64::INFINITY), 1 => Just(0.0), 3 => -3.0..0.0_f64, 6 => 0.0..2.0_f64]
}

/// The two masses (`None` for a static partner), the restitution, and whether the pair is inside the discontinuity.
type Pair = (f64, Option<f64>, f64, bool);
/// Speed, whether the pair recedes, the energy step in units of the radial kinetic energy, and the separation.
type Motion = (f64, bool, f64, f64);

#[test]
fn reference_outcomes_match_the_engine() {
    let counts = RefCell::new(BTreeMap::<(Side, String), u32>::new());
    let strategy = (
        (mass(), prop::option::weighted(0.8, mass()), restitution(), any::<bool>()),
        (speed(), prop::bool::weighted(0.1), step(), (-3.0..3.0_f64).prop_map(f64::exp)),
    );
    let run = |((first, second, restitution, outer), (speed, recedes, step, length)): (Pair, Motion)| {
        let side = if outer { Side::Negative } else { Side::Positive };
        let sides = if outer { overlap::Side::Negative } else { overlap::Side::Positive };
        let reduced_mass = 1.0 / (1.0 / first + second.map_or(0.0, f64::recip));
        let vn = if recedes { side.sign() } else { -side.sign() } * speed;
        let unit = if vn == 0.0 { 1.0 } else { vn * vn };
        let energy_step = 0.5 * reduced_mass * step * unit;
        let (outcome, after) = respond(&at(energy_step), side, vn, reduced_mass, &ContactLaw::smooth(restitution));
        // The engine does not normalize the separation, so any length must give the same result.
        let approach = response::Approach { radial: vn * length, squared: length * length, reduced_mass };
        let engine = response::respond(sides, energy_step, &approach, &ContactLaw::smooth(restitution));

        // Each implementation rounds about four products.
        let finite = if step.is_finite() { step } else { 0.0 };
        let rounding = 8.0 * EPS * unit * (1.0 + finite.abs());
        if step.is_finite() && (unit * step - vn * vn).abs() <= rounding && vn != 0.0 {
            return Ok(());
        }
        let kind = format!("{outcome:?}");
        prop_assert_eq!(&kind, &format!("{:?}", engine.outcome));
        let by = (engine.radial / length - after).abs();
        let crosses = matches!(outcome, Outcome::Capture | Outcome::Release);
        let bound = 8.0 * EPS * after.abs() + if crosses { of_root(rounding, after) } else { 0.0 };
        prop_assert!(by <= bound, "{by} of {after}, not {bound}");
        let is_barrier = if step.is_finite() { "finite" } else { "infinite" };
        *counts.borrow_mut().entry((side, format!("{kind}, {is_barrier}"))).or_default() += 1;
        Ok(())
    };
    TestRunner::new(ProptestConfig { cases: CASES, ..ProptestConfig::default() }).run(&strategy, run).unwrap();
    let counts = counts.into_inner();
    println!("{counts:?}");
    assert_eq!(counts.len(), 6, "Core, Capture, Release, and Bounces in and out: {counts:?}");
    assert!(counts.values().all(|&count| count >= FEWEST), "{counts:?}");
    // Only ties within round-off are skipped, and they are rare.
    assert!(counts.values().sum::<u32>() > CASES * 9 / 10, "{counts:?}");
}

/// First particle, offset to the second particle, and scaled time since the previous contact. `None` means exactly 1.
type Contact = (u32, u32, Option<f64>);
/// Restitution, speed towards the barrier, speed along the barrier, scaled acceleration towards the barrier, and the part
/// of it that also acts at rest.
type Arriving = (f64, f64, f64, f64, f64);

#[test]
fn reference_tc_model_matches_the_engine() {
    let counts = RefCell::new(BTreeMap::<&str, u32>::new());
    let contact = (
        (0..4_u32, 1..4_u32, prop::option::weighted(0.9, 0.0..2.0_f64)),
        (restitution(), speed(), speed(), prop_oneof![3 => -2.0..400.0_f64, 1 => 400.0..40_000.0_f64], -0.5..1.5_f64),
    );
    let strategy = ((-6.0..0.0_f64).prop_map(f64::exp), prop::collection::vec(contact, 1..20));
    let run = |(contact_time, contacts): (f64, Vec<(Contact, Arriving)>)| {
        let (mut ours, mut theirs) =
            (TcModel::new(contact_time, 4), ContactTimes::new(contact_time, TcRule::Resting, 4));
        let mut time = 0.0;
        for ((first, step, gap), (restitution, approach, tangential, closing, at_rest)) in contacts {
            time += gap.map_or(contact_time, |gap: f64| gap * contact_time);
            let particles = [first, (first + step) % 4];
            let closing = closing * 0.01 * (approach + 0.1 * tangential) / contact_time;
            let closing_at_rest = at_rest * closing;
            let arrival = Arrival { restitution, approach, tangential, closing, closing_at_rest };
            let (speed, scale) = ours.contact(&particles, time, &arrival);
            let since = theirs.note(&particles, time);
            let arrival = response::Arrival { approach, restitution, tangential, closing, closing_at_rest };
            let leaving =
                response::tc_contact(TcRule::Resting, &ContactLaw::smooth(restitution), since, &arrival, contact_time);
            prop_assert!((leaving.speed - speed).abs() <= 4.0 * EPS * speed, "{leaving:?} {speed}");
            let squared = 8.0 * EPS * (approach * approach + tangential * tangential);
            let (a, b) = (leaving.tangential_scale * tangential, scale * tangential);
            prop_assert!((a - b).abs() <= of_root(squared, b) + 4.0 * EPS * b, "{leaving:?} {scale}");
            let kind = match () {
                () if leaving.is_lifted => "lifted",
                () if scale != 1.0 => "slides",
                () if speed == approach && restitution < 1.0 => "elastic",
                () if speed > restitution * approach => "kept away",
                () => "plain",
            };
            *counts.borrow_mut().entry(kind).or_default() += 1;
        }
        Ok(())
    };
    TestRunner::new(ProptestConfig { cases: CASES / 10, ..ProptestConfig::default() }).run(&strategy, run).unwrap();
    let counts = counts.into_inner();
    println!("{counts:?}");
    assert_eq!(counts.len(), 5, "{counts:?}");
    assert!(counts.values().all(|&count| count >= FEWEST), "{counts:?}");
}
