//! Proofs that two particles never meet, despite rounding.
//!
//! On a path of ten million diameters, rounding errors decide between a miss and a collision. The result `true` is a
//! proof for all states within a [`Doubt`] of the given state. The result `false` proves nothing.

use crate::Vector;
use crate::physics::motion::RelativeState;

/// Relative rounding error of a number after a few operations.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Rounding error of a polynomial after 50 bisections, relative to its coefficients.
const BISECTED: f64 = 64.0 * f64::EPSILON;

/// Maximum number of intervals that the bisection of a polynomial examines.
const MOST_PIECES: u32 = 200;

/// Largest deviations of a relative state from the exact state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// Largest error of the relative position `[length]`.
    pub position: f64,
    /// Largest error of the relative velocity `[length / time]`.
    pub velocity: f64,
}

impl Doubt {
    /// Returns the rounding errors of a relative state. The arguments are sums of absolute positions and velocities.
    #[must_use]
    pub fn of(lengths: f64, speeds: f64) -> Self {
        Self { position: ROUNDING * lengths, velocity: ROUNDING * speeds }
    }
}

/// Returns true if a pair without relative acceleration provably stays farther apart than `distance`, or recedes
/// forever. The velocity is taken as exact.
///
/// The shortest distance on a straight path is `|r x v| / |v|`. This form avoids the cancellation in the discriminant.
#[must_use]
pub fn inertial(state: &RelativeState, doubt: &Doubt, distance: f64) -> bool {
    let RelativeState { position, velocity } = state;
    let doubt = doubt.position + ROUNDING * position.norm();
    let (speed, kept) = (velocity.norm(), distance * (1.0 + ROUNDING) + doubt);
    if *velocity == Vector::zeros() {
        return position.norm() > kept;
    }
    velocity.dot(position) > speed * doubt || position.cross(velocity).norm() > speed * kept
}

/// Like [`inertial`], for a pair with a relative acceleration.
#[must_use]
pub fn accelerated(state: &RelativeState, acceleration: &Vector, doubt: &Doubt, distance: f64) -> bool {
    let RelativeState { position: r, velocity: v } = state;
    let (length, speed, push) = (r.norm(), v.norm(), acceleration.norm());
    let squared = distance * distance;
    let (dr, dv) = (doubt.position + ROUNDING * length, doubt.velocity + ROUNDING * speed);
    // Coefficients of a lower bound of the overlap function.
    let lowest = [
        r.norm_squared() - squared - 2.0 * dr * (length + dr) - ROUNDING * squared,
        2.0 * (v.dot(r) - speed * dr - length * dv - dr * dv),
        acceleration.dot(r) + v.norm_squared() - push * dr - 2.0 * dv * (speed + dv) - ROUNDING * push * length,
        acceleration.dot(v) - push * dv - ROUNDING * push * speed,
        0.25 * push * push * (1.0 - ROUNDING),
    ];
    let recedes = lowest[1..].iter().all(|&c| c >= 0.0) && lowest[4] > 0.0;
    recedes || is_always_positive(&lowest, speed / push + (length / push).sqrt())
}

/// Returns true if a particle provably never reaches a plane. The signed distance from the plane is `height`.
#[must_use]
pub fn plane(height: f64, velocity: f64, acceleration: f64, doubt: &Doubt) -> bool {
    if acceleration == 0.0 {
        // Without acceleration, the velocity is constant between events and has no rounding error.
        return velocity >= 0.0;
    }
    let (lowest, fastest) = (height - doubt.position, doubt.velocity - velocity);
    let turns_above = lowest > 0.0 && 2.0 * acceleration * lowest > fastest * fastest * (1.0 + ROUNDING);
    acceleration > 0.0 && (fastest <= 0.0 || turns_above)
}

/// Returns true if a quartic is provably positive for all times `t >= 0`. The constant coefficient comes first. `scale`
/// is a typical time over which the quartic changes.
///
/// Times below and above `scale` are examined separately. For late times, the coefficients are reversed, so that the
/// argument is `scale / t`. On each interval, the quartic lies within the convex hull of its Bernstein coefficients.
/// The hulls become tighter when an interval is halved.
fn is_always_positive(coefficients: &[f64; 5], scale: f64) -> bool {
    let mut power = 1.0;
    let near = coefficients.map(|c| {
        let scaled = c * power;
        power *= scale;
        scaled
    });
    let least = BISECTED * near.iter().map(|c| c.abs()).sum::<f64>();
    let [c0, c1, c2, c3, c4] = near;
    least.is_finite() && [near, [c4, c3, c2, c1, c0]].iter().all(|c| is_positive_up_to_one(c, least))
}

