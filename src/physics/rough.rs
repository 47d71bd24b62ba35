//! Rough contacts: tangential impulses with restitution and Coulomb friction, which change spins.
//!
//! Two surfaces touch at one point. Their relative velocity there has the tangential part `gt`. The tangential impulse
//! is
//!
//! ```text
//! Jt = -min((1 + b) m_t |gt|, mu Jn) gt / |gt|
//! 1 / m_t = 1 / m_i + 1 / m_j + R_i^2 / I_i + R_j^2 / I_j
//! ```
//!
//! with the normal impulse `Jn`, the tangential restitution `b`, the friction coefficient `mu`, and the mass `m`, the
//! moment of inertia `I` and the lever arm `R` of each particle. The contact sticks if the first term is smaller, and
//! slides if the second one is. Sources: O. R. Walton and R. L. Braun, J. Rheol. 30, 949 (1986); S. F. Foerster et
//! al., Phys. Fluids 6, 1108 (1994); S. Luding et al., Phys. Rev. E 58, 3416 (1998).

use crate::Vector;
use serde::{Deserialize, Serialize};

/// Tangential part of a contact law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Roughness {
    /// Tangential restitution `b` in `[-1, 1]`. A contact that sticks multiplies the tangential velocity of the
    /// surfaces at the point of contact by `-b`. The velocity is reversed if `b = 1`, zero if `b = 0`, and unchanged if
    /// `b = -1`.
    pub tangential_restitution: f64,
    /// Coulomb friction coefficient `mu`. The tangential impulse is at most `mu` times the normal impulse. Infinity
    /// removes this limit.
    pub friction: f64,
}

impl Roughness {
    /// Whether contacts dissipate kinetic energy, by sliding or by a tangential restitution between -1 and 1.
    #[must_use]
    pub fn dissipates(&self) -> bool {
        let acts = self.tangential_restitution > -1.0 && self.friction > 0.0;
        acts && (self.tangential_restitution < 1.0 || self.friction < f64::INFINITY)
    }

    /// Returns the law of an elastic contact: a contact that sticks reverses the tangential velocity. The friction
    /// coefficient does not change, and smooth surfaces remain smooth.
    #[must_use]
    pub fn elastic(self) -> Self {
        let is_smooth = self.tangential_restitution == -1.0;
        Self { tangential_restitution: if is_smooth { -1.0 } else { 1.0 }, ..self }
    }

    /// Returns the tangential impulse on the first particle `[mass length / time]`.
    ///
    /// `slip` is the tangential velocity `gt` of the first surface relative to the second, and `mass` is `m_t`. Without
    /// a normal impulse, there is no tangential impulse.
    #[must_use]
    pub fn impulse(&self, slip: &Vector, mass: f64, normal_impulse: f64) -> Vector {
        if normal_impulse <= 0.0 {
            return Vector::zeros();
        }
        let sticking = (1.0 + self.tangential_restitution) * mass;
        let (speed, limit) = (slip.norm(), self.friction * normal_impulse);
        if sticking * speed <= limit { slip * -sticking } else { slip * (-limit / speed) }
    }
}

/// Two bodies at their point of contact. Walls, surfaces and static particles have inverse masses of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Unit vector from the second body to the first.
    pub normal: Vector,
    /// Velocity of the first body relative to the second, without the contribution of their spins `[length / time]`.
    pub velocity: Vector,
    /// Spins of the bodies `[1 / time]`.
    pub spins: [Vector; 2],
    /// Distances of the point of contact from the centres of the bodies `[length]`.
    pub arms: [f64; 2],
    /// Inverse moments of inertia `[1 / (mass length^2)]`.
    pub inverse_inertias: [f64; 2],
    /// `1 / m_i + 1 / m_j` `[1 / mass]`.
    pub inverse_mass: f64,
}

/// Effects of the tangential impulse of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grip {
    /// Tangential impulse on the first body `[mass length / time]`. The second body gets the opposite impulse.
    pub impulse: Vector,
    /// Angular momenta that the bodies gain about their centres `[mass length^2 / time]`.
    pub torques: [Vector; 2],
    /// Kinetic energy that is lost `[energy]`.
    pub dissipated: f64,
}

