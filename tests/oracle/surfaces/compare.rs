//! Judges Carom's answer for a feature. The answer must equal the oracle's answer for the exact polynomials, within the
//! error of its time that rounding allows. If rounding decides between two verdicts, the answer may instead equal the
//! oracle's answer for a witness.

use super::feature::State;
use super::rule::{Kind, Verdict, next_event};
use super::witness::witness;
use crate::measure::distance;

/// The largest allowed [`crate::measure::Distance::ratio`]. As in `tests/oracle/compare.rs`, the error of a contact
/// time is at most the condition of the root plus 3 ulp. The time at which the foot enters a feature adds a rounded
/// time to a closed form, so its limit is 4.
pub fn largest_ratio(kind: Kind) -> f64 {
    if matches!(kind, Kind::Entry(_)) { 4.0 } else { 3.0 }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement {
    /// The answer has the oracle's verdict. The number is the error of the time, relative to the allowed error.
    Right(Option<f64>),
    /// The answer is right for a witness. The number is the largest shift, relative to the error bound.
    WithinRounding(f64),
    Wrong(&'static str),
}

#[derive(Debug)]
pub struct Comparison {
    pub answer: Option<f64>,
    pub verdict: Verdict,
    pub judgement: Judgement,
}

pub fn compare(state: &State) -> Comparison {
    let (answer, question) = (state.ask(), state.question());
    let verdict = next_event(&question.exact());
    let by_witness = || witness(&question, answer).map_or(Judgement::Wrong("verdict"), Judgement::WithinRounding);
    let parts = question.forms.iter().flat_map(super::question::Form::place_of_computed);
    let judgement = match (answer, &verdict) {
        _ if parts.into_iter().any(|part| !(-1.0..=1.0).contains(&part)) => Judgement::Wrong("coefficients"),
        (Some(t), _) if !(0.0..f64::INFINITY).contains(&t) => Judgement::Wrong("not a time"),
        (None, Verdict::None) | (Some(0.0), Verdict::Now) => Judgement::Right(None),
        (Some(t), Verdict::Later(kind, crossing)) if t > 0.0 => {
            let rounding = question.error_of(&question.functional(*kind, t));
            let ratio = distance(crossing, t, rounding).ratio();
            if ratio <= largest_ratio(*kind) { Judgement::Right(Some(ratio)) } else { by_witness() }
        }
        _ => by_witness(),
    };
    Comparison { answer, verdict, judgement }
}
