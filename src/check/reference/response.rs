//! Outcome and velocity after an event at a discontinuity. The TC model acts at infinite barriers.

use super::rules::{Discontinuity, Side};
use crate::Vector;
use crate::model::{ContactLaw, Roughness, TcRule};

/// Outcome of a pair event (paper, figure 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// Reflection from an infinite inner barrier.
    Core,
    /// One step inwards.
    Capture,
    /// One step outwards.
    Release,
    /// Reflection from a finite step that exceeds the radial kinetic energy, or at the maximum length of a bond.
    Bounce,
}

/// Returns the outcome and the normal velocity `vn'` after an event. Before the event, it is `vn = v_ij . rhat`.
///
/// If the radial kinetic energy `mu/2 vn^2` exceeds the step `dU`, the pair crosses the discontinuity with
/// `vn'^2 = vn^2 - 2 dU / mu`. Otherwise it is reflected: `vn' = -e vn` at an infinite barrier, `vn' = -vn` at a step.
pub(super) fn respond(seen: &Discontinuity, side: Side, vn: f64, mu: f64, law: &ContactLaw) -> (Outcome, f64) {
    let across = -side.sign();
    if 0.5 * mu * vn * vn > seen.energy_step {
        let outcome = if side == Side::Positive { Outcome::Capture } else { Outcome::Release };
        return (outcome, across * (vn * vn - 2.0 * seen.energy_step / mu).max(0.0).sqrt());
    }
    let is_barrier = seen.energy_step == f64::INFINITY;
    let outcome = if is_barrier && side == Side::Positive { Outcome::Core } else { Outcome::Bounce };
    let e = if is_barrier { law.restitution.at(vn.abs(), mu) } else { 1.0 };
    // Near a turning point, the pair may recede because of round-off. The pair then keeps its velocity.
    (outcome, if across * vn > 0.0 { -e * vn } else { vn })
}

/// An event between two particles, or between a particle and a wall. A wall acts as a static partner without curvature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Encounter {
    pub seen: Discontinuity,
    pub side: Side,
    pub normal: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    /// `1 / |r_ij|` for two particles, 0 for a wall.
    pub curvature: f64,
    /// `mu = 1 / (w_i + w_j)`, with the inverse masses `w_i` and `w_j` `[mass]`.
    pub reduced_mass: f64,
    pub law: ContactLaw,
    /// For a surface that moves, or whose material does: velocity of the material along it, relative to its shape.
    pub sliding: Option<Vector>,
}

impl Encounter {
    /// Returns the outcome and the velocity `v_ij` after the event. If the contact is rough, also returns the roughness and
    /// [`TcModel::rattle`]. `moving` lists the particles that are not static.
    pub fn leave(
        &self,
        tc_model: Option<&mut TcModel>,
        moving: &[u32],
        time: f64,
    ) -> (Outcome, Vector, Option<(Roughness, [f64; 2])>) {
        let Self { seen, side, normal, velocity, acceleration, sliding, .. } = self;
        let vn = velocity.dot(normal);
        let along = velocity - normal * vn;
        let material = sliding.unwrap_or_default();
        let (outcome, after) = respond(seen, *side, vn, self.reduced_mass, &self.law);
        let Some(tc_model) = tc_model.filter(|_| seen.energy_step == f64::INFINITY) else {
            let roughness = self.law.roughness.filter(|_| seen.energy_step == f64::INFINITY);
            return (outcome, along + normal * after, roughness.map(|roughness| (roughness, [0.0; 2])));
        };
        let approach = (-side.sign() * vn).max(0.0);
        let arrival = Arrival {
            restitution: self.law.restitution.at(approach, self.reduced_mass),
            approach,
            tangential: (along - material).norm(),
            // The second derivative of |r| is a . rhat + along^2 / |r|, with the tangential velocity `along`.
            closing: -side.sign() * (acceleration.dot(normal) + along.norm_squared() * self.curvature),
            closing_at_rest: -side.sign() * acceleration.dot(normal),
        };
        let (speed, scale) = tc_model.contact(moving, time, &arrival);
        let (is_rough, rattle) = (!tc_model.is_smooth, tc_model.rattle);
        // Such a surface supplies energy, so the slip must be smaller than at a surface at rest.
        let rattle = if sliding.is_some() { [rattle[0], libm::sqrt(rattle[0] * arrival.approach)] } else { rattle };
        let recedes = arrival.approach == 0.0 && speed == 0.0;
        let along = material + (along - material) * scale;
        let after = along + normal * if recedes { vn } else { side.sign() * speed };
        let mut roughness = self.law.roughness.filter(|_| is_rough);
        if let Some(Roughness { tangential_restitution, .. }) = &mut roughness
            && tc_model.reverses_slip
            && *tangential_restitution > -1.0
        {
            *tangential_restitution = 1.0;
        }
        (outcome, after, roughness.map(|roughness| (roughness, rattle)))
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    pub restitution: f64,
    /// Speed towards the barrier; 0 for motion away from it `[length / time]`.
    pub approach: f64,
    /// Speed along the barrier `[length / time]`.
    pub tangential: f64,
    /// Acceleration towards the barrier, from forces and curvature `[length / time^2]`.
    pub closing: f64,
    /// Acceleration towards the barrier from forces alone `[length / time^2]`.
    pub closing_at_rest: f64,
}

/// The TC model (Luding and McNamara, Granular Matter 1, 113, 1998): a contact is elastic if either particle had its
/// previous contact less than `t_c` ago. It remains rough, unless only the rule of the published model applies.
#[derive(Debug)]
pub(super) struct TcModel {
    contact_time: f64,
    /// Whether only the published rule applies: a contact within the contact time is elastic and smooth.
    is_published: bool,
    last: Vec<f64>,
    /// Whether the latest contact was smooth, because the particle slid or was at rest.
    pub is_smooth: bool,
    /// Whether the latest contact was elastic, or that of a particle at rest, so that it reverses the slip.
    pub reverses_slip: bool,
    /// Two normal speeds. The energy that the latest contact lost to friction goes into the normal motion, up to the
    /// first speed. At the second speed, contacts would be `t_c` apart. The first speed equals the second, but is at
    /// most 16 times the approach speed.
    pub rattle: [f64; 2],
}

impl TcModel {
    pub fn new(contact_time: f64, particles: usize) -> Self {
        let last = vec![f64::NEG_INFINITY; particles];
        Self { contact_time, is_published: false, last, is_smooth: false, reverses_slip: false, rattle: [0.0; 2] }
    }

