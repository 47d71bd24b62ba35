//! What the pressure between walls takes: where centres can be, and how far impulses act from the middle.

use super::event_loop::Engine;
use crate::Vector;
use crate::engine::neighbours::grid::Face;
use crate::model::Scene;
use serde::{Deserialize, Serialize};

/// The walls of a box as the centres of each species see them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Confinement {
    /// Axes between two walls.
    axes: [bool; 3],
    middle: Vector,
    /// By species, 1 over the volume that its centres can reach `[length^-D]`.
    per_volume: Vec<f64>,
    /// By species and axis, 1 over the area of a wall that they can reach `[length^(1 - D)]`; 0 where the area has no end.
    per_area: Vec<[f64; 3]>,
}

impl Confinement {
    /// None where there are no walls.
    pub fn of(scene: &Scene) -> Option<Self> {
        let space = &scene.space;
        let is_walled = (0..3).any(|axis| space.walls(axis) > 0);
        is_walled.then(|| Self {
            axes: std::array::from_fn(|axis| space.walls(axis) == 2),
            middle: space.lower + 0.5 * space.size,
            per_volume: scene.species.iter().map(|species| 1.0 / space.accessible_volume(species.diameter)).collect(),
            per_area: scene
                .species
                .iter()
                .map(|species| {
                    std::array::from_fn(|axis| space.accessible_area(axis, species.diameter).map_or(0.0, f64::recip))
                })
                .collect(),
        })
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Adds an impulse between two particles, from their velocities before it, to the virial of each wall's axis.
    ///
    /// Along an axis between walls, the mean of `d/dt sum x m v` over a long time is zero for each species: `N T + <sum x F> = L p A`, where
    /// `x` is measured from the middle, `L` is the length that the centres reach and `p A` the mean force of the two walls. Divided by the volume
    /// `L A` of that species and summed over all, it is the pressure.
    pub(super) fn note_confined(&mut self, pair: [u32; 2], before: &[Vector; 2]) {
        let Some(confinement) = &self.confinement else { return };
        for (particle, before) in pair.into_iter().zip(before) {
            if self.is_static(particle) {
                continue;
            }
            let body = &self.bodies[particle as usize];
            let species = usize::from(self.species[particle as usize]);
            let share = confinement.per_volume[species] / self.inverse_mass(particle);
            for axis in (0..3).filter(|&axis| confinement.axes[axis]) {
                let arm = body.position[axis] - confinement.middle[axis];
                self.tally.confined_virial[axis] += share * (body.velocity[axis] - before[axis]) * arm;
            }
        }
    }

    /// Adds the momentum that a wall has given a particle to what the wall has taken from all.
    pub(super) fn note_push(&mut self, particle: u32, face: Face, impulse: f64) {
        let Some(confinement) = &self.confinement else { return };
        let (axis, species) = (usize::from(face.axis), usize::from(self.species[particle as usize]));
        self.tally.wall_push[axis][usize::from(face.is_upper)] += impulse * confinement.per_area[species][axis];
    }
}
