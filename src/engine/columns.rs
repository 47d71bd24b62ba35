//! Columns: all that there is one of for each particle, by its number in memory.
//!
//! A column is registered once, in [`Engine::for_each_column`]. From there particles are put in another order, and times are counted from another
//! epoch; nothing else knows which columns there are.

use super::images::travelled::Travelled;
use super::neighbours::Neighbours;
use super::pairs::contacts::ContactTimes;
use super::pairs::states::{CapturedPairs, PairState};
use super::parts::Engine;
use super::prediction::Prediction;
use super::state::Body;

/// A new order of particles: by new number the old one, and the other way round.
pub(super) struct Order {
    pub old: Vec<u32>,
    pub new: Vec<u32>,
}

impl Order {
    /// The order in which the particle of old number `old[0]` comes first.
    pub fn of(old: Vec<u32>) -> Self {
        let mut new = vec![0; old.len()];
        for (&old, number) in old.iter().zip(0..) {
            new[old as usize] = number;
        }
        Self { old, new }
    }

    /// Elements in the new order.
    pub fn permuted<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.old.iter().map(|&old| values[old as usize]).collect()
    }
}

/// Data with an entry for each particle.
pub(super) trait Column {
    /// Puts the entries in another order, and renumbers particles that they name.
    fn permute(&mut self, order: &Order);

    /// Counts times from an epoch that is later by `shift`.
    fn shift(&mut self, _shift: f64) {}
}

impl Column for Vec<Body> {
    fn permute(&mut self, order: &Order) {
        *self = order.permuted(self);
    }

    fn shift(&mut self, shift: f64) {
        self.iter_mut().for_each(|body| body.time -= shift);
    }
}

impl Column for Vec<u16> {
    /// Empty where all particles are of one species.
    fn permute(&mut self, order: &Order) {
        if !self.is_empty() {
            *self = order.permuted(self);
        }
    }
}

impl Column for Travelled {
    fn permute(&mut self, order: &Order) {
        match self {
            Self::Near(images) => *images = order.permuted(images),
            Self::Far(images) => *images = order.permuted(images),
        }
    }
}

impl Column for Vec<Prediction> {
    fn permute(&mut self, order: &Order) {
        *self = order.permuted(self);
        self.iter_mut().for_each(|prediction| prediction.renumber(&order.new));
    }

    fn shift(&mut self, shift: f64) {
        for prediction in self {
            prediction.contact_time -= shift;
            prediction.transition_time -= shift;
        }
    }
}

impl Column for ContactTimes {
    fn permute(&mut self, order: &Order) {
        self.last = order.permuted(&self.last);
    }

    fn shift(&mut self, shift: f64) {
        self.last.iter_mut().for_each(|last| *last -= shift);
    }
}

impl Column for CapturedPairs {
    /// Empty where no pair can be captured.
    fn permute(&mut self, order: &Order) {
        if self.is_empty() {
            return;
        }
        let mut states = Self::new(order.old.len());
        for (&old, particle) in order.old.iter().zip(0..) {
            for captured in self.of(old) {
                states.set(particle, PairState { partner: order.new[captured.partner as usize], ..*captured });
            }
        }
        *self = states;
    }
}

impl Column for Neighbours {
    fn permute(&mut self, order: &Order) {
        match self {
            Self::Cells(cells) => cells.permute(order),
            Self::Lists(verlet) => verlet.permute(order),
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Calls `visit` for every column.
    fn for_each_column(&mut self, mut visit: impl FnMut(&mut dyn Column)) {
        visit(&mut self.state.bodies);
        visit(&mut self.state.species);
        visit(&mut self.state.images);
        visit(&mut self.schedule.predictions);
        visit(&mut self.neighbours);
        visit(&mut self.pairs.states);
        if let Some(times) = &mut self.pairs.contact_times {
            visit(times);
        }
    }

    /// Gives the particles other numbers in memory.
    pub(super) fn permute(&mut self, order: &Order) {
        self.for_each_column(|column| column.permute(order));
        for number in &mut self.state.numbers {
            *number = order.new[*number as usize];
        }
    }

    /// Counts the times of all particles from an epoch that is later by `shift`.
    pub(super) fn shift_columns(&mut self, shift: f64) {
        self.for_each_column(|column| column.shift(shift));
    }
}

#[cfg(test)]
mod tests;