fn is_positive_up_to_one(c: &[f64; 5], least: f64) -> bool {
    let [c0, c1, c2, c3, c4] = *c;
    let whole =
        [c0, c0 + c1 / 4.0, c0 + c1 / 2.0 + c2 / 6.0, c0 + 0.75 * c1 + c2 / 2.0 + c3 / 4.0, c0 + c1 + c2 + c3 + c4];
    let mut pieces = vec![whole];
    for _ in 0..MOST_PIECES {
        let Some(mut piece) = pieces.pop() else { return true };
        if piece.iter().all(|&b| b > least) {
            continue;
        }
        if piece[0] <= least || piece[4] <= least {
            return false;
        }
        // De Casteljau's algorithm halves the interval: `first` becomes the left half, and `piece` the right half.
        let mut first = [piece[0]; 5];
        for (round, end) in first.iter_mut().enumerate().skip(1) {
            for k in 0..5 - round {
                piece[k] = 0.5 * (piece[k] + piece[k + 1]);
            }
            *end = piece[0];
        }
        pieces.extend([first, piece]);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Doubt = Doubt { position: 0.0, velocity: 0.0 };

    fn state(position: [f64; 3], velocity: [f64; 3]) -> RelativeState {
        RelativeState { position: position.into(), velocity: velocity.into() }
    }

    #[test]
    fn straight_miss_is_proven_unless_rounding_could_undo_it() {
        for (position, velocity, expected) in [
            ([3.0, 0.0, 0.0], [1.0, 0.0, 0.0], true),
            ([1.0, 0.0, 0.0], [1e-9, 1.0, 0.0], true),
            ([3.0, 0.0, 0.0], [-1.0, 0.0, 0.0], false),
            ([3.0, 1.1, 0.0], [-1.0, 0.0, 0.0], true),
            ([3.0, 0.9, 0.0], [-1.0, 0.0, 0.0], false),
            ([1e7, 1.0 + 1e-7, 0.0], [-1.0, 0.0, 0.0], true),
            ([1e7, 1.0 + 1e-8, 0.0], [-1.0, 0.0, 0.0], false),
            ([1e7, 1.0 + 1e-7, 0.0], [-1e-170, 0.0, 0.0], false),
            ([1.1, 0.0, 0.0], [0.0, 0.0, 0.0], true),
            ([0.9, 0.0, 0.0], [0.0, 0.0, 0.0], false),
        ] {
            assert_eq!(inertial(&state(position, velocity), &EXACT, 1.0), expected, "{position:?} {velocity:?}");
        }
        let close = state([3.0, 1.1, 0.0], [-1.0, 0.0, 0.0]);
        assert!(inertial(&close, &Doubt { position: 0.09, velocity: 0.0 }, 1.0));
        assert!(
            !inertial(&close, &Doubt { position: 0.11, velocity: 0.0 }, 1.0),
            "if the error of the position is larger, a contact is possible"
        );
    }

    #[test]
    fn fall_past_a_sphere_is_proven_to_miss() {
        let down = Vector::new(0.0, 0.0, -1.0);
        for (position, velocity, expected) in [
            ([2.0, 0.0, 3.0], [0.0, 0.0, 0.0], true),
            ([0.9, 0.0, 3.0], [0.0, 0.0, 0.0], false),
            ([0.0, 0.0, -2.0], [0.0, 0.0, 0.0], true),
            ([0.0, 0.0, -1.0], [0.0, 0.0, -0.1], true),
            ([0.0, 0.0, -2.0], [0.0, 0.0, 1.0], true),
            ([0.0, 0.0, -2.0], [0.0, 0.0, 1.5], false),
            // The particle flies over the sphere, 1.5 above its centre at x = 0, and falls on the far side.
            ([-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], true),
            ([-1.0, 0.0, 1.0], [0.5, 0.0, 0.5], false),
        ] {
            assert_eq!(
                accelerated(&state(position, velocity), &down, &EXACT, 1.0),
                expected,
                "{position:?} {velocity:?}"
            );
        }
        // The particle rises for a time of 10^9. The rounding error of its squared height exceeds the squared radius.
        let slow = Vector::new(0.0, 0.0, -1e-9);
        assert!(!accelerated(&state([0.0, 0.0, 6.0], [0.0, 0.0, 1.0]), &slow, &EXACT, 1.0));
        assert!(!accelerated(&state([1e-3, 0.0, 6.0], [0.0, 0.0, 1.0]), &slow, &EXACT, 1.0));
    }

    #[test]
    fn plane_is_missed_by_receding_or_turning_particles() {
        for (height, velocity, acceleration, expected) in [
            (0.0, 0.0, 0.0, true),
            (-1e-20, 1.0, 0.0, true),
            (3.0, -1e-9, 0.0, false),
            (3.0, 1.0, -1e-9, false),
            (0.0, 1.0, 1.0, true),
            (3.0, -2.0, 1.0, true),
            (2.0, -2.0, 1.0, false),
        ] {
            assert_eq!(plane(height, velocity, acceleration, &EXACT), expected, "{height} {velocity} {acceleration}");
        }
        assert!(!plane(2.1, -2.0, 1.0, &Doubt { position: 0.2, velocity: 0.0 }));
        assert!(!plane(2.1, -2.0, 1.0, &Doubt { position: 0.0, velocity: 0.1 }));
    }
}
