//! Interaction distances that the neighbour search has to cover.

use crate::model::{Scene, SpeciesId};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ranges {
    /// Contact distances of uncaptured pairs `[length]`, as a matrix over table rows. Negative without contacts.
    pub between: Vec<f64>,
    /// The largest interaction distance, including bonds `[length]`.
    pub longest: f64,
    /// The largest interaction distance without bonds `[length]`. If grains sleep, a little more, so that the cells also
    /// contain the neighbours that a grain almost touches.
    pub of_cells: f64,
    /// True if bonded pairs may start beyond `of_cells`. Their nearest images may be across any side of the box.
    pub may_be_overstretched: bool,
}

impl Ranges {
    /// Returns the ranges for the species of the table rows.
    #[must_use]
    pub fn of(scene: &Scene, species: &[SpeciesId]) -> Self {
        Self {
            between: species.iter().flat_map(|&a| species.iter().map(move |&b| scene.range(a, b))).collect(),
            longest: scene.bonds().iter().fold(scene.longest_range(), |longest, bond| {
                longest.max(scene.interactions()[bond.interaction.0 as usize].potential.range())
            }),
            of_cells: scene.longest_range() + scene.sleep().map_or(0.0, |sleep| sleep.distance),
            may_be_overstretched: scene.allow_invalid_start(),
        }
    }

    /// Returns true if bonds are no longer than cells. Captured pairs are then in the same cell or in adjacent cells.
    #[inline]
    #[must_use]
    pub fn are_captured_near(&self) -> bool {
        self.longest <= self.of_cells
    }
}
