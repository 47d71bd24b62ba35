//! Lists of neighbours for the baselines: each pair once, from cells where a periodic cube has enough of them.

use carom::Vector;

/// The partners of particle `i` are `partners[starts[i]..starts[i + 1]]`.
#[derive(Default)]
pub struct List {
    pub starts: Vec<usize>,
    pub partners: Vec<u32>,
    /// Particles of each cell, and the cells around it.
    members: Vec<Vec<u32>>,
    around: Vec<[u32; 27]>,
}

/// The component of a separation to the nearest image, for positions within the box; the period may be infinite.
#[inline]
fn nearest(d: f64, period: f64) -> f64 {
    let half = 0.5 * period;
    let shift = if d > half {
        period
    } else if d < -half {
        -period
    } else {
        0.0
    };
    d - shift
}

#[inline]
pub fn separation(a: &Vector, b: &Vector, periods: &Vector) -> Vector {
    (a - b).zip_map(periods, nearest)
}

/// The image of a position in `[0, period)`.
pub fn wrapped(position: &Vector, periods: &Vector) -> Vector {
    position.zip_map(periods, |x, period| if period.is_finite() { x - period * (x / period).floor() } else { x })
}

impl List {
    /// All pairs within `range` of wrapped positions.
    pub fn build(&mut self, positions: &[Vector], periods: &Vector, range: f64) {
        let length = periods.x;
        let cells =
            if length.is_finite() && *periods == Vector::repeat(length) { (length / range) as usize } else { 0 };
        self.starts.clear();
        self.partners.clear();
        if cells > 3 {
            self.list_cells(positions, length, range, cells);
        } else {
            self.list_all(positions, periods, range);
        }
        self.starts.push(self.partners.len());
    }

    fn list_cells(&mut self, positions: &[Vector], length: f64, range: f64, cells: usize) {
        let periods = Vector::repeat(length);
        let along = |x: f64| ((x / length * cells as f64) as usize).min(cells - 1);
        let cell_of = |x: &Vector| (along(x.z) * cells + along(x.y)) * cells + along(x.x);
        if self.around.len() != cells.pow(3) {
            self.around = (0..cells.pow(3)).map(|cell| neighbourhood(cell, cells)).collect();
        }
        self.members.resize(cells.pow(3), Vec::new());
        self.members.iter_mut().for_each(Vec::clear);
        for (i, x) in positions.iter().enumerate() {
            self.members[cell_of(x)].push(i as u32);
        }
        for (i, x) in positions.iter().enumerate() {
            self.starts.push(self.partners.len());
            for &cell in &self.around[cell_of(x)] {
                for &j in self.members[cell as usize].iter().filter(|&&j| j > i as u32) {
                    if separation(x, &positions[j as usize], &periods).norm_squared() < range * range {
                        self.partners.push(j);
                    }
                }
            }
        }
    }

    fn list_all(&mut self, positions: &[Vector], periods: &Vector, range: f64) {
        for (i, x) in positions.iter().enumerate() {
            self.starts.push(self.partners.len());
            for (j, y) in positions.iter().enumerate().skip(i + 1) {
                if separation(x, y, periods).norm_squared() < range * range {
                    self.partners.push(j as u32);
                }
            }
        }
    }
}

/// A cell and those around it in a periodic box.
fn neighbourhood(cell: usize, cells: usize) -> [u32; 27] {
    let shifted = |x: usize, shift: usize| (x + shift + cells - 1) % cells;
    std::array::from_fn(|k| {
        let x = shifted(cell % cells, k % 3);
        let y = shifted(cell / cells % cells, k / 3 % 3);
        let z = shifted(cell / cells / cells, k / 9);
        ((z * cells + y) * cells + x) as u32
    })
}
