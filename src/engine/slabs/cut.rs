//! A system that is cut into slabs.

use super::geometry::Geometry;
use super::part::{Part, Phase};
use super::stretch::{PHASES, Progress};
use crate::engine::neighbours::Neighbours;
use crate::engine::parts::Engine;
use std::sync::{PoisonError, RwLock};

/// A system that is cut into slabs.
#[derive(Debug)]
pub struct Cut {
    pub geometry: Geometry,
    pub parts: Vec<Part>,
    pub phases: Vec<[RwLock<Phase>; PHASES]>,
    /// Time since the epoch that has been reached.
    pub now: f64,
    /// Time of the last step, or the time limit if the run has reached it.
    pub latest: f64,
    /// Number of steps of this epoch.
    pub steps: u64,
    /// Whether one thread executes the next window.
    pub is_alone: bool,
    /// Whether the queue of the engine has all entries, too.
    pub is_complete: bool,
}

impl Clone for Cut {
    fn clone(&self) -> Self {
        Self {
            geometry: self.geometry.clone(),
            parts: self.parts.clone(),
            phases: self.parts.iter().map(|_| new_phases()).collect(),
            ..*self
        }
    }
}

impl Cut {
    pub fn new<const FALLING: bool, const TABLE: bool>(whole: &Engine<FALLING, TABLE>, geometry: Geometry) -> Self {
        let (count, threads) = (whole.particles().len(), geometry.slabs.len());
        // No event is due before the epoch, so the threads can start there.
        let now = whole.clock.now.max(0.0);
        let queue = &whole.schedule.queue;
        let part =
            || Part::new(queue.of_part(now, count / threads, count), queue.of_part(now, 1, count), whole.no_counts());
        let parts: Vec<Part> = (0..threads).map(|_| part()).collect();
        Self {
            phases: parts.iter().map(|_| new_phases()).collect(),
            geometry,
            parts,
            now,
            latest: whole.clock.now,
            steps: queue.steps(),
            is_alone: false,
            is_complete: false,
        }
    }

    /// Sets memory of the neighbour lists apart for each thread.
    pub fn make_rooms(&mut self, neighbours: &mut Neighbours, particles: usize) {
        let threads = self.parts.len();
        let share = particles / threads;
        for (part, left) in self.parts.iter_mut().zip((1..=threads).rev()) {
            neighbours.make_room(&mut part.rooms, share, left);
        }
    }

    pub fn give_rooms_back(&mut self, neighbours: &mut Neighbours) {
        self.parts.iter_mut().for_each(|part| neighbours.take_room(&mut part.rooms));
    }
}

fn new_phases() -> [RwLock<Phase>; PHASES] {
    std::array::from_fn(|_| RwLock::new(Phase::new()))
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Adds the counts and the progress of a stretch.
    pub(super) fn take_progress(&mut self, cut: &mut Cut, progress: &Progress) {
        for part in &mut cut.parts {
            self.counts.merge(&part.total);
        }
        let none = self.no_counts();
        for part in &mut cut.parts {
            for counts in [&mut part.total, &mut part.counts, &mut part.none] {
                (**counts).clone_from(&none);
            }
        }
        (self.clock.standstill.since, self.clock.standstill.events) = progress.standstill;
        if let Some(quiet) = progress.quiet {
            self.counts.transitions_at_event = self.counts.totals.transition.wrapping_sub(quiet);
        }
        (cut.now, cut.latest) = (progress.now, progress.latest);
        cut.steps += progress.steps;
        self.clock.now = cut.now;
    }

    /// Undoes all steps of the last window.
    pub(super) fn undo_window(&mut self, cut: &mut Cut) {
        let mut changed = Vec::new();
        for number in (0..PHASES).rev() {
            for phases in &mut cut.phases {
                let phase = phases[number].get_mut().unwrap_or_else(PoisonError::into_inner);
                let undone = phase.log.undone(&self.state.bodies);
                changed.extend(self.restore(&undone));
                changed.extend(phase.held_back.iter().map(|held| held.entry.particle));
                phase.clear();
            }
        }
        let due = self.schedule.due(&self.state.bodies);
        for part in &mut cut.parts {
            part.queue.rewind(cut.now, &due);
        }
        changed.sort_unstable();
        changed.dedup();
        for particle in changed {
            let along = cut.geometry.along(self, particle);
            let slab = cut.geometry.slab_of(along);
            for (number, part) in cut.parts.iter_mut().enumerate() {
                let is_here = number == slab;
                part.own.put(particle, is_here);
                if is_here {
                    part.queue.enter(particle, &due);
                }
            }
        }
    }
}
