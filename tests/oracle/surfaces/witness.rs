//! Witnesses are polynomials that differ from the exact ones by rounding errors, and for which a given answer is right.

use super::question::{DISTANCE, Form, Functional, Question, Shape};
use super::rule::{Kind, Verdict, next_event, possible_events};
use crate::crossing::Crossing;
use crate::dyadic::Dyadic;
use crate::measure::last_place;

/// Shifts to try, as fractions of the boxes around the coefficients.
const PARTS: [f64; 4] = [0.0625, 0.25, 0.5, 1.0];

/// Searches for a witness. Returns its shift as a fraction of the boxes. Tries the centres of the boxes and Carom's own
/// coefficients, then shifts and tilts of whole polynomials, then the corners, edges and faces of the boxes, and
/// finally pairs of witnesses.
pub fn witness(question: &Question, answer: Option<f64>) -> Option<f64> {
    let computed: Vec<_> = question.forms.iter().map(Form::place_of_computed).collect();
    let middle: Vec<_> = computed.iter().map(|parts| vec![0.0; parts.len()]).collect();
    let try_all = |parts: &[Vec<f64>], ends: Ends| size_of_witness(question, parts, answer, ends);
    let found = [middle, computed].iter().find_map(|parts| try_all(parts, Ends::Free));
    let found = found.or_else(|| {
        let mut as_a_whole = PARTS.into_iter().flat_map(|part| directions(question, part, UNIFORM));
        as_a_whole.find_map(|parts| try_all(&parts, Ends::Free))
    });
    let found = found.or_else(|| {
        let mut tilts = PARTS.into_iter().flat_map(|part| tilts(question, part));
        tilts.find_map(|parts| try_all(&parts, Ends::Pinned))
    });
    let found = found.or_else(|| question.straight().and_then(|straight| witness(&straight, answer)));
    let found = found.or_else(|| {
        let mut one_by_one = PARTS.into_iter().flat_map(|part| directions(question, part, usize::MAX));
        one_by_one.find_map(|parts| try_all(&parts, Ends::Free))
    });
    found.or_else(|| pair_of_witnesses(question, answer?))
}

/// Searches for two motions within the rounding errors. The first motion has no event before the computed time, and the
/// second one has an event at this time. Two motions may be needed, because each evaluation has its own rounding error.
fn pair_of_witnesses(question: &Question, t: f64) -> Option<f64> {
    let tried = || PARTS.into_iter().flat_map(|part| directions(question, part, UNIFORM));
    let before = &Dyadic::from(t) - &Dyadic::power_of_two(last_place(t) + SLACK);
    let is_free_before = |parts: &Vec<Vec<f64>>| {
        let coefficients: Vec<_> = question.forms.iter().zip(parts).map(|(form, parts)| form.moved(parts)).collect();
        question.with(&squared(question, coefficients)).is_some_and(|exact| match next_event(&exact) {
            Verdict::Now => false,
            Verdict::Later(_, crossing) => crossing.is_after(&before),
            Verdict::None => true,
        })
    };
    let free = tried().find(is_free_before)?;
    let met = tried().find_map(|parts| size_of_witness(question, &parts, Some(t), Ends::AfterOthers))?;
    Some(met.max(largest(&free)))
}

/// The first `UNIFORM` items of `directions` leave the overlap function unchanged or shift it as a whole.
const UNIFORM: usize = 3;

/// Treatment of the extents that have no event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ends {
    Free,
    /// If possible, each extent is shifted so that it is slightly positive at the time of the event.
    Pinned,
    /// Extents are not shifted, and events before the answer are ignored.
    AfterOthers,
}

/// Returns the largest shift if the shifted polynomials are a witness for the answer.
fn size_of_witness(question: &Question, parts: &[Vec<f64>], answer: Option<f64>, ends: Ends) -> Option<f64> {
    if let Some(t) = answer.filter(|t| *t > 0.0) {
        return question.kinds().into_iter().find_map(|kind| event_near(question, parts, (t, kind), ends));
    }
    let coefficients: Vec<_> = question.forms.iter().zip(parts).map(|(form, parts)| form.moved(parts)).collect();
    let exact = question.with(&squared(question, coefficients))?;
    let is_it = match next_event(&exact) {
        Verdict::Now => answer.is_some(),
        Verdict::None => answer.is_none(),
        Verdict::Later(..) => false,
    };
    is_it.then(|| largest(parts))
}

