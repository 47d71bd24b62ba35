use super::{Column, Order};
use crate::engine::pairs::Pairs;
use crate::engine::parts::Engine;
use crate::engine::prediction::Schedule;
use crate::engine::sources::Sources;
use crate::engine::state::State;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns an engine for a subset of the particles, in a given order. The new engine has an empty queue, no table
    /// of ids, and no event sources for the whole system.
    pub(in crate::engine) fn part(&self, order: &Order) -> Self {
        let (state, sources) = (&self.state, &self.sources);
        Self {
            state: State {
                bodies: state.bodies.permuted(order),
                numbers: Vec::new(),
                next_id: state.next_id,
                vacant: Vec::new(),
                moving: state.moving,
                count_when_sorted: state.count_when_sorted,
                rows: state.rows.permuted(order),
                images: state.images.permuted(order),
                spins: state.spins.permuted(order),
                sizes: state.sizes.permuted(order),
                space: state.space.clone(),
                periods: state.periods,
            },
            clock: self.clock.clone(),
            schedule: Schedule {
                predictions: self.schedule.predictions.permuted(order),
                queue: self.schedule.queue.of_part(self.clock.now, order.old.len(), order.new.len()),
                part: None,
            },
            neighbours: self.neighbours.permuted(order),
            ranges: self.ranges.clone(),
            pairs: Pairs {
                rules: self.pairs.rules.clone(),
                states: self.pairs.states.permuted(order),
                contact_times: self.pairs.contact_times.as_ref().map(|column| column.permuted(order)),
                has_loose_bonds: self.pairs.has_loose_bonds,
                bias: None,
            },
            images: self.images.clone(),
            distances: self.distances,
            sources: Sources {
                surfaces: sources.surfaces.clone(),
                confinement: sources.confinement.clone(),
                surface_random: sources.surface_random.as_ref().map(|column| column.permuted(order)),
                andersen: None,
                restraint: None,
                inlets: None,
                sleepers: None,
                is_watched: sources.confinement.is_some(),
                next_global: f64::INFINITY,
            },
            counts: Box::new(self.no_counts()),
            hardware: self.hardware,
            broken: self.broken,
            domains: None,
            slabs: None,
            scratch: None,
        }
    }
}
