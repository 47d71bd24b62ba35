//! Witnesses: polynomials that rounding cannot distinguish from the exact one, and for which a given answer is right.

use super::dyadic::Dyadic;
use super::exact::Overlap;
use super::measure::last_place;
use super::polynomial::Polynomial;
use super::rule::{Kind, Verdict, next_event};

/// Shifts to try in the search for witnesses, as fractions of the boxes around the coefficients. The centre comes
/// first.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];

/// Returns whether a shifted polynomial in the boxes has this answer: an event at this time, or no event. A given
/// `kind` must be the kind of the event.
pub fn witness(overlap: &Overlap, answer: Option<f64>, kind: Option<Kind>) -> bool {
    let kinds = kind.map_or_else(|| vec![Kind::Root, Kind::TurningPoint], |kind| vec![kind]);
    directions(overlap).any(|signs| match answer {
        None => matches!(next_event(&overlap.shifted(&signs)), Verdict::None),
        Some(0.0) => matches!(next_event(&overlap.shifted(&signs)), Verdict::Now),
        Some(t) => kinds.iter().any(|&kind| is_event_near(overlap, &signs, t, kind)),
    })
}

/// Largest distance between the answer and the event of a witness: `2^SLACK` ulp, the width of a final bracket.
const SLACK: i64 = 2;

/// Shifts a polynomial within its box so that it has a root, or a turning point, at `t`. Returns whether this is the
/// first event of the shifted polynomial.
fn is_event_near(overlap: &Overlap, signs: &[f64], t: f64, kind: Kind) -> bool {
    let at = Dyadic::from(t);
    let available = match kind {
        Kind::Root => overlap.error_at(t),
        Kind::TurningPoint => overlap.error_of_derivative_at(t),
    };
    let missing = |f: &Polynomial| if kind == Kind::Root { f.value(&at) } else { f.derivative().value(&at) };
    let part = missing(&overlap.shifted(signs)).to_f64() / available;
    let moved: Vec<_> = signs.iter().map(|sign| sign - part).collect();
    if !moved.iter().all(|s| s.abs() <= 1.0) {
        return false;
    }
    // The fractions are rounded and leave a small remainder. It is subtracted from the term with the largest effect.
    let effects = (0..signs.len()).map(|k| effect(k, t, kind));
    let (term, effect) =
        effects.enumerate().max_by(|a, b| weigh(overlap, a).total_cmp(&weigh(overlap, b))).expect("terms");
    let mut coefficients = overlap.moved(&moved);
    for _ in 0..CORRECTIONS {
        let rest = missing(&Polynomial::new(&coefficients)).to_f64() / effect;
        if rest.abs() > REST * overlap.rounding[term] {
            return false;
        }
        coefficients[term] = &coefficients[term] - &Dyadic::from(rest);
    }
    let slack = &Dyadic::power_of_two(last_place(t) + SLACK);
    match next_event(&Polynomial::new(&coefficients)) {
        Verdict::Later(found, crossing) if found == kind => {
            crossing.is_after(&(&at - slack)) && !crossing.is_after(&(&at + slack))
        }
        _ => false,
    }
}

/// Number of corrections. Each one leaves one part in 10^16 of the remainder. One is not enough, because `f` at `t` can
/// be smaller than its rounding error by many orders of magnitude.
const CORRECTIONS: usize = 4;

/// The change of `f`, or of its derivative, at `t` if a coefficient changes by 1.
fn effect(term: usize, t: f64, kind: Kind) -> f64 {
    let power = i32::try_from(term).unwrap();
    match (kind, term) {
        (Kind::Root, _) => t.powi(power),
        (Kind::TurningPoint, 0) => 0.0,
        (Kind::TurningPoint, _) => term as f64 * t.powi(power - 1),
    }
}

fn weigh(overlap: &Overlap, (term, effect): &(usize, f64)) -> f64 {
    overlap.rounding[*term] * effect
}

/// Largest remainder that is left uncorrected, as a fraction of the box. It comes from the rounding of the fractions.
const REST: f64 = 1e-9;

/// Shifts of the coefficients within their boxes: first to the centre, then to the corners and the midpoints of edges
/// and faces. The factors in `PARTS` shrink the boxes.
fn directions(overlap: &Overlap) -> impl Iterator<Item = Vec<f64>> {
    let count = overlap.coefficients.len();
    let power_of_three = |k: usize| 3_usize.pow(u32::try_from(k).unwrap());
    let all = power_of_three(count);
    let digit = move |code: usize, k: usize| (code / power_of_three(k) % 3) as f64 - 1.0;
    let vector = move |code: usize, part: f64| (0..count).map(|k| part * digit(code, k)).collect::<Vec<_>>();
    // Shifts of all coefficients in the same direction come first, because they change f most.
    let ordered = [0, all - 1].into_iter().chain(1..all - 1);
    let parts = PARTS.into_iter().flat_map(move |part| ordered.clone().map(move |code| vector(code, part)));
    std::iter::once(vec![0.0; count]).chain(parts)
}
