//! Algorithm 1 of the paper, including corrections, for any polynomial overlap function.

use roots::{Convergency, find_root_brent};

use super::rules::Side;
use crate::Vector;

/// A polynomial, given by its coefficients in ascending order of powers.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial(Vec<f64>);

impl Polynomial {
    /// Creates a polynomial. Zero coefficients of the highest powers are dropped.
    #[must_use]
    pub fn new(coefficients: &[f64]) -> Self {
        let degree = coefficients.iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1);
        Self(coefficients[..degree].to_vec())
    }

    /// Returns the overlap function of a pair at a discontinuity of distance `s` (paper, equation 6), with `r_ij`,
    /// `v_ij` and `a_ij`: `f+ = a^2/4 dt^4 + a.v dt^3 + (a.r + v^2) dt^2 + 2 v.r dt + r^2 - s^2`, and `f- = -f+`.
    #[must_use]
    pub fn overlap(side: Side, s: f64, r: &Vector, v: &Vector, a: &Vector) -> Self {
        let f = [r.dot(r) - s * s, 2.0 * v.dot(r), a.dot(r) + v.dot(v), a.dot(v), 0.25 * a.dot(a)];
        Self::new(&f.map(|coefficient| side.sign() * coefficient))
    }

    /// Evaluates the polynomial by Horner's scheme.
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Returns the derivative of the polynomial.
    #[must_use]
    pub fn derivative(&self) -> Self {
        Self(self.0.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect())
    }

    /// Returns the first `t > after` at which the polynomial changes sign (`FindNextRoot` in the paper).
    #[must_use]
    pub fn next_root(&self, after: f64) -> Option<f64> {
        self.sign_changes(after).first().copied()
    }

    /// Returns all `t > after` at which the polynomial changes sign, in ascending order. Between two sign changes of
    /// the derivative, the polynomial changes sign at most once, and Brent's method (crate `roots`) finds this root.
    fn sign_changes(&self, after: f64) -> Vec<f64> {
        let mut found = Vec::new();
        if self.0.len() < 2 {
            return found;
        }
        let turns = self.derivative().sign_changes(after);
        let last = turns.last().copied().unwrap_or(after);
        let (mut from, mut sign) = (after, self.sign_after(after));
        for to in turns.into_iter().chain(self.far_beyond(last)) {
            if self.value(to) * sign < 0.0 {
                found.push(self.root_between(from, to, sign));
                sign = -sign;
            }
            from = to;
        }
        found
    }

    /// Returns a point after the last turning point, at which the polynomial has its final sign.
    fn far_beyond(&self, last: f64) -> Option<f64> {
        let sign = self.0.last()?.signum();
        let mut step = f64::EPSILON * last.max(1.0);
        while self.value(last + step) * sign <= 0.0 {
            step *= 2.0;
            if !(last + step).is_finite() {
                return None;
            }
        }
        Some(last + step)
    }

    /// Returns the sign just after `t`. If the polynomial is zero at `t`, its derivative decides.
    fn sign_after(&self, t: f64) -> f64 {
        let value = self.value(t);
        if value != 0.0 {
            value.signum()
        } else if self.0.len() < 2 {
            0.0
        } else {
            self.derivative().sign_after(t)
        }
    }

    /// Returns the point at which the polynomial changes from `sign` to the opposite sign.
    fn root_between(&self, from: f64, to: f64, sign: f64) -> f64 {
        // Brent's method multiplies function values. Division by the largest value prevents overflow.
        let size = self.value(from).abs().max(self.value(to).abs());
        let value = |t: f64| self.value(t) / size;
        let is_before = |t: f64| self.value(t) * sign > 0.0;
        // A root exactly at the start is in the past.
        let start = if value(from) == 0.0 { from + (to - from) * f64::EPSILON } else { from };
        // The solver may return a wrong point, so the change of sign is checked.
        find_root_brent(start, to, value, &mut NeighbouringFloats)
            .ok()
            .filter(|&t| is_before(t * (1.0 - WIDTH)) && !is_before(t * (1.0 + WIDTH)))
            .unwrap_or_else(|| bisect(from, to, is_before))
    }
}

/// Returns the last floating-point number between `from` and `to` for which `is_before` is true.
fn bisect(mut from: f64, mut to: f64, is_before: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * from + 0.5 * to;
        if middle <= from || middle >= to {
            return from;
        }
        if is_before(middle) { from = middle } else { to = middle }
    }
}

/// Algorithm 1: returns the time from now to the next event of a pair with the overlap function `f`.
#[must_use]
pub fn next_event(f: &Polynomial) -> Option<f64> {
    let derivative = f.derivative();
    if f.value(0.0) > 0.0 {
        return f.next_root(0.0);
    }
    // At a turning point, the next derivative decides whether the polynomial decreases.
    if derivative.sign_after(0.0) < 0.0 {
        return Some(0.0);
    }
    let turn = derivative.next_root(0.0)?;
    if f.value(turn) > 0.0 { f.next_root(turn) } else { Some(turn) }
}

