//! Algorithms 4, 5 and 6: pairs with a constant relative acceleration, such as a falling and a static particle.
//!
//! The overlap function is a quartic. It is monotone between its turning points, so each falling piece contains at most
//! one event. The falling pieces are the paper's two regions of interaction: `(-inf, t1]` and `[t2, t3]` for `f+`,
//! `[t1, t2]` and `[t3, inf)` for `f-`. The derivative shows whether `f` falls just after now, so a contact that has
//! just ended is not found again.

use super::roots::{bracketed, grow, sign_changes_of_cubic};
use super::stretch::Stretch;
use crate::physics::overlap::{Quartic, Side};

/// Time to the next event of a pair with relative acceleration, for the overlap function `f` on one side.
#[must_use]
pub fn next_event(f: &Quartic, side: Side) -> Option<f64> {
    let value = |dt: f64| side.sign() * f.value(dt);
    let turns = sign_changes_of_cubic(&f.derivative());
    let mut falls = turns.starts_negative == (side == Side::Positive);
    let mut from = 0.0;
    for &to in &turns.at[..turns.count] {
        if falls && let Some(begin) = begin_of_invalid(value, from, to) {
            return Some(begin);
        }
        falls = !falls;
        from = to;
    }
    if !falls {
        return None;
    }
    if value(from) <= 0.0 {
        return Some(from);
    }
    find_last_root(f, from)
}

/// Returns the first time in `[from, to]` at which a falling function is not positive.
#[inline(always)]
fn begin_of_invalid(value: impl Fn(f64) -> f64, from: f64, to: f64) -> Option<f64> {
    if value(from) <= 0.0 {
        return Some(from);
    }
    (value(to) < 0.0).then(|| bracketed(value, from, to))
}

/// The intervals in which `f+` is falling and not positive: the paper's two regions of interaction.
#[must_use]
pub fn falling_stretches(f: &Quartic) -> [Option<Stretch>; 2] {
    let turns = sign_changes_of_cubic(&f.derivative());
    let mut found = [None; 2];
    let mut free = found.iter_mut();
    let (mut falls, mut from) = (turns.starts_negative, 0.0);
    for &until in &turns.at[..turns.count] {
        if falls
            && let Some(from) = begin_of_invalid(|dt| f.value(dt), from, until)
            && let Some(free) = free.next()
        {
            *free = Some(Stretch { from, until });
        }
        falls = !falls;
        from = until;
    }
    found
}

