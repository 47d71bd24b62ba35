//! The state of all particles: positions and velocities with local times, images, species, and the box.

use super::images::travelled::Travelled;
use super::order::along_curve;
use super::pairs::rows::Rows;
use crate::Vector;
use crate::model::Scene;
use crate::model::space::Space;
use serde::{Deserialize, Serialize};

/// A particle at its last event: a *delayed state* of one cache line.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(super) struct Body {
    /// Position at the local time.
    pub position: Vector,
    /// Velocity at the local time.
    pub velocity: Vector,
    /// Local time, since the epoch.
    pub time: f64,
    /// Number of events that changed the particle's motion. Predictions with an earlier number are void.
    pub events: u32,
    /// Id of the particle.
    pub name: u32,
}

impl Body {
    /// Position, velocity and time as one array; the last number is padding.
    #[inline(always)]
    pub fn numbers(&self) -> &[f64; 8] {
        const { assert!(size_of::<Self>() == size_of::<[f64; 8]>()) };
        // SAFETY: the array is as large, its alignment is no stricter, there is no padding, and any bits are
        // a valid number.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
}

/// All particles, by number in memory, and the box.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct State {
    pub bodies: Vec<Body>,
    /// The number of each particle, in the order of ids.
    pub numbers: Vec<u32>,
    /// The row of each particle's species; empty if there is only one.
    pub species: Vec<u16>,
    /// Number of periods that each particle has travelled along each axis.
    pub images: Travelled,
    pub space: Space,
    /// Periods of the box, infinite along axes that are not periodic.
    pub periods: Vector,
}

impl State {
    /// The particles of a scene at its start. Neighbours in space have adjacent numbers.
    pub fn of(scene: &Scene, rows: &Rows, has_table: bool) -> Self {
        let names = {
            let positions: Vec<Vector> = scene.particles().iter().map(|p| p.position).collect();
            along_curve(scene.space(), &positions)
        };
        let mut numbers = vec![0; names.len()];
        for (&name, number) in names.iter().zip(0..) {
            numbers[name as usize] = number;
        }
        let particles = || names.iter().map(|&name| &scene.particles()[name as usize]);
        let bodies = particles()
            .zip(&names)
            .map(|(p, &name)| Body { position: p.position, velocity: p.velocity, time: 0.0, events: 0, name })
            .collect();
        Self {
            bodies,
            numbers,
            species: particles().filter(|_| has_table).map(|p| rows.row(p.species)).collect(),
            images: Travelled::new(names.len()),
            space: scene.space().clone(),
            periods: scene.space().periods(),
        }
    }
}

impl State {
    /// Returns the number in memory of an id, if the particle exists. Ids increase with every insertion and
    /// are never reused. Until a particle is removed, they equal the ids of the scene.
    #[inline]
    pub fn number(&self, id: u32) -> Option<u32> {
        let of = |number: u32| self.bodies[number as usize].name;
        let number = self.numbers.get(id as usize).copied().filter(|&number| of(number) == id);
        number.or_else(|| {
            let at = self.numbers.binary_search_by_key(&id, |&number| of(number)).ok()?;
            Some(self.numbers[at])
        })
    }

    /// Lists the numbers in the order of ids again, after particles were added at the end of memory.
    pub fn number_anew(&mut self) {
        self.numbers.extend((0..).take(self.bodies.len()).skip(self.numbers.len()));
        self.numbers.sort_by_key(|&number| self.bodies[number as usize].name);
    }

    /// Number of particles of each species.
    pub fn population(&self, rows: &Rows, species: usize) -> Vec<usize> {
        let mut population = vec![0; species];
        if self.species.is_empty() && !self.bodies.is_empty() {
            population[0] = self.bodies.len();
        }
        for &row in &self.species {
            population[rows.species()[usize::from(row)].0 as usize] += 1;
        }
        population
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_is_eight_numbers_of_which_seven_have_a_meaning() {
        let (position, velocity) = (Vector::new(1.0, 2.0, 3.0), Vector::new(4.0, 5.0, 6.0));
        let bodies = [Body { position, velocity, time: 7.0, events: 8, name: 9 }; 2];
        for body in &bodies {
            assert_eq!(body.numbers()[..7], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        }
    }
}
