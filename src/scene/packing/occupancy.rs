//! Overlap search during insertion: the particles placed so far, in hashed grids of cells.

use crate::Vector;
use crate::base::numbers::{id, trunc_to_i64};
use crate::model::space::{Boundary, Space, minimum_image};
use crate::model::species_pairs::SpeciesPairs;

/// The distances that the cores of each two species keep `[length]`; 0 where they have none.
#[derive(Debug, Clone)]
pub(crate) struct Contacts(SpeciesPairs<f64>);

impl Contacts {
    pub(crate) fn of(pairs: SpeciesPairs<f64>) -> Self {
        Self(pairs)
    }

    #[cfg(test)]
    pub(crate) fn new(species: usize) -> Self {
        Self(SpeciesPairs::new(species))
    }

    #[cfg(test)]
    pub(crate) fn set(&mut self, a: usize, b: usize, distance: f64) {
        self.0.set(a, b, distance);
    }

    #[inline]
    pub(crate) fn get(&self, a: usize, b: usize) -> f64 {
        self.0.get(a, b).unwrap_or(0.0)
    }

    /// Those that are not 0, each once.
    pub(crate) fn iter(&self) -> impl Iterator<Item = ([usize; 2], f64)> + '_ {
        self.0.iter()
    }

    /// The same distances, all times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self(self.0.map(|distance| Some(distance * factor)))
    }

    pub(crate) fn largest(&self) -> f64 {
        self.iter().map(|(_, distance)| distance).fold(0.0, f64::max)
    }
}

/// Two particles closer than their cores allow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overlapping {
    pub other: u32,
    pub distance: f64,
    pub contact: f64,
}

/// Offsets to the cells around one, nearest first: the likeliest to hold an overlap, where most random attempts end.
const NEIGHBOURS: [[i64; 3]; 27] = neighbours();

const fn neighbours() -> [[i64; 3]; 27] {
    let mut sorted = [[0; 3]; 27];
    let (mut count, mut distance) = (0, 0);
    while distance <= 3 {
        let mut k = 0;
        while k < 27 {
            let offset = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            if offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2] == distance {
                sorted[count] = offset;
                count += 1;
            }
            k += 1;
        }
        distance += 1;
    }
    sorted
}

/// Marks the end of a cell's list.
const NONE: u32 = u32::MAX;

/// Particles whose shortest contacts differ by less than this factor share a grid; those of a coarser one are too many for a small particle
/// to look at, and cells of a finer one for a large particle.
const COARSER: f64 = 8.0;

/// Room for this many particles in a grid at first, where there are several.
const FIRST: usize = 64;

/// The particles placed so far, in hashed grids of cells, a coarse one for large particles and finer ones for smaller ones.
///
/// Cells are a hash table of linked lists: the memory follows the number of particles, however far apart they are.
pub(crate) struct Occupancy<'a> {
    contacts: &'a Contacts,
    /// The grid of each species, coarsest first; none for those that touch nothing.
    grid_of: Vec<Option<usize>>,
    grids: Vec<Grid<'a>>,
    taken: Vec<(Vector, u32)>,
}

/// The particles of one grid.
struct Grid<'a> {
    space: &'a Space,
    periods: Vector,
    edge: Vector,
    /// Number of cells around a periodic axis, 0 elsewhere.
    around: [i64; 3],
    /// Steps to the neighbouring cells per axis.
    reach: [i64; 3],
    /// Longest contact of each species with those in the grid.
    ranges: Vec<f64>,
    /// Contacts up to this long are found in neighbouring cells.
    finest: f64,
    heads: Vec<u32>,
    /// Next of the same list, and which of the taken ones it is.
    entries: Vec<(u32, u32)>,
}

/// Particles in contact may be closer than their core by the rounding of their coordinates: a few units in the last
/// place of the coordinate, of which each separation has two per axis.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

