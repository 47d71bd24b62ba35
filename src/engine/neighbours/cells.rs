//! A grid of cells no smaller than the longest interaction range, and the particles in each cell.
//!
//! Uncaptured pairs can only meet in the same cell or in adjacent cells. The cell of a particle changes only at a cell
//! transition. It is never recomputed from the position, because round-off may put a position on the wrong side of a
//! face. Along axes that are not periodic, the outermost cells extend to infinity.

mod search;

use super::grid::{CellFace, Grid};
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::array::Array;
use crate::engine::columns::Order;
use crate::engine::hardware::pages::enlarge;
use crate::model::space::Space;
use crate::physics::kinetics::{cross_section, free_path};
use serde::{Deserialize, Serialize};

/// No particle, for example at the end of a list.
pub const NO_PARTICLE: u32 = u32::MAX;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    pub cell: u32,
    /// Number of periods to add to the coordinate: -1, 0 or 1.
    pub wrap: i32,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Cells {
    pub grid: Grid,
    /// First particle of each cell.
    first: Array<u32>,
    /// For each particle, the next particle in the same cell.
    next: Array<u32>,
    homes: Array<u32>,
}

/// Smallest side of a cell, in units of the mean distance of particles, in one, two and three dimensions. Particles
/// leave smaller cells more often, and larger cells hold more candidates. The first value is for dense systems. The
/// second is for thin gases, in which particles fly through many cells between two collisions. The values were measured
/// with hard spheres and disks.
const SIDES: [[f64; 2]; 3] = [[1.0, 1.0], [0.8, 2.0], [0.7, 1.0]];

/// Mean free paths, in units of the mean distance of particles, between which the side of a cell is interpolated. The
/// first value of [`SIDES`] is best for shorter free paths, and the second value for longer ones.
const FREE_PATHS: [f64; 2] = [2.0, 10.0];

/// Maximum number of cells per particle. More cells would cost memory and cause more transitions.
const CELLS_PER_PARTICLE: f64 = 8.0;

/// Returns the smallest sides of cells in one, two and three dimensions, in units of the mean distance of particles.
fn sides(space: &Space, range: f64, particles: usize) -> [f64; 3] {
    let dimensions = space.dimensions();
    let volume: f64 = space.size.iter().filter(|size| **size > 0.0).product();
    let distance = libm::pow(volume / particles as f64, 1.0 / dimensions as f64);
    // Mean free path between hard spheres or disks of this diameter, in units of their mean distance.
    let free_path = free_path(cross_section(range / distance, dimensions));
    let [short, long] = FREE_PATHS;
    let weight = (libm::log(free_path / short) / libm::log(long / short)).clamp(0.0, 1.0);
    SIDES.map(|[fine, wide]| if weight > 0.0 { fine * libm::pow(wide / fine, weight) } else { fine })
}

impl Cells {
    /// Checks data from a file: the sizes of the arrays, and that each particle is only in the list of its cell.
    #[must_use]
    pub fn is_sound(&self, particles: usize) -> bool {
        if !self.grid.is_sound()
            || self.first.len() != self.grid.count()
            || self.next.len() != particles
            || self.homes.len() != particles
            || self.homes.iter().any(|&home| home as usize >= self.first.len())
        {
            return false;
        }
        let mut found = 0;
        for (cell, &first) in (0..).zip(&self.first) {
            let mut particle = first;
            while particle != NO_PARTICLE {
                found += 1;
                if found > particles || self.homes.get(particle as usize) != Some(&cell) {
                    return false;
                }
                particle = self.next[particle as usize];
            }
        }
        found == particles
    }

    /// Creates cells for interactions up to `range` `[length]`, and sorts particles at `positions` into them.
    #[must_use]
    pub fn new(space: &Space, range: f64, positions: &[Vector]) -> Self {
        let grid = Grid::new(space, range, positions, sides(space, range, positions.len()), CELLS_PER_PARTICLE);
        let mut cells = Self {
            first: vec![NO_PARTICLE; grid.count()].into(),
            next: vec![NO_PARTICLE; positions.len()].into(),
            homes: vec![0; positions.len()].into(),
            grid,
        };
        // Inserts in reverse, so that the list of each cell is in ascending order.
        for (index, position) in positions.iter().enumerate().rev() {
            let cell = cells.grid.cell_at(position);
            cells.insert(id(index), cell);
        }
        cells
    }

    /// See [`Array::become_alias`].
    pub fn become_alias(&mut self) {
        for array in [&mut self.first, &mut self.next, &mut self.homes] {
            array.become_alias();
        }
    }

    pub fn enlarge(&self) {
        enlarge(&self.first);
        enlarge(&self.next);
        enlarge(&self.homes);
    }

