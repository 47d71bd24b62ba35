//! Roots of polynomials. Closed forms bracket the roots, and a safeguarded iteration refines them.

/// Sign changes of a cubic at positive arguments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignChanges {
    /// Positive arguments of the sign changes, ascending. Only the first `count` are valid.
    pub at: [f64; 3],
    /// Number of sign changes.
    pub count: usize,
    /// Whether the cubic is negative just after 0.
    pub starts_negative: bool,
}

/// Returns the arguments `t > 0` at which `c[0] + c[1] t + c[2] t^2 + c[3] t^3`, with `c[3] > 0`, changes sign.
///
/// The turning points of the cubic divide the positive axis into monotone pieces. A piece whose ends differ in sign
/// contains one root, which [`bracketed`] refines. Roots that stay finite as `c[3] -> 0` are accurate. Double roots are
/// left out, because the sign does not change there.
#[must_use]
pub fn sign_changes_of_cubic(c: &[f64; 4]) -> SignChanges {
    let value = |t: f64| ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
    let starts_negative = c.iter().find(|&&x| x != 0.0).is_some_and(|&x| x < 0.0);
    let mut found = SignChanges { at: [0.0; 3], count: 0, starts_negative };
    let (mut from, mut negative) = (0.0, starts_negative);
    let mut piece = |from: f64, to: f64| {
        let inside =
            bracketed(|t| if found.count % 2 == usize::from(starts_negative) { value(t) } else { -value(t) }, from, to);
        found.at[found.count] = inside;
        found.count += 1;
    };
    for turn in turning_points(c).into_iter().filter(|&t| t > 0.0 && t < f64::INFINITY) {
        let at_turn = value(turn);
        if (negative && at_turn > 0.0) || (!negative && at_turn < 0.0) {
            piece(from, turn);
            negative = !negative;
        }
        from = turn;
    }
    if negative && let Some(to) = grow(from, initial_step(c), |t| value(t) > 0.0) {
        piece(from, to);
    }
    found
}

/// The two real roots of `c[1] + 2 c[2] t + 3 c[3] t^2`, ascending; NaN if there are none.
fn turning_points(c: &[f64; 4]) -> [f64; 2] {
    let (a, half_b, constant) = (3.0 * c[3], c[2], c[1]);
    let q = -(half_b + (half_b * half_b - a * constant).sqrt().copysign(half_b));
    let (first, second) = (q / a, constant / q);
    if first <= second { [first, second] } else { [second, first] }
}

/// Returns a step comparable to the largest root of the cubic.
fn initial_step(c: &[f64; 4]) -> f64 {
    let step = libm::cbrt((c[0] / c[3]).abs()).max((c[1] / c[3]).abs().sqrt()).max((c[2] / c[3]).abs());
    if step > 0.0 && step.is_finite() { step } else { 1.0 }
}

/// Returns the first of `from + step`, `from + 3 step`, `from + 7 step`, ... that satisfies `is_beyond`, if any.
pub(crate) fn grow(from: f64, step: f64, is_beyond: impl Fn(f64) -> bool) -> Option<f64> {
    let (mut to, mut step) = (from + step, step);
    while to < f64::MAX {
        if is_beyond(to) {
            return Some(to);
        }
        step *= 2.0;
        to += step;
    }
    None
}

/// Returns the last argument in `[valid, invalid]` at which `f >= 0`, for a function that becomes negative once.
///
/// Chandrupatla's method: inverse quadratic interpolation if the last three points allow it, otherwise bisection (Adv.
/// Eng. Software 28, 145, 1997). The iteration ends when the bracket is one or two floats wide. The valid end of the
/// bracket is returned.
#[must_use]
pub fn bracketed(f: impl Fn(f64) -> f64, valid: f64, invalid: f64) -> f64 {
    let (mut a, mut b) = (valid, invalid);
    let (mut fa, mut fb) = (f(a), f(b));
    let mut fraction = 0.5;
    // The root is between `a`, the newest point, and `b`. The point `c` is the previous end of the bracket.
    for _ in 0..MOST_ITERATIONS {
        let mut x = a + fraction * (b - a);
        if x == a || x == b {
            x = 0.5 * a + 0.5 * b;
            if x == a || x == b {
                break;
            }
        }
        let fx = f(x);
        if fx == 0.0 {
            return x;
        }
        let (c, fc) = if (fx > 0.0) == (fa > 0.0) {
            (a, fa)
        } else {
            let last = (b, fb);
            (b, fb) = (a, fa);
            last
        };
        (a, fa) = (x, fx);
        let resolution = f64::EPSILON * a.abs().max(b.abs());
        let width = (b - a).abs();
        if width <= resolution {
            break;
        }
        let xi = (a - b) / (c - b);
        let phi = (fa - fb) / (fc - fb);
        fraction = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            (fa / (fb - fa)) * (fc / (fb - fc)) + ((c - a) / (b - a)) * (fa / (fc - fa)) * (fb / (fc - fb))
        } else {
            0.5
        };
        let smallest = 0.5 * resolution / width;
        fraction = fraction.clamp(smallest, 1.0 - smallest);
    }
    if fa >= 0.0 {
        a
    } else if fb >= 0.0 {
        b
    } else {
        valid
    }
}

