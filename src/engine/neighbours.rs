//! Neighbour search: finds the particles that a particle could meet.
//!
//! In a thin fluid, only [`cells`] are used, because a Verlet list would be outdated before its second use. In a dense
//! fluid, Verlet lists with a skin are used ([`lists`]).

pub mod candidates;
pub mod cell_list;
pub mod cells;
mod divisor;
pub mod grid;
pub mod lists;
pub mod packed;
pub mod ranges;
pub mod verlet;

use crate::Vector;
use crate::base::numbers::{id, trunc_to_i32, trunc_to_usize};
use crate::engine::images::ImagePolicy;
use crate::model::space::{Boundary, Space};
use crate::model::{Scene, SpeciesId};
use candidates::Candidates;
use cells::Cells;
use lists::Lists;
use serde::{Deserialize, Serialize};
use std::fmt;
use verlet::VerletLists;

/// Method of the neighbour search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Search {
    /// Cells: the neighbours of a particle are in its own cell and in the adjacent cells.
    Cells,
    /// Verlet lists: each moving particle has a list of its neighbours.
    Lists {
        /// Half of the skin: the distance that a particle may move before its list is rebuilt `[length]`.
        half_skin: f64,
    },
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "there is one in an engine, and it is reached without a detour")]
pub enum Neighbours {
    Cells(Cells),
    Lists(VerletLists),
}

/// Place of a particle in the neighbour search: its cell, or the centre of its Verlet list.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Place {
    Cell(u32),
    Centre(Vector),
}

impl Neighbours {
    #[must_use]
    pub fn place(&self, particle: u32) -> Place {
        match self {
            Self::Cells(cells) => Place::Cell(cells.home(particle)),
            Self::Lists(verlet) => Place::Centre(verlet.centres[particle as usize]),
        }
    }

    /// Adds a particle with an empty list at `place`, or at `position` if `place` does not fit the search method.
    pub fn push(&mut self, position: &Vector, place: Option<Place>) {
        match (self, place) {
            (Self::Cells(cells), Some(Place::Cell(cell))) => cells.push(cell),
            (Self::Cells(cells), _) => cells.push(cells.grid.cell_at(position)),
            (Self::Lists(verlet), Some(Place::Centre(centre))) => verlet.push(centre),
            (Self::Lists(verlet), _) => verlet.push(*position),
        }
    }

    /// Moves a particle to another cell, or the centre of its list. The lists do not change.
    pub fn relocate(&mut self, particle: u32, place: Place) {
        match (self, place) {
            (Self::Cells(cells), Place::Cell(cell)) => cells.relocate(particle, cell),
            (Self::Lists(verlet), Place::Centre(centre)) => verlet.relocate(particle, centre),
            _ => debug_assert!(false, "a search with cells needs a cell, and a search with lists needs a centre"),
        }
    }

    /// Cells without particles.
    #[must_use]
    pub fn none(space: &Space) -> Self {
        Self::Cells(Cells::new(space, 0.0, &[]))
    }

    #[must_use]
    pub fn search(&self) -> Search {
        match self {
            Self::Cells(_) => Search::Cells,
            Self::Lists(verlet) => Search::Lists { half_skin: verlet.half_skin },
        }
    }

    #[inline]
    #[must_use]
    pub fn verlet(&self) -> Option<&VerletLists> {
        match self {
            Self::Cells(_) => None,
            Self::Lists(verlet) => Some(verlet),
        }
    }

    #[inline]
    #[must_use]
    pub fn lists_mut(&mut self) -> Option<&mut Lists> {
        match self {
            Self::Cells(_) => None,
            Self::Lists(verlet) => Some(&mut verlet.lists),
        }
    }

    /// Finds all particles in the cell of a particle and in the adjacent cells.
    pub fn find_candidates(&self, particle: u32, near: &mut Candidates) {
        match self {
            Self::Cells(cells) => cells.find_candidates(cells.home(particle), near),
            Self::Lists(verlet) => verlet.cells.find_candidates(verlet.home(particle), near),
        }
    }

    /// Finds all particles that could be within the interaction range of a new particle at `position`.
    pub fn find_candidates_at(&self, position: &Vector, near: &mut Candidates) {
        match self {
            Self::Cells(cells) => cells.find_candidates(cells.grid.cell_at(position), near),
            Self::Lists(verlet) => verlet.cells.find_candidates(verlet.cells.home(position), near),
        }
    }

