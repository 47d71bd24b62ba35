//! Tests every detection function on every family of hard cases, within the limits of rounding.

use crate::compare::largest_ratio;
use crate::detection::Algorithm;
use crate::per_family;
use crate::tally::run;
use carom::physics::overlap::Side;

const PER_FAMILY: usize = 500;

const SEED: u64 = 20_260_101;

fn agrees(algorithm: Algorithm) {
    let mut wrong = 0;
    for (family, tally) in run(algorithm, per_family(PER_FAMILY), SEED) {
        wrong += tally.wrong_count;
        for (state, comparison) in &tally.wrong {
            eprintln!("{family}: {} {state:?}\n    answer {:?}", algorithm.name(), comparison.answer);
            eprintln!("    {:?} {:?}", comparison.judgement, comparison.distance);
        }
        if tally.wrong_count + tally.within_rounding > 0 {
            eprintln!("{family}: {} wrong, {} within rounding", tally.wrong_count, tally.within_rounding);
        }
        let worst = tally.ratios.iter().copied().fold(0.0, f64::max);
        assert!(worst <= largest_ratio(algorithm), "{family}: {worst} times what rounding allows");
    }
    assert_eq!(wrong, 0, "{}", algorithm.name());
}

#[test]
fn algorithm_2_is_exact_to_rounding() {
    agrees(Algorithm::InertialPositive);
}

#[test]
fn algorithm_3_is_exact_to_rounding() {
    agrees(Algorithm::InertialNegative);
}

#[test]
fn algorithm_4_is_exact_to_rounding() {
    agrees(Algorithm::AcceleratedPositive);
}

#[test]
fn algorithms_5_and_6_are_exact_to_rounding() {
    agrees(Algorithm::AcceleratedNegative);
}

#[test]
fn the_plane_is_exact_to_rounding() {
    agrees(Algorithm::Plane);
}

#[test]
fn algorithm_1_is_exact_to_rounding_on_the_positive_side() {
    agrees(Algorithm::General(Side::Positive));
}

#[test]
fn algorithm_1_is_exact_to_rounding_on_the_negative_side() {
    agrees(Algorithm::General(Side::Negative));
}