impl<'a> Occupancy<'a> {
    /// Room for `capacity` particles.
    pub(crate) fn new(space: &'a Space, contacts: &'a Contacts, capacity: usize) -> Self {
        let species = contacts.iter().map(|([_, b], _)| b + 1).max().unwrap_or(0);
        // The shortest contact is a measure of size: the longest of a small particle is that with a large one.
        let mut shortest = vec![f64::INFINITY; species];
        for ([a, b], contact) in contacts.iter().filter(|(_, contact)| *contact > 0.0) {
            shortest[a] = shortest[a].min(contact);
            shortest[b] = shortest[b].min(contact);
        }
        let largest = contacts.largest();
        let size_of = |shortest: f64| {
            shortest.is_finite().then(|| (libm::log2(largest / shortest) / libm::log2(COARSER)).floor())
        };
        let mut sizes: Vec<f64> = shortest.iter().copied().filter_map(size_of).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        sizes.dedup();
        let grid_of: Vec<Option<usize>> = shortest
            .iter()
            .map(|&shortest| size_of(shortest).and_then(|size| sizes.iter().position(|other| *other == size)))
            .collect();
        let capacity = if sizes.len() == 1 { capacity } else { capacity.min(FIRST) };
        let mut ranges = vec![vec![0.0_f64; species]; sizes.len()];
        for ([a, b], contact) in contacts.iter() {
            for (one, other) in [(a, b), (b, a)] {
                if let Some(grid) = grid_of[other] {
                    ranges[grid][one] = ranges[grid][one].max(contact);
                }
            }
        }
        let grids = ranges.into_iter().enumerate().map(|(number, ranges)| {
            let own = (0..species).filter(|&species| grid_of[species] == Some(number)).map(|species| ranges[species]);
            // In a grid whose particles touch only larger ones, any size will do.
            let cell = Some(own.fold(0.0, f64::max)).filter(|cell| *cell > 0.0).unwrap_or(largest);
            Grid::new(space, cell, ranges, capacity)
        });
        Self { contacts, grids: grids.collect(), grid_of, taken: Vec::with_capacity(capacity) }
    }

    /// Takes a place. The particle's number is how many were taken before it.
    pub(crate) fn take(&mut self, position: Vector, species: u32) {
        let number = id(self.taken.len());
        self.taken.push((position, species));
        if let Some(Some(grid)) = self.grid_of.get(species as usize) {
            self.grids[*grid].take(number, &self.taken);
        }
    }

    /// The first overlap of a particle here with one that was taken and for which `counts` holds.
    pub(crate) fn overlap(&self, position: &Vector, species: u32, counts: impl Fn(u32) -> bool) -> Option<Overlapping> {
        let is_overlap = |other: u32, periods: &Vector| {
            let (there, its_species) = &self.taken[other as usize];
            let contact = self.contacts.get(species as usize, *its_species as usize);
            let separation = minimum_image(position - there, periods);
            if separation.norm_squared() < contact * contact {
                let distance = separation.norm();
                let rounding = ROUNDING * (position.amax() + there.amax() + contact);
                if distance < contact - rounding && counts(other) {
                    return Some(Overlapping { other, distance, contact });
                }
            }
            None
        };
        self.grids.iter().find_map(|grid| {
            let range = grid.ranges.get(species as usize).copied().unwrap_or(0.0);
            if range > 0.0 { grid.find(position, range, |other| is_overlap(other, &grid.periods)) } else { None }
        })
    }
}

impl<'a> Grid<'a> {
    /// Cells for contacts of at least `cell`.
    fn new(space: &'a Space, cell: f64, ranges: Vec<f64>, capacity: usize) -> Self {
        let mut edge = Vector::repeat(cell);
        let (mut around, mut reach) = ([0; 3], [1; 3]);
        for k in 0..3 {
            match space.boundary[k] {
                Boundary::Flat => reach[k] = 0,
                Boundary::Periodic => {
                    let cells = (space.size[k] / cell).floor().clamp(1.0, f64::from(1_u32 << 30));
                    edge[k] = space.size[k] / cells;
                    around[k] = trunc_to_i64(cells);
                    reach[k] = i64::from(cells > 1.0);
                }
                Boundary::Bounded { .. } => {}
            }
        }
        Self {
            space,
            periods: space.periods(),
            edge,
            around,
            reach,
            ranges,
            finest: cell,
            heads: vec![NONE; (2 * capacity.max(8)).next_power_of_two()],
            entries: Vec::with_capacity(capacity),
        }
    }

    /// Takes the place of the particle `number` of `taken`.
    fn take(&mut self, number: u32, taken: &[(Vector, u32)]) {
        self.entries.push((NONE, number));
        if 2 * self.entries.len() <= self.heads.len() {
            self.link(self.entries.len() - 1, taken);
            return;
        }
        self.heads = vec![NONE; 2 * self.heads.len()];
        (0..self.entries.len()).for_each(|entry| self.link(entry, taken));
    }

    fn link(&mut self, entry: usize, taken: &[(Vector, u32)]) {
        let (position, _) = &taken[self.entries[entry].1 as usize];
        let bucket = self.bucket(self.cell(position));
        self.entries[entry].0 = self.heads[bucket];
        self.heads[bucket] = id(entry);
    }