    /// Takes a moving particle out of its cell and out of all lists. Its captured pairs must have been removed.
    pub fn withdraw(&mut self, particle: u32) {
        match self {
            Self::Cells(cells) => cells.lift(particle),
            Self::Lists(verlet) => verlet.withdraw(particle),
        }
    }

    pub fn enlarge(&self) {
        match self {
            Self::Cells(cells) => cells.enlarge(),
            Self::Lists(verlet) => verlet.enlarge(),
        }
    }
}

impl fmt::Display for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cells => f.write_str("cells"),
            Self::Lists { half_skin } => {
                let skin = 2.0 * half_skin;
                let is_plain = (0.1..1e4).contains(&skin) || !skin.is_normal();
                f.write_str("neighbour lists with a skin of ")?;
                if is_plain { write!(f, "{skin:.2}") } else { write!(f, "{skin:.2e}") }
            }
        }
    }
}

/// Number of particles beyond the interaction range that a Verlet list should contain, in one, two and three
/// dimensions. More particles slow down predictions, and fewer cause more rebuilds. The third number was measured in
/// hard-sphere fluids, crystals and square wells. With half or twice this number, runs are about a tenth slower.
const LISTED: [f64; 3] = [1.5, 5.5, 11.0];

/// Largest reach of Verlet lists at which lists are faster than cells, in units of the interaction range. This value is
/// the reach at a packing fraction of 0.36. The measured limit is a packing fraction of 0.35 for 11,000 hard spheres,
/// 0.38 for ten times as many, and a reach of 1.66 for square wells.
const WORTHWHILE: f64 = 1.69;

/// Replaces [`WORTHWHILE`] in boxes with up to three cells along a period, where particles are candidates in several
/// images. It is the reach at a packing fraction of 0.14. The measured limit for ten hard spheres is 0.1 to 0.15.
const WORTHWHILE_IN_SMALL_BOX: f64 = 2.2;

/// The search method changes only if the limit is passed by this fraction.
const HYSTERESIS: f64 = 0.05;

/// The half skin is replaced only if the new value differs from it by at least this fraction.
const DIFFERENT: f64 = 0.3;

/// Up to this number of particles, Verlet lists are cheap even if each list contains all particles.
const FEW: usize = 32;

/// Half skin, in units of the interaction range, for a few particles in a box longer than [`LONG`] ranges. A wide skin
/// avoids rebuilds when particles fly far. But contacts are predicted at distances of up to four half skins, and the
/// error of the overlap function grows with the square of this distance. The largest error is about `1e5` ulp.
const WIDE: f64 = 100.0;
const LONG: f64 = 1e4;

/// The half skin is at most this fraction of the largest half skin that the box allows.
const WITHIN: f64 = 0.95;

/// Smallest half skin as a fraction of the interaction range.
const THINNEST: f64 = 0.08;

impl Search {
    /// Chooses the search method at the start of a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        if !ImagePolicy::stay(scene) {
            // Verlet lists do not support the sliding images of sheared boxes.
            return Self::Cells;
        }
        let positions = || scene.particles.iter().map(|particle| particle.position);
        let species = |index: usize| SpeciesId(id(index));
        let ranges = scene.table.iter().map(|([a, b], _)| scene.range(species(a), species(b)));
        let range = ranges.fold(0.0, f64::max);
        Self::choose_among(&scene.space, range, positions, None)
    }

    /// Chooses the search method for particles at `positions` that interact up to a distance `range`. The
    /// `current` method is kept if the density is close to the limit between the methods.
    #[must_use]
    pub fn choose(space: &Space, range: f64, positions: &[Vector], current: Option<Self>) -> Self {
        Self::choose_among(space, range, || positions.iter().copied(), current)
    }

    pub(super) fn choose_among<I: Iterator<Item = Vector>>(
        space: &Space,
        range: f64,
        positions: impl Fn() -> I,
        current: Option<Self>,
    ) -> Self {
        let widest = VerletLists::widest_half_skin(space, range);
        if positions().count() <= FEW && range > 0.0 && range < widest {
            let is_long = (0..3).all(|k| space.boundary[k] == Boundary::Flat || space.size[k] >= LONG * range);
            return Self::Lists { half_skin: if is_long { WIDE * range } else { range } };
        }
        let reach = reach_of_lists(space, range, local_density(space, range, &positions));
        // Even a thin skin, as in a small box, is better than testing all images of all particles.
        let half_skin = (0.5 * (reach - range)).min(WITHIN * widest).max(THINNEST * range);
        // Without particles or a range, the reach is NaN, and cells are chosen.
        if !(reach < worthwhile(space, range, current) * range && half_skin < widest) {
            return Self::Cells;
        }
        match current {
            Some(Self::Lists { half_skin: old }) if (half_skin - old).abs() < DIFFERENT * old && old < widest => {
                Self::Lists { half_skin: old }
            }
            _ => Self::Lists { half_skin },
        }
    }
}

