//! Counts how often different methods evaluate `f` to find a root. Also measures errors of closed forms.

use crate::compare::Comparison;
use crate::detection::{Algorithm, quartic};
use crate::exact::State;
use crate::rule::{Kind, Verdict};
use carom::physics::detection::roots::{bracketed, sign_changes_of_cubic};
use carom::physics::overlap::Quartic;
use roots::{Convergency, Roots, find_root_brent, find_roots_cubic, find_roots_quartic};
use std::cell::Cell;

#[derive(Debug, Default)]
pub struct Evaluations {
    pub ours: Vec<f64>,
    pub bisection: Vec<f64>,
    pub brent: Vec<f64>,
    /// Relative errors of the closed forms for roots of `f` and of `f'`.
    pub quartic: Vec<f64>,
    pub cubic: Vec<f64>,
}

impl Evaluations {
    pub fn append(&mut self, other: Self) {
        self.ours.extend(other.ours);
        self.bisection.extend(other.bisection);
        self.brent.extend(other.brent);
        self.quartic.extend(other.quartic);
        self.cubic.extend(other.cubic);
    }
}

pub fn evaluations(algorithm: Algorithm, state: &State, comparison: &Comparison) -> Evaluations {
    let mut found = Evaluations::default();
    let (Verdict::Later(kind, _), Some(t)) = (&comparison.verdict, comparison.answer) else { return found };
    if algorithm.takes_acceleration() != Some(true) {
        return found;
    }
    let f = quartic(state);
    if *kind == Kind::TurningPoint {
        let [c0, c1, c2, c3] = f.derivative();
        found.cubic.push(nearest(&find_roots_cubic(c3, c2, c1, c0), t));
        return found;
    }
    let [c0, c1, c2, c3, c4] = f.coefficients;
    found.quartic.push(nearest(&find_roots_quartic(c4, c3, c2, c1, c0), t));
    let count = Cell::new(0_u32);
    let value = |t: f64| {
        count.set(count.get() + 1);
        algorithm.side().sign() * f.value(t)
    };
    let (from, to) = bracket(&f, t);
    if !(value(from) > 0.0 && value(to) < 0.0) {
        return found;
    }
    count.set(0);
    let _ = bracketed(value, from, to);
    found.ours.push(f64::from(count.take()));
    bisect(value, from, to);
    found.bisection.push(f64::from(count.take()));
    let _ = find_root_brent(from, to, value, &mut AdjacentFloats);
    found.brent.push(f64::from(count.take()));
    found
}

/// The bracket between turning points in which Algorithms 4 to 6 search for a root. After the last turning point, the
/// bracket grows until it contains the root.
fn bracket(f: &Quartic, t: f64) -> (f64, f64) {
    let turns = sign_changes_of_cubic(&f.derivative());
    let turns = &turns.at[..turns.count];
    let from = turns.iter().copied().filter(|&turn| turn < t).fold(0.0, f64::max);
    let after = turns.iter().copied().find(|&turn| turn >= t);
    let mut step = (f.distance_squared / f.coefficients[4]).sqrt().sqrt().max(from * f64::EPSILON);
    let mut to = from + step;
    while to <= t.next_up().next_up() {
        step *= 2.0;
        to += step;
    }
    (from, after.unwrap_or(to))
}

fn bisect(f: impl Fn(f64) -> f64, valid: f64, invalid: f64) -> f64 {
    let (mut a, mut b) = (valid, invalid);
    loop {
        let x = 0.5 * a + 0.5 * b;
        if x == a || x == b {
            return a;
        }
        if f(x) >= 0.0 { a = x } else { b = x }
    }
}

/// Returns the relative difference between `t` and the nearest root, or infinity without roots.
fn nearest(roots: &Roots<f64>, t: f64) -> f64 {
    let errors = roots.as_ref().iter().map(|root| ((root - t) / t).abs());
    errors.filter(|e| !e.is_nan()).fold(f64::INFINITY, f64::min)
}

/// Stops Brent's method at the same width of the bracket as the other methods.
struct AdjacentFloats;

impl Convergency<f64> for AdjacentFloats {
    fn is_root_found(&mut self, y: f64) -> bool {
        y == 0.0
    }

    fn is_converged(&mut self, x1: f64, x2: f64) -> bool {
        (x1 - x2).abs() <= f64::EPSILON * x1.abs().max(x2.abs())
    }

    fn is_iteration_limit_reached(&mut self, iteration: usize) -> bool {
        iteration > 10_000
    }
}
