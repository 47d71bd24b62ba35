//! Tangential impulse of a rough contact, with its uncertainty. The verifier proves the engine, so it shares no formula
//! with `physics::rough`.

use super::bounds::{Bounds, rounded};
use crate::Vector;
use crate::model::Roughness;

/// A rough contact before its event. The first body is a particle. The second body is a particle or a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rub {
    pub roughness: Roughness,
    /// Unit vector from the second body to the first.
    pub normal: Vector,
    /// Velocity of the centres relative to each other, or to the surface `[length / time]`.
    pub velocity: Vector,
    /// Spins of the bodies, relative to the spin of the surface if there is one `[1 / time]`.
    pub spins: [Vector; 2],
    /// Distances of the point of contact from the centres of the bodies `[length]`.
    pub arms: [f64; 2],
    pub inverse_inertias: [f64; 2],
    pub inverse_mass: f64,
    /// Uncertainty of the velocity of the material of a surface `[length / time]`.
    pub material_bound: f64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Rubbed {
    pub impulse: Vector,
    /// Uncertainty of the impulse `[mass length / time]`.
    pub bound: f64,
    pub dissipated: f64,
    /// Uncertainty of the dissipated energy `[energy]`.
    pub dissipated_bound: f64,
    /// Speed at which the surfaces slip, and its uncertainty `[length / time]`.
    pub slip: (f64, f64),
}

impl Rubbed {
    pub const NONE: Self = Self {
        impulse: Vector::new(0.0, 0.0, 0.0),
        bound: 0.0,
        dissipated: 0.0,
        dissipated_bound: 0.0,
        slip: (0.0, 0.0),
    };
}

impl Rub {
    /// Upper bound of the relative speed that the spins cause at the point of contact `[length / time]`.
    pub fn turning_speed(&self) -> f64 {
        self.spins[0].norm() * self.arms[0] + self.spins[1].norm() * self.arms[1]
    }

    /// Tangential velocity of the first surface relative to the second `[length / time]`.
    fn slip(&self) -> Vector {
        let of_surface = |k: usize| self.spins[k].cross(&self.normal) * self.arms[k];
        let velocity = self.velocity - of_surface(0) - of_surface(1);
        velocity - self.normal * self.normal.dot(&velocity)
    }

    /// Returns the tangential impulse. `pushed` is the normal impulse and its uncertainty. The smaller of the impulses
    /// for sticking and sliding applies, so no case has to be decided at the limit of friction. If the TC model
    /// `reverses_slip`, the tangential restitution is 1, except in a smooth law.
    pub fn rubbed(&self, pushed: (f64, f64), reverses_slip: bool, bounds: &Bounds) -> Rubbed {
        let turn = |k: usize| self.arms[k] * self.arms[k] * self.inverse_inertias[k];
        let mass = 1.0 / (self.inverse_mass + turn(0) + turn(1));
        let (slip, turning) = (self.slip(), self.turning_speed());
        let slip_bound = bounds.normal_velocity + rounded(turning) + turning * bounds.direction + self.material_bound;
        let Roughness { tangential_restitution, friction } = self.roughness;
        let is_reversed = reverses_slip && tangential_restitution > -1.0;
        let stick = if is_reversed { 2.0 * mass } else { (1.0 + tangential_restitution) * mass };
        let sticking = stick * slip.norm();
        let limit = if pushed.0 > 0.0 { friction * pushed.0 } else { 0.0 };
        let limit_bound = if friction < f64::INFINITY { friction * pushed.1 + rounded(limit) } else { 0.0 };
        let size = sticking.min(limit);
        let impulse = slip.try_normalize(0.0).map_or(Vector::zeros(), |direction| direction * -size);
        // Far from the limit of friction, the uncertainty of the limit has no effect.
        let of_limit = if limit - limit_bound > 2.0 * (sticking + stick * slip_bound) { 0.0 } else { limit_bound };
        // If the normal impulse may be zero, the contact may be smooth or rough.
        let of_touch = if pushed.0 <= pushed.1 { stick * (slip.norm() + slip_bound) } else { 0.0 };
        let bound = stick * slip_bound + rounded(size) + of_limit + of_touch;
        let dissipated = -impulse.dot(&slip) - impulse.norm_squared() / (2.0 * mass);
        let dissipated_bound = 2.0 * bound * (slip.norm() + (size + bound) / mass) + size * slip_bound;
        let dissipated_bound = dissipated_bound + rounded(size * slip.norm());
        Rubbed { impulse, bound, dissipated, dissipated_bound, slip: (slip.norm(), slip_bound) }
    }
}
