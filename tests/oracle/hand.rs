//! Tests the exact oracle on polynomials with known roots.

use crate::crossing::{first_fall, first_fall_by_sturm};
use crate::dyadic::Dyadic;
use crate::polynomial::Polynomial;
use crate::random::Random;
use crate::rule::{Kind, Verdict, next_event, sign_at_crossing};
use crate::sturm::Chain;

fn with_roots(roots: &[f64], scale: f64) -> Polynomial {
    let mut c = vec![Dyadic::from(scale)];
    for &root in roots {
        let lower: Vec<_> = c.iter().map(|c| c * &Dyadic::from(-root)).collect();
        c.insert(0, Dyadic::zero());
        c = c.iter().enumerate().map(|(k, c)| lower.get(k).map_or_else(|| c.clone(), |l| c + l)).collect();
    }
    Polynomial::new(&c)
}

/// Asserts the kind and the time of the next event, to one part in 2^100.
fn expect_later(f: &Polynomial, kind: Kind, at: f64) {
    match next_event(f) {
        Verdict::Later(found, crossing) => {
            assert_eq!(found, kind, "{f:?}");
            let (lower, upper) = crossing.refine(100);
            let at = Dyadic::from(at);
            assert!(lower <= at && at <= upper, "{lower:?} {at:?} {upper:?}");
        }
        other => panic!("{other:?} for {f:?}"),
    }
}

fn expect_none(f: &Polynomial) {
    assert!(matches!(next_event(f), Verdict::None), "{f:?}");
}

fn expect_now(f: &Polynomial) {
    assert!(matches!(next_event(f), Verdict::Now), "{f:?}");
}

#[test]
fn dyadic_numbers_are_exact() {
    let (tiny, huge) = (Dyadic::from(f64::from_bits(1)), Dyadic::from(f64::MAX));
    assert!(&huge + &tiny > huge && &(&huge + &tiny) - &huge == tiny);
    for x in [0.0, 1.0, -0.1, 1e-310, 1e300, -3.0] {
        assert_eq!(Dyadic::from(x).to_f64(), x);
        assert_eq!(Dyadic::from(x).half(), &Dyadic::from(x) * &Dyadic::from(0.5));
    }
}

#[test]
fn taylor_coefficients_are_the_derivatives() {
    let f = with_roots(&[1.0, 2.0, 4.0], 0.25);
    let x = Dyadic::from(1.5);
    let around = f.around(&x);
    // The expansion is in units of 1/2, because 1.5 is 3 / 2.
    assert_eq!(Dyadic { mantissa: around.coefficients[0].clone(), exponent: around.exponent }, f.value(&x));
    let slope = Dyadic { mantissa: around.coefficients[1].clone(), exponent: around.exponent + 1 };
    assert_eq!(slope, f.derivative().value(&x));
}

#[test]
fn sturm_counts_distinct_roots_between_any_two_numbers() {
    for (roots, inside) in [
        (vec![1.0, 2.0, 4.0, 8.0], 2),
        (vec![1.0, 2.0, 2.0, 8.0], 1),
        (vec![3.0, 3.0, 3.0, 8.0], 1),
        (vec![2.0, 2.0, 3.0, 3.0], 2),
        (vec![4.0, 4.0, 4.0, 4.0], 1),
        (vec![-1.0, 1.0, 5.0], 0),
    ] {
        for scale in [1.0, -0.375] {
            let chain = Chain::new(&with_roots(&roots, scale));
            assert_eq!(chain.count(&Dyadic::from(1.0), &Dyadic::from(4.0)), inside, "{roots:?}");
            let mut distinct = roots.clone();
            distinct.dedup();
            assert_eq!(chain.count(&Dyadic::from(-10.0), &Dyadic::from(10.0)), distinct.len());
        }
    }
    // `t^4 + 1` has no roots.
    let none = Chain::new(&Polynomial::from_floats(&[1.0, 0.0, 0.0, 0.0, 1.0]));
    assert_eq!(none.count(&Dyadic::from(-10.0), &Dyadic::from(10.0)), 0);
}

#[test]
fn a_fall_is_a_root_of_odd_multiplicity_from_above() {
    let zero = Dyadic::zero();
    let at = |roots: &[f64], scale| first_fall(&with_roots(roots, scale), &zero).map(|c| c.refine(60).1.to_f64());
    assert_eq!(at(&[1.0, 2.0], 1.0), Some(1.0));
    assert_eq!(at(&[1.0, 2.0], -1.0), Some(2.0));
    assert_eq!(at(&[1.0, 1.0, 3.0], -1.0), Some(3.0));
    assert_eq!(at(&[2.0, 2.0, 2.0], -1.0), Some(2.0));
    assert_eq!(at(&[2.0, 2.0, 2.0], 1.0), None);
    assert_eq!(at(&[1.0, 1.0, 2.0, 2.0], 1.0), None);
    assert_eq!(at(&[-1.0, 0.0], -1.0), None);
    assert!(first_fall(&Polynomial::from_floats(&[-1.0, 0.0, 0.0, -1.0]), &zero).is_none());
    assert!(first_fall(&Polynomial::from_floats(&[1.0, 0.0, 0.0, 1.0]), &zero).is_none());
}

