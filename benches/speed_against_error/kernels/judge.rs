//! An answer compared with the exact one.

use super::problem::Pair;
use crate::oracle::dyadic::Dyadic;
use crate::oracle::exact::Overlap;
use crate::oracle::measure::distance;
use crate::oracle::rule::{Kind, Verdict, next_event};
use crate::oracle::witness::witness;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement {
    /// The correct verdict: no event, or now.
    Right,
    /// The correct event after now: relative error of its time, and the error in units of the error
    /// that rounding allows.
    Time { relative: f64, of_allowed: f64 },
    /// Correct for coefficients within their rounding.
    WithinRounding,
    /// No event, or a later one.
    Missed,
    /// An event that does not happen, or not yet.
    Invented,
}

/// A time with a larger relative error belongs to another event.
const ANOTHER_EVENT: f64 = 1e-2;

/// Bits of the bracket around an exact time: more than a floating-point number has.
const BITS: i64 = 80;

pub struct Truth {
    overlap: Overlap,
    verdict: Verdict,
}

impl Truth {
    pub fn new(pair: &Pair) -> Self {
        let overlap = pair.problem.overlap(&pair.state);
        let verdict = next_event(&overlap.polynomial());
        Self { overlap, verdict }
    }

    pub fn judge(&self, answer: Option<f64>) -> Judgement {
        let wrong = match (&self.verdict, answer) {
            (Verdict::None, None) => return Judgement::Right,
            (Verdict::Now, Some(0.0)) => return Judgement::Right,
            (Verdict::None, Some(_)) => Judgement::Invented,
            (Verdict::Now, _) | (Verdict::Later(..), None) => Judgement::Missed,
            (Verdict::Later(kind, crossing), Some(t)) => {
                let (lower, _) = crossing.refine(BITS);
                let error = (&Dyadic::from(t) - &lower).to_f64() / lower.to_f64();
                if error.abs() <= ANOTHER_EVENT && t > 0.0 {
                    if *kind == Kind::TurningPoint && self.may_be_root(t) {
                        return Judgement::WithinRounding;
                    }
                    let rounding = match kind {
                        Kind::Root => self.overlap.error_at(t),
                        Kind::TurningPoint => self.overlap.error_of_derivative_at(t),
                    };
                    let of_allowed = distance(crossing, t, rounding).ratio();
                    return Judgement::Time { relative: error.abs(), of_allowed };
                }
                if error > 0.0 { Judgement::Missed } else { Judgement::Invented }
            }
        };
        if witness(&self.overlap, answer, None) { Judgement::WithinRounding } else { wrong }
    }

    /// Whether `f` is indistinguishable from zero. Then the event may be a root, which has another condition.
    fn may_be_root(&self, t: f64) -> bool {
        self.overlap.polynomial().value(&Dyadic::from(t)).to_f64().abs() <= self.overlap.error_at(t)
    }
}
