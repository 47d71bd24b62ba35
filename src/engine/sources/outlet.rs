//! Outlets: a particle that touches one leaves the system. It may return at an inlet.

use crate::engine::InvariantBroken;
use crate::engine::contact::apply::With;
use crate::engine::event::CountedKind;
use crate::engine::observe::Observe;
use crate::engine::pairs::states::PairState;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::engine::sources::inlet::newcomer::Newcomer;
use crate::engine::sources::surface::Touching;
use crate::engine::surfaces::Surface;
use std::ops::ControlFlow;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Removes a particle at its contact with an outlet.
    pub(in crate::engine) fn leave_at_outlet(
        &mut self,
        particle: u32,
        outlet: u32,
        at: &Touching,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let woken = self.wake_neighbours(particle, observe);
        let normal = at.in_space(&at.shape.normal(&at.position));
        let how = (With::Surface(outlet), Some(CountedKind::Exit));
        let flow = self.end_motion(particle, &normal, how, observe);
        if TABLE {
            let captured: Vec<PairState> = self.pairs.states.of(particle).to_vec();
            for pair in captured {
                let energy = self.energy_of_pair(&pair);
                self.note_energies(-energy, 0.0, -energy);
                self.remove_pair_state(particle, pair.partner)?;
            }
        }
        self.neighbours.withdraw(particle);
        self.schedule.predictions[particle as usize] = Prediction::NONE;
        self.state.vacant.push(particle);
        self.send_back(particle, outlet);
        self.note_population(-1);
        Ok(if woken.is_break() { woken } else { flow })
    }

    /// Tells the inlet of an outlet, if there is one, that a particle returns.
    fn send_back(&mut self, particle: u32, outlet: u32) {
        let species = self.species_of(particle);
        let size = self.own_diameter(particle).and_then(|_| self.state.sizes.get(particle));
        let number = self.sources.surfaces.get(outlet).map(|placed| placed.number);
        if let (Some(inlets), Some(number)) = (&mut self.sources.inlets, number) {
            inlets.take(Newcomer { species, size }, number, self.clock.now);
        }
    }

    /// Closes the gaps in memory that particles have left.
    pub(in crate::engine) fn close_gaps(&mut self) {
        if !self.state.vacant.is_empty() {
            let vacant = std::mem::take(&mut self.state.vacant);
            self.remove(&vacant);
        }
    }
}
