//! A grid of cells no smaller than the longest interaction.
//!
//! A particle can only meet strangers in its own cell and the ones next to it. Which cell a particle is in is state: it is
//! set once at the start and then changed by cell transitions only, never recomputed from a position, because round-off
//! puts positions on the wrong side of a cell's face. Along axes that are not periodic the outermost cells reach to infinity.

mod divisor;
mod search;

use crate::Vector;
use crate::pages::enlarge;
use crate::space::{Boundary, Space};
use divisor::Divisor;

/// No particle: the end of a cell's list.
pub const NOBODY: u32 = u32::MAX;

/// A face through which a particle leaves its cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// 0, 1 or 2.
    pub axis: u8,
    /// Whether it is the face with the higher coordinate.
    pub is_upper: bool,
}

/// What a transition did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// The new cell.
    pub cell: u32,
    /// Along a periodic axis, the number of periods to add to the particle's coordinate: -1, 0 or 1.
    pub wrap: i32,
}

/// The grid and the particles in it.
#[derive(Debug)]
pub struct Cells {
    counts: [u32; 3],
    /// To divide by the first two counts.
    by: [Divisor; 2],
    is_periodic: [bool; 3],
    lower: Vector,
    side: Vector,
    /// First particle of each cell.
    first: Vec<u32>,
    /// Next particle of the same cell.
    next: Vec<u32>,
    /// The cell of each particle.
    homes: Vec<u32>,
}

/// In a thin fluid, a cell's side over the mean distance of particles in one, two and three dimensions: finer ones are left more
/// often, coarser ones hold more particles that are not met. In three, within a tenth of the best speed from 0.5 to 0.7 at packing
/// fractions of 0.02 and 0.1.
const FINE: [f64; 3] = [1.0, 0.8, 0.6];

/// Grids finer than this many cells per particle only cost memory and transitions.
const CELLS_PER_PARTICLE: f64 = 8.0;

/// With this many cells along a periodic axis, particles in neighbouring cells are less than half a period apart, so that
/// their minimum image is the one that they can meet in before either changes its cell.
const UNAMBIGUOUS: u32 = 4;

/// Cells are this much wider than the interaction's range, so that round-off of positions (which stays below some
/// `1e-10` of the box) never hides a neighbour two cells away.
const MARGIN: f64 = 1.0 + 1e-6;

impl Cells {
    /// A grid over `space` for interactions up to `range` `[length]`, grown along open axes to hold all `positions`.
    #[must_use]
    pub fn new(space: &Space, range: f64, positions: &[Vector]) -> Self {
        let is_periodic = space.boundary.map(|b| b == Boundary::Periodic);
        let (mut lower, mut upper) = (space.lower, space.upper());
        for position in positions {
            for k in (0..3).filter(|&k| matches!(space.boundary[k], Boundary::Bounded { .. })) {
                lower[k] = lower[k].min(position[k]);
                upper[k] = upper[k].max(position[k]);
            }
        }
        let extent = upper - lower;
        let most = CELLS_PER_PARTICLE * positions.len() as f64 + 64.0;
        let moving = (0..3).filter(|&k| extent[k] > 0.0);
        let volume_each = moving.clone().map(|k| extent[k]).product::<f64>() / positions.len() as f64;
        let spacing = match moving.count() {
            3 => FINE[2] * libm::cbrt(volume_each),
            2 => FINE[1] * volume_each.sqrt(),
            _ => FINE[0] * volume_each,
        };
        let mut target = (range * MARGIN).max(spacing);
        let counts = loop {
            let counts = std::array::from_fn(|k| {
                let fit = |side: f64| if side > 0.0 { (extent[k] / side).floor() } else { 0.0 };
                // Coarse cells are no reason to fall below the number that needs no second images.
                let few = if is_periodic[k] { fit(range * MARGIN).min(f64::from(UNAMBIGUOUS)) } else { 1.0 };
                fit(target).max(few).clamp(1.0, f64::from(u32::MAX))
            });
            let [nx, ny, nz]: [f64; 3] = counts;
            if nx * ny * nz <= most {
                break counts.map(|n| n as u32);
            }
            target = if target > 0.0 { target * 1.05 } else { extent.max() / most };
        };
        let side = Vector::from_fn(|k, _| extent[k] / f64::from(counts[k]));
        let cells = counts.iter().map(|&n| n as usize).product();
        let mut grid = Self {
            counts,
            by: [Divisor::new(counts[0]), Divisor::new(counts[1])],
            is_periodic,
            lower,
            side,
            first: vec![NOBODY; cells],
            next: vec![NOBODY; positions.len()],
            homes: vec![0; positions.len()],
        };
        // Backwards, so that each list ends up in ascending order.
        for (id, position) in positions.iter().enumerate().rev() {
            let cell = grid.cell_at(position);
            grid.insert(id as u32, cell);
        }
        grid
    }