fn largest(parts: &[Vec<f64>]) -> f64 {
    parts.iter().flatten().fold(0.0, |largest, part| largest.max(part.abs()))
}

/// Removes leading coefficients of a squared distance if a shift has changed their sign.
fn squared(question: &Question, mut coefficients: Vec<Vec<Dyadic>>) -> Vec<Vec<Dyadic>> {
    if let Shape::Square(sign) = question.shape {
        while coefficients[0].len() > 2 && coefficients[0].last().is_some_and(|leading| leading.sign() == -sign) {
            // Without acceleration, there is neither a term of degree 4 nor of degree 3.
            coefficients[0].pop();
            if coefficients[0].len() == 4 {
                coefficients[0].pop();
            }
        }
    }
    coefficients
}

/// The event of a witness may differ from the answer by `2^SLACK` ulp, the final width of a bracket.
const SLACK: i64 = 2;

/// Shifts polynomials within their boxes, to put a root or a turning point at `t`. Returns the size of the
/// shift if this is the first event. With `AfterOthers`, the event need not be the first.
fn event_near(question: &Question, parts: &[Vec<f64>], (t, kind): (f64, Kind), ends: Ends) -> Option<f64> {
    let functional = question.functional(kind, t);
    let mut coefficients: Vec<_> = question.forms.iter().zip(parts).map(|(form, parts)| form.moved(parts)).collect();
    let mut size = largest(parts);
    let (moved, part) = set(question, &functional, &parts[functional.form], 0.0)?;
    coefficients[functional.form] = moved;
    size = size.max(part);
    for k in (1..question.forms.len()).filter(|k| ends == Ends::Pinned && *k != functional.form) {
        let own = question.functional(Kind::Entry(k - 1), t);
        if let Some((moved, part)) = set(question, &own, &parts[k], JUST_POSITIVE) {
            coefficients[k] = moved;
            size = size.max(part);
        }
    }
    let (at, slack) = (Dyadic::from(t), Dyadic::power_of_two(last_place(t) + SLACK));
    let exact = question.with(&coefficients)?;
    let is_it = |found: Kind, crossing: &Crossing| {
        found == kind && crossing.is_after(&(&at - &slack)) && !crossing.is_after(&(&at + &slack))
    };
    let is_found = if ends == Ends::AfterOthers {
        possible_events(&exact).any(|(kind, crossing)| is_it(kind, &crossing))
    } else {
        matches!(next_event(&exact), Verdict::Later(kind, crossing) if is_it(kind, &crossing))
    };
    is_found.then_some(size)
}

/// Extents are shifted to this positive value, in units of their error. No event becomes earlier.
const JUST_POSITIVE: f64 = 1e-12;

/// Shifts coefficients within their box until `functional` has the value `to`, in units of its error. Starts at the
/// shift `parts`. Also returns the largest shift as a fraction of the box.
fn set(question: &Question, functional: &Functional, parts: &[f64], to: f64) -> Option<(Vec<Dyadic>, f64)> {
    let form = &question.forms[functional.form];
    let error = question.error_of(functional);
    let target = Dyadic::from(to * error);
    let missing = |coefficients: &[Dyadic]| (&functional.value(coefficients) - &target).to_f64();
    let weights: Vec<_> = functional.weights.iter().map(Dyadic::to_f64).collect();
    let mut effects: Vec<_> = weights.iter().zip(&form.errors).map(|(weight, error)| weight * error).collect();
    let mut parts = parts.to_vec();
    if functional.form == 0 && question.is_thin() {
        // With a negative contact distance, no contact would be possible.
        (effects[DISTANCE], parts[DISTANCE]) = (0.0, 0.0);
    }
    let parts = moved_within(&parts, &effects, -missing(&form.moved(&parts)))?;
    let size = parts.iter().fold(0.0_f64, |largest, part| largest.max(part.abs()));
    let mut coefficients = form.moved(&parts);
    // The fractions are rounded. The remainder is subtracted from the term with the largest effect.
    let term = (0..weights.len()).max_by(|a, b| effects[*a].abs().total_cmp(&effects[*b].abs()))?;
    for _ in 0..CORRECTIONS {
        let rest = missing(&coefficients) / weights[term];
        if rest.abs() > REST * form.errors[term] {
            return None;
        }
        coefficients[term] = &coefficients[term] - &Dyadic::from(rest);
    }
    Some((coefficients, size))
}