    /// The first of what `found` gives for those within `range` of a position; it is also asked for others.
    fn find<T>(&self, position: &Vector, range: f64, found: impl Fn(u32) -> Option<T>) -> Option<T> {
        if range > self.finest {
            return self.find_far(position, range, found);
        }
        let cell = self.cell(position);
        // How far the position is from the lower side of its cell, as a part of the edge.
        let within = self.within(position);
        // A little more than the longest contact, for the rounding of the place within a cell.
        let longest_squared = range * range * (1.0 + 1e-6);
        for offset in &NEIGHBOURS {
            let mut squared = 0.0;
            let mut is_reached = true;
            for k in 0..3 {
                let away = match offset[k] {
                    0 => 0.0,
                    1 => 1.0 - within[k],
                    _ => within[k],
                } * self.edge[k];
                squared += away * away;
                is_reached &= offset[k].abs() <= self.reach[k];
            }
            // A cell that is out of reach of the longest contact holds no overlap.
            if !is_reached || squared > longest_squared {
                continue;
            }
            let neighbour = [0, 1, 2].map(|k| cell[k].wrapping_add(offset[k]));
            let first = self.find_in(self.wrap(neighbour), &found);
            if first.is_some() {
                return first;
            }
        }
        None
    }

    /// The same where more than the neighbouring cells are within range: all of those, or all particles if they are fewer.
    fn find_far<T>(&self, position: &Vector, range: f64, found: impl Fn(u32) -> Option<T>) -> Option<T> {
        let steps = [0, 1, 2].map(|k| if self.reach[k] == 0 { 0.0 } else { (range / self.edge[k]).ceil() + 1.0 });
        let cells: f64 = steps.iter().map(|steps| 2.0 * steps + 1.0).product();
        if cells > self.entries.len() as f64 {
            return self.entries.iter().find_map(|(_, number)| found(*number));
        }
        let cell = self.cell(position);
        let steps = steps.map(trunc_to_i64);
        let along = |k: usize| -steps[k]..=steps[k];
        along(0).flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z]))).find_map(|offset| {
            let there = [0, 1, 2].map(|k| cell[k].wrapping_add(offset[k]));
            self.find_in(self.wrap(there), &found)
        })
    }

    fn within(&self, position: &Vector) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let along = (position[k] - self.space.lower[k]) / self.edge[k];
            along - along.floor()
        })
    }

    fn find_in<T>(&self, cell: [i64; 3], found: &impl Fn(u32) -> Option<T>) -> Option<T> {
        let mut entry = self.heads[self.bucket(cell)];
        while entry != NONE {
            let (next, number) = self.entries[entry as usize];
            let first = found(number);
            if first.is_some() {
                return first;
            }
            entry = next;
        }
        None
    }

    fn cell(&self, position: &Vector) -> [i64; 3] {
        let along = |k: usize| trunc_to_i64(((position[k] - self.space.lower[k]) / self.edge[k]).floor());
        self.wrap([along(0), along(1), along(2)])
    }

    fn wrap(&self, mut cell: [i64; 3]) -> [i64; 3] {
        for (index, &around) in cell.iter_mut().zip(&self.around) {
            if around > 0 && !(0..around).contains(index) {
                *index = index.rem_euclid(around);
            }
        }
        cell
    }

    /// Neighbours along x share cache lines; two cells in one bucket only cost time.
    fn bucket(&self, [x, y, z]: [i64; 3]) -> usize {
        let key = x.wrapping_add(y.wrapping_mul(8_191)).wrapping_add(z.wrapping_mul(67_867_967));
        #[expect(clippy::cast_possible_truncation, reason = "the lowest bits of a hash")]
        let hash = key as u64 as usize;
        hash & (self.heads.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::random::{Purpose, Random};

    #[test]
    fn overlaps_are_those_of_a_search_over_all_pairs() {
        let mut contacts = Contacts::new(2);
        contacts.set(0, 0, 1.0);
        contacts.set(0, 1, 0.7);
        let mut random = Random::new(5, Purpose::Placement, 0);
        for boundary in [Boundary::Periodic, Boundary::OPEN] {
            for length in [2.5, 5.0] {
                let mut space = Space::periodic_cube(length);
                space.boundary[1] = boundary;
                // Few at a time: among many, another overlap would hide one that is missed.
                for _ in 0..2000 {
                    let mut occupancy = Occupancy::new(&space, &contacts, 3);
                    let mut taken: Vec<(Vector, u32)> = Vec::new();
                    for _ in 0..3 {
                        let position = Vector::from_fn(|_, _| length * random.uniform());
                        let species = id(random.below(2));
                        let expected = taken.iter().any(|(there, other)| {
                            minimum_image(position - there, &space.periods()).norm()
                                < contacts.get(species as usize, *other as usize)
                        });
                        assert_eq!(occupancy.overlap(&position, species, |_| true).is_some(), expected);
                        occupancy.take(position, species);
                        taken.push((position, species));
                    }
                }
            }
        }
    }

    #[test]
    fn sizes_that_differ_a_thousandfold_are_searched_in_grids_of_their_own() {
        let mut contacts = Contacts::new(4);
        for (a, b, contact) in [(0, 0, 0.02), (0, 1, 1.01), (1, 1, 2.0), (0, 2, 0.3), (1, 2, 1.1)] {
            contacts.set(a, b, contact);
        }
        let mut random = Random::new(6, Purpose::Placement, 0);
        for boundary in [Boundary::Periodic, Boundary::OPEN] {
            let mut space = Space::periodic_cube(4.5);
            space.boundary[2] = boundary;
            let mut found = 0;
            for _ in 0..300 {
                let mut occupancy = Occupancy::new(&space, &contacts, 300);
                let mut taken: Vec<(Vector, u32)> = Vec::new();
                // The order of sizes is any, and many are small.
                for _ in 0..300 {
                    let position = Vector::from_fn(|_, _| 4.5 * random.uniform());
                    let species = [0, 0, 0, 0, 2, 3, 1][random.below(7)];
                    let overlaps = |(there, other): &(Vector, u32)| {
                        let contact = contacts.get(species as usize, *other as usize);
                        minimum_image(position - there, &space.periods()).norm() < contact
                    };
                    let expected: Vec<u32> =
                        (0..).zip(&taken).filter(|(_, taken)| overlaps(taken)).map(|(number, _)| number).collect();
                    let overlap = occupancy.overlap(&position, species, |_| true);
                    assert_eq!(overlap.is_some(), !expected.is_empty());
                    assert!(overlap.is_none_or(|overlap| expected.contains(&overlap.other)));
                    found += expected.len();
                    // Nearly all that overlap are left out, so that none hides another.
                    if expected.is_empty() || random.below(10) == 0 {
                        occupancy.take(position, species);
                        taken.push((position, species));
                    }
                }
            }
            assert!(found > 1000, "{found}");
        }
    }

    #[test]
    fn a_small_particle_is_held_against_few_others_among_large_ones() {
        let mut contacts = Contacts::new(2);
        contacts.set(0, 0, 1.0);
        contacts.set(0, 1, 500.5);
        contacts.set(1, 1, 1000.0);
        let space = Space::periodic_cube(4000.0);
        let mut random = Random::new(7, Purpose::Placement, 0);
        let mut occupancy = Occupancy::new(&space, &contacts, 10_000);
        for _ in 0..10_000 {
            occupancy.take(Vector::from_fn(|_, _| 4000.0 * random.uniform()), 0);
        }
        let asked = std::cell::Cell::new(0);
        let grid = &occupancy.grids[occupancy.grid_of[0].unwrap()];
        let _ = grid.find(&Vector::repeat(2000.0), 1.0, |_| {
            asked.set(asked.get() + 1);
            None::<()>
        });
        assert!(asked.get() < 100, "{}", asked.get());
    }

    #[test]
    fn contact_is_not_an_overlap_but_a_gap_beyond_rounding_is() {
        let mut contacts = Contacts::new(1);
        contacts.set(0, 0, 1.0);
        let space = Space::periodic_cube(10.0);
        let mut occupancy = Occupancy::new(&space, &contacts, 1);
        occupancy.take(Vector::repeat(0.3), 0);
        let at = |x: f64| occupancy.overlap(&Vector::new(x, 0.3, 0.3), 0, |_| true);
        assert_eq!(at(1.3_f64.next_down()), None);
        assert!(at(1.3 - 1e-12).is_some());
        assert!(at(9.4).is_some(), "across the periodic side");
        assert_eq!(at(9.2), None);
    }

    #[test]
    fn particles_at_the_ends_of_the_world_are_no_trouble() {
        let mut contacts = Contacts::new(1);
        contacts.set(0, 0, 1.0);
        let mut space = Space::periodic_cube(1.0);
        space.boundary = [Boundary::OPEN; 3];
        let mut occupancy = Occupancy::new(&space, &contacts, 1);
        occupancy.take(Vector::new(1e300, -1e300, 0.0), 0);
        assert!(occupancy.overlap(&Vector::zeros(), 0, |_| true).is_none());
    }
}
