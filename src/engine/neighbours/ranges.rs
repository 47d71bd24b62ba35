//! The distance that a neighbour search has to cover.

use crate::model::{Scene, SpeciesId};
use serde::{Deserialize, Serialize};

/// The distances at which uncaptured pairs meet.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ranges {
    /// Distances at which uncaptured pairs meet `[length]`, as a matrix over pairs of species, row by row.
    /// They are negative for pairs that never meet.
    pub between: Vec<f64>,
    /// The longest distance, bonds included.
    pub longest: f64,
    /// The range that the cells must cover.
    pub of_cells: f64,
    /// Whether a bonded pair may start further apart than `of_cells`. Its nearest image may then be across
    /// any side of the box.
    pub may_be_overstretched: bool,
}

impl Ranges {
    /// Returns the ranges between the species in `species`. Each of these species has a row.
    #[must_use]
    pub fn of(scene: &Scene, species: &[SpeciesId]) -> Self {
        Self {
            between: species.iter().flat_map(|&a| species.iter().map(move |&b| scene.range(a, b))).collect(),
            longest: scene.bonds().iter().fold(scene.longest_range(), |longest, bond| {
                longest.max(scene.interactions()[bond.interaction.0 as usize].potential.range())
            }),
            of_cells: scene.longest_range(),
            may_be_overstretched: scene.allow_invalid_start(),
        }
    }

    /// Whether captured pairs stay within the range of the cells, so that their particles are in the same or
    /// adjacent cells.
    #[inline]
    #[must_use]
    pub fn are_captured_near(&self) -> bool {
        self.longest <= self.of_cells
    }
}