/// Shifts all fractions by the same amount, until the sum of the effects has changed by `growth`. Each shift has the
/// sign of the effect. Fractions stay between -1 and 1. Returns `None` if the boxes are too small.
fn moved_within(parts: &[f64], effects: &[f64], growth: f64) -> Option<Vec<f64>> {
    let moved = |step: f64| -> Vec<_> {
        let moved = |(part, effect): (&f64, &f64)| match effect {
            0.0 => *part,
            _ => (part + step * effect.signum()).clamp(-1.0, 1.0),
        };
        parts.iter().zip(effects).map(moved).collect()
    };
    let grown = |step: f64| {
        let grown =
            moved(step).into_iter().zip(parts).zip(effects).map(|((moved, part), effect)| (moved - part) * effect);
        grown.sum::<f64>()
    };
    let step = growth / effects.iter().map(|effect| effect.abs()).sum::<f64>();
    if parts.iter().all(|part| part.abs() + step.abs() <= 1.0) {
        return Some(moved(step));
    }
    let (mut lower, mut upper) = (-2.0, 2.0);
    // `step` is NaN if `growth` and all effects are zero.
    if step.is_nan() || grown(lower) > growth || grown(upper) < growth {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (lower + upper);
        (lower, upper) = if grown(middle) < growth { (middle, upper) } else { (lower, middle) };
    }
    Some(moved(lower))
}

/// Bisections from an interval of width 4 to half the spacing of floating-point numbers at 1.
const BISECTIONS: usize = 55;

/// Number of corrections. Each leaves a rounding error of one part in 10^16, which can exceed the value at `t`.
const CORRECTIONS: usize = 4;

/// Largest remainder that is corrected, as a fraction of the box. Rounding leaves less.
const REST: f64 = 1e-9;

/// Shifts to the corners of the boxes and to the midpoints of edges and faces. Extents are shifted as a whole. The
/// overlap function is shifted as a whole in the first three shifts, then coefficient by coefficient.
fn directions(question: &Question, part: f64, most: usize) -> impl Iterator<Item = Vec<Vec<f64>>> {
    let sizes: Vec<_> = question.forms.iter().map(|form| form.coefficients.len()).collect();
    let extents: Vec<Vec<Vec<f64>>> = (0..power_of_three(sizes.len() - 1))
        .map(|code| sizes[1..].iter().enumerate().map(|(k, size)| vec![part * digit(code, k); *size]).collect())
        .collect();
    let all = power_of_three(sizes[0]);
    let vector = move |code: usize| (0..sizes[0]).map(|k| part * digit(code, k)).collect::<Vec<_>>();
    // Equal shifts of all coefficients come first, because they change f most.
    let ordered = std::iter::once(all / 2).chain([0, all - 1]).chain((1..all - 1).filter(move |code| *code != all / 2));
    ordered.take(most).flat_map(move |code| {
        let overlap = vector(code);
        extents.clone().into_iter().map(move |extents| std::iter::once(overlap.clone()).chain(extents).collect())
    })
}

/// Shifts the linear terms of the extents. The overlap function is unchanged or shifted as a whole. If two extents turn
/// at the same time, the verdict depends on the order of the turning points.
fn tilts(question: &Question, part: f64) -> impl Iterator<Item = Vec<Vec<f64>>> {
    let sizes: Vec<_> = question.forms.iter().map(|form| form.coefficients.len()).collect();
    [0.0, -part, part].into_iter().flat_map(move |shift| {
        let sizes = sizes.clone();
        (0..power_of_three(sizes.len() - 1)).map(move |code| {
            let tilt = |k: usize| vec![0.0, part * digit(code, k), 0.0];
            std::iter::once(vec![shift; sizes[0]]).chain((0..sizes.len() - 1).map(tilt)).collect()
        })
    })
}

fn power_of_three(k: usize) -> usize {
    3_usize.pow(u32::try_from(k).expect("a few"))
}

fn digit(code: usize, k: usize) -> f64 {
    (code / power_of_three(k) % 3) as f64 - 1.0
}
