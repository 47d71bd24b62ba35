//! A cell list of points at a single time. It finds pairs within a range, and the point nearest to a position.
//!
//! Cell lists are used by code that needs neighbours only once, such as instruments.

use super::grid::Grid;
use crate::Vector;
use crate::model::space::{Boundary, Space, nearest_image};
use std::ops::ControlFlow;

/// Maximum number of cells per point. More cells would only cost memory.
const CELLS_PER_POINT: f64 = 2.0;

/// Points sorted into cells no smaller than a range.
#[derive(Debug)]
pub(crate) struct CellList {
    grid: Grid,
    periods: Vector,
    /// Displacement along x of the periodic image above a sheared box.
    displacement: f64,
    range: f64,
    /// For each cell, the index of its first point. The last entry is the number of points.
    starts: Vec<usize>,
    /// Ids and positions of the points, sorted by cell.
    ids: Vec<u32>,
    positions: Vec<Vector>,
}

impl CellList {
    /// Sorts points into cells. Along periodic axes, the points must be inside `space`. The periodic image above a
    /// sheared box is displaced by `displacement` along x.
    pub fn new(space: &Space, displacement: f64, range: f64, points: impl Iterator<Item = (u32, Vector)>) -> Self {
        let (ids, positions): (Vec<u32>, Vec<Vector>) = points.unzip();
        let grid = Grid::new(&bounds(space, &positions), range, &positions, [0.0; 3], CELLS_PER_POINT);
        let cells: Vec<usize> = positions.iter().map(|position| grid.cell_at(position) as usize).collect();
        let mut starts = vec![0; grid.count() + 1];
        cells.iter().for_each(|&cell| starts[cell + 1] += 1);
        (1..starts.len()).for_each(|cell| starts[cell] += starts[cell - 1]);
        let mut next = starts.clone();
        let mut sorted = vec![0; ids.len()];
        for (index, &cell) in cells.iter().enumerate() {
            sorted[next[cell]] = index;
            next[cell] += 1;
        }
        Self {
            grid,
            periods: space.periods(),
            displacement,
            range,
            starts,
            ids: sorted.iter().map(|&index| ids[index]).collect(),
            positions: sorted.iter().map(|&index| positions[index]).collect(),
        }
    }

    /// Returns the largest range for which the nearest image of a pair is sufficient; infinite without periodic axes.
    pub fn largest_range(space: &Space) -> f64 {
        0.5 * space.periods().min()
    }

    /// Calls `visit(a, b, r_a - r_b, r^2)` once for each pair of points within the range.
    pub fn for_each_pair(&self, mut visit: impl FnMut(u32, u32, &Vector, f64)) {
        self.has_pair(|a, b, separation, squared| {
            visit(a, b, separation, squared);
            false
        });
    }

    /// Returns true if `is(a, b, r_a - r_b, r^2)` is true for any pair within the range. A pair is tested at most once.
    pub fn has_pair(&self, mut is: impl FnMut(u32, u32, &Vector, f64) -> bool) -> bool {
        let found = self.for_each(|index, runs| {
            for &(begin, end) in runs {
                for other in begin.max(index + 1)..end {
                    if let Some(separation) = self.separation(index, other)
                        && is(self.ids[index], self.ids[other], &separation, separation.norm_squared())
                    {
                        return ControlFlow::Break(());
                    }
                }
            }
            ControlFlow::Continue(())
        });
        found.is_break()
    }

    /// Calls `visit(id, separations)` for each point. Separations lead to the point from all other points in range.
    pub fn for_each_particle(&self, mut visit: impl FnMut(u32, &[Vector])) {
        let mut separations = Vec::new();
        let _ = self.for_each(|index, runs| {
            separations.clear();
            for &(begin, end) in runs {
                let others = (begin..end).filter(|&other| other != index);
                separations.extend(others.filter_map(|other| self.separation(index, other)));
            }
            visit(self.ids[index], &separations);
            ControlFlow::<()>::Continue(())
        });
    }

