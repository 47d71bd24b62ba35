//! The state of all particles, and the box.

use super::array::Array;
use super::images::travelled::Travelled;
use super::order::along_curve;
use super::pairs::rows::Rows;
use super::sizes::Sizes;
use crate::Vector;
use crate::base::numbers::id;
use crate::model::Scene;
use crate::model::space::Space;
use serde::{Deserialize, Serialize};

/// State of a particle at its last event, called a *delayed state*. It fills one cache line.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(super) struct Body {
    pub position: Vector,
    pub velocity: Vector,
    /// Time of this state, since the epoch.
    pub time: f64,
    /// Version of the motion. It grows with each event that changes the motion, and when all predictions are discarded.
    /// A prediction for another version is outdated.
    pub version: u32,
    /// Id of the particle.
    pub id: u32,
}

impl Body {
    /// Returns an array of position, velocity and time. The last number has no meaning: it holds `version` and `id`.
    #[inline(always)]
    pub fn numbers(&self) -> &[f64; 8] {
        const { assert!(size_of::<Self>() == size_of::<[f64; 8]>()) };
        // SAFETY: the array has the same size, its alignment is no stricter, `Self` has no padding, and any bits are a
        // valid `f64`.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct State {
    pub bodies: Array<Body>,
    /// Index in memory of each particle, in the order of the ids.
    pub numbers: Vec<u32>,
    /// The id of the next particle that enters.
    pub next_id: u32,
    /// Indices of particles that have left. Empty except within the event loop, see [`Engine::close_gaps`].
    ///
    /// [`Engine::close_gaps`]: super::parts::Engine::close_gaps
    #[serde(skip)]
    pub vacant: Vec<u32>,
    /// Number of particles that are not static.
    pub moving: usize,
    /// Number of particles when the neighbour search was set up.
    pub count_when_sorted: usize,
    /// Table row of each particle: its species, its range of diameters, and whether it sleeps. Empty if there is no table.
    pub rows: Array<u16>,
    pub images: Travelled,
    /// Spin of each particle `[1 / time]`; empty if the scene has no spins.
    pub spins: Array<Vector>,
    pub sizes: Sizes,
    pub space: Space,
    /// Periods of the box, infinite along axes that are not periodic.
    pub periods: Vector,
}

impl State {
    /// Returns the particles of a scene at its start, sorted so that neighbours in space are close in memory.
    pub fn of(scene: &Scene, rows: &Rows, has_table: bool) -> Self {
        let ids = {
            let positions: Vec<Vector> = scene.particles().iter().map(|p| p.position).collect();
            along_curve(scene.space(), &positions)
        };
        let mut numbers = vec![0; ids.len()];
        for (&id, number) in ids.iter().zip(0..) {
            numbers[id as usize] = number;
        }
        let particles = || ids.iter().map(|&id| &scene.particles()[id as usize]);
        let bodies = particles()
            .zip(&ids)
            .map(|(p, &id)| Body { position: p.position, velocity: p.velocity, time: 0.0, version: 0, id })
            .collect();
        let spins = if scene.has_spins() { particles().map(|p| p.spin).collect() } else { Array::new() };
        Self {
            bodies,
            next_id: id(numbers.len()),
            vacant: Vec::new(),
            moving: scene.moving().count(),
            count_when_sorted: 0,
            numbers,
            rows: particles().filter(|_| has_table).map(|p| rows.row_of(p)).collect(),
            images: Travelled::new(ids.len()),
            spins,
            sizes: Sizes::of(scene, particles()),
            space: scene.space().clone(),
            periods: scene.space().periods(),
        }
    }
}

impl State {
    /// Returns the index in memory of a particle, if it exists. Until a particle is removed, ids are indices of
    /// `numbers`.
    #[inline]
    pub fn number(&self, id: u32) -> Option<u32> {
        let of = |number: u32| self.bodies[number as usize].id;
        let number = self.numbers.get(id as usize).copied().filter(|&number| of(number) == id);
        number.or_else(|| {
            let at = self.numbers.binary_search_by_key(&id, |&number| of(number)).ok()?;
            Some(self.numbers[at])
        })
    }

    /// Number of particles in the system.
    pub fn count(&self) -> usize {
        self.bodies.len() - self.vacant.len()
    }

    /// Updates `numbers` after particles were added at the end of `bodies`.
    pub fn number_anew(&mut self) {
        if let Some(new) = self.bodies.last()
            && self.numbers.len() + 1 == self.bodies.len()
            && new.id >= self.next_id
        {
            // Ids of particles that enter are the largest, so nothing has to be sorted.
            self.numbers.push(id(self.numbers.len()));
            self.next_id = new.id + 1;
            return;
        }
        self.numbers.extend((0..).take(self.bodies.len()).skip(self.numbers.len()));
        self.numbers.sort_by_key(|&number| self.bodies[number as usize].id);
        let last = self.numbers.last().map_or(0, |&number| self.bodies[number as usize].id + 1);
        self.next_id = self.next_id.max(last);
    }

    pub fn population(&self, rows: &Rows, species: usize) -> Vec<usize> {
        let mut population = vec![0; species];
        if self.rows.is_empty() && !self.bodies.is_empty() {
            population[0] = self.bodies.len();
        }
        for &row in &self.rows {
            population[rows.species()[usize::from(row)].0 as usize] += 1;
        }
        population
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_as_numbers_holds_position_velocity_and_time() {
        let (position, velocity) = (Vector::new(1.0, 2.0, 3.0), Vector::new(4.0, 5.0, 6.0));
        let bodies = [Body { position, velocity, time: 7.0, version: 8, id: 9 }; 2];
        for body in &bodies {
            assert_eq!(body.numbers()[..7], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        }
    }
}
