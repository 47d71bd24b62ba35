//! Search for overlaps with hashed grids of cells, during insertion or in a complete initial state.

mod contacts;
mod grid;

pub(crate) use contacts::{Contacts, Kind};

use self::grid::{Grid, Taken};
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::CellList;
use crate::engine::surfaces::{Surface, Surfaces};
use crate::model::Particle;
use crate::model::space::{Boundary, Space, minimum_image};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overlapping {
    pub other: u32,
    pub distance: f64,
    pub contact: f64,
}

/// Largest ratio of particle sizes in one grid. Small particles have too many candidates in a coarse grid, and large
/// particles search too many cells in a fine grid.
const COARSER: f64 = 8.0;

const FIRST: usize = 64;

/// The particles placed so far, in hashed grids of cells. Large particles are in a coarse grid, and smaller particles
/// in finer grids. The memory does not depend on the distances between particles.
pub(crate) struct Occupancy<'a> {
    pub space: &'a Space,
    contacts: &'a Contacts,
    /// Index of the grid of each species, coarsest grid first; `None` for species without contacts.
    grid_of: Vec<Option<usize>>,
    grids: Vec<Grid<'a>>,
    taken: Vec<Taken>,
    /// Largest magnitude of a coordinate on a periodic side `[length]`.
    side: f64,
    /// Surfaces that particles must not overlap, and the radius of each species; `None` to check particles only.
    surfaces: Option<(&'a Surfaces, Vec<f64>)>,
}

/// Relative tolerance of overlaps, because coordinates are rounded.
pub(crate) const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Rounding error of the distance between two positions `[length]`. Includes the coarser rounding at the far side of a
/// periodic box, where a particle near coordinate 0 may have been during the contact.
pub(crate) fn rounding(positions: [&Vector; 2], side: f64, contact: f64) -> f64 {
    ROUNDING * (positions[0].amax() + positions[1].amax() + 2.0 * side + contact)
}

impl<'a> Occupancy<'a> {
    pub(crate) fn new(space: &'a Space, contacts: &'a Contacts, capacity: usize) -> Self {
        let species = contacts.iter().map(|([_, b], _)| b + 1).max().unwrap_or(0);
        // The longest contact distance of a small particle may be with a large partner, so the shortest is used.
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
            // If no two particles of a grid can touch each other, any cell size is suitable.
            let cell = Some(own.fold(0.0, f64::max)).filter(|cell| *cell > 0.0).unwrap_or(largest);
            Grid::new(space, cell, ranges, capacity)
        });
        Self {
            space,
            contacts,
            grids: grids.collect(),
            grid_of,
            taken: Vec::with_capacity(capacity),
            side: space.farthest_side(),
            surfaces: None,
        }
    }

    pub(crate) fn among(self, surfaces: &'a Surfaces, radii: Vec<f64>) -> Self {
        Self { surfaces: Some((surfaces, radii)), ..self }
    }

    pub(crate) fn is_free(&self, position: &Vector, kind: &Kind) -> bool {
        self.overlap(position, kind, |_| true).is_none() && !self.reaches_surface(position, kind)
    }

    fn reaches_surface(&self, position: &Vector, kind: &Kind) -> bool {
        let Some((surfaces, radii)) = &self.surfaces else { return false };
        let of_species = radii.get(kind.index()).copied().unwrap_or(0.0);
        let radius = kind.diameter.map_or(of_species, |diameter| 0.5 * diameter);
        let mut reaches = false;
        let row = u16::try_from(kind.index()).unwrap_or(u16::MAX);
        surfaces.for_each_near((position, radius), row, surfaces.start_time(), |surface, position| {
            // Walls of the box need no check: positions are always drawn inside the walls.
            reaches |= surface.shape.side().is_none() && surface.shape.gap(position, radius) < 0.0;
        });
        reaches
    }

    /// Adds a particle. Its index is the number of earlier particles.
    pub(crate) fn take(&mut self, position: Vector, kind: Kind) {
        let number = id(self.taken.len());
        self.taken.push(Taken::new(position, kind));
        if let Some(Some(grid)) = self.grid_of.get(kind.index()) {
            self.grids[*grid].take(number, &mut self.taken);
        }
    }

    pub(crate) fn overlap(&self, position: &Vector, kind: &Kind, counts: impl Fn(u32) -> bool) -> Option<Overlapping> {
        let is_overlap = |other: u32, periods: &Vector| {
            let Taken { position: there, kind: its_kind, .. } = &self.taken[other as usize];
            let contact = self.contacts.between(kind, its_kind);
            let separation = minimum_image(position - there, periods);
            if separation.norm_squared() < contact * contact {
                let distance = separation.norm();
                if distance < contact - rounding([position, there], self.side, contact) && counts(other) {
                    return Some(Overlapping { other, distance, contact });
                }
            }
            None
        };
        self.grids.iter().find_map(|grid| {
            let range = grid.ranges.get(kind.index()).copied().unwrap_or(0.0);
            if range > 0.0 {
                grid.find(&self.taken, position, range, |other| is_overlap(other, &grid.periods))
            } else {
                None
            }
        })
    }
}

