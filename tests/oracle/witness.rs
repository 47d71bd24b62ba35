//! Witnesses are polynomials that differ from the exact one by rounding errors, and for which a given answer is right.

use super::dyadic::Dyadic;
use super::exact::Overlap;
use super::measure::last_place;
use super::polynomial::Polynomial;
use super::rule::{Kind, Verdict, next_event};

/// Shifts to try, as fractions of the boxes around the coefficients.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];

/// Returns whether `answer` is right for a shifted polynomial. The answer is a time, or `None` for no event. A later
/// event must be of the kind `kind`, if given.
pub fn witness(overlap: &Overlap, answer: Option<f64>, kind: Option<Kind>) -> bool {
    let kinds = kind.map_or_else(|| vec![Kind::Root, Kind::TurningPoint], |kind| vec![kind]);
    directions(overlap).any(|signs| match answer {
        None => matches!(next_event(&overlap.shifted(&signs)), Verdict::None),
        Some(0.0) => matches!(next_event(&overlap.shifted(&signs)), Verdict::Now),
        Some(t) => kinds.iter().any(|&kind| is_event_near(overlap, &signs, t, kind)),
    })
}

/// The event of a witness may differ from the answer by `2^SLACK` ulp, the final width of a bracket.
const SLACK: i64 = 2;

/// Shifts a polynomial within its box, to put a root or a turning point at `t`. Returns whether this is the
/// first event.
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
    // The fractions are rounded. The remainder is subtracted from the term with the largest effect.
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

/// Number of corrections. Each leaves a rounding error of one part in 10^16, which can exceed the value at `t`.
const CORRECTIONS: usize = 4;

/// Returns the change of `f` or its derivative at `t` if a coefficient changes by 1.
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

/// Largest remainder that is corrected, as a fraction of the box. Rounding leaves less.
const REST: f64 = 1e-9;

/// Shifts to the centre, the corners and the midpoints of edges and faces of boxes shrunk by `PARTS`.
fn directions(overlap: &Overlap) -> impl Iterator<Item = Vec<f64>> {
    let count = overlap.coefficients.len();
    let power_of_three = |k: usize| 3_usize.pow(u32::try_from(k).unwrap());
    let all = power_of_three(count);
    let digit = move |code: usize, k: usize| (code / power_of_three(k) % 3) as f64 - 1.0;
    let vector = move |code: usize, part: f64| (0..count).map(|k| part * digit(code, k)).collect::<Vec<_>>();
    // Equal shifts of all coefficients come first, because they change f most.
    let ordered = [0, all - 1].into_iter().chain(1..all - 1);
    let parts = PARTS.into_iter().flat_map(move |part| ordered.clone().map(move |code| vector(code, part)));
    std::iter::once(vec![0.0; count]).chain(parts)
}
