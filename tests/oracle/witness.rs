//! Witnesses: polynomials indistinguishable from the exact one by rounding, for which an answer is right.

use super::dyadic::Dyadic;
use super::exact::Overlap;
use super::measure::last_place;
use super::polynomial::Polynomial;
use super::rule::{Kind, Verdict, next_event};

/// Fractions of the boxes at which witnesses are searched, in addition to the centre.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];

/// Whether any polynomial in the boxes has the answer, and an event of the requested kind.
pub fn witness(overlap: &Overlap, answer: Option<f64>, kind: Option<Kind>) -> bool {
    let kinds = kind.map_or_else(|| vec![Kind::Root, Kind::TurningPoint], |kind| vec![kind]);
    directions(overlap).any(|signs| match answer {
        None => matches!(next_event(&overlap.shifted(&signs)), Verdict::None),
        Some(0.0) => matches!(next_event(&overlap.shifted(&signs)), Verdict::Now),
        Some(t) => kinds.iter().any(|&kind| is_event_near(overlap, &signs, t, kind)),
    })
}

/// Largest distance of a witness's event from the answer, as an exponent of 2 [ulp]: as wide as a closed
/// bracket.
const SLACK: i64 = 2;

/// Shifts a polynomial in the boxes so that it has a root, or a turning point, at `t`; returns whether that
/// is its next event.
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
    // The fractions are rounded and leave a small remainder, which is taken from the term that changes f
    // most.
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

/// Number of corrections. Each leaves one part in 10^16: `f` at `t` can be that much smaller than its own
/// rounding.
const CORRECTIONS: usize = 4;

/// Change of `f`, or of its derivative, at `t` per unit of a coefficient.
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

/// Fraction of a box that may be left out of its size: a few roundings of the fractions of other boxes.
const REST: f64 = 1e-9;

/// The centre of the boxes, then their corners and the midpoints of edges and faces, for each fraction of
/// their size.
fn directions(overlap: &Overlap) -> impl Iterator<Item = Vec<f64>> {
    let count = overlap.coefficients.len();
    let power_of_three = |k: usize| 3_usize.pow(u32::try_from(k).unwrap());
    let all = power_of_three(count);
    let digit = move |code: usize, k: usize| (code / power_of_three(k) % 3) as f64 - 1.0;
    let vector = move |code: usize, part: f64| (0..count).map(|k| part * digit(code, k)).collect::<Vec<_>>();
    // The uniform shifts come first: they shift f as far as possible.
    let ordered = [0, all - 1].into_iter().chain(1..all - 1);
    let parts = PARTS.into_iter().flat_map(move |part| ordered.clone().map(move |code| vector(code, part)));
    std::iter::once(vec![0.0; count]).chain(parts)
}