/// Bisection alone needs 2,100 steps to search all positive floats. At least one step in three is a bisection.
const MOST_ITERATIONS: usize = 6_300;

#[cfg(test)]
mod tests {
    use super::*;

    fn cubic(roots: [f64; 3], scale: f64) -> [f64; 4] {
        let [p, q, r] = roots;
        [-p * q * r * scale, (p * q + q * r + p * r) * scale, -(p + q + r) * scale, scale]
    }

    #[test]
    fn a_cubic_with_three_positive_roots_changes_sign_three_times() {
        let found = sign_changes_of_cubic(&cubic([1.0, 2.0, 4.0], 0.25));
        assert_eq!((found.count, found.starts_negative), (3, true));
        for (at, root) in found.at.into_iter().zip([1.0, 2.0, 4.0]) {
            assert!((at - root).abs() <= 4.0 * f64::EPSILON * root, "{at} is not {root}");
        }
    }

    #[test]
    fn roots_in_the_past_do_not_count() {
        let found = sign_changes_of_cubic(&cubic([-3.0, -1.0, 2.0], 1.0));
        assert_eq!((found.count, found.starts_negative), (1, true));
        let found = sign_changes_of_cubic(&cubic([-3.0, 1.0, 2.0], 1.0));
        assert_eq!((found.count, found.starts_negative), (2, false));
        assert_eq!(sign_changes_of_cubic(&cubic([-3.0, -2.0, -1.0], 1.0)).count, 0);
    }

    #[test]
    fn double_roots_change_no_sign() {
        let found = sign_changes_of_cubic(&cubic([1.0, 1.0, 3.0], 1.0));
        assert_eq!(found.count, 1);
        assert!((found.at[0] - 3.0).abs() < 1e-14);
    }

    #[test]
    fn sign_at_a_zero_follows_the_next_derivative() {
        assert!(sign_changes_of_cubic(&[0.0, -1.0, 0.0, 1.0]).starts_negative);
        assert!(!sign_changes_of_cubic(&[0.0, 1.0, 0.0, 1.0]).starts_negative);
        assert!(!sign_changes_of_cubic(&[0.0, 0.0, 0.0, 1.0]).starts_negative);
        assert_eq!(sign_changes_of_cubic(&[-1.0, 0.0, 0.0, 1.0]).at[0], 1.0, "all middle coefficients vanish");
        assert_eq!(sign_changes_of_cubic(&[1.0, 0.0, 0.0, 1.0]).count, 0);
    }

    #[test]
    fn near_roots_stay_accurate_as_the_leading_coefficient_vanishes() {
        for leading in [1e-3, 1e-8, 1e-16, 1e-40, 1e-300] {
            // The root of `-2 + 3 t + leading t^3` near 2/3 is about `2/3 (1 - 4/27 leading)`.
            let found = sign_changes_of_cubic(&[-2.0, 3.0, 0.0, leading]);
            let exact = 2.0 / 3.0 - leading * 8.0 / 81.0;
            assert!((found.at[0] - exact).abs() < 1e-15 + leading * leading, "{leading}: {found:?}");
        }
    }

    #[test]
    fn a_bracketed_root_ends_on_its_valid_side() {
        let f = |t: f64| 2.0 - t * t;
        let root = bracketed(f, 0.0, 2.0);
        assert!(f(root) >= 0.0 && f(root.next_up().next_up()) < 0.0);
        let steep = |t: f64| 1e-300 - t;
        assert_eq!(bracketed(steep, 0.0, 1.0), 1e-300);
    }

    #[test]
    fn a_bracket_closes_in_a_few_evaluations() {
        let evaluations = std::cell::Cell::new(0);
        let f = |t: f64| {
            evaluations.set(evaluations.get() + 1);
            3.0 - t * t * t - 0.1 * t.powi(4)
        };
        let root = bracketed(f, 0.0, 100.0);
        assert!((3.0 - root.powi(3) - 0.1 * root.powi(4)).abs() < 1e-14);
        assert!(evaluations.get() < 30, "{}", evaluations.get());
    }
}