impl Touch {
    /// Returns the tangential velocity of the two surfaces at the point of contact, `gt` `[length / time]`.
    #[must_use]
    pub fn slip(&self) -> Vector {
        let turning = self.spins[0] * self.arms[0] + self.spins[1] * self.arms[1];
        let velocity = self.velocity - turning.cross(&self.normal);
        velocity - self.normal * velocity.dot(&self.normal)
    }

    /// Returns the effects of the tangential impulse in a contact with the given normal impulse.
    #[must_use]
    pub fn grip(&self, roughness: &Roughness, normal_impulse: f64) -> Grip {
        let [i, j] = [0, 1].map(|k| self.arms[k] * self.arms[k] * self.inverse_inertias[k]);
        let mass = 1.0 / (self.inverse_mass + i + j);
        let slip = self.slip();
        let impulse = roughness.impulse(&slip, mass, normal_impulse);
        let twist = self.normal.cross(&impulse);
        let dissipated = -impulse.dot(&(slip + impulse / (2.0 * mass)));
        Grip { impulse, torques: self.arms.map(|arm| twist * -arm), dissipated }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const LIMITLESS: f64 = f64::INFINITY;

    fn rough(tangential_restitution: f64, friction: f64) -> Roughness {
        Roughness { tangential_restitution, friction }
    }

    fn ball(velocity: Vector, spin: Vector) -> Touch {
        let (mass, radius) = (1.3, 0.7);
        Touch {
            normal: Vector::z(),
            velocity,
            spins: [spin, Vector::zeros()],
            arms: [radius, 0.0],
            inverse_inertias: [1.0 / (0.4 * mass * radius * radius), 0.0],
            inverse_mass: 1.0 / mass,
        }
    }

    fn velocity_and_spin(ball: &Touch, grip: &Grip) -> (Vector, Vector) {
        (ball.velocity + grip.impulse * ball.inverse_mass, ball.spins[0] + grip.torques[0] * ball.inverse_inertias[0])
    }

    #[test]
    fn a_ball_sticks_to_the_floor_or_slides_as_in_the_textbook() {
        let (vt, vn, e, b, mu, radius) = (3.0, -0.8, 0.6, 0.25, 0.3, 0.7);
        let ball = ball(Vector::new(vt, 0.0, vn), Vector::zeros());
        let normal_impulse = 1.3 * (1.0 + e) * -vn;
        // The ball slides, because mu (1 + e) |vn| = 0.384 is below (1 + b) 2/7 |vt| = 1.07.
        let (v, w) = velocity_and_spin(&ball, &ball.grip(&rough(b, mu), normal_impulse));
        assert!((v.x - (vt + mu * (1.0 + e) * vn)).abs() < 1e-15, "{v}");
        // A positive spin about y rolls the ball along +x.
        assert!((w.y - 2.5 * mu * (1.0 + e) * -vn / radius).abs() < 1e-14, "{w}");
        let (v, w) = velocity_and_spin(&ball, &ball.grip(&rough(b, 2.0), normal_impulse));
        assert!((v.x - vt * (1.0 - 2.0 / 7.0 * (1.0 + b))).abs() < 1e-15, "{v}");
        assert!((w.y - 5.0 / 7.0 * (1.0 + b) * vt / radius).abs() < 1e-14, "{w}");
        // With a tangential restitution of 0, the ball leaves rolling.
        let (v, w) = velocity_and_spin(&ball, &ball.grip(&rough(0.0, LIMITLESS), normal_impulse));
        assert!((v.x - 5.0 / 7.0 * vt).abs() < 1e-15 && (v.x - radius * w.y).abs() < 1e-15, "{v} {w}");
    }

    #[test]
    fn friction_limits_one_float_above_the_sticking_impulse() {
        let slip = Vector::new(0.0, 2.0, 0.0);
        let sticking = rough(0.5, LIMITLESS).impulse(&slip, 0.25, 1.0);
        assert_eq!(sticking, Vector::new(0.0, -0.75, 0.0));
        assert_eq!(rough(0.5, 0.75).impulse(&slip, 0.25, 1.0), sticking);
        let lower = 0.75_f64.next_down();
        assert_eq!(rough(0.5, lower).impulse(&slip, 0.25, 1.0), Vector::new(0.0, -lower, 0.0));
        assert_eq!(rough(-1.0, 0.75).impulse(&slip, 0.25, 1.0).norm(), 0.0, "smooth");
        assert_eq!(rough(1.0, LIMITLESS).impulse(&Vector::zeros(), 0.25, 1.0), Vector::zeros(), "no slip");
        assert_eq!(rough(1.0, LIMITLESS).impulse(&slip, 0.25, 0.0), Vector::zeros(), "no normal impulse");
        assert_eq!(rough(1.0, 0.0).impulse(&slip, 0.25, 1.0).norm(), 0.0, "no friction");
    }

    #[test]
    fn energy_and_angular_momentum_balance() {
        let turn = |k: f64| Vector::new((PI * k).sin(), (2.0 * k).cos(), (3.0 * k + 0.4).sin());
        for k in 0..200 {
            let k = f64::from(k);
            let (mi, mj, arms) = (1.3 + 0.1 * k, 0.7, [0.55, 0.35]);
            let inverse_inertias = [1.0 / (0.4 * mi * 0.3), 1.0 / (0.5 * mj * 0.2)];
            let normal = turn(k).normalize();
            let touch = Touch {
                normal,
                velocity: turn(k + 0.3) * 2.0,
                spins: [turn(k + 1.0) * 3.0, turn(k + 2.0)],
                arms,
                inverse_inertias,
                inverse_mass: 1.0 / mi + 1.0 / mj,
            };
            let b = -1.0 + 0.01 * k;
            let roughness = rough(b, if k % 2.0 == 0.0 { LIMITLESS } else { 0.2 });
            let grip = touch.grip(&roughness, 1.5);
            // The centres are at rest relative to their centre of mass. The kinetic energy of the translation is
            // therefore `mu/2 v^2`.
            let energy = |velocity: &Vector, spins: &[Vector; 2]| {
                0.5 / touch.inverse_mass * velocity.norm_squared()
                    + 0.5 * spins[0].norm_squared() / inverse_inertias[0]
                    + 0.5 * spins[1].norm_squared() / inverse_inertias[1]
            };
            let velocity = touch.velocity + grip.impulse * touch.inverse_mass;
            let spins = [0, 1].map(|n| touch.spins[n] + grip.torques[n] * inverse_inertias[n]);
            let lost = energy(&touch.velocity, &touch.spins) - energy(&velocity, &spins);
            assert!((lost - grip.dissipated).abs() < 1e-13, "{lost} {}", grip.dissipated);
            assert!(grip.dissipated >= -1e-15, "{}", grip.dissipated);
            // The centres are `arms[0] + arms[1]` apart, along the normal.
            let orbital = (normal * (arms[0] + arms[1])).cross(&grip.impulse);
            assert!((orbital + grip.torques[0] + grip.torques[1]).norm() < 1e-14);
            assert!(grip.impulse.dot(&normal).abs() < 1e-14);
            let after = Touch { velocity, spins, ..touch };
            if roughness.friction == LIMITLESS {
                assert!((after.slip() + touch.slip() * b).norm() < 1e-13, "the slip is multiplied by -b");
            } else {
                assert!(grip.impulse.norm() <= 0.2 * 1.5 * (1.0 + 1e-15));
            }
        }
    }

    #[test]
    fn only_perfectly_rough_and_smooth_contacts_conserve_energy() {
        for (b, mu, dissipates) in
            [(1.0, LIMITLESS, false), (1.0, 0.5, true), (0.999, LIMITLESS, true), (-1.0, 0.5, false), (0.0, 0.0, false)]
        {
            assert_eq!(rough(b, mu).dissipates(), dissipates, "{b} {mu}");
        }
    }
}
