//! An answer of a detection function against the oracle's.
//!
//! The answer has to be the oracle's for the exact overlap function, or, where the input sits within its own rounding of the
//! boundary between two verdicts, the oracle's for a witness: another polynomial inside the boxes of [`Overlap::rounding`].

use crate::detection::{Algorithm, quartic};
use crate::dyadic::Dyadic;
use crate::exact::{Overlap, State};
use crate::measure::{Distance, distance, last_place};
use crate::rule::{Kind, Verdict, next_event};

/// The largest error of a time, in units of what rounding allows ([`Distance::ratio`]).
///
/// Outside of the root's condition every evaluation of `f` has the right sign, so a bracket's ends lie inside of it or
/// enclose it, and are at most 2 ulp apart (4 in Algorithm 1, whose search ends at twice the width): `condition + 2` or
/// `+ 4`. The closed forms of Algorithms 2 and 3 and of the plane round a root, a sum and a quotient after that, each
/// half an ulp or, across a power of two, one: `condition + 3`.
pub fn largest_ratio(algorithm: Algorithm) -> f64 {
    if matches!(algorithm, Algorithm::General(_)) { 4.0 } else { 3.0 }
}

/// How an answer stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Judgement {
    /// The oracle's verdict, at its time.
    Right,
    /// The verdict or time of a witness.
    WithinRounding,
    /// Neither.
    Wrong(&'static str),
}

/// An answer, and what the oracle says about it.
#[derive(Debug)]
pub struct Comparison {
    pub answer: Option<f64>,
    pub verdict: Verdict,
    pub judgement: Judgement,
    /// Where both name a time after now.
    pub distance: Option<Distance>,
}

/// Asks a detection function and the oracle.
pub fn compare(algorithm: Algorithm, state: &State) -> Comparison {
    let answer = algorithm.ask(state);
    let overlap = algorithm.overlap(state);
    let verdict = next_event(&overlap.polynomial());
    let (judgement, distance) = match (answer, &verdict) {
        (Some(t), _) if !(t >= 0.0 && t < f64::INFINITY) => (Judgement::Wrong("not a time"), None),
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

/// Whether the end that was returned is the valid one, and an invalid state follows within the bracket's width.
fn judge_end(algorithm: Algorithm, state: &State, overlap: &Overlap, kind: Kind, t: f64) -> Judgement {
    if algorithm.takes_acceleration() != Some(true) || kind == Kind::TurningPoint {
        return Judgement::Right;
    }
    let f = quartic(state);
    let value = |t: f64| algorithm.side().sign() * f.value(t);
    if value(t) < 0.0 {
        // Only right if a turning point below zero is within rounding.
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

/// Parts of the boxes' size at which witnesses are sought.
const PARTS: [f64; 3] = [1.0, 0.25, 0.0625];

/// Whether some polynomials within the boxes have the answer: its verdict, and times that enclose its time.
fn witness(overlap: &Overlap, answer: Option<f64>, kind: Option<Kind>) -> bool {
    let (mut before, mut after) = (false, false);
    for part in PARTS {
        for signs in directions(overlap.coefficients.len()) {
            let signs: Vec<_> = signs.iter().map(|s| s * part).collect();
            match (next_event(&overlap.shifted(&signs)), answer) {
                (Verdict::None, None) => return true,
                (Verdict::Now, Some(0.0)) => return true,
                (Verdict::Now, Some(_)) => before = true,
                (Verdict::Later(found, crossing), Some(t)) if t > 0.0 => {
                    if kind.is_some_and(|kind| kind != found) {
                        continue;
                    }
                    let slack = &Dyadic::power_of_two(last_place(t) + 2);
                    let t = &Dyadic::from(t);
                    before |= !crossing.is_after(&(t + slack));
                    after |= crossing.is_after(&(t - slack));
                }
                _ => {}
            }
            if before && after {
                return true;
            }
        }
    }
    false
}

/// All combinations of -1, 0 and 1, the uniform ones first.
fn directions(count: usize) -> impl Iterator<Item = Vec<f64>> {
    let all = 3_usize.pow(count as u32);
    let digit = |code: usize, k: usize| (code / 3_usize.pow(k as u32) % 3) as f64 - 1.0;
    let vector = move |code: usize| (0..count).map(|k| digit(code, k)).collect::<Vec<_>>();
    [0, all - 1].into_iter().chain(1..all - 1).map(vector)
}