    pub fn permuted(&self, order: &Order) -> Self {
        if self.homes.is_empty() {
            return self.clone();
        }
        let homes = order.permuted(&self.homes);
        let mut next = Vec::with_capacity(homes.capacity());
        next.resize(homes.len(), NO_PARTICLE);
        let mut first = vec![NO_PARTICLE; self.first.len()];
        for (particle, home) in homes.iter().enumerate().rev() {
            next[particle] = std::mem::replace(&mut first[*home as usize], id(particle));
        }
        Self { grid: self.grid.clone(), first: first.into(), next: next.into(), homes }
    }

    pub fn push(&mut self, cell: u32) {
        let particle = id(self.homes.len());
        self.homes.push(cell);
        self.next.push(NO_PARTICLE);
        self.insert(particle, cell);
    }

    fn insert(&mut self, particle: u32, cell: u32) {
        self.homes[particle as usize] = cell;
        self.next[particle as usize] = self.first[cell as usize];
        self.first[cell as usize] = particle;
    }

    fn remove(&mut self, particle: u32, cell: u32) {
        let after = self.next[particle as usize];
        let mut at = self.first[cell as usize];
        if at == particle {
            self.first[cell as usize] = after;
            return;
        }
        while self.next[at as usize] != particle {
            at = self.next[at as usize];
        }
        self.next[at as usize] = after;
    }

    /// Takes a particle out of its cell. It stays in the array of homes.
    pub fn lift(&mut self, particle: u32) {
        self.remove(particle, self.home(particle));
        self.next[particle as usize] = NO_PARTICLE;
    }

    #[inline]
    #[must_use]
    pub fn home(&self, particle: u32) -> u32 {
        self.homes[particle as usize]
    }

    pub fn relocate(&mut self, particle: u32, to: u32) {
        let from = self.home(particle);
        if to != from {
            self.remove(particle, from);
            self.insert(particle, to);
        }
    }

    /// Returns true if a particle that leaves its cell through a face crosses a periodic boundary.
    #[must_use]
    pub fn wraps_behind(&self, particle: u32, face: CellFace) -> bool {
        self.grid.behind(self.home(particle), face).is_some_and(|(_, wrap)| wrap != 0)
    }

    #[must_use]
    pub fn is_outermost(&self, cell: u32, axis: usize) -> bool {
        self.grid.is_outermost(cell, axis).contains(&true)
    }

    /// Moves a particle that has crossed a sliding side to the first or last row of cells along the gradient. The cell
    /// along the flow follows from `position`.
    pub fn slide_in(&mut self, particle: u32, position: &Vector, [flow, gradient]: [usize; 2], is_last: bool) {
        let to = self.grid.slid(self.home(particle), self.grid.cell_at(position), [flow, gradient], is_last);
        self.relocate(particle, to);
    }

    /// Calls `visit` for the particles across the sliding side next to a cell. `axes` are the flow and the gradient.
    pub fn for_each_across(&self, cell: u32, axes: [usize; 2], mut visit: impl FnMut(u32)) {
        self.grid.for_each_across(cell, axes, |across| {
            let mut at = self.first[across as usize];
            while at != NO_PARTICLE {
                visit(at);
                at = self.next[at as usize];
            }
        });
    }

    #[inline]
    pub fn cross(&mut self, particle: u32, face: CellFace) -> Option<Transition> {
        let (to, wrap) = self.grid.behind(self.home(particle), face)?;
        self.relocate(particle, to);
        Some(Transition { cell: to, wrap })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::neighbours::candidates::Candidates;
    use crate::model::space::Boundary;

    fn near(grid: &Cells, cell: u32) -> Vec<u32> {
        let mut near = Candidates::default();
        grid.find_candidates(cell, &mut near);
        let mut found = near.found().to_vec();
        found.sort_unstable();
        found
    }

    fn lattice(n: u32) -> (Space, Vec<Vector>) {
        let at = |k: u32| f64::from(k) + 0.5;
        let positions = (0..n * n * n).map(|k| Vector::new(at(k % n), at(k / n % n), at(k / n / n))).collect();
        (Space::periodic_cube(f64::from(n)), positions)
    }

    #[test]
    fn cells_are_wider_where_particles_fly_far_between_collisions() {
        // The mean free path of a hard-sphere gas is `sigma / (6 sqrt(2) phi)`.
        let volume = |phi: f64| 1000.0 * std::f64::consts::FRAC_PI_6 / phi;
        let of_gas = |phi: f64| sides(&Space::periodic_cube(libm::cbrt(volume(phi))), 1.0, 1000)[2];
        assert_eq!([of_gas(0.3), of_gas(0.02)], [0.7, 0.7]);
        assert_eq!([of_gas(1e-3), of_gas(1e-8)], [1.0, 1.0]);
        assert!((0.75..0.95).contains(&of_gas(4e-3)), "{}", of_gas(4e-3));
        let square = |size: f64| Space {
            size: Vector::new(size, size, 0.0),
            boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::Flat],
            ..Space::periodic_cube(1.0)
        };
        let of_disks = |size: f64| sides(&square(size), 1.0, 1000)[1];
        assert_eq!([of_disks(40.0), of_disks(1e4)], [0.8, 2.0]);
    }