/// Algorithm 1 for a feature with ends. Returns the first time at which `f <= 0`, `f` decreases, and the projection of
/// the particle is on the feature. The projection is on the feature if none of the `extents` is negative.
#[must_use]
pub(in super::super) fn first_on(f: &Polynomial, extents: &[Polynomial]) -> Option<f64> {
    let first = next_event(f)?;
    let is_on = |time: f64| extents.iter().all(|extent| extent.value(time) >= 0.0);
    if is_on(first) {
        return Some(first);
    }
    // The condition changes only where one of these polynomials changes sign. One test in each interval is enough.
    let falls = f.derivative();
    let all = [f, &falls].into_iter().chain(extents);
    let mut times: Vec<f64> = all.flat_map(|polynomial| polynomial.sign_changes(first)).chain([first]).collect();
    times.sort_by(f64::total_cmp);
    times.extend(times.last().map(|last| 2.0 * last + 1.0));
    let stretch = times.windows(2).find(|stretch| {
        let middle = 0.5 * (stretch[0] + stretch[1]);
        f.value(middle) <= 0.0 && falls.value(middle) < 0.0 && is_on(middle)
    });
    stretch.map(|stretch| stretch[0])
}

/// Relative width at which the search for a root ends.
const WIDTH: f64 = 2.0 * f64::EPSILON;

struct NeighbouringFloats;

impl Convergency<f64> for NeighbouringFloats {
    fn is_root_found(&mut self, y: f64) -> bool {
        y == 0.0
    }

    fn is_converged(&mut self, x1: f64, x2: f64) -> bool {
        (x1 - x2).abs() <= WIDTH * x1.abs().max(x2.abs())
    }

    fn is_iteration_limit_reached(&mut self, iteration: usize) -> bool {
        iteration > 10_000
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_root_is_the_next_sign_change() {
        // f = (t - 1)(t - 2)(t - 4)
        let f = Polynomial::new(&[-8.0, 14.0, -7.0, 1.0]);
        for (after, root) in [(0.0, 1.0), (1.5, 2.0), (3.0, 4.0)] {
            let found = f.next_root(after).unwrap();
            assert!((found - root).abs() < 1e-14, "{found} is not {root}");
        }
        assert_eq!(f.next_root(5.0), None);
        // f = (t - 1)^2 touches zero without changing sign.
        assert_eq!(Polynomial::new(&[1.0, -2.0, 1.0]).next_root(0.0), None);
        assert_eq!(Polynomial::new(&[]).next_root(0.0), None);
        assert_eq!(Polynomial::new(&[-1.0, 0.0, 0.0, 1.0]).next_root(0.0), Some(1.0));
    }

    #[test]
    fn a_valid_pair_interacts_at_the_next_root() {
        assert_eq!(next_event(&Polynomial::new(&[8.0, -6.0, 1.0])), Some(2.0));
        assert_eq!(next_event(&Polynomial::new(&[8.0, 6.0, 1.0])), None);
    }

    #[test]
    fn a_feature_is_met_while_the_foot_is_on_it() {
        let falling = Polynomial::new(&[2.0, -1.0]);
        let from = |start: f64| Polynomial::new(&[-start, 1.0]);
        let until = |end: f64| Polynomial::new(&[end, -1.0]);
        assert_eq!(first_on(&falling, &[]), Some(2.0));
        assert_eq!(first_on(&falling, &[from(1.0), until(3.0)]), Some(2.0));
        assert_eq!(first_on(&falling, &[from(2.0), until(2.0)]), Some(2.0), "ends are on it");
        assert_eq!(first_on(&falling, &[until(1.0)]), None);
        // When the sphere moves onto the feature, it is below the height of contact, so the event is immediate.
        let late = first_on(&falling, &[from(2.5), until(3.0)]).unwrap();
        assert!((late - 2.5).abs() < 1e-14, "{late}");
        assert_eq!(first_on(&falling, &[from(3.0), until(2.5)]), None);
        // f = -(t - 1)(t - 3)(t - 4) becomes negative at 1, positive at 3 and negative again at 4.
        let again = first_on(&Polynomial::new(&[12.0, -19.0, 8.0, -1.0]), &[from(2.5)]).unwrap();
        assert!((again - 4.0).abs() < 1e-13, "{again}");
    }

    #[test]
    fn an_invalid_pair_interacts_when_it_does_not_improve() {
        assert_eq!(next_event(&Polynomial::new(&[-1.0, -1.0, 1.0])), Some(0.0));
        assert_eq!(next_event(&Polynomial::new(&[0.0, 0.0, -1.0])), Some(0.0));
        assert_eq!(next_event(&Polynomial::new(&[0.0, 0.0, 1.0])), None);
        assert_eq!(next_event(&Polynomial::new(&[-1.0, 1.0, 1.0])), None);
        assert_eq!(next_event(&Polynomial::new(&[-2.0, 2.0, -1.0])), Some(1.0), "at its turning point");
        assert_eq!(next_event(&Polynomial::new(&[-0.75, 2.0, -1.0])), Some(1.5), "after it has recovered");
    }
}
