//! Judges the answer of a detection function. The answer must equal the oracle's answer for the exact overlap function
//! or for a witness. A witness is a polynomial that differs from the exact overlap function by rounding errors.

use crate::detection::{Algorithm, quartic};
use crate::exact::{Overlap, State};
use crate::measure::{Distance, distance};
use crate::rule::{Kind, Verdict, next_event};
use crate::witness::witness;

/// The largest allowed [`Distance::ratio`].
///
/// The condition of a root is the largest shift of the root by round-off, in ulp. Farther from the root, every computed
/// value of `f` has the right sign. The error of a search is therefore at most the condition plus the final width of
/// the bracket. This width is 4 ulp in Algorithm 1, and 2 ulp in other searches. The closed forms of Algorithms 2 and 3
/// and of the plane have three roundings of at most one ulp each.
pub fn largest_ratio(algorithm: Algorithm) -> f64 {
    if matches!(algorithm, Algorithm::General(_)) { 4.0 } else { 3.0 }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Judgement {
    /// The answer equals the oracle's answer.
    Right,
    /// The answer is right for a witness.
    WithinRounding,
    Wrong(&'static str),
}

#[derive(Debug)]
pub struct Comparison {
    pub answer: Option<f64>,
    pub verdict: Verdict,
    pub judgement: Judgement,
    /// Error of the time, if the answer and the oracle both predict a later event.
    pub distance: Option<Distance>,
}

pub fn compare(algorithm: Algorithm, state: &State) -> Comparison {
    let answer = algorithm.ask(state);
    let overlap = algorithm.overlap(state);
    let verdict = next_event(&overlap.polynomial());
    let (judgement, distance) = match (answer, &verdict) {
        (Some(t), _) if !(0.0..f64::INFINITY).contains(&t) => (Judgement::Wrong("not a time"), None),
        (None, Verdict::None) => (Judgement::Right, None),
        (Some(0.0), Verdict::Now) => (Judgement::Right, None),
        (Some(t), Verdict::Later(kind, crossing)) if t > 0.0 => {
            let rounding = match kind {
                Kind::Root => overlap.error_at(t),
                Kind::TurningPoint => overlap.error_of_derivative_at(t),
            };
            let distance = distance(crossing, t, rounding);
            let judgement = if distance.ratio() <= largest_ratio(algorithm) {
                judge_end(algorithm, state, &overlap, *kind, t)
            } else if witness(&overlap, answer, None) {
                Judgement::WithinRounding
            } else {
                Judgement::Wrong("time")
            };
            (judgement, Some(distance))
        }
        _ if witness(&overlap, answer, None) => (Judgement::WithinRounding, None),
        _ => (Judgement::Wrong("verdict"), None),
    };
    Comparison { answer, verdict, judgement, distance }
}

/// Checks that `t` is the end of the bracket before the event. At `t`, the overlap function must be zero, or become
/// negative within the next three floating-point numbers.
fn judge_end(algorithm: Algorithm, state: &State, overlap: &Overlap, kind: Kind, t: f64) -> Judgement {
    if algorithm.takes_acceleration() != Some(true) || kind == Kind::TurningPoint {
        return Judgement::Right;
    }
    let f = quartic(state);
    let value = |t: f64| algorithm.side().sign() * f.value(t);
    if value(t) < 0.0 {
        // A negative value is right only at a turning point that is below zero within rounding.
        let is_turn = witness(overlap, Some(t), Some(Kind::TurningPoint));
        return if is_turn { Judgement::WithinRounding } else { Judgement::Wrong("invalid end") };
    }
    let (next, second) = (t.next_up(), t.next_up().next_up());
    if value(t) == 0.0 || value(next) < 0.0 || value(second) < 0.0 || value(second.next_up()) < 0.0 {
        Judgement::Right
    } else {
        Judgement::Wrong("early end")
    }
}