    #[test]
    fn lost_and_doubled_particles_are_noticed() {
        let (space, positions) = lattice(3);
        let cells = Cells::new(&space, 0.999, &positions);
        assert!(cells.is_sound(27));
        let mut lost = cells.clone();
        lost.first[5] = NO_PARTICLE;
        assert!(!lost.is_sound(27));
        let mut round = cells.clone();
        let particle = round.first[5];
        round.next[particle as usize] = particle;
        assert!(!round.is_sound(27));
        let mut elsewhere = cells;
        elsewhere.homes[7] = 8;
        assert!(!elsewhere.is_sound(27));
    }

    #[test]
    fn neighbour_cells_hold_every_particle_in_range_once() {
        for n in 1..6 {
            let (mut space, positions) = lattice(n);
            for boundary in [Boundary::Periodic, Boundary::OPEN] {
                space.boundary = [boundary; 3];
                let grid = Cells::new(&space, 0.999, &positions);
                for (id, position) in positions.iter().enumerate() {
                    let expected: Vec<u32> = (0..)
                        .take(positions.len())
                        .filter(|&other| {
                            let apart = crate::model::space::minimum_image(
                                positions[other as usize] - position,
                                &space.periods(),
                            );
                            apart.amax() < 1.5
                        })
                        .collect();
                    assert_eq!(near(&grid, grid.grid.cell_at(position)), expected, "{n} {boundary:?} {id}");
                }
            }
        }
    }

    #[test]
    fn candidates_after_a_transition_cover_the_new_cell() {
        for n in 1..6 {
            let (mut space, positions) = lattice(n);
            for boundary in [Boundary::Periodic, Boundary::OPEN] {
                space.boundary = [boundary; 3];
                let mut grid = Cells::new(&space, 0.999, &positions);
                let mut faces = Vec::new();
                grid.grid.for_each_face(0, |face, _| faces.push(face));
                for face in faces {
                    let before = near(&grid, 0);
                    let to = grid.cross(0, face).unwrap().cell;
                    let mut found = Candidates::default();
                    grid.find_new_candidates(to, face, &mut found);
                    let new = found.found();
                    assert!(new.iter().all(|id| *id == 0 || !before.contains(id)));
                    let after = near(&grid, to);
                    assert!(after.iter().all(|id| before.contains(id) || new.contains(id)));
                    let back = CellFace { is_upper: !face.is_upper, ..face };
                    assert_eq!(grid.cross(0, back).unwrap().cell, 0);
                }
            }
        }
    }

    #[test]
    fn a_transition_through_a_periodic_side_wraps() {
        let (space, positions) = lattice(4);
        let mut grid = Cells::new(&space, 0.9, &positions);
        let face = CellFace { axis: 0, is_upper: false };
        assert_eq!(grid.cross(0, face), Some(Transition { cell: 3, wrap: 1 }));
        assert_eq!(grid.cross(0, CellFace { axis: 0, is_upper: true }), Some(Transition { cell: 0, wrap: -1 }));
    }

    #[test]
    fn far_away_particles_of_an_open_axis_share_the_outermost_cells() {
        let mut space = Space::periodic_cube(10.0);
        space.boundary = [Boundary::OPEN; 3];
        let grid = Cells::new(&space, 1.0, &[Vector::repeat(-5.0), Vector::repeat(9.0)]);
        assert_eq!(grid.grid.cell_at(&Vector::repeat(-1e9)), grid.grid.cell_at(&Vector::repeat(-5.0)));
        grid.grid.for_each_face(grid.grid.cell_at(&Vector::repeat(-1e9)), |face, _| assert!(face.is_upper));
    }

    #[test]
    fn a_flat_axis_has_one_cell() {
        let mut space = Space::periodic_cube(10.0);
        (space.boundary[2], space.size.z) = (Boundary::Flat, 0.0);
        let grid = Cells::new(&space, 1.0, &vec![Vector::new(0.5, 0.5, 0.0); 100]);
        assert_eq!(grid.grid.counts()[2], 1);
    }
}
