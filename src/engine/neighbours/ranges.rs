//! Interaction distances that the neighbour search has to cover.

use crate::engine::pairs::rows::Rows;
use crate::model::{Scene, SpeciesId};
use serde::{Deserialize, Serialize};

/// Rows of a level differ in size by at most this factor.
const SIMILAR: f64 = 2.0;

/// The distances for the species that occur in a scene. Species without particles cost nothing.
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
    /// For each row, whether such particles occur, at the start or later.
    occurs: Vec<bool>,
    /// For each row, whether its particles move. Sleeping particles do not.
    pub moves: Vec<bool>,
    /// The level of each row: 0 for the smallest particles.
    pub levels: Vec<u8>,
    /// For each row, the diameter of its particles `[length]`; 0 for static particles.
    diameters: Vec<f64>,
    /// The largest length of a bond `[length]`; 0 without bonds.
    longest_bond: f64,
    /// The distance up to which sleeping grains have neighbours `[length]`.
    pub sleep_distance: f64,
}

impl Ranges {
    /// Returns the ranges for all rows of a scene.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        Self::of(scene, Rows::of(scene).species())
    }

    /// Returns the ranges for the species of the table rows.
    #[must_use]
    pub fn of(scene: &Scene, species: &[SpeciesId]) -> Self {
        let occurring = scene.occurring_species();
        let of = |id: &SpeciesId| &scene.species[id.0 as usize];
        // The second half of the rows is for sleeping particles.
        let awake = if scene.sleep().is_some() { species.len() / 2 } else { species.len() };
        let bonds = scene.bonds().iter().map(|bond| &scene.interactions()[bond.interaction.0 as usize].potential);
        let mut ranges = Self {
            between: species.iter().flat_map(|&a| species.iter().map(move |&b| scene.range(a, b))).collect(),
            longest: 0.0,
            of_cells: 0.0,
            may_be_overstretched: scene.allow_invalid_start(),
            occurs: species.iter().map(|species| occurring[species.0 as usize]).collect(),
            moves: (0..).zip(species).map(|(row, id)| row < awake && !of(id).is_static()).collect(),
            levels: Vec::new(),
            diameters: species.iter().map(|id| if of(id).is_static() { 0.0 } else { of(id).diameter }).collect(),
            longest_bond: bonds.map(|potential| potential.range()).fold(0.0, f64::max),
            sleep_distance: scene.sleep().map_or(0.0, |sleep| sleep.distance),
        };
        ranges.update();
        ranges
    }

    /// Whether particles of a row occur.
    #[must_use]
    pub fn includes(&self, row: u16) -> bool {
        self.occurs[usize::from(row)]
    }

    /// Includes species that did not occur before. Returns true if there are any.
    pub fn include(&mut self, rows: impl Iterator<Item = u16>) -> bool {
        let before = self.occurs.clone();
        rows.for_each(|row| self.occurs[usize::from(row)] = true);
        let has_grown = self.occurs != before;
        if has_grown {
            self.update();
        }
        has_grown
    }

    fn update(&mut self) {
        let diameters = self.diameters.iter().zip(&self.occurs).filter(|(_, occurs)| **occurs);
        let range = diameters.map(|(diameter, _)| *diameter).fold(self.largest(), f64::max);
        self.of_cells = range + self.sleep_distance;
        self.longest = range.max(self.longest_bond);
        self.levels = self.find_levels();
    }

    /// The rows of particles that occur.
    pub fn occurring(&self) -> impl Iterator<Item = usize> {
        (0..self.occurs.len()).filter(|&row| self.occurs[row])
    }

    /// Returns the largest contact distance of two particles that occur `[length]`; 0 without contacts.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.occurring().flat_map(|a| self.occurring().map(move |b| self.at(a, b))).fold(0.0, f64::max)
    }

    /// Returns the contact distance of a pair of rows `[length]`; negative without contacts.
    #[inline]
    #[must_use]
    pub fn at(&self, a: usize, b: usize) -> f64 {
        self.between[a * self.occurs.len() + b]
    }

    /// Checks data from a file.
    #[must_use]
    pub fn is_sound(&self, rows: usize) -> bool {
        let has_all = [self.occurs.len(), self.moves.len(), self.levels.len(), self.diameters.len()] == [rows; 4];
        has_all && self.between.len() == rows * rows
    }

    /// Returns true if bonds are no longer than cells. Captured pairs are then in the same cell or in adjacent cells.
    #[inline]
    #[must_use]
    pub fn are_captured_near(&self) -> bool {
        self.longest <= self.of_cells
    }

    /// Number of levels of particles of similar size. At least 1.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.levels.iter().max().map_or(1, |highest| usize::from(*highest) + 1)
    }

    /// Sorts rows into levels by their size. The size is the contact distance of two such particles. For particles that
    /// do not meet their like, it is their largest contact distance.
    fn find_levels(&self) -> Vec<u8> {
        let size = |row: usize| {
            let own = self.at(row, row);
            if own > 0.0 { own } else { self.occurring().map(|other| self.at(row, other)).fold(0.0, f64::max) }
        };
        let sizes: Vec<f64> = (0..self.occurs.len()).map(size).collect();
        let mut sorted: Vec<usize> = self.occurring().filter(|&row| sizes[row] > 0.0).collect();
        sorted.sort_by(|&a, &b| sizes[a].total_cmp(&sizes[b]));
        let mut levels = vec![0; self.occurs.len()];
        let (mut level, mut smallest) = (0, sorted.first().map_or(0.0, |&row| sizes[row]));
        for row in sorted {
            if sizes[row] > SIMILAR * smallest && level < u8::MAX {
                (level, smallest) = (level + 1, sizes[row]);
            }
            levels[row] = level;
        }
        levels
    }
}

#[cfg(test)]
impl Ranges {
    /// One row of particles that move.
    pub(super) fn of_equal(range: f64) -> Self {
        Self::of_matrix(vec![range])
    }

    /// Particles that move, with a matrix of ranges.
    pub(super) fn of_matrix(between: Vec<f64>) -> Self {
        let rows = between.len().isqrt();
        let mut ranges = Self {
            between,
            longest: 0.0,
            of_cells: 0.0,
            may_be_overstretched: false,
            occurs: vec![true; rows],
            moves: vec![true; rows],
            levels: Vec::new(),
            diameters: vec![0.0; rows],
            longest_bond: 0.0,
            sleep_distance: 0.0,
        };
        ranges.update();
        ranges
    }
}
