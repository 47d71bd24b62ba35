//! Regression tests of contact detection. For each state, a detection function or its test was once wrong.

use crate::compare::{Judgement, compare};
use crate::detection::Algorithm;
use crate::exact::State;
use carom::Vector;
use carom::physics::overlap::Side;

fn state(r: [f64; 3], v: [f64; 3], a: [f64; 3], distance: f64) -> State {
    State { position: Vector::from(r), velocity: Vector::from(v), acceleration: Vector::from(a), distance }
}

fn is_not_wrong(algorithm: Algorithm, state: &State) {
    let comparison = compare(algorithm, state);
    assert!(!matches!(comparison.judgement, Judgement::Wrong(_)), "{comparison:?}");
}

#[test]
fn turning_point_rounded_to_a_root_is_within_round_off() {
    // The pair is one floating-point number beyond the end of its bond, so `R2` rounds to zero.
    is_not_wrong(
        Algorithm::InertialNegative,
        &state(
            [1.5000000000000002, 0.0, -2.0000000000000004],
            [-7.437862465520784e-11, 1.5242914750111353e-8, -5.578396849140464e-11],
            [0.0; 3],
            2.5000000000000004,
        ),
    );
    is_not_wrong(
        Algorithm::AcceleratedPositive,
        &state(
            [-7.999999999999999, -4.0, -8.0],
            [-4.540532853379365e-9, 1.6847465747732462e-9, -8.87917105579543e-10],
            [6.767436368904282, -14.12330979561322, 10.679744203248886],
            12.0,
        ),
    );
}

#[test]
fn near_miss_rounded_to_a_hit_is_within_round_off() {
    // Rounding turns an exact grazing into two roots that are sqrt(epsilon) apart.
    for (r, v, a, distance) in [
        (
            [-1.9575268761518552, -5.872580628455566, -17.617741885366698],
            [0.0, 1.9575268761518552, 5.872580628455566],
            [0.0; 3],
            1.9575268761518552,
        ),
        ([25.200000000000003, -33.6, 0.0], [30.799999999999997, 25.6, -168.0], [-31.4, -24.8, 168.0], 40.0),
    ] {
        is_not_wrong(Algorithm::General(Side::Positive), &state(r, v, a, distance));
        if a != [0.0; 3] {
            is_not_wrong(Algorithm::AcceleratedPositive, &state(r, v, a, distance));
        }
    }
}

#[test]
fn turning_point_far_below_the_terms_is_within_round_off() {
    // The squared contact distance is at least 10^18 times the values of `f`.
    for (r, v, a, distance) in [
        (
            [14.333333333333334, 2.5243548967072375e-29, -6688574853559353.0],
            [-20.333333333333332, 53.0, 0.0],
            [4.4726801511442e-33, 0.0, -2.848526764311838e18],
            6688574853559353.0,
        ),
        (
            [43.0, -0.3333333333333333, -2.7415662817517235e18],
            [0.0005340576171875, 33.0, 0.0],
            [0.0, -3.689108619554875e19, -20.333333333333332],
            2.7415662817517235e18,
        ),
        (
            [-0.3333333333333333, -1.0, -2.8479770085315046e18],
            [-20.333333333333332, 11.0, 0.0],
            [-0.3333333333333333, -3.689108619554875e19, -20.333333333333332],
            2.8479770085315046e18,
        ),
    ] {
        is_not_wrong(Algorithm::AcceleratedNegative, &state(r, v, a, distance));
    }
}

#[test]
fn the_reference_finds_a_root_that_brents_method_left_behind() {
    let (r, v) = ([79.0, -2.6666666666666665, 8.0], [-0.3333333333333333, 0.0, -3.1728598231957846e47]);
    let state = state(r, v, [-26624.0, 0.0, 8589934596.999998], 79.44879552964356);
    is_not_wrong(Algorithm::General(Side::Negative), &state);
}

#[test]
fn the_reference_finds_roots_among_values_of_1e150() {
    // Brent's method overflowed and the middle of the bracket was returned as the root.
    for (r, v, a, distance) in [
        (
            [1.3462627539392349e23, 4.038515711558194e-42, 2.2132505582398304e-45],
            [-15929691.845486917, -3.3060668933226155e37, 7.631383366665236e-34],
            [-6.693176166632322e-19, 0.2862791257859689, 2.251513434220725e-29],
            5.06540620544025e-28,
        ),
        (
            [181601834313.5309, 124929545808.85123, 47146334777.364456],
            [-8.908640393296296e-46, 2.8561181817002057e-8, 7.290692513194066e34],
            [1.0782611171384586e-40, 1.2042256746615528e-47, -1.4745946131450365e-10],
            1.6152245761593664e35,
        ),
        (
            [-95.0, 0.0, 0.0],
            [-2.848055655925778e18, -5.254360077455675e37, 3.595179056420045e-11],
            [0.0, 37.0, 0.0],
            60.0,
        ),
    ] {
        is_not_wrong(Algorithm::General(Side::Positive), &state(r, v, a, distance));
    }
}

#[test]
fn the_reference_keeps_the_sign_that_it_had_before_a_turning_point() {
    // At the turning point, f is zero within rounding. A second evaluation returned another sign.
    let r = [44250737.39427264, -63070544.57782876, -175729120.62115726];
    let v = [-2.474881449500859, 4.097577369464359, 10.424111698348904];
    let a = [3.2026923444437286e-8, -1.009063392089401e-7, -1.849349310097299e-7];
    is_not_wrong(Algorithm::General(Side::Negative), &state(r, v, a, 1.0));
}
