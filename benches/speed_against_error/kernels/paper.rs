//! Algorithms 4 to 6 of the paper as printed, with the roots of `f'` in closed form and with bisection.
//!
//! The printed version does not run without two corrections: the upper limit in Algorithm 6, and the choice of the
//! simple root if `f'` has a double root.

use super::problem::Pair;
use carom::physics::overlap::Side;

/// Returns the time of the next event. `width` is the relative width at which bisection ends.
pub fn next_event(pair: &Pair, width: f64) -> Option<f64> {
    let [d0, d1, d2, d3] = pair.quartic.derivative();
    let found = roots::find_roots_cubic(d3, d2, d1, d0);
    let turns = match found.as_ref() {
        // Two roots: one is a double root, at which the cubic `f'` does not change sign. Only the simple root is a
        // turning point.
        [first, second] if pair.slope(0.5 * (first + second)) * pair.side.sign() > 0.0 => &[*first],
        [_, second] => &[*second],
        turns => turns,
    };
    match pair.side {
        Side::Positive => algorithm_4(pair, turns, width),
        Side::Negative => algorithm_5(pair, turns, width),
    }
}

fn algorithm_4(pair: &Pair, turns: &[f64], width: f64) -> Option<f64> {
    let f = |t: f64| pair.value(t);
    let &first = turns.first()?;
    if first > 0.0 && f(first) < 0.0 {
        return Some(fall(f, 0.0, first, width));
    }
    if let [_, second, third] = *turns
        && third > 0.0
        && f(third) < 0.0
    {
        return Some(fall(f, second.max(0.0), third, width));
    }
    None
}

fn algorithm_5(pair: &Pair, turns: &[f64], width: f64) -> Option<f64> {
    let f = |t: f64| pair.value(t);
    if let [first, second, _] = *turns
        && second > 0.0
        && f(second) < 0.0
    {
        return Some(fall(f, first.max(0.0), second, width));
    }
    let &last = turns.last()?;
    if f(last) <= 0.0 {
        return Some(last.max(0.0));
    }
    if last < 0.0 && f(0.0) <= 0.0 {
        return Some(0.0);
    }
    algorithm_6(pair, last.max(0.0), width)
}

fn algorithm_6(pair: &Pair, mut from: f64, width: f64) -> Option<f64> {
    let f = |t: f64| pair.value(t);
    let mut step = (pair.quartic.distance_squared / pair.quartic.coefficients[4]).sqrt().sqrt();
    while f(from + step) >= 0.0 {
        from += step;
        step *= 2.0;
        if !from.is_finite() {
            return None;
        }
    }
    Some(bisect(f, from, from + step, width))
}

/// Returns the time of an event in an interval. At the end of the interval, `f` is negative. If `f` is not positive at
/// the start, the event is at the start.
fn fall(f: impl Fn(f64) -> f64, from: f64, to: f64, width: f64) -> f64 {
    if f(from) <= 0.0 { from } else { bisect(f, from, to, width) }
}

/// Bisects until `invalid - valid` is at most `width * invalid`. Returns `valid`, where `f` is not negative.
pub fn bisect(f: impl Fn(f64) -> f64, mut valid: f64, mut invalid: f64, width: f64) -> f64 {
    loop {
        let middle = 0.5 * (valid + invalid);
        if invalid - valid <= width * invalid || middle <= valid || middle >= invalid {
            return valid;
        }
        if f(middle) >= 0.0 {
            valid = middle;
        } else {
            invalid = middle;
        }
    }
}
