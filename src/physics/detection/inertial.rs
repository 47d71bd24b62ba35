//! Algorithms 2 and 3: pairs without relative acceleration.

use super::stretch::Stretch;
use crate::physics::overlap::{Quadratic, Side};

/// Time to the next event of a pair without relative acceleration, on one side of the discontinuity.
#[inline]
#[must_use]
pub fn next_event(f: &Quadratic, side: Side) -> Option<f64> {
    match side {
        Side::Positive => positive(f),
        Side::Negative => negative(f),
    }
}

/// Algorithm 2: the next event on the positive side (Core, Capture) of a pair with `a_ij = 0`.
#[inline]
#[must_use]
pub fn positive(f: &Quadratic) -> Option<f64> {
    if f.b >= 0.0 {
        return None;
    }
    if f.r2 <= 0.0 {
        return Some(0.0);
    }
    let discriminant = f.b * f.b - f.v2 * f.r2;
    if discriminant <= 0.0 {
        return None;
    }
    Some(f.r2 / (discriminant.sqrt() - f.b))
}

/// The interval in which `f+` falls and is not positive, from the event of Algorithm 2 to the shortest distance.
#[must_use]
pub fn falling_stretch(f: &Quadratic) -> Option<Stretch> {
    let from = positive(f)?;
    // In a grazing contact, rounding may give both ends the same time.
    Some(Stretch { from, until: (-f.b / f.v2).max(from.next_up()) })
}

/// Algorithm 3: the next event on the negative side (Bounce, Release) of a pair with `a_ij = 0`.
///
/// If a pair is outside and its path never leads back inside, the event is at the shortest distance.
#[inline]
#[must_use]
pub fn negative(f: &Quadratic) -> Option<f64> {
    if f.v2 == 0.0 {
        return None;
    }
    let discriminant = f.b * f.b - f.v2 * f.r2;
    let dt = if discriminant > 0.0 {
        // The later root, without cancellation. If both roots are in the past, the result is 0.
        let root = discriminant.sqrt();
        if f.b < 0.0 { -(f.b - root) / f.v2 } else { -f.r2 / (f.b + root) }
    } else if f.r2 < 0.0 {
        // The pair is inside and so slow that both products underflow.
        return None;
    } else {
        -f.b / f.v2
    };
    Some(dt.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn f(r2: f64, b: f64, v2: f64) -> Quadratic {
        Quadratic { r2, b, v2 }
    }

    #[test]
    fn figure_3a_a_pair_on_collision_course_meets_at_the_first_root() {
        // From r = 3 with velocity -1, the pair reaches s = 1 at t = 2.
        assert_eq!(positive(&f(8.0, -3.0, 1.0)), Some(2.0));
    }

    #[test]
    fn figure_3a_a_receding_or_resting_pair_never_meets() {
        assert_eq!(positive(&f(8.0, 3.0, 1.0)), None);
        assert_eq!(positive(&f(8.0, 0.0, 1.0)), None);
        assert_eq!(positive(&f(-0.5, 0.0, 0.0)), None);
        assert_eq!(positive(&f(-0.5, 1.0, 1.0)), None, "an overlap that decreases causes no event");
    }

    #[test]
    fn growing_overlap_is_an_immediate_event() {
        assert_eq!(positive(&f(-0.5, -1.0, 1.0)), Some(0.0));
        assert_eq!(positive(&f(0.0, -1.0, 1.0)), Some(0.0));
        let soon = positive(&f(f64::EPSILON, -1.0, 1.0)).unwrap();
        assert!(soon > 0.0 && soon < f64::EPSILON);
    }

    #[test]
    fn figure_3b_a_pair_that_misses_or_grazes_has_no_event() {
        assert_eq!(positive(&f(8.0, -1.0, 1.0)), None);
        assert_eq!(positive(&f(1.0, -1.0, 1.0)), None, "the two roots coincide: f never changes sign");
    }

    #[test]
    fn figure_3c_a_captured_pair_leaves_at_the_last_root() {
        // From r = -1/2 with velocity 1, the pair reaches s = 1 at t = 1.5.
        assert_eq!(negative(&f(-0.75, -0.5, 1.0)), Some(1.5));
        assert_eq!(negative(&f(-0.75, 0.5, 1.0)), Some(0.5));
        assert_eq!(negative(&f(-1.0, 0.0, 1.0)), Some(1.0));
        assert_eq!(negative(&f(-1.0, -0.0, 1.0)), Some(1.0), "the sign of a zero does not matter");
    }

    #[test]
    fn figure_3c_a_pair_outside_that_recedes_interacts_now() {
        assert_eq!(negative(&f(0.0, 1.0, 1.0)), Some(0.0));
        assert_eq!(negative(&f(0.25, 1.0, 1.0)), Some(0.0));
        assert_eq!(
            negative(&f(0.1, -1.0, 1.0)).map(|t| t > 1.0),
            Some(true),
            "a pair that moves inwards has no event until it leaves again"
        );
    }

    #[test]
    fn figure_3d_a_pair_that_stays_outside_interacts_at_its_turning_point() {
        assert_eq!(negative(&f(3.0, -1.0, 1.0)), Some(1.0));
        assert_eq!(negative(&f(3.0, 1.0, 1.0)), Some(0.0));
        assert_eq!(negative(&f(1.0, -1.0, 1.0)), Some(1.0), "grazing from outside");
    }

    #[test]
    fn captured_pair_with_underflowing_squared_speed_never_leaves() {
        let (r2, radial, speed) = (-1.7e-9, 2.6e-6, 3.4e-161_f64);
        for radial in [radial, 0.0, -radial] {
            assert_eq!(negative(&f(r2, radial * speed, speed * speed)), None);
        }
        let speed = 1e-140_f64;
        let dt = negative(&f(r2, radial * speed, speed * speed)).unwrap();
        assert!((dt * speed / 3.87e-5 - 1.0).abs() < 0.01, "{dt}");
    }

    #[test]
    fn a_captured_pair_at_relative_rest_has_no_event() {
        assert_eq!(negative(&f(-1.0, 0.0, 0.0)), None);
    }
}
