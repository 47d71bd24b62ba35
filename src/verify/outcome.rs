//! Whether an event did what the physics says, from the states before and after it.

use super::bounds::{Bounds, Flight, rounded};
use super::certificate::Margins;
use super::contact::Contact;
use super::violation::{Fault, Quantity};
use super::world::{Wall, World};
use crate::Vector;
use crate::event::Event;
use crate::interaction::rules::Discontinuity;
use crate::overlap::Side;
use crate::response::Outcome;
use crate::simulation::States;

/// An event with all that its outcome depends on.
pub(super) struct Encounter<'a> {
    pub world: &'a World,
    pub event: &'a Event,
    /// All states at the event's time: along the flights before it, and after it.
    pub before: &'a States,
    pub after: &'a States,
    pub bounds: Bounds,
    pub flights: [Flight; 2],
    pub margins: &'a mut Margins,
}

impl Encounter<'_> {
    /// The table of outcomes: Core, Capture, Release or Bounce, from the energy step and the radial kinetic energy.
    pub fn check_pair(
        &mut self,
        j: u32,
        side: Side,
        seen: &Discontinuity,
        restitution: f64,
        found: Outcome,
    ) -> Result<(), Fault> {
        let i = self.event.particle.0;
        let weights = [i, j].map(|p| self.world.inverse_masses[p as usize]);
        let mu = 1.0 / (weights[0] + weights[1]);
        let apart = self.world.nearest(self.before, i, j);
        let normal = apart.try_normalize(0.0).unwrap_or(self.event.normal);
        let relative = |states: &States| states.velocities[i as usize] - states.velocities[j as usize];
        let vn = relative(self.before).dot(&normal);

        let (expected, crosses) = self.expected(side, seen.energy_step, mu, vn, found);
        let contact = Contact::of(self.event);
        if found != expected {
            return Err(Fault::WrongOutcome { contact, expected, found });
        }
        let energy_step = if crosses { seen.energy_step } else { 0.0 };
        self.within(Quantity::EnergyStep, (self.event.energy_step - energy_step).abs(), 0.0)?;
        self.within(Quantity::Normal, (self.event.normal - normal).norm(), 2.0 * self.bounds.direction)?;
        let onwards = if crosses { side.sign() } else { -side.sign() };
        let wrong_way = onwards * relative(self.after).dot(&normal);
        self.within(Quantity::Direction, wrong_way, self.bounds.normal_velocity)?;

        let is_barrier = seen.energy_step == f64::INFINITY;
        let lenient = is_barrier && self.world.has_contact_time;
        self.check_velocities(&[i, j], &weights, lenient)?;
        let approach = if is_barrier { (-side.sign() * vn).max(0.0) } else { 0.0 };
        self.check_energy(&[i, j], &weights, mu, approach, restitution, lenient)
    }

    /// A reflection off a wall.
    pub fn check_wall(&mut self, wall: &Wall) -> Result<(), Fault> {
        let i = self.event.particle.0;
        let (k, inwards) = (usize::from(wall.axis), wall.inwards());
        let mut normal = Vector::zeros();
        normal[k] = inwards;
        self.within(Quantity::Normal, (self.event.normal - normal).norm(), 0.0)?;
        let along = |states: &States| inwards * states.velocities[i as usize][k];
        let leaving = along(self.after);
        self.within(Quantity::Direction, -leaving, self.bounds.normal_velocity)?;
        let weight = self.world.inverse_masses[i as usize];
        self.check_velocities(&[i], &[weight], self.world.has_contact_time)?;
        let approach = (-along(self.before)).max(0.0);
        self.check_energy(&[i], &[weight], 1.0 / weight, approach, wall.restitution, self.world.has_contact_time)
    }

    /// The outcome that the energies demand; where they are equal but for round-off, the one that was found.
    fn expected(&self, side: Side, energy_step: f64, mu: f64, vn: f64, found: Outcome) -> (Outcome, bool) {
        let (crossing, barrier) = match side {
            Side::Positive => (Outcome::Capture, Outcome::Core),
            Side::Negative => (Outcome::Release, Outcome::Bounce),
        };
        if energy_step == f64::INFINITY {
            return (barrier, false);
        }
        let step = 2.0 * energy_step / mu;
        let squared = vn * vn - step;
        let slack = 2.0 * vn.abs() * self.bounds.normal_velocity + rounded(vn * vn + step.abs());
        let crosses = if squared.abs() <= slack { found == crossing } else { squared > 0.0 };
        (if crosses { crossing } else { Outcome::Bounce }, crosses)
    }

    /// Each velocity changes by the impulse along the normal and by nothing else. The TC model may turn sliding motion, and is
    /// only held to momentum.
    fn check_velocities(&mut self, particles: &[u32], weights: &[f64], lenient: bool) -> Result<(), Fault> {
        let change = |p: u32| self.after.velocities[p as usize] - self.before.velocities[p as usize];
        let changes: Vec<Vector> = particles.iter().map(|&p| change(p)).collect();
        if let (&[a, b], &[wa, wb]) = (&changes[..], weights)
            && wa > 0.0
            && wb > 0.0
        {
            let mu = 1.0 / (wa + wb);
            let bound = self.flights[0].velocity() / wa + self.flights[1].velocity() / wb + mu * self.bounds.velocity;
            self.within(Quantity::Momentum, (a / wa + b / wb).norm(), bound)?;
        }
        let signs = [1.0, -1.0];
        for ((change, weight), sign) in changes.iter().zip(weights).zip(signs) {
            let expected = self.event.normal * (sign * weight * self.event.impulse);
            if !lenient || *weight == 0.0 {
                self.within(Quantity::Velocity, (change - expected).norm(), self.bounds.velocity)?;
            }
        }
        Ok(())
    }

    /// Kinetic energy changes by the step and by what restitution takes; the TC model takes less, and never adds any.
    fn check_energy(
        &mut self,
        particles: &[u32],
        weights: &[f64],
        mu: f64,
        approach: f64,
        restitution: f64,
        lenient: bool,
    ) -> Result<(), Fault> {
        let (mut gained, mut scale) = (0.0, 0.0);
        for ((&p, &weight), flight) in particles.iter().zip(weights).zip(&self.flights) {
            if weight > 0.0 {
                let (old, new) = (&self.before.velocities[p as usize], &self.after.velocities[p as usize]);
                gained += 0.5 / weight * (new - old).dot(&(new + old));
                scale += (flight.speed + new.norm()) * flight.velocity() / weight;
            }
        }
        let speed: f64 = self.flights.iter().map(|flight| flight.speed).sum();
        let bound = scale + mu * speed * self.bounds.velocity + rounded(self.event.energy_step.abs());
        self.within(Quantity::Energy, (gained + self.event.energy_step + self.event.dissipated).abs(), bound)?;
        let full = 0.5 * mu * (1.0 - restitution * restitution) * approach * approach;
        let least = if lenient { 0.0 } else { full };
        let bound = bound + 2.0 * mu * approach * self.bounds.normal_velocity;
        let by = (self.event.dissipated - full).max(least - self.event.dissipated);
        self.within(Quantity::Dissipation, by, bound)
    }

    /// Compares what should be nothing with what round-off explains.
    fn within(&mut self, quantity: Quantity, by: f64, bound: f64) -> Result<(), Fault> {
        if by <= bound {
            self.margins.note_outcome(by, bound);
            return Ok(());
        }
        Err(Fault::WrongNumbers { contact: Contact::of(self.event), quantity, by, bound })
    }
}
