//! Sums of the energies and momenta of events, for energy balances and pressures.

use super::parts::Engine;
use crate::Vector;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline(always)]
    pub(super) fn note_energies(&mut self, energy_step: f64, dissipated: f64, supplied: f64) {
        let time = self.clock.epoch + self.clock.now;
        let totals = &mut self.counts.totals;
        if dissipated != 0.0 {
            totals.dissipated.add(dissipated);
            totals.dissipated_moment.add(dissipated * time);
        }
        if supplied != 0.0 {
            totals.supplied.add(supplied);
            totals.supplied_moment.add(supplied * time);
        }
        if TABLE && energy_step != 0.0 {
            totals.pair_energy_moment.add(energy_step * time);
        }
    }

    /// Adds the change of `sum m v^2` in an event for each axis between walls. Impulses of pairs also add to the
    /// virial.
    ///
    /// The sum is constant between events. Its integral from 0 to `t` is `t` times the final value, minus each change
    /// times the time of the change.
    ///
    /// Along an axis between walls, the long-time mean of `d/dt sum x m v` is zero for each species: `<sum m v^2> +
    /// <sum x F> = L p A`. Here `x` is the distance from the middle, and `L` is the length accessible to the centres of
    /// particles. `p A` is the mean of the forces on the two walls. The pressure is the sum over all species, each
    /// divided by its volume `L A`.
    pub(super) fn note_confined(&mut self, particles: [Option<u32>; 2], is_internal: bool, before: &[Vector; 2]) {
        let Some(confinement) = &self.sources.confinement else { return };
        let (mut virial, mut change) = (Vector::zeros(), Vector::zeros());
        for (particle, before) in particles.into_iter().flatten().zip(before) {
            if self.is_static(particle) {
                continue;
            }
            let body = &self.state.bodies[particle as usize];
            let share = self.per_volume(confinement, particle) / self.inverse_mass(particle);
            let gained = (body.velocity - before) * share;
            virial += gained.component_mul(&(body.position - confinement.middle));
            change += gained.component_mul(&(body.velocity + before));
        }
        let (axes, time) = (confinement.axes, self.time());
        for axis in (0..3).filter(|&axis| axes[axis]) {
            if is_internal {
                self.counts.totals.confined_virial[axis].add(virial[axis]);
            }
            self.counts.totals.confined_heating[axis].add(change[axis] * time);
        }
    }

    pub(super) fn note_push(&mut self, particle: u32, axis: usize, is_upper: bool, impulse: f64) {
        let Some(confinement) = &self.sources.confinement else { return };
        let per_area = self.per_area(confinement, particle, axis);
        self.counts.totals.wall_push[axis][usize::from(is_upper)].add(impulse * per_area);
    }
}
