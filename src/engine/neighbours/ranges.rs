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
    /// The largest interaction distance without bonds `[length]`. If grains sleep, the sleep distance is added, so that
    /// the cells also contain the neighbours that a grain almost touches.
    pub of_cells: f64,
    /// True if bonded pairs may start beyond `of_cells`. Their nearest images may be across any side of the box.
    pub may_be_overstretched: bool,
    kinds: Vec<Kind>,
    /// The level of each row: 0 for the smallest particles.
    levels: Vec<u8>,
    /// The largest length of a bond `[length]`; 0 without bonds.
    longest_bond: f64,
    /// The distance up to which sleeping grains have neighbours `[length]`.
    pub sleep_distance: f64,
    /// Whether all particles have the same table row. Batches then skip the look-up.
    pub has_one_row: bool,
}

/// The particles of a row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Kind {
    /// Whether such particles occur, at the start or later.
    occurs: bool,
    /// Whether they move. Sleeping particles do not.
    moves: bool,
    /// Their diameter `[length]`; 0 for static particles.
    diameter: f64,
}

impl Ranges {
    /// Returns the ranges for the table rows.
    #[must_use]
    pub fn of(scene: &Scene, rows: &Rows) -> Self {
        let (species, radii) = (rows.species(), rows.largest_radii());
        let occurring = scene.occurring_species();
        // The second half of the rows is for sleeping particles.
        let awake = if scene.sleep().is_some() { species.len() / 2 } else { species.len() };
        let kind = |(row, id): (usize, &SpeciesId)| {
            let species = &scene.species[id.0 as usize];
            Kind {
                occurs: occurring[id.0 as usize],
                moves: row < awake && !species.is_static(),
                diameter: if species.is_static() { 0.0 } else { 2.0 * radii[row] },
            }
        };
        let all = || species.iter().copied().zip(radii.iter().copied());
        let bonds = scene.bonds().iter().map(|bond| scene.potential_of_bond(bond).range());
        let mut ranges = Self {
            between: all().flat_map(|a| all().map(move |b| scene.range_with(a, b))).collect(),
            longest: 0.0,
            of_cells: 0.0,
            may_be_overstretched: scene.allow_invalid_start(),
            kinds: (0..).zip(species).map(kind).collect(),
            levels: Vec::new(),
            longest_bond: bonds.fold(0.0, f64::max),
            sleep_distance: scene.sleep().map_or(0.0, |sleep| sleep.distance),
            has_one_row: false,
        };
        ranges.update();
        ranges
    }

    /// Whether particles of a row occur.
    #[must_use]
    pub fn includes(&self, row: u16) -> bool {
        self.kinds[usize::from(row)].occurs
    }

    /// Includes species that did not occur before. Returns true if there are any.
    pub fn include(&mut self, rows: impl Iterator<Item = u16>) -> bool {
        let mut has_grown = false;
        for row in rows {
            has_grown |= !std::mem::replace(&mut self.kinds[usize::from(row)].occurs, true);
        }
        if has_grown {
            self.update();
        }
        has_grown
    }

    fn update(&mut self) {
        let has_one_row = self.occurring().nth(1).is_none();
        self.has_one_row = has_one_row;
        let range = self.occurring().map(|row| self.kinds[row].diameter).fold(self.largest(), f64::max);
        self.of_cells = range + self.sleep_distance;
        self.longest = range.max(self.longest_bond);
        self.levels = self.find_levels();
    }

    /// The rows of particles that occur.
    pub fn occurring(&self) -> impl Iterator<Item = usize> {
        (0..self.kinds.len()).filter(|&row| self.kinds[row].occurs)
    }

    /// Whether the particles of a row move. Sleeping particles do not.
    #[must_use]
    pub fn moves(&self, row: usize) -> bool {
        self.kinds[row].moves
    }

    /// The level of each row: 0 for the smallest particles.
    #[must_use]
    pub fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// Returns the largest contact distance of two particles that occur `[length]`; 0 without contacts.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.occurring().flat_map(|a| self.occurring().map(move |b| self.at(a, b))).fold(0.0, f64::max)
    }

    /// Returns the smallest contact distance of two particles of the same row `[length]`. If particles of the same row
    /// never meet, returns the largest contact distance.
    #[must_use]
    pub fn smallest(&self) -> f64 {
        let own = self.occurring().map(|row| self.at(row, row)).filter(|range| *range > 0.0);
        own.fold(self.largest(), f64::min)
    }

    /// Returns the contact distance of a pair of rows `[length]`; negative without contacts.
    #[inline]
    #[must_use]
    pub fn at(&self, a: usize, b: usize) -> f64 {
        self.between[a * self.kinds.len() + b]
    }

    /// Checks data from a file.
    #[must_use]
    pub fn is_sound(&self, rows: usize) -> bool {
        [self.kinds.len(), self.levels.len()] == [rows; 2] && self.between.len() == rows * rows
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

    /// Sorts rows into levels by size. The size of a row is the contact distance of two of its particles. If these
    /// never meet, the size is their largest contact distance with other rows.
    fn find_levels(&self) -> Vec<u8> {
        let size = |row: usize| {
            let own = self.at(row, row);
            if own > 0.0 { own } else { self.occurring().map(|other| self.at(row, other)).fold(0.0, f64::max) }
        };
        let sizes: Vec<f64> = (0..self.kinds.len()).map(size).collect();
        let mut sorted: Vec<usize> = self.occurring().filter(|&row| sizes[row] > 0.0).collect();
        sorted.sort_by(|&a, &b| sizes[a].total_cmp(&sizes[b]));
        let mut levels = vec![0; self.kinds.len()];
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
            kinds: vec![Kind { occurs: true, moves: true, diameter: 0.0 }; rows],
            levels: Vec::new(),
            longest_bond: 0.0,
            sleep_distance: 0.0,
            has_one_row: false,
        };
        ranges.update();
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::pairs::rules::Rules;

    #[test]
    fn the_longest_bond_is_that_of_its_particles() {
        // The sum of the two radii is 0.95. For two particles with the diameter of the species, it would be 0.8.
        let scene = Scene::from_toml(
            "space = { size = [9.0, 9.0, 9.0] }
            species = [{ name = 'bead', mass = 1.3, diameter = 0.8, diameters = 'individual' }]
            interaction = [
                { species = ['bead', 'bead'], potential = 'hard-sphere' },
                { name = 'link', potential = 'bond', shortest = 0.9, longest = 1.2 },
            ]
            particle = [
                { species = 'bead', position = [1, 1, 1], diameter = 1.3 },
                { species = 'bead', position = [2.2, 1, 1], diameter = 0.6 },
            ]
            bond = [{ particles = [0, 1], interaction = 'link' }]
            run = { until_time = 1.0 }",
            "dumbbell.toml",
        );
        let scene = scene.unwrap();
        let ranges = Ranges::of(&scene, &Rules::new(&scene).rows);
        assert!((ranges.longest - 1.2 * 0.95 / 0.8).abs() < 1e-12, "{ranges:?}");
        assert!(ranges.of_cells > 1.2 && !ranges.are_captured_near(), "{ranges:?}");
    }
}
