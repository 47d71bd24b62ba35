//! Which places are taken: particles in a hashed grid of cells, asked for overlaps.

use crate::Vector;
use crate::scene::pairs::SpeciesPairs;
use crate::space::{Boundary, Space, minimum_image};

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

/// Cells as a hash table of linked lists: the memory follows the number of particles, however far apart they are.
pub(crate) struct Occupancy<'a> {
    space: &'a Space,
    contacts: &'a Contacts,
    periods: Vector,
    edge: Vector,
    /// Number of cells around a periodic axis, 0 elsewhere.
    around: [i64; 3],
    /// Steps to the neighbouring cells per axis.
    reach: [i64; 3],
    longest_squared: f64,
    heads: Vec<u32>,
    next: Vec<u32>,
    taken: Vec<(Vector, u32)>,
}

/// Particles in contact may be closer than their core by the rounding of their coordinates: a few units in the last
/// place of the coordinate, of which each separation has two per axis.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

impl<'a> Occupancy<'a> {
    /// Room for `capacity` particles.
    pub(crate) fn new(space: &'a Space, contacts: &'a Contacts, capacity: usize) -> Self {
        let cell = match contacts.largest() {
            0.0 => 1.0,
            contact => contact,
        };
        let mut edge = Vector::repeat(cell);
        let (mut around, mut reach) = ([0; 3], [1; 3]);
        for k in 0..3 {
            match space.boundary[k] {
                Boundary::Flat => reach[k] = 0,
                Boundary::Periodic => {
                    let cells = (space.size[k] / cell).floor().clamp(1.0, f64::from(1_u32 << 30));
                    edge[k] = space.size[k] / cells;
                    around[k] = cells as i64;
                    reach[k] = i64::from(cells > 1.0);
                }
                Boundary::Bounded { .. } => {}
            }
        }
        let buckets = (2 * capacity.max(8)).next_power_of_two();
        Self {
            space,
            contacts,
            periods: space.periods(),
            edge,
            around,
            reach,
            // A little more than the longest contact, for the rounding of the place within a cell.
            longest_squared: cell * cell * (1.0 + 1e-6),
            heads: vec![NONE; buckets],
            next: Vec::with_capacity(capacity),
            taken: Vec::with_capacity(capacity),
        }
    }

    /// Takes a place. The particle's number is how many were taken before it.
    pub(crate) fn take(&mut self, position: Vector, species: u32) {
        let bucket = self.bucket(self.cell(&position));
        self.next.push(self.heads[bucket]);
        self.heads[bucket] = self.taken.len() as u32;
        self.taken.push((position, species));
    }

    /// The first overlap of a particle here with one that was taken and for which `counts` holds.
    pub(crate) fn overlap(&self, position: &Vector, species: u32, counts: impl Fn(u32) -> bool) -> Option<Overlapping> {
        let cell = self.cell(position);
        // How far the position is from the lower side of its cell, as a part of the edge.
        let within = self.within(position);
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
            if !is_reached || squared > self.longest_squared {
                continue;
            }
            let neighbour = [0, 1, 2].map(|k| cell[k].wrapping_add(offset[k]));
            let found = self.overlap_in(self.wrap(neighbour), position, species, &counts);
            if found.is_some() {
                return found;
            }
        }
        None
    }

    fn within(&self, position: &Vector) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let along = (position[k] - self.space.lower[k]) / self.edge[k];
            along - along.floor()
        })
    }

    fn overlap_in(
        &self,
        cell: [i64; 3],
        position: &Vector,
        species: u32,
        counts: &impl Fn(u32) -> bool,
    ) -> Option<Overlapping> {
        let mut other = self.heads[self.bucket(cell)];
        while other != NONE {
            let (there, its_species) = &self.taken[other as usize];
            let contact = self.contacts.get(species as usize, *its_species as usize);
            let separation = minimum_image(position - there, &self.periods);
            if separation.norm_squared() < contact * contact {
                let distance = separation.norm();
                let rounding = ROUNDING * (position.amax() + there.amax() + contact);
                if distance < contact - rounding && counts(other) {
                    return Some(Overlapping { other, distance, contact });
                }
            }
            other = self.next[other as usize];
        }
        None
    }

    fn cell(&self, position: &Vector) -> [i64; 3] {
        let along = |k: usize| ((position[k] - self.space.lower[k]) / self.edge[k]).floor() as i64;
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
        key as u64 as usize & (self.heads.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::random::{Purpose, Random};

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
                        let species = random.below(2) as u32;
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