    /// Asks for large pages.
    pub fn enlarge(&self) {
        enlarge(&self.first);
        enlarge(&self.next);
        enlarge(&self.homes);
    }

    /// Numbers of cells along the axes.
    #[must_use]
    pub fn counts(&self) -> [u32; 3] {
        self.counts
    }

    /// Separations, besides the minimum image, at which a pair can meet before either particle changes its cell.
    ///
    /// Empty unless a periodic axis is shorter than four cells. Between two predictions of a pair each of the two travels one
    /// cell at most, so their separation changes by up to two cells: one period for two or three cells, two for a single one.
    #[must_use]
    pub fn further_images(&self, periods: &Vector) -> Vec<Vector> {
        let mut images = vec![Vector::zeros()];
        for axis in 0..3 {
            let most = match self.counts[axis] {
                _ if !self.is_periodic[axis] => 0,
                1 => 2,
                2 | 3 => 1,
                _ => 0,
            };
            images = images
                .iter()
                .flat_map(|image| {
                    (-most..=most).map(move |k: i32| {
                        let mut shifted = *image;
                        if k != 0 {
                            shifted[axis] += f64::from(k) * periods[axis];
                        }
                        shifted
                    })
                })
                .collect();
        }
        images.retain(|image| *image != Vector::zeros());
        images
    }

    /// The cell that holds a position at the start.
    #[must_use]
    pub fn cell_at(&self, position: &Vector) -> u32 {
        let index = |k: usize| {
            let at = ((position[k] - self.lower[k]) / self.side[k]).floor();
            // Positions in the outermost cells of open axes, and NaN from 0/0 on flat ones, saturate.
            (at.max(0.0) as u32).min(self.counts[k] - 1)
        };
        self.join([index(0), index(1), index(2)])
    }