    /// Returns the distance from a position to the nearest point `[length]`; `None` beyond the range.
    pub fn distance_to_nearest(&self, place: &Vector) -> Option<f64> {
        let mut runs = Vec::with_capacity(27);
        self.find_runs(self.grid.cell_at(place), &mut runs);
        let near = runs.iter().flat_map(|&(begin, end)| &self.positions[begin..end]);
        let distances = near.map(|point| nearest_image(point - place, &self.periods, self.displacement).norm());
        distances.filter(|distance| *distance < self.range).reduce(f64::min)
    }

    /// Returns the separation of two points in their nearest images; `None` beyond the range.
    #[inline]
    fn separation(&self, index: usize, other: usize) -> Option<Vector> {
        let separation = nearest_image(self.positions[index] - self.positions[other], &self.periods, self.displacement);
        (separation.norm_squared() < self.range * self.range).then_some(separation)
    }

    /// Calls `visit(index, runs)` for each point. `runs` are the indices of the points in the same and adjacent cells.
    fn for_each(&self, mut visit: impl FnMut(usize, &[(usize, usize)]) -> ControlFlow<()>) -> ControlFlow<()> {
        let mut runs = Vec::with_capacity(27);
        for (cell, bounds) in (0..).zip(self.starts.windows(2)) {
            if bounds[0] == bounds[1] {
                continue;
            }
            self.find_runs(cell, &mut runs);
            (bounds[0]..bounds[1]).try_for_each(|index| visit(index, &runs))?;
        }
        ControlFlow::Continue(())
    }

    fn find_runs(&self, cell: u32, runs: &mut Vec<(usize, usize)>) {
        runs.clear();
        self.grid.for_each_row(cell, self.displacement != 0.0, |cells| {
            runs.push((self.starts[cells.start as usize], self.starts[cells.end as usize]));
        });
    }
}