/// Algorithm 6: the only root of `f-` after `from`, where `f-` is positive and falling. The first step is the time in
/// which a pair at rest at the centre falls to the discontinuity. The step doubles until the sign changes.
fn find_last_root(f: &Quartic, from: f64) -> Option<f64> {
    let step = (f.distance_squared / f.coefficients[4]).sqrt().sqrt();
    let step = if step.is_normal() { step } else { 1.0 };
    // A step below the round-off of `from` would have no effect.
    let step = step.max(from * f64::EPSILON);
    let beyond = grow(from, step, |t| f.value(t) > 0.0)?;
    Some(bracketed(|t| -f.value(t), from, beyond))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::physics::motion::RelativeState;

    /// One-dimensional motion `x + v t + a t^2 / 2` across a discontinuity at distance 1.
    fn line(x: f64, v: f64, a: f64) -> Quartic {
        plane(Vector::new(x, 0.0, 0.0), Vector::new(v, 0.0, 0.0), Vector::new(a, 0.0, 0.0))
    }

    fn plane(position: Vector, velocity: Vector, acceleration: Vector) -> Quartic {
        Quartic::new(&RelativeState { position, velocity }, &acceleration, 1.0)
    }

    fn close(found: Option<f64>, expected: f64) {
        let found = found.expect("there is an event");
        assert!((found - expected).abs() <= 8.0 * f64::EPSILON * expected.max(1.0), "{found} is not {expected}");
    }

    #[test]
    fn figure_4a_a_ball_dropped_on_a_sphere_meets_it() {
        close(next_event(&line(3.0, 0.0, -1.0), Side::Positive), 2.0);
        close(next_event(&line(3.0, -1.0, -1.0), Side::Positive), 5.0_f64.sqrt() - 1.0);
    }

    #[test]
    fn figure_4b_an_overlap_that_deepens_is_an_event_now() {
        assert_eq!(next_event(&line(0.9, -1.0, -1.0), Side::Positive), Some(0.0));
        assert_eq!(next_event(&line(1.0, -1.0, -1.0), Side::Positive), Some(0.0));
        assert_eq!(next_event(&line(1.0, 0.0, -1.0), Side::Positive), Some(0.0), "f' becomes negative at once");
    }

    #[test]
    fn figure_4c_a_ball_thrown_up_from_contact_comes_back() {
        close(next_event(&line(1.0, 1.0, -1.0), Side::Positive), 2.0);
        close(next_event(&line(1.0_f64.next_down(), 1.0, -1.0), Side::Positive), 2.0);
        close(next_event(&line(1.0_f64.next_up(), 1.0, -1.0), Side::Positive), 2.0);
        close(next_event(&line(1.0, 1e-9, -1.0), Side::Positive), 2e-9);
    }

    #[test]
    fn figure_4d_a_throw_that_stays_overlapped_interacts_at_its_turning_point() {
        close(next_event(&line(0.5, 0.5, -1.0), Side::Positive), 0.5);
    }

    #[test]
    fn figure_4e_after_a_miss_the_second_region_counts() {
        let f = plane(Vector::new(-3.0, 1.2, 0.0), Vector::new(1.5, 1.0, 0.0), Vector::new(0.0, -1.0, 0.0));
        let dt = next_event(&f, Side::Positive).unwrap();
        assert!(dt > 1.0 && f.value(dt) >= 0.0 && f.value(dt + 1e-9) < 0.0);
    }

    #[test]
    fn a_ball_that_falls_past_or_away_never_meets() {
        assert_eq!(next_event(&line(3.0, 1.0, 1.0), Side::Positive), None);
        let past = plane(Vector::new(2.0, 3.0, 0.0), Vector::zeros(), Vector::new(0.0, -1.0, 0.0));
        assert_eq!(next_event(&past, Side::Positive), None);
    }

    #[test]
    fn figure_5a_a_bonded_bead_that_falls_reaches_the_end_of_its_bond() {
        close(next_event(&line(0.0, 0.0, -0.5), Side::Negative), 2.0);
        // The initial state of a pendulum: the bead is at rest, and its position is perpendicular to the acceleration.
        let start = plane(Vector::new(0.5, 0.0, 0.0), Vector::zeros(), Vector::new(0.0, 0.0, -1.0));
        close(next_event(&start, Side::Negative), 3.0_f64.sqrt().sqrt());
    }

    #[test]
    fn figure_5b_a_bond_at_its_end_that_lengthens_interacts_now() {
        assert_eq!(next_event(&line(-1.0, -1.0, -1.0), Side::Negative), Some(0.0));
        assert_eq!(next_event(&line(-1.0, 0.0, -1.0), Side::Negative), Some(0.0));
        assert_eq!(next_event(&line(-1.1, -1.0, -1.0), Side::Negative), Some(0.0));
    }

    #[test]
    fn figure_5c_a_bead_thrown_through_the_bond_leaves_on_the_far_side() {
        // The bead starts at -1 with velocity 3 and acceleration -1. It reaches +1 at t = 3 - sqrt(5).
        close(next_event(&line(-1.0, 3.0, -1.0), Side::Negative), 3.0 - 5.0_f64.sqrt());
    }

    #[test]
    fn figure_5f_overlong_bond_that_never_recovers_acts_at_turning_point() {
        close(next_event(&line(-2.0, 1.0, -1.0), Side::Negative), 1.0);
    }

    #[test]
    fn figure_5g_overlong_bond_that_recovers_acts_when_it_leaves_again() {
        close(next_event(&line(-1.5, 2.0, -1.0), Side::Negative), 2.0 + 3.0_f64.sqrt());
    }

    #[test]
    fn algorithm_6_brackets_the_last_root_after_the_turning_point() {
        // The bead follows `r = 20 t - 4.905 t^2`. At t = 4.0775 it is back at r = 0, and only the root r = -1 is left.
        let f = line(0.0, 20.0, -9.81);
        let first = next_event(&f, Side::Negative).unwrap();
        assert!((first - 0.050_628_7).abs() < 1e-6);
        let last = find_last_root(&f, 4.0775).unwrap();
        assert!((last - 4.126_87).abs() < 1e-5);
    }

    #[test]
    fn the_limit_of_vanishing_acceleration_is_the_inertial_result() {
        for a in [1e-8, 1e-16, 1e-100] {
            close(next_event(&line(3.0, -1.0, -a), Side::Positive), 2.0 - 2.0 * a.min(1e-8));
            close(next_event(&line(0.5, 1.0, -a), Side::Negative), 0.5 + a / 8.0);
        }
    }
}
