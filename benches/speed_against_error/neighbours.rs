//! Neighbour lists for the baselines. Each pair is listed once.

use carom::Vector;

/// The partners of particle `i` are `partners[starts[i]..starts[i + 1]]`.
#[derive(Default)]
pub struct List {
    pub starts: Vec<usize>,
    pub partners: Vec<u32>,
    members: Vec<Vec<u32>>,
    around: Vec<[u32; 27]>,
}

#[derive(Debug, Clone)]
pub struct Periods {
    /// Edge lengths of the box, and their inverses. Along open axes, lengths and inverses are zero.
    lengths: Vector,
    inverses: Vector,
}

impl Periods {
    /// `periods` are the edge lengths of the box, which are infinite along open axes.
    pub fn new(periods: &Vector) -> Self {
        Self { lengths: periods.map(|x| if x.is_finite() { x } else { 0.0 }), inverses: periods.map(f64::recip) }
    }

    /// Vector from `b` to the nearest image of `a`.
    #[inline]
    pub fn separation(&self, a: &Vector, b: &Vector) -> Vector {
        let mut d = a - b;
        for k in 0..3 {
            d[k] -= self.lengths[k] * nearest_integer(d[k] * self.inverses[k]);
        }
        d
    }

    /// Moves a position into the periodic box, `[0, period)` along each axis.
    pub fn wrapped(&self, position: &Vector) -> Vector {
        position - position.component_mul(&self.inverses).map(f64::floor).component_mul(&self.lengths)
    }

    /// Edge length of the box, if the box is a periodic cube.
    fn cube(&self) -> Option<f64> {
        let edge = self.lengths.x;
        (edge > 0.0 && self.lengths == Vector::repeat(edge)).then_some(edge)
    }
}

/// Rounds to an integer without a branch, by adding and subtracting 1.5 * 2^52. Floating-point numbers of this size are
/// integers. Requires a magnitude below 2^51.
#[inline]
fn nearest_integer(x: f64) -> f64 {
    const LAST_PLACE_IS_ONE: f64 = 6_755_399_441_055_744.0;
    (x + LAST_PLACE_IS_ONE) - LAST_PLACE_IS_ONE
}

impl List {
    /// Lists all pairs within `range`. The positions must be wrapped.
    pub fn build(&mut self, positions: &[Vector], periods: &Periods, range: f64) {
        self.starts.clear();
        self.partners.clear();
        match periods.cube() {
            Some(edge) if edge > 4.0 * range => self.list_cells(positions, periods, edge, range),
            _ => self.list_all(positions, periods, range),
        }
        self.starts.push(self.partners.len());
    }

    fn list_cells(&mut self, positions: &[Vector], periods: &Periods, edge: f64, range: f64) {
        #[expect(clippy::cast_possible_truncation, reason = "cells in a box and coordinates in it")]
        let whole = |x: f64| x as usize;
        let cells = whole(edge / range);
        let along = |x: f64| whole(x / edge * cells as f64).min(cells - 1);
        let cell_of = |x: &Vector| (along(x.z) * cells + along(x.y)) * cells + along(x.x);
        if self.around.len() != cells.pow(3) {
            self.around = (0..cells.pow(3)).map(|cell| neighbourhood(cell, cells)).collect();
        }
        self.members.resize(cells.pow(3), Vec::new());
        self.members.iter_mut().for_each(Vec::clear);
        for (i, x) in (0..).zip(positions) {
            self.members[cell_of(x)].push(i);
        }
        for (i, x) in (0..).zip(positions) {
            self.starts.push(self.partners.len());
            for &cell in &self.around[cell_of(x)] {
                for &j in self.members[cell as usize].iter().filter(|&&j| j > i) {
                    if periods.separation(x, &positions[j as usize]).norm_squared() < range * range {
                        self.partners.push(j);
                    }
                }
            }
        }
    }

    fn list_all(&mut self, positions: &[Vector], periods: &Periods, range: f64) {
        for (i, x) in positions.iter().enumerate() {
            self.starts.push(self.partners.len());
            for (j, y) in (0..).zip(positions).skip(i + 1) {
                if periods.separation(x, y).norm_squared() < range * range {
                    self.partners.push(j);
                }
            }
        }
    }
}

fn neighbourhood(cell: usize, cells: usize) -> [u32; 27] {
    let shifted = |x: usize, shift: usize| (x + shift + cells - 1) % cells;
    std::array::from_fn(|k| {
        let x = shifted(cell % cells, k % 3);
        let y = shifted(cell / cells % cells, k / 3 % 3);
        let z = shifted(cell / cells / cells, k / 9);
        u32::try_from((z * cells + y) * cells + x).unwrap()
    })
}
