//! Sums of energies and momenta that came, went and changed their form: what balances and pressures are made of.

use super::parts::Engine;
use crate::Vector;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Counts what an event adds to the potential energy of a pair, what it dissipates and what comes from outside, and when.
    #[inline]
    pub(super) fn note_energies(&mut self, energy_step: f64, dissipated: f64, supplied: f64) {
        let time = self.elapsed();
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

    /// Takes note of what a change of a particle's velocity does to `sum m v^2` along each axis between walls; where another particle has made it,
    /// its impulse counts in the virial of each wall's axis.
    ///
    /// Between two changes the sum is constant, so that its integral up to a time `t` is exactly its value then times `t`, less the sum of all changes
    /// that there were times their times.
    ///
    /// Along an axis between walls, the mean of `d/dt sum x m v` over a long time is zero for each species: `<sum m v^2> + <sum x F> = L p A`, with
    /// the components along the axis, where `x` is measured from the middle, `L` is the length that the centres reach and `p A` the mean force
    /// of the two walls. Divided by the volume `L A` of that species and summed over all, it is the pressure.
    pub(super) fn note_confined(&mut self, particle: u32, before: &Vector, is_by_particle: bool) {
        let Some(confinement) = self.sources.confinement.as_ref().filter(|_| !self.is_static(particle)) else { return };
        let (body, time) = (&self.state.bodies[particle as usize], self.time());
        let share = confinement.per_volume[usize::from(self.row(particle))] / self.inverse_mass(particle);
        for axis in (0..3).filter(|&axis| confinement.axes[axis]) {
            let gained = body.velocity[axis] - before[axis];
            if is_by_particle {
                let arm = body.position[axis] - confinement.middle[axis];
                self.counts.totals.confined_virial[axis].add(share * gained * arm);
            }
            let change = share * gained * (body.velocity[axis] + before[axis]);
            if change != 0.0 {
                self.counts.totals.confined_heating[axis].add(change * time);
            }
        }
    }

    /// Adds the momentum that a wall has given a particle to what the wall has taken from all.
    pub(super) fn note_push(&mut self, particle: u32, axis: usize, is_upper: bool, impulse: f64) {
        let Some(confinement) = &self.sources.confinement else { return };
        let per_area = confinement.per_area[usize::from(self.row(particle))][axis];
        self.counts.totals.wall_push[axis][usize::from(is_upper)].add(impulse * per_area);
    }
}
