//! Chooses periodic images in SIMD lanes, like [`Engine::nearest`](super::Engine) for single pairs.

use super::{FLOW, GRADIENT};
use crate::Vector;
use crate::physics::detection::lanes::Lanes;

/// The motion of the periodic images across the sliding sides of a sheared box.
#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Sliding {
    /// Displacement of the image above the box along the flow, reduced by whole periods `[length]`.
    pub displacement: f64,
    /// Speed of the image above the box along the flow `[length / time]`.
    pub speed: f64,
}

/// Reduces separations to the nearest images, in a box without shear.
#[inline(always)]
pub(in crate::engine) fn nearest<F: Lanes>(r: &mut [F; 3], periods: &Vector) {
    for (apart, period) in r.iter_mut().zip(periods) {
        *apart = minimum_image(*apart, *period);
    }
}

/// Reduces separations to the nearest images, and corrects the relative velocities, in a sheared box.
#[inline(always)]
pub(in crate::engine) fn nearest_sheared<F: Lanes>(
    r: &mut [F; 3],
    v: &mut [F; 3],
    periods: &Vector,
    sliding: &Sliding,
) {
    let half = 0.5 * periods[GRADIENT];
    let zero = F::all(0.0);
    let above = F::all(half).if_less(r[GRADIENT], F::all(1.0), zero);
    let up = r[GRADIENT].if_less(F::all(-half), F::all(-1.0), above);
    r[GRADIENT] = r[GRADIENT].sub(up.mul(F::all(2.0 * half)));
    r[FLOW] = r[FLOW].sub(up.mul(F::all(sliding.displacement)));
    v[FLOW] = v[FLOW].sub(up.mul(F::all(sliding.speed)));
    r[FLOW] = minimum_image(minimum_image(r[FLOW], periods[FLOW]), periods[FLOW]);
    r[2] = minimum_image(r[2], periods[2]);
}

/// Returns the squared distance to the second nearest image, minus the squared distance to the nearest image.
///
/// The second nearest image is shifted by one period `L` along one axis. For a separation `x` along this axis, the
/// squared distances differ by `(L - |x|)^2 - x^2 = L^2 - 2 L |x|`. The result is the minimum over the axes.
#[inline(always)]
pub(in crate::engine) fn squared_distance_to_others<F: Lanes>(r: &[F; 3], periods: &Vector) -> F {
    let mut further = F::all(f64::INFINITY);
    for (&apart, &period) in r.iter().zip(periods).filter(|(_, period)| period.is_finite()) {
        further = F::all(period * period).sub(size(apart).mul(F::all(2.0 * period))).least(further);
    }
    further
}

/// Returns a bit mask of the lanes whose separation along any axis is at least `least`.
#[inline(always)]
pub(in crate::engine) fn are_apart<F: Lanes>(r: &[F; 3], least: [f64; 3]) -> u32 {
    r.iter().zip(least).fold(0, |bits, (&apart, least)| bits | F::all(least).sub(size(apart)).at_most(0.0))
}

#[inline(always)]
fn minimum_image<F: Lanes>(apart: F, period: f64) -> F {
    let half = F::all(0.5 * period);
    let below = apart.if_less(F::all(-0.5 * period), F::all(-period), F::all(0.0));
    apart.sub(half.if_less(apart, F::all(period), below))
}

#[inline(always)]
fn size<F: Lanes>(x: F) -> F {
    F::all(0.0).if_less(x, x, F::all(0.0).sub(x))
}