/// Returns the reach `[length]` at which Verlet lists are fastest, for a given number density.
fn reach_of_lists(space: &Space, range: f64, density: f64) -> f64 {
    let dimensions = space.dimensions();
    let volume = LISTED[dimensions - 1] / density;
    match dimensions {
        3 => libm::cbrt(range * range * range + volume / (4.0 / 3.0 * std::f64::consts::PI)),
        2 => (range * range + volume / std::f64::consts::PI).sqrt(),
        _ => range + 0.5 * volume,
    }
}

/// Returns the largest reach, in units of the interaction range, at which lists are chosen.
fn worthwhile(space: &Space, range: f64, current: Option<Search>) -> f64 {
    let has_few_cells = (0..3).any(|k| space.boundary[k] == Boundary::Periodic && space.size[k] < 4.0 * range);
    let worthwhile = if has_few_cells { WORTHWHILE_IN_SMALL_BOX } else { WORTHWHILE };
    match current {
        None => worthwhile,
        Some(Search::Cells) => worthwhile * (1.0 - HYSTERESIS),
        Some(Search::Lists { .. }) => worthwhile * (1.0 + HYSTERESIS),
    }
}

/// Mean number density around particles `[length^-dimensions]`. Empty parts of the box do not count.
fn local_density<I: Iterator<Item = Vector>>(space: &Space, range: f64, positions: impl Fn() -> I) -> f64 {
    /// Mean number of particles per cell. A single particle then hardly changes the density.
    const MANY: f64 = 32.0;
    let extent = |k: usize| (space.boundary[k] != Boundary::Flat).then_some(space.size[k]);
    let volume: f64 = (0..3).filter_map(extent).product();
    let mut density = positions().count() as f64 / volume;
    // If part of the box is empty, the first cells are too large. Each pass uses the density of the previous pass.
    for _ in 0..3 {
        let fair = libm::pow(MANY / density, 1.0 / space.dimensions() as f64).max(2.0 * range);
        density = density_in_cells(space, fair, &positions);
    }
    density
}