    fn join(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    #[inline]
    fn split(&self, cell: u32) -> [u32; 3] {
        let [yz, x] = self.by[0].divide(cell);
        let [z, y] = self.by[1].divide(yz);
        [x, y, z]
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

    /// The cell that a particle is in.
    #[inline]
    #[must_use]
    pub fn home(&self, particle: u32) -> u32 {
        self.homes[particle as usize]
    }

    /// Moves a particle to a cell.
    pub fn relocate(&mut self, particle: u32, to: u32) {
        let from = self.home(particle);
        if to != from {
            self.remove(particle, from);
            self.insert(particle, to);
        }
    }

    /// The indices next to `index` along an axis, itself included, each once.
    #[inline]
    fn around(&self, axis: usize, index: u32) -> ([u32; 3], usize) {
        let n = self.counts[axis];
        if self.is_periodic[axis] {
            match n {
                1 => ([0; 3], 1),
                2 => ([0, 1, 0], 2),
                _ => {
                    let before = if index == 0 { n - 1 } else { index - 1 };
                    let after = if index + 1 == n { 0 } else { index + 1 };
                    ([before, index, after], 3)
                }
            }
        } else {
            let first = index.saturating_sub(1);
            let last = (index + 1).min(n - 1);
            ([first, first + 1, first + 2], (last - first + 1) as usize)
        }
    }

    /// The index beyond an upper or lower face, and the periods to add; none at an end that is not periodic.
    #[inline]
    fn beyond(&self, axis: usize, index: u32, is_upper: bool) -> Option<(u32, i32)> {
        let last = self.counts[axis] - 1;
        match (is_upper, self.is_periodic[axis]) {
            (true, _) if index < last => Some((index + 1, 0)),
            (false, _) if index > 0 => Some((index - 1, 0)),
            (true, true) => Some((0, -1)),
            (false, true) => Some((last, 1)),
            _ => None,
        }
    }

    /// Calls `visit(face, coordinate)` for the faces through which a particle can leave its cell, along its coordinates.
    ///
    /// Outermost faces of axes that are not periodic are no faces.
    #[inline]
    pub fn for_each_face(&self, cell: u32, mut visit: impl FnMut(Face, f64)) {
        let at = self.split(cell);
        for (axis, index) in at.into_iter().enumerate() {
            let n = self.counts[axis];
            let face = |is_upper| Face { axis: axis as u8, is_upper };
            if self.is_periodic[axis] || index > 0 {
                visit(face(false), self.lower[axis] + f64::from(index) * self.side[axis]);
            }
            if self.is_periodic[axis] || index + 1 < n {
                visit(face(true), self.lower[axis] + f64::from(index + 1) * self.side[axis]);
            }
        }
    }

    /// The same for the faces that a particle with a constant velocity flies towards, one per axis at most.
    #[inline]
    pub fn for_each_face_ahead(&self, cell: u32, velocity: &Vector, mut visit: impl FnMut(Face, f64)) {
        let at = self.split(cell);
        for (axis, index) in at.into_iter().enumerate() {
            let is_upper = velocity[axis] > 0.0;
            let last = if is_upper { self.counts[axis] - 1 } else { 0 };
            if velocity[axis] != 0.0 && (self.is_periodic[axis] || index != last) {
                let line = f64::from(index + u32::from(is_upper));
                visit(Face { axis: axis as u8, is_upper }, self.lower[axis] + line * self.side[axis]);
            }
        }
    }

    /// Whether the cell is the first (or the last) along an axis that is not periodic, so that a wall may be near.
    #[inline]
    #[must_use]
    pub fn is_outermost(&self, cell: u32, axis: usize) -> [bool; 2] {
        let index = self.split(cell)[axis];
        [index == 0, index + 1 == self.counts[axis]]
    }

    /// Moves a particle through a face of its cell.
    #[inline]
    pub fn cross(&mut self, particle: u32, face: Face) -> Transition {
        let mut at = self.split(self.home(particle));
        let axis = usize::from(face.axis);
        // A particle at an end that is not periodic has no face there.
        let (index, wrap) = self.beyond(axis, at[axis], face.is_upper).unwrap_or((at[axis], 0));
        at[axis] = index;
        let to = self.join(at);
        self.relocate(particle, to);
        Transition { cell: to, wrap }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::near::Near;

    fn near(grid: &Cells, cell: u32) -> Vec<u32> {
        let mut near = Near::default();
        grid.find_near(cell, &mut near);
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
    fn every_particle_within_range_is_near_and_met_once() {
        for n in 1..6 {
            let (mut space, positions) = lattice(n);
            for boundary in [Boundary::Periodic, Boundary::OPEN] {
                space.boundary = [boundary; 3];
                let grid = Cells::new(&space, 0.999, &positions);
                for (id, position) in positions.iter().enumerate() {
                    let expected: Vec<u32> = (0..positions.len() as u32)
                        .filter(|&other| {
                            let apart =
                                crate::space::minimum_image(positions[other as usize] - position, &space.periods());
                            apart.amax() < 1.5
                        })
                        .collect();
                    assert_eq!(near(&grid, grid.cell_at(position)), expected, "{n} {boundary:?} {id}");
                }
            }
        }
    }

    #[test]
    fn what_is_new_after_a_transition_completes_what_was_near() {
        for n in 1..6 {
            let (mut space, positions) = lattice(n);
            for boundary in [Boundary::Periodic, Boundary::OPEN] {
                space.boundary = [boundary; 3];
                let mut grid = Cells::new(&space, 0.999, &positions);
                let mut faces = Vec::new();
                grid.for_each_face(0, |face, _| faces.push(face));
                for face in faces {
                    let before = near(&grid, 0);
                    let to = grid.cross(0, face).cell;
                    let mut found = Near::default();
                    grid.find_new(to, face, &mut found);
                    let new = found.found();
                    assert!(new.iter().all(|id| *id == 0 || !before.contains(id)));
                    let after = near(&grid, to);
                    assert!(after.iter().all(|id| before.contains(id) || new.contains(id)));
                    let back = Face { is_upper: !face.is_upper, ..face };
                    assert_eq!(grid.cross(0, back).cell, 0);
                }
            }
        }
    }

    #[test]
    fn a_transition_through_a_periodic_side_wraps() {
        let (space, positions) = lattice(4);
        let mut grid = Cells::new(&space, 0.9, &positions);
        let face = Face { axis: 0, is_upper: false };
        assert_eq!(grid.cross(0, face), Transition { cell: 3, wrap: 1 });
        assert_eq!(grid.cross(0, Face { axis: 0, is_upper: true }), Transition { cell: 0, wrap: -1 });
    }

    #[test]
    fn far_away_particles_of_an_open_axis_share_the_outermost_cells() {
        let mut space = Space::periodic_cube(10.0);
        space.boundary = [Boundary::OPEN; 3];
        let grid = Cells::new(&space, 1.0, &[Vector::repeat(-5.0), Vector::repeat(9.0)]);
        assert_eq!(grid.cell_at(&Vector::repeat(-1e9)), grid.cell_at(&Vector::repeat(-5.0)));
        grid.for_each_face(grid.cell_at(&Vector::repeat(-1e9)), |face, _| assert!(face.is_upper));
    }

    #[test]
    fn a_flat_axis_has_one_cell() {
        let mut space = Space::periodic_cube(10.0);
        (space.boundary[2], space.size.z) = (Boundary::Flat, 0.0);
        let grid = Cells::new(&space, 1.0, &vec![Vector::new(0.5, 0.5, 0.0); 100]);
        assert_eq!(grid.counts()[2], 1);
    }
}
