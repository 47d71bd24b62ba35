//! A cell list: pairs of particles that are closer than a range.

use super::system::Sample;
use crate::Vector;
use crate::base::numbers::trunc_to_usize;
use crate::model::space::{Boundary, Space, nearest_image};

/// Cells are this much wider than the range: round-off of positions hides no pair.
const MARGIN: f64 = 1.0 + 1e-6;

/// A cell list for one sample: particles sorted into cells no smaller than a range; pairs by their minimum image.
///
/// The range may be at most half of the shortest period.
#[derive(Debug)]
pub(super) struct CellList {
    periods: Vector,
    /// Of the next image up along y, along x.
    displacement: f64,
    range: f64,
    counts: [usize; 3],
    /// Where the particles of each cell begin, and the end.
    starts: Vec<usize>,
    /// Ids and positions, cell by cell.
    ids: Vec<u32>,
    positions: Vec<Vector>,
}

impl CellList {
    /// Sorts particles with these ids into cells.
    pub fn new(space: &Space, range: f64, ids: &[u32], sample: &Sample<'_>) -> Self {
        let &Sample { positions, displacement, .. } = sample;
        let (lower, extent) = extents(space, ids, positions);
        let counts = cell_counts(&extent, range * MARGIN, ids.len());
        let cell_of = |position: &Vector| {
            let index = |k: usize| {
                let at = (position[k] - lower[k]) / extent[k] * counts[k] as f64;
                // NaN from 0/0 on flat axes, and round-off outside of the box, saturate.
                trunc_to_usize(at).min(counts[k] - 1)
            };
            (index(2) * counts[1] + index(1)) * counts[0] + index(0)
        };
        let cells: Vec<usize> = ids.iter().map(|&id| cell_of(&positions[id as usize])).collect();
        let mut starts = vec![0; counts.iter().product::<usize>() + 1];
        cells.iter().for_each(|&cell| starts[cell + 1] += 1);
        (1..starts.len()).for_each(|cell| starts[cell] += starts[cell - 1]);
        let mut next = starts.clone();
        let mut sorted = vec![0; ids.len()];
        for (&cell, &id) in cells.iter().zip(ids) {
            sorted[next[cell]] = id;
            next[cell] += 1;
        }
        let positions = sorted.iter().map(|&id| positions[id as usize]).collect();
        Self { periods: space.periods(), displacement, range, counts, starts, ids: sorted, positions }
    }

    /// The largest range for which minimum images are all there are: half of the shortest period, infinite without one.
    pub fn largest_range(space: &Space) -> f64 {
        0.5 * space.periods().min()
    }

    /// Calls `visit(id, id, r^2)` once for each pair within the range.
    pub fn for_each_pair(&self, mut visit: impl FnMut(u32, u32, f64)) {
        self.for_each(|index, runs| {
            for &(begin, end) in runs {
                for other in begin.max(index + 1)..end {
                    if let Some(separation) = self.separation(index, other) {
                        visit(self.ids[index], self.ids[other], separation.norm_squared());
                    }
                }
            }
        });
    }

    /// Calls `visit(id, separations)` for each particle, with the separations from those within its range.
    pub fn for_each_particle(&self, mut visit: impl FnMut(u32, &[Vector])) {
        let mut separations = Vec::new();
        self.for_each(|index, runs| {
            separations.clear();
            for &(begin, end) in runs {
                let others = (begin..end).filter(|&other| other != index);
                separations.extend(others.filter_map(|other| self.separation(index, other)));
            }
            visit(self.ids[index], &separations);
        });
    }

    /// The nearest image of a separation, if it is within the range.
    #[inline]
    fn separation(&self, index: usize, other: usize) -> Option<Vector> {
        let separation = nearest_image(self.positions[index] - self.positions[other], &self.periods, self.displacement);
        (separation.norm_squared() < self.range * self.range).then_some(separation)
    }

    /// Calls `visit(index, runs)` for each particle in the order of the cells, with the runs of those in cells near it.
    fn for_each(&self, mut visit: impl FnMut(usize, &[(usize, usize)])) {
        let mut runs = Vec::with_capacity(27);
        let [nx, ny, nz] = self.counts;
        for cell in 0..nx * ny * nz {
            if self.starts[cell] == self.starts[cell + 1] {
                continue;
            }
            runs.clear();
            let (x, y, z) = (cell % nx, cell / nx % ny, cell / (nx * ny));
            for z in self.around(2, z) {
                for row in self.around(1, y) {
                    let first = (z * ny + row) * nx;
                    if self.slides(y, row) {
                        runs.push((self.starts[first], self.starts[first + nx]));
                        continue;
                    }
                    for near in self.around(0, x).map(|x| first + x) {
                        runs.push((self.starts[near], self.starts[near + 1]));
                    }
                }
            }
            (self.starts[cell]..self.starts[cell + 1]).for_each(|index| visit(index, &runs));
        }
    }