/// Returns the first particle whose core overlaps an earlier particle, and the overlap. Bonded pairs are ignored. In a
/// sheared box, the next image along y is displaced along x by `displacement` `[length]`.
pub(crate) fn first_overlap(
    particles: &[Particle],
    contacts: &Contacts,
    space: &Space,
    displacement: f64,
    is_bonded: impl Fn(u32, u32) -> bool,
) -> Option<(u32, Overlapping)> {
    if contacts.largest() == 0.0 {
        return None;
    }
    let side = space.farthest_side();
    let is_overlap = |a: u32, b: u32, distance: f64| {
        let [first, second] = [a, b].map(|id| &particles[id as usize]);
        let contact = contacts.between(&Kind::of(first), &Kind::of(second));
        contact > 0.0
            && distance < contact - rounding([&first.position, &second.position], side, contact)
            && !is_bonded(a.min(b), a.max(b))
    };
    if let Some(cells) = cell_list(particles, contacts, space, displacement)
        && !cells.has_pair(|a, b, _, squared| is_overlap(a, b, squared.sqrt()))
    {
        return None;
    }
    // In a sheared box, the displaced images along y are searched separately, with y as an open axis.
    let mut unstacked = space.clone();
    if displacement != 0.0 {
        unstacked.boundary[1] = Boundary::OPEN;
    }
    let up = Vector::new(displacement, space.size.y, 0.0);
    let images: &[Vector] = if displacement == 0.0 { &[Vector::zeros()] } else { &[Vector::zeros(), up, -up] };
    let mut occupancy = Occupancy::new(&unstacked, contacts, particles.len());
    for (id, particle) in (0..).zip(particles) {
        let (position, kind) = (&particle.position, Kind::of(particle));
        let overlap = |image| occupancy.overlap(&(position + image), &kind, |other| !is_bonded(other, id));
        if let Some(overlapping) = images.iter().find_map(overlap) {
            return Some((id, overlapping));
        }
        occupancy.take(*position, kind);
    }
    None
}

/// Largest ratio of contact distances for a single cell list.
const ALIKE: f64 = 2.0;

/// Returns `None` if the contact distances differ too much, or if a pair could meet through several images.
fn cell_list(particles: &[Particle], contacts: &Contacts, space: &Space, displacement: f64) -> Option<CellList> {
    let largest = contacts.largest();
    let mut touches = vec![false; contacts.iter().map(|([a, b], _)| a.max(b) + 1).max()?];
    contacts.iter().for_each(|(pair, _)| pair.iter().for_each(|&species| touches[species] = true));
    let differs = |species: usize| touches[species] && ALIKE * contacts.get(species, species) < largest;
    if largest > CellList::largest_range(space) || (0..touches.len()).any(differs) {
        return None;
    }
    let is_in_the_way = |it: &Particle| touches.get(it.species.0 as usize) == Some(&true);
    let points = (0..).zip(particles).filter(|(_, it)| is_in_the_way(it)).map(|(id, it)| (id, it.position));
    Some(CellList::new(space, displacement, largest, points))
}

#[cfg(test)]
mod tests;
