//! A grid of cells over a part of the box.

use super::bins::Bins;
use super::quantity::Variable;
use crate::Vector;
use crate::base::numbers::{index, trunc_to_usize};
use crate::model::measurement_plan::MOST_CELLS;
use crate::model::space::{AXES, Boundary, Space};
use serde::{Deserialize, Serialize};

/// Cells of equal size. The first axis varies fastest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Grid {
    lower: Vector,
    size: Vector,
    pub bins: [usize; 3],
}

impl Grid {
    /// Creates a grid over the box, or between the given corners.
    pub fn new(bins: [u64; 3], lower: Option<[f64; 3]>, upper: Option<[f64; 3]>, space: &Space) -> Self {
        let lower = lower.map_or(space.lower, Vector::from);
        let upper = upper.map_or(space.upper(), Vector::from);
        Self { lower, size: upper - lower, bins: affordable(bins) }
    }

    pub fn cells(&self) -> usize {
        self.bins.iter().product()
    }

    fn bins(&self, axis: usize) -> Bins {
        Bins::over(self.lower[axis], self.size[axis], self.bins[axis])
    }

    /// Returns the cell that contains a position or one of its periodic images.
    pub fn cell_of(&self, position: &Vector, space: &Space) -> Option<usize> {
        let mut cell = 0;
        for k in (0..3).rev() {
            let index = match space.boundary[k] {
                Boundary::Flat => 0,
                boundary => {
                    let mut offset = position[k] - self.lower[k];
                    // The position may be outside the box by round-off, or the grid may not start at the corner of the
                    // box.
                    if boundary == Boundary::Periodic && !(0.0..space.size[k]).contains(&offset) {
                        // The result of `rem_euclid` may round up to the period.
                        offset = offset.rem_euclid(space.size[k]).min(space.size[k].next_down());
                    }
                    if !(0.0..self.size[k]).contains(&offset) {
                        return None;
                    }
                    Bins::over(0.0, self.size[k], self.bins[k]).nearest(offset)
                }
            };
            cell = cell * self.bins[k] + index;
        }
        Some(cell)
    }