    /// Whether a row of cells along x is next to another one through the side that slides, so that any cell of it may be near.
    fn slides(&self, y: usize, row: usize) -> bool {
        self.displacement != 0.0 && (self.counts[1] < 3 || y.abs_diff(row) > 1)
    }

    /// The indices next to one along an axis, itself included, each once.
    fn around(&self, axis: usize, index: usize) -> impl Iterator<Item = usize> {
        let count = self.counts[axis];
        let is_periodic = self.periods[axis].is_finite();
        let first = if count < 3 || (!is_periodic && index == 0) { 0 } else { index + count - 1 };
        let number = match count {
            0..3 => count,
            _ if !is_periodic && (index == 0 || index + 1 == count) => 2,
            _ => 3,
        };
        (first..first + number).map(move |at| at % count)
    }
}

/// Lower corner and edges of what the cells cover: the box along periodic axes, the particles along others.
fn extents(space: &Space, ids: &[u32], positions: &[Vector]) -> (Vector, Vector) {
    let (mut lower, mut upper) = (space.lower, space.upper());
    for k in (0..3).filter(|&k| space.boundary[k] != Boundary::Periodic) {
        let along = || ids.iter().map(|&id| positions[id as usize][k]);
        (lower[k], upper[k]) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
    }
    (lower, upper - lower)
}

/// Numbers of cells along the axes: no smaller than `side`, and no more than two for each particle.
fn cell_counts(extent: &Vector, mut side: f64, particles: usize) -> [usize; 3] {
    let most = 2.0 * particles as f64 + 64.0;
    loop {
        let fit = |k: usize| if extent[k].is_finite() { (extent[k] / side).floor().max(1.0) } else { 1.0 };
        let counts = [fit(0), fit(1), fit(2)];
        // A side of zero gives infinitely many cells: the next one is positive.
        if counts.iter().product::<f64>() <= most {
            return counts.map(trunc_to_usize);
        }
        side = if side > 0.0 { 1.2 * side } else { extent.max() / most };
    }
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

    fn sample(positions: &[Vector], displacement: f64) -> Sample<'_> {
        Sample { time: 0.0, positions, velocities: &[], images: &[], displacement }
    }

    fn random_points(count: usize, space: &Space) -> Vec<Vector> {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        (0..count).map(|_| space.lower + Vector::from_fn(|k, _| next() * space.size[k])).collect()
    }

    /// Displacements of all images up to two periods away along each periodic axis.
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
    fn it_finds_the_pairs_that_all_pairs_contain() {
        let flat = Boundary::Flat;
        let (whole, plane) = ([Boundary::Periodic; 3], [Boundary::Periodic, Boundary::Periodic, flat]);
        let (box_of_three, sheet) = (Vector::new(10.0, 7.0, 3.0), Vector::new(12.0, 9.0, 0.0));
        for (boundary, size, displacement) in [
            (whole, box_of_three, 0.0),
            ([Boundary::Periodic, Boundary::OPEN, Boundary::walls(1.0)], Vector::new(2.9, 8.0, 12.0), 0.0),
            (plane, sheet, 0.0),
            ([flat, Boundary::OPEN, flat], Vector::new(0.0, 50.0, 0.0), 0.0),
            // Sheared, also with fewer than three rows.
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
                let cells = CellList::new(&space, range, &ids, &sample(&points, displacement));
                let mut found = Vec::new();
                cells.for_each_pair(|a, b, _| found.push((a.min(b), a.max(b))));
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
                    // The sum of their tensors distinguishes directions, whatever the order.
                    let difference = all.map(tensor).sum::<Matrix>() - separations.iter().map(tensor).sum::<Matrix>();
                    assert!(difference.amax() < 1e-12, "{displacement} {range} {id}: {difference}");
                });
                assert_eq!(ends, 2 * expected.len());
            }
        }
    }

    #[test]
    fn nothing_and_far_away_are_no_trouble() {
        let space = Space { lower: Vector::zeros(), size: Vector::repeat(1.0), boundary: [Boundary::OPEN; 3] };
        CellList::new(&space, 1.0, &[], &sample(&[], 0.0)).for_each_pair(|_, _, _| panic!("no particles"));
        let points = [Vector::repeat(1e40), Vector::repeat(-1e40), Vector::zeros(), Vector::new(0.5, 0.0, 0.0)];
        let mut found = Vec::new();
        let cells = CellList::new(&space, 1.0, &[0, 1, 2, 3], &sample(&points, 0.0));
        cells.for_each_pair(|a, b, square| found.push((a, b, square)));
        assert_eq!(found, [(2, 3, 0.25)]);
    }
}
