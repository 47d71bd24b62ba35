//! Textbook methods. They return the next time at which `f` becomes negative, and do not handle overlapping pairs.

use super::paper::bisect;
use super::problem::Pair;
use carom::physics::overlap::Side;

/// Solves `v2 t^2 + 2 b t + r2 = 0`. Outside the discontinuity, the event is the root with the minus sign.
pub fn quadratic(pair: &Pair) -> Option<f64> {
    let f = &pair.quadratic;
    let root = (f.b * f.b - f.v2 * f.r2).sqrt();
    let t = match pair.side {
        Side::Positive => (-f.b - root) / f.v2,
        Side::Negative => (-f.b + root) / f.v2,
    };
    (t >= 0.0 && t.is_finite()).then_some(t)
}

/// Finds all four roots by Ferrari's formula. Returns the first future root at which `f` falls.
pub fn closed_form_quartic(pair: &Pair) -> Option<f64> {
    let c = &pair.quartic.coefficients;
    let roots = roots::find_roots_quartic(c[4], c[3], c[2], c[1], c[0]);
    let falls = roots.as_ref().iter().copied().filter(|&t| t >= 0.0 && t.is_finite() && pair.slope(t) < 0.0);
    falls.min_by(f64::total_cmp)
}

/// Newton's method from time 0, until a step is below the resolution of the time.
pub fn newton(pair: &Pair) -> Option<f64> {
    const MOST_STEPS: usize = 100;
    let mut t: f64 = 0.0;
    for _ in 0..MOST_STEPS {
        let step = pair.value(t) / pair.slope(t);
        t -= step;
        if !t.is_finite() {
            return None;
        }
        if step.abs() <= 2.0 * f64::EPSILON * t.abs() {
            return (t >= 0.0 && pair.slope(t) < 0.0).then_some(t);
        }
    }
    None
}

const HORIZON: f64 = 100.0;

/// Takes steps of fixed length until `f` is negative at the end of a step, and bisects this step.
pub fn scan(pair: &Pair, step: f64) -> Option<f64> {
    let mut before = pair.value(0.0);
    #[expect(clippy::cast_possible_truncation, reason = "steps are no shorter than 1e-6")]
    let steps = (HORIZON / step) as u32;
    for k in 1..=steps {
        let t = f64::from(k) * step;
        let after = pair.value(t);
        if before >= 0.0 && after < 0.0 {
            return Some(bisect(|t| pair.value(t), t - step, t, f64::EPSILON));
        }
        before = after;
    }
    None
}