    /// Calls `visit(cell, fraction)` for the pieces of a straight line in each cell, and their fractions of its length.
    pub fn for_each_piece(&self, start: &Vector, line: &Vector, space: &Space, mut visit: impl FnMut(usize, f64)) {
        let mut cuts = vec![1.0];
        for axis in 0..3 {
            self.cut(axis, start[axis], line[axis], space, &mut cuts);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let mut from = 0.0;
        for to in cuts {
            if to > from {
                if let Some(cell) = self.cell_of(&(start + line * (0.5 * (from + to))), space) {
                    visit(cell, to - from);
                }
                from = to;
            }
        }
    }

    /// Adds the fractions of a line at which it crosses an edge of a cell along an axis.
    fn cut(&self, axis: usize, start: f64, line: f64, space: &Space, cuts: &mut Vec<f64>) {
        if line == 0.0 || space.boundary[axis] == Boundary::Flat {
            return;
        }
        let (low, high) = (start.min(start + line), start.max(start + line));
        let period = space.periods()[axis];
        let images = if space.boundary[axis] == Boundary::Periodic { MOST_IMAGES } else { 0 };
        let first = if images > 0 { ((low - self.lower[axis]) / period).floor() } else { 0.0 };
        for image in 0..=images {
            let from = self.lower[axis] + if images > 0 { (first + f64::from(image)) * period } else { 0.0 };
            if from > high {
                break;
            }
            let bins = Bins::over(from, self.size[axis], self.bins[axis]);
            let begin = trunc_to_usize(bins.place(low).max(0.0));
            for edge in (begin..=self.bins[axis]).map(|edge| bins.edge(edge)).take_while(|edge| *edge < high) {
                if edge > low {
                    cuts.push((edge - start) / line);
                }
            }
        }
    }

    /// Volume of a cell; area or length with flat axes.
    pub fn cell_volume(&self, space: &Space) -> f64 {
        (0..3).filter(|&k| space.boundary[k] != Boundary::Flat).map(|k| self.bins(k).width()).product()
    }

    /// Returns the cell centres along each axis with more than one cell, or along x if there is only one cell.
    pub fn variables(&self) -> Vec<Variable> {
        let axes = (0..3).filter(|&k| self.bins[k] > 1 || (k == 0 && self.bins == [1; 3]));
        let variable = |k: usize| {
            let stride: usize = self.bins[..k].iter().product();
            let centre = |cell: usize| self.bins(k).centre(cell / stride % self.bins[k]);
            let values = (0..self.cells()).map(centre).collect();
            Variable { name: AXES[k].to_owned(), unit: "length".to_owned(), values }
        };
        axes.map(variable).collect()
    }
}

/// Largest number of further periods that a line may reach.
const MOST_IMAGES: u32 = 64;

/// Reduces the numbers of bins to at most [`MOST_CELLS`] cells. The last axes are reduced first.
fn affordable(bins: [u64; 3]) -> [usize; 3] {
    let mut left = MOST_CELLS;
    bins.map(|count| {
        let count = count.clamp(1, left);
        left /= count;
        index(count)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(grid: &Grid, start: [f64; 3], line: [f64; 3], space: &Space) -> Vec<(usize, f64)> {
        let mut pieces = Vec::new();
        grid.for_each_piece(&start.into(), &line.into(), space, |cell, fraction| pieces.push((cell, fraction)));
        pieces
    }

    fn assert_near(found: &[(usize, f64)], expected: &[(usize, f64)]) {
        let is_near = |(a, b): (&(usize, f64), &(usize, f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-14;
        assert!(found.len() == expected.len() && found.iter().zip(expected).all(is_near), "{found:?} {expected:?}");
    }

    #[test]
    fn number_of_cells_is_limited() {
        assert_eq!(affordable([200, 200, 5]), [200, 50, 1]);
        assert_eq!(affordable([0, 3, u64::MAX]), [1, 3, 3333]);
    }

    #[test]
    fn line_is_divided_at_the_edges_of_cells() {
        let space = Space::periodic_cube(6.0);
        let grid = Grid::new([3, 2, 1], None, None, &space);
        assert_near(&pieces(&grid, [0.5, 1.0, 1.0], [0.0, 0.0, 3.0], &space), &[(0, 1.0)]);
        // Along x, the edges are at 2 and 4; along y, at 3.
        assert_near(
            &pieces(&grid, [1.0, 2.0, 1.0], [4.0, 2.0, 0.0], &space),
            &[(0, 0.25), (1, 0.25), (4, 0.25), (5, 0.25)],
        );
        // Backwards across the periodic boundary.
        assert_near(&pieces(&grid, [0.5, 4.0, 1.0], [-2.0, 0.0, 0.0], &space), &[(3, 0.25), (5, 0.75)]);
    }

    #[test]
    fn line_beyond_the_grid_is_left_out() {
        let space = Space::periodic_cube(6.0);
        // The grid covers x from 4 to 7, so that it contains the image of 0 to 1.
        let grid = Grid::new([3, 1, 1], Some([4.0, 0.0, 0.0]), Some([7.0, 6.0, 6.0]), &space);
        assert_near(&pieces(&grid, [0.5, 1.0, 1.0], [2.0, 0.0, 0.0], &space), &[(2, 0.25)]);
        assert_near(&pieces(&grid, [3.5, 1.0, 1.0], [2.0, 0.0, 0.0], &space), &[(0, 0.5), (1, 0.25)]);
        let line = pieces(&grid, [5.0, 1.0, 1.0], [12.0, 0.0, 0.0], &space);
        assert!((line.iter().map(|(_, fraction)| fraction).sum::<f64>() - 0.5).abs() < 1e-14, "{line:?}");
    }
}
