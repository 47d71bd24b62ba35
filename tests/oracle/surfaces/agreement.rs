//! Tests every kind of feature on every family of states, within the limits of rounding.

use super::approach::Target;
use super::compare::{Comparison, Judgement, compare};
use super::families::{FAMILIES, draw};
use super::feature::State;
use super::rule::{Kind, Verdict};
use crate::per_family;
use crate::random::Random;

/// Number of states per family and kind of feature.
const PER_FAMILY: usize = 250;

/// Number of wrong answers that are printed.
const SHOWN: usize = 3;
const ENOUGH: usize = 10;

#[derive(Debug, Default)]
struct Tally {
    states: usize,
    now: usize,
    roots: usize,
    turning_points: usize,
    entries: usize,
    right: usize,
    within_rounding: usize,
    wrong: Vec<(&'static str, State, Comparison)>,
    wrong_count: usize,
    /// Largest error of a time, relative to the error that rounding allows.
    worst_ratio: f64,
    worst_witness: f64,
    /// Number of witnesses that shift a coefficient by more than half of its error bound.
    far_witnesses: usize,
}

impl Tally {
    fn add(&mut self, family: &'static str, state: State) {
        let comparison = compare(&state);
        self.states += 1;
        match &comparison.verdict {
            Verdict::Now => self.now += 1,
            Verdict::Later(Kind::Root { .. }, _) => self.roots += 1,
            Verdict::Later(Kind::TurningPoint, _) => self.turning_points += 1,
            Verdict::Later(..) => self.entries += 1,
            Verdict::None => {}
        }
        match comparison.judgement {
            Judgement::Right(ratio) => {
                self.right += 1;
                self.worst_ratio = self.worst_ratio.max(ratio.unwrap_or(0.0));
            }
            Judgement::WithinRounding(part) => {
                self.within_rounding += 1;
                self.worst_witness = self.worst_witness.max(part);
                self.far_witnesses += usize::from(part > 0.5);
            }
            Judgement::Wrong(_) => {
                self.wrong_count += 1;
                if self.wrong.len() < SHOWN {
                    self.wrong.push((family, state, comparison));
                }
            }
        }
    }

    fn show(&self, target: Target) {
        for (family, state, comparison) in &self.wrong {
            eprintln!("{family}: {:?}\n    {state:?}\n    {:?}", comparison.judgement, comparison.answer);
            let at = match &comparison.verdict {
                Verdict::Now => "now".into(),
                Verdict::None => "none".into(),
                Verdict::Later(kind, crossing) => format!("{kind:?} at {:e}", crossing.refine(60).1.to_f64()),
            };
            eprintln!("    exact: {at}");
        }
        eprintln!(
            "{target:?}: {} states; now {}, roots {}, turning points {}, entries {}; wrong {}, within rounding {} \
             (part {:.2} at most, {} above 0.5); worst error / allowed {:.2}",
            self.states,
            self.now,
            self.roots,
            self.turning_points,
            self.entries,
            self.wrong_count,
            self.within_rounding,
            self.worst_witness,
            self.far_witnesses,
            self.worst_ratio
        );
    }
}

fn count_wrong(target: Target, per_family: usize, seed: u64) -> usize {
    let mut tally = Tally::default();
    for (number, (family, _)) in FAMILIES.iter().enumerate() {
        let mut random = Random::new(seed + number as u64);
        for _ in 0..per_family {
            if tally.wrong_count >= ENOUGH {
                break;
            }
            let state = draw(&mut random, target, number);
            tally.add(family, state);
        }
    }
    tally.show(target);
    tally.wrong_count
}

fn agrees(target: Target) {
    assert_eq!(count_wrong(target, per_family(PER_FAMILY), SEED), 0, "{target:?}");
}

const SEED: u64 = 20_261_125;

#[test]
fn points_are_met_as_exact_arithmetic_says() {
    agrees(Target::Point);
}

#[test]
fn lines_are_met_as_exact_arithmetic_says() {
    agrees(Target::Line);
}

#[test]
fn segments_are_met_as_exact_arithmetic_says() {
    agrees(Target::Segment);
}

#[test]
fn faces_are_met_as_exact_arithmetic_says() {
    agrees(Target::Face);
}

#[test]
fn planes_are_met_as_exact_arithmetic_says() {
    agrees(Target::Plane);
}