#[test]
fn two_roots_one_part_in_2_to_the_200_apart_are_told_apart() {
    let (p, q) = (Dyadic::from(1.0), &Dyadic::from(1.0) + &Dyadic::power_of_two(-200));
    let f = Polynomial::new(&[&p * &q, -&(&p + &q), Dyadic::from(1.0)]);
    let Verdict::Later(Kind::Root, crossing) = next_event(&f) else { panic!("one root after the other") };
    let (lower, upper) = crossing.refine(300);
    assert!(lower <= p && p <= upper && upper < q);
    // A polynomial that touches zero from above has no event.
    expect_none(&with_roots(&[1.0, 1.0], 1.0));
}

#[test]
fn first_fall_is_the_event_of_a_valid_state() {
    expect_later(&with_roots(&[2.0, 4.0], 1.0), Kind::Root, 2.0);
    expect_later(&with_roots(&[1.0, 1.0, 2.0, 4.0], 1.0), Kind::Root, 2.0);
    expect_later(&with_roots(&[3.0, 3.0, 3.0, -1.0], -1.0), Kind::Root, 3.0);
    expect_none(&with_roots(&[1.0, 1.0, 2.0, 2.0], 1.0));
    expect_none(&with_roots(&[-1.0, -2.0], 1.0));
}

#[test]
fn deepening_or_turning_point_is_the_event_of_an_invalid_state() {
    expect_now(&Polynomial::from_floats(&[-1.0, -1.0, 1.0]));
    expect_now(&Polynomial::from_floats(&[0.0, 0.0, 0.0, 0.0, -1.0]));
    expect_now(&Polynomial::from_floats(&[-1.0, 0.0, 0.0, -1.0]));
    expect_none(&Polynomial::from_floats(&[-1.0, 0.0, 0.0, 1.0]));
    expect_none(&Polynomial::from_floats(&[0.0, 0.0, 0.0, 0.0, 1.0]));
    expect_later(&with_roots(&[1.0, 3.0], -1.0), Kind::Root, 3.0);
    expect_later(&Polynomial::from_floats(&[-2.0, 2.0, -1.0]), Kind::TurningPoint, 1.0);
    // A polynomial that touches zero from below has an event at the double root.
    expect_later(&with_roots(&[1.0, 1.0], -1.0), Kind::TurningPoint, 1.0);
    expect_later(&with_roots(&[1.0, 1.0, 5.0, 5.0], -1.0), Kind::TurningPoint, 1.0);
    // At t = 1, `f = -(t-1)^3 (t-5)` has a saddle point, which is no turning point. The event is at t = 5.
    expect_later(&with_roots(&[1.0, 1.0, 1.0, 5.0], -1.0), Kind::Root, 5.0);
}

#[test]
fn a_constant_never_has_an_event() {
    expect_none(&Polynomial::from_floats(&[-1.0]));
    expect_none(&Polynomial::from_floats(&[1.0]));
    expect_none(&Polynomial::from_floats(&[]));
}

#[test]
fn the_start_of_a_pendulum_reaches_the_end_of_its_bond() {
    // The squared distance |r|^2 = 1/4 + t^4/4 reaches 1/4 + 4 at t = 2.
    expect_later(&Polynomial::from_floats(&[4.0, 0.0, 0.0, 0.0, -0.25]), Kind::Root, 2.0);
    expect_now(&Polynomial::from_floats(&[0.0, 0.0, 0.0, 0.0, -0.25]));
}

#[test]
fn the_sign_at_a_turning_point_is_exact() {
    for (shift, sign) in [(Dyadic::power_of_two(-400), 1), (Dyadic::zero(), 0), (-&Dyadic::power_of_two(-400), -1)] {
        let f = Polynomial::new(&[&Dyadic::from(-1.0) + &shift, Dyadic::from(6.0), Dyadic::from(-9.0)]);
        let turn = first_fall(&f.derivative(), &Dyadic::zero()).unwrap();
        assert_eq!(sign_at_crossing(&f, &turn), sign);
    }
}

#[test]
fn the_rule_of_signs_never_disagrees_with_sturm() {
    let mut random = Random::new(7);
    for _ in 0..2_000 {
        let f = if random.chance(0.5) {
            let roots: Vec<_> = (0..4).map(|_| random.below(9) as f64 - 4.0).collect();
            with_roots(&roots, random.sign())
        } else {
            Polynomial::from_floats(&[(); 5].map(|()| random.sign() * random.scale(-4.0, 4.0)))
        };
        for after in [0.0, 1.0, 2.5] {
            let after = Dyadic::from(after);
            let (a, b) = (first_fall(&f, &after), first_fall_by_sturm(&f, &after));
            assert_eq!(a.is_some(), b.is_some(), "{f:?}");
            if let (Some(a), Some(b)) = (a, b) {
                let ((lower, _), (_, upper)) = (a.refine(60), b.refine(60));
                assert!(lower <= upper && b.refine(60).0 <= a.refine(60).1, "{f:?}");
            }
        }
    }
}