/// Returns the box along periodic axes, and the extent of the points along other axes.
fn bounds(space: &Space, positions: &[Vector]) -> Space {
    let (mut lower, mut upper, mut boundary) = (space.lower, space.upper(), space.boundary);
    for k in (0..3).filter(|&k| space.boundary[k] != Boundary::Periodic) {
        let along = || positions.iter().map(|position| position[k]);
        (lower[k], upper[k]) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        boundary[k] = Boundary::OPEN;
    }
    Space { lower, size: upper - lower, boundary }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    type Matrix = nalgebra::Matrix3<f64>;

    fn tensor(separation: impl std::borrow::Borrow<Vector>) -> Matrix {
        separation.borrow() * separation.borrow().transpose()
    }

    fn cell_list(space: &Space, displacement: f64, range: f64, ids: &[u32], all: &[Vector]) -> CellList {
        CellList::new(space, displacement, range, ids.iter().map(|&id| (id, all[id as usize])))
    }

    fn random_points(count: usize, space: &Space) -> Vec<Vector> {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        (0..count).map(|_| space.lower + Vector::from_fn(|k, _| next() * space.size[k])).collect()
    }

    /// Displacements of all periodic images up to two periods away.
    fn all_images(space: &Space, displacement: f64) -> impl Iterator<Item = Vector> {
        let all = |k: usize| {
            let is_periodic = space.boundary[k] == Boundary::Periodic;
            (if is_periodic { -2..=2 } else { 0..=0 }).map(f64::from)
        };
        let (size, [x, y, z]) = (space.size, [all(0), all(1), all(2)]);
        z.flat_map(move |k| y.clone().map(move |j| (j, k))).flat_map(move |(j, k)| {
            x.clone().map(move |i| Vector::new(i * size.x + j * displacement, j * size.y, k * size.z))
        })
    }

    #[test]
    fn cell_list_finds_the_same_pairs_as_brute_force() {
        let flat = Boundary::Flat;
        let (whole, plane) = ([Boundary::Periodic; 3], [Boundary::Periodic, Boundary::Periodic, flat]);
        let (box_of_three, sheet) = (Vector::new(10.0, 7.0, 3.0), Vector::new(12.0, 9.0, 0.0));
        for (boundary, size, displacement) in [
            (whole, box_of_three, 0.0),
            ([Boundary::Periodic, Boundary::OPEN, Boundary::walls(1.0)], Vector::new(2.9, 8.0, 12.0), 0.0),
            (plane, sheet, 0.0),
            ([flat, Boundary::OPEN, flat], Vector::new(0.0, 50.0, 0.0), 0.0),
            // These boxes are sheared. Some have fewer than three rows of cells.
            (whole, box_of_three, 0.9),
            (whole, box_of_three, -4.2),
            (whole, Vector::new(7.0, 2.95, 5.0), 3.5),
            (whole, Vector::new(3.0, 8.0, 4.0), 1.1),
            (plane, sheet, -2.5),
            (plane, sheet, 6.0),
        ] {
            let space = Space { lower: Vector::new(-1.0, 2.0, 0.5), size, boundary };
            let points = random_points(300, &space);
            let ids: Vec<u32> = (0..300).filter(|id| id % 7 != 0).collect();
            for range in [0.3, 1.0, 1.45] {
                let is_near = |&(a, b): &(u32, u32)| {
                    let apart = points[a as usize] - points[b as usize];
                    all_images(&space, displacement).any(|image| (apart + image).norm_squared() < range * range)
                };
                let all = ids.iter().flat_map(|&a| ids.iter().filter(move |&&b| b > a).map(move |&b| (a, b)));
                let expected: Vec<(u32, u32)> = all.filter(is_near).collect();
                let cells = cell_list(&space, displacement, range, &ids, &points);
                let mut found = Vec::new();
                cells.for_each_pair(|a, b, _, _| found.push((a.min(b), a.max(b))));
                found.sort_unstable();
                assert_eq!(found, expected);
                let mut ends = 0;
                cells.for_each_particle(|id, separations| {
                    ends += separations.len();
                    let others = ids.iter().filter(|&&other| other != id);
                    let apart = others.map(|&other| points[id as usize] - points[other as usize]);
                    let images =
                        apart.flat_map(|apart| all_images(&space, displacement).map(move |image| apart + image));
                    let all = images.filter(|separation| separation.norm_squared() < range * range);
                    // Sums of tensors depend on the directions of the separations, but not on their order.
                    let difference = all.map(tensor).sum::<Matrix>() - separations.iter().map(tensor).sum::<Matrix>();
                    assert!(difference.amax() < 1e-12, "{displacement} {range} {id}: {difference}");
                });
                assert_eq!(ends, 2 * expected.len());
            }
        }
    }

    #[test]
    fn empty_and_distant_points_are_handled() {
        let space = Space { lower: Vector::zeros(), size: Vector::repeat(1.0), boundary: [Boundary::OPEN; 3] };
        CellList::new(&space, 0.0, 1.0, std::iter::empty()).for_each_pair(|_, _, _, _| panic!("no particles"));
        let points = [Vector::repeat(1e40), Vector::repeat(-1e40), Vector::zeros(), Vector::new(0.5, 0.0, 0.0)];
        let mut found = Vec::new();
        let cells = CellList::new(&space, 0.0, 1.0, (0..).zip(points));
        cells.for_each_pair(|a, b, _, square| found.push((a, b, square)));
        assert_eq!(found, [(2, 3, 0.25)]);
    }

    #[test]
    fn nearest_point_matches_brute_force() {
        for displacement in [0.0, 1.7] {
            let space =
                Space { lower: Vector::zeros(), size: Vector::new(9.0, 5.0, 7.0), boundary: [Boundary::Periodic; 3] };
            let points = random_points(40, &space);
            let cells = CellList::new(&space, displacement, 1.2, (0..).zip(points.iter().copied()));
            let mut found = 0;
            for place in random_points(300, &space) {
                let apart =
                    points.iter().map(|point| nearest_image(point - place, &space.periods(), displacement).norm());
                let expected = apart.reduce(f64::min).filter(|distance| *distance < 1.2);
                assert_eq!(cells.distance_to_nearest(&place), expected);
                found += usize::from(expected.is_some());
            }
            assert!((50..290).contains(&found), "{found}");
        }
        let space = Space { lower: Vector::zeros(), size: Vector::zeros(), boundary: [Boundary::OPEN; 3] };
        let cells = CellList::new(&space, 0.0, 1.0, [(0, Vector::repeat(4.0))].into_iter());
        assert_eq!(cells.distance_to_nearest(&Vector::new(4.0, 4.0, 3.5)), Some(0.5));
        assert_eq!(cells.distance_to_nearest(&Vector::new(4.0, 4.0, 2.5)), None);
    }
}
