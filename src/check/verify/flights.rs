//! Checks that particles fly freely, and that only the current event changes velocities.

use super::certificate::note;
use super::verifier::Verifier;
use super::violation::Fault;
use crate::Vector;
use crate::engine::States;
use crate::model::ParticleId;

impl Verifier {
    pub(super) fn check_flights(&mut self, after: &States, takes_part: impl Fn(u32) -> bool) -> Result<(), Fault> {
        for (i, at) in (0_u32..).zip(0..self.before.positions.len()) {
            let jump = self.world.shortest(after.positions[at] - self.before.positions[at]).norm();
            let change = (after.velocities[at] - self.before.velocities[at]).norm();
            let turned = self.states.spins.get(at) != after.spins.get(at);
            if turned && !takes_part(i) {
                return Err(Fault::Turned { particle: ParticleId(i) });
            }
            if jump == 0.0 && (change == 0.0 || takes_part(i)) && self.world.is_in_box(&after.positions[at]) {
                continue;
            }
            let flight = self.flight(i);
            let bound = flight.position();
            if !(jump <= bound && self.world.is_in_box(&after.positions[at])) {
                return Err(Fault::Jumped { particle: ParticleId(i), by: jump, bound });
            }
            note(&mut self.proof.margins.flight, jump, bound);
            let falls = self.world.accelerations[at] != Vector::zeros();
            let bound = if falls { flight.velocity() } else { 0.0 };
            if !(change <= bound || takes_part(i)) {
                return Err(Fault::Disturbed { particle: ParticleId(i), by: change });
            }
        }
        Ok(())
    }
}