    pub fn with(self, rule: TcRule) -> Self {
        Self { is_published: rule == TcRule::LudingMcNamara, ..self }
    }

    pub fn meet_newcomer(&mut self) {
        self.last.push(f64::NEG_INFINITY);
    }

    /// Records a contact at `time`. Returns the speed away from the barrier, and the factor of the speed along the
    /// barrier.
    ///
    /// In the published model, a particle with a restitution near 0 almost stops. Here it keeps its approach speed, up
    /// to the speed `v = closing t_c / 2` with which it returns after `t_c`. Slower than `v / 64`, it leaves at `v / 32`,
    /// or at its total speed if that is lower. The speed along the barrier decreases at constant energy.
    ///
    /// Let `v0 = closing_at_rest t_c / 2`. A particle with a total speed below `v0 / 64` is at rest, and leaves at `v0`.
    pub fn contact(&mut self, particles: &[u32], time: f64, arrival: &Arrival) -> (f64, f64) {
        let &Arrival { restitution, approach, tangential, closing, closing_at_rest } = arrival;
        let last = |&particle: &u32| self.last[particle as usize];
        let since = particles.iter().map(|particle| time - last(particle)).fold(f64::INFINITY, f64::min);
        let is_recent = since < self.contact_time;
        particles.iter().for_each(|&particle| self.last[particle as usize] = time);

        if self.is_published {
            (self.is_smooth, self.reverses_slip, self.rattle) = (is_recent, false, [0.0; 2]);
            return (if is_recent { approach } else { restitution * approach }, 1.0);
        }
        let back_after_contact_time = 0.5 * closing * self.contact_time;
        let slowest = back_after_contact_time / 64.0;
        self.is_smooth = approach < slowest;
        self.reverses_slip = is_recent || approach < closing * self.contact_time;
        let apart = |most: f64| if is_recent { approach * (self.contact_time / since).min(most) } else { 0.0 };
        self.rattle = [apart(16.0), apart(f64::INFINITY)];
        if approach < slowest {
            let total = libm::hypot(approach, tangential);
            let at_rest = 0.5 * closing_at_rest * self.contact_time;
            if total < at_rest / 64.0 {
                return (at_rest, 1.0);
            }
            let speed = (2.0 * slowest).min(total);
            let along = ((total - speed) * (total + speed)).sqrt();
            return (speed, if tangential > 0.0 { along / tangential } else { 1.0 });
        }
        let e = if is_recent { 1.0 } else { restitution };
        ((e * approach).max(approach.min(back_after_contact_time)), 1.0)
    }
}

#[cfg(test)]
mod tests;
