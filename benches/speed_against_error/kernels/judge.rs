use super::problem::Pair;
use crate::oracle::dyadic::Dyadic;
use crate::oracle::exact::Overlap;
use crate::oracle::measure::distance;
use crate::oracle::rule::{Kind, Verdict, next_event};
use crate::oracle::witness::witness;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement {
    /// The method finds no event, or an event at the current time, as the exact result does.
    Right,
    /// The method finds the correct event. `relative` is the relative error of its time. `of_allowed` is the error
    /// divided by the allowed round-off.
    Time { relative: f64, of_allowed: f64 },
    /// The answer is correct within the round-off of the coefficients.
    WithinRounding,
    /// The answer is too late, or the method finds no event.
    Missed,
    /// The answer is too early, or there is no event.
    Invented,
}

/// A larger relative error of the time means that the method has found another event.
const ANOTHER_EVENT: f64 = 1e-2;

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

    /// Whether `f(t)` is zero within round-off. A turning point at `t` may then be a root.
    fn may_be_root(&self, t: f64) -> bool {
        self.overlap.polynomial().value(&Dyadic::from(t)).to_f64().abs() <= self.overlap.error_at(t)
    }
}
