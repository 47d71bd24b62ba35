//! Tangential impulses of rough contacts: sticking with a tangential restitution, or sliding with Coulomb friction.

use super::Reference;
use crate::Vector;
use crate::model::Roughness;

#[derive(Debug, Clone, Copy)]
pub(super) struct Rub {
    pub particle: u32,
    pub partner: Option<u32>,
    /// Distances of the point of contact from the two centres.
    pub radii: [f64; 2],
    /// Unit vector from the partner to the particle.
    pub normal: Vector,
    /// Velocity of the centre of the particle, relative to the partner.
    pub velocity: Vector,
    /// Angular velocity of a rotating surface.
    pub turning: Vector,
    /// Positive change of the normal component of `velocity` in the contact, without the energy lost to friction.
    pub kick: f64,
    /// Two normal speeds. Energy lost to friction goes into the normal motion, which becomes at most as fast as the first
    /// speed: all of this energy if the slip is at most 4 times the second speed, and none of it if the slip is at least
    /// 8 times the second speed.
    pub rattle: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Rubbed {
    /// Momentum that the particle gains by friction: the tangential one, and the normal one from the energy lost.
    pub impulse: Vector,
    /// Angular momenta that the particle and its partner gain.
    pub torques: [Vector; 2],
    pub dissipated: f64,
}

impl Reference {
    pub(super) fn angular_momentum(&self, i: u32, spin: &Vector) -> Vector {
        let inverse = self.own[i as usize].inverse_inertia(self.scene.space.dimensions());
        if inverse > 0.0 { spin / inverse } else { Vector::zeros() }
    }

    pub(super) fn rub(&mut self, rub: &Rub, roughness: &Roughness) -> Rubbed {
        let Rub { particle, partner, radii: [ri, rj], normal, velocity, turning, kick, rattle: [fastest, rattling] } =
            *rub;
        let dimensions = self.scene.space.dimensions();
        let constants = |reference: &Self, i: u32| {
            let species = reference.species(i);
            (species.inverse_mass(), species.inverse_inertia(dimensions))
        };
        let (mi, ti) = constants(self, particle);
        let (mj, tj) = partner.map_or((0.0, 0.0), |j| constants(self, j));
        let mut spins =
            [self.spins[particle as usize] - turning, partner.map_or(Vector::zeros(), |j| self.spins[j as usize])];

        // From the centre of the particle, the point of contact is at `-ri n`. From the centre of the partner, it is at
        // `rj n`.
        let slip = velocity + spins[0].cross(&(normal * -ri)) - spins[1].cross(&(normal * rj));
        let slip = slip - normal * slip.dot(&normal);
        let response = mi + mj + ri * ri * ti + rj * rj * tj;
        let stop = (1.0 + roughness.tangential_restitution) / response;
        let largest = roughness.friction * (kick / (mi + mj));
        let impulse = match slip.try_normalize(0.0) {
            Some(direction) if kick > 0.0 => direction * -largest.min(stop * slip.norm()),
            _ => Vector::zeros(),
        };
        let energy = |spins: &[Vector; 2]| {
            let of =
                |spin: &Vector, inverse: f64| if inverse > 0.0 { spin.norm_squared() / (2.0 * inverse) } else { 0.0 };
            of(&spins[0], ti) + of(&spins[1], tj)
        };
        let before = energy(&spins);
        let torques = [(normal * -ri).cross(&impulse), -(normal * rj).cross(&impulse)];
        spins[0] += torques[0] * ti;
        spins[1] += torques[1] * tj;
        self.spins[particle as usize] = spins[0] + turning;
        if let Some(j) = partner {
            self.spins[j as usize] = spins[1];
        }
        let along = velocity - normal * velocity.dot(&normal);
        let of_centres = impulse.dot(&along) + 0.5 * (mi + mj) * impulse.norm_squared();
        let lost = before - energy(&spins) - of_centres;
        let speed = velocity.dot(&normal) + kick;
        // Grains that rattle keep this energy, and bodies that slide lose it.
        let share = if rattling > 0.0 { (2.0 - slip.norm() / (4.0 * rattling)).clamp(0.0, 1.0) } else { 0.0 };
        let kept = lost.max(0.0) * share;
        let faster = libm::sqrt(speed * speed + 2.0 * (mi + mj) * kept).min(fastest).max(speed);
        let push = (faster - speed) / (mi + mj);
        Rubbed { impulse: impulse + normal * push, torques, dissipated: lost - 0.5 * push * (faster + speed) }
    }
}