/// Returns the mean number density around particles, from counts in cells with sides of about `fair`.
fn density_in_cells<I: Iterator<Item = Vector>>(space: &Space, fair: f64, positions: impl Fn() -> I) -> f64 {
    /// Up to this number of cells, or of particles, counts are stored in a dense array.
    const SOME: usize = 4096;
    let extent = |k: usize| (space.boundary[k] != Boundary::Flat).then_some(space.size[k]);
    let along = |k: usize| extent(k).map_or(1.0, |size| (size / fair).floor().max(1.0));
    let side = Vector::from_fn(|k, _| extent(k).map_or(f64::INFINITY, |size| size / along(k)));
    let cell_of = |position: &Vector| -> [i32; 3] {
        std::array::from_fn(|k| trunc_to_i32(((position[k] - space.lower[k]) / side[k]).floor()))
    };
    let cells: f64 = (0..3).map(along).product();
    let are_few = cells <= positions().count().max(SOME) as f64;
    let numbers: [usize; 3] = std::array::from_fn(|k| if are_few { trunc_to_usize(along(k)) } else { 0 });
    let mut counts = vec![0_u32; numbers.iter().product()];
    let mut elsewhere = Vec::new();
    for position in positions() {
        let cell = cell_of(&position);
        let [x, y, z] = cell.map(|index| usize::try_from(index).unwrap_or(usize::MAX));
        if x < numbers[0] && y < numbers[1] && z < numbers[2] {
            counts[(z * numbers[1] + y) * numbers[0] + x] += 1;
        } else {
            elsewhere.push(cell);
        }
    }
    elsewhere.sort_unstable();
    let cell: f64 = side.iter().filter(|side| side.is_finite()).product();
    let others = elsewhere.chunk_by(|a, b| a == b).map(|same| same.len() as f64);
    // The sums are exact in any order, because all terms are integers.
    let (mut squares, mut all) = (0.0, 0.0);
    for n in counts.into_iter().map(f64::from).chain(others) {
        (squares, all) = (squares + n * n, all + n);
    }
    squares / all / cell
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: u32, spacing: f64) -> (Space, Vec<Vector>) {
        let at = |k: u32| (f64::from(k) + 0.5) * spacing;
        let positions = (0..n * n * n).map(|k| Vector::new(at(k % n), at(k / n % n), at(k / n / n))).collect();
        (Space::periodic_cube(f64::from(n) * spacing), positions)
    }

    #[test]
    fn a_dense_system_has_lists_and_a_thin_or_small_one_cells() {
        let choose = |n, spacing: f64| {
            let (space, positions) = lattice(n, spacing);
            Search::choose(&space, 1.0, &positions, None)
        };
        assert!(
            matches!(choose(12, 1.0), Search::Lists { half_skin } if (0.2..0.3).contains(&half_skin)),
            "{:?}",
            choose(12, 1.0)
        );
        assert_eq!(choose(12, 1.5), Search::Cells);
        assert_eq!(choose(2, 1.2), Search::Cells);
        assert_eq!(Search::choose(&Space::periodic_cube(9.0), 1.0, &[], None), Search::Cells);
    }

    #[test]
    fn few_particles_in_long_box_use_lists_with_wide_skin() {
        let at = [Vector::repeat(1.0), Vector::repeat(3.0)];
        for (size, half_skin) in [(20.0, 1.0), (9e3, 1.0), (1e4, WIDE), (1e9, WIDE)] {
            let mut space = Space::periodic_cube(size);
            assert_eq!(Search::choose(&space, 1.0, &at, None), Search::Lists { half_skin });
            space.size.x = 1e9;
            assert_eq!(Search::choose(&space, 1.0, &at, None), Search::Lists { half_skin });
        }
    }

    #[test]
    fn a_small_box_has_lists_with_a_skin_that_fits() {
        for (n, spacing) in [(3, 1.0), (3, 1.3), (2, 1.5), (4, 1.0)] {
            let (space, positions) = lattice(n, spacing);
            let chosen = Search::choose(&space, 1.0, &positions, None);
            let Search::Lists { half_skin } = chosen else { panic!("{n} {spacing}") };
            assert!(half_skin >= THINNEST && space.size[0] > 2.0 * (1.0 + 4.0 * half_skin), "{half_skin}");
            assert_eq!(Search::choose(&space, 1.0, &positions, Some(chosen)), chosen);
            // A skin that is too thick for the box is replaced, even if the change is small.
            let wider = Search::Lists { half_skin: 1.1 * half_skin };
            assert_eq!(Search::choose(&space, 1.0, &positions, Some(wider)), chosen);
        }
    }

    #[test]
    fn local_density_ignores_empty_parts_of_the_box() {
        let (mut space, positions) = lattice(12, 1.0);
        assert!((local_density(&space, 1.0, || positions.iter().copied()) - 1.0).abs() < 0.1);
        space.size *= 4.0;
        assert!((local_density(&space, 1.0, || positions.iter().copied()) - 1.0).abs() < 0.3);
    }

    #[test]
    fn a_search_changes_only_with_the_density() {
        let (space, positions) = lattice(12, 1.0);
        let first = Search::choose(&space, 1.0, &positions, None);
        assert_eq!(Search::choose(&space, 1.0, &positions, Some(first)), first);
        let (space, wider) = lattice(12, 1.02);
        assert_eq!(Search::choose(&space, 1.0, &wider, Some(first)), first);
        let (space, far) = lattice(12, 1.9);
        assert_eq!(Search::choose(&space, 1.0, &far, Some(first)), Search::Cells);
    }

    #[test]
    fn skin_is_printed_with_two_digits_in_any_unit() {
        let skin = |skin: f64| Search::Lists { half_skin: 0.5 * skin }.to_string();
        assert_eq!(skin(0.256), "neighbour lists with a skin of 0.26");
        assert_eq!(skin(2.56e-6), "neighbour lists with a skin of 2.56e-6");
        assert_eq!(skin(2.56e7), "neighbour lists with a skin of 2.56e7");
    }
}
