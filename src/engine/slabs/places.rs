//! A set of places with times, sorted into cells.

use super::geometry::{Geometry, Near};
use crate::Vector;
use crate::base::numbers::trunc_to_usize;
use crate::engine::marks::Marks;

const NONE: u32 = u32::MAX;

/// Largest number of cells. More cells would leave the cache.
const MOST_CELLS: usize = 16_384;

#[derive(Debug, Clone, Copy)]
struct Entry {
    at: Vector,
    time: f64,
    next: u32,
}

#[derive(Debug, Clone)]
pub struct Places {
    near: Near,
    periods: Vector,
    lower: Vector,
    /// Inverse width and number of the cells along each axis.
    per_width: Vector,
    counts: [usize; 3],
    /// The first entry of each cell.
    first: Vec<u32>,
    /// The cells that are not empty.
    filled: Vec<usize>,
    entries: Vec<Entry>,
    /// Particles that are held back.
    held: Marks,
    listed: Vec<u32>,
    /// Largest depth of a place.
    pub deepest: f64,
}

impl Places {
    /// Creates an empty set for searches within `near`.
    pub fn new(geometry: &Geometry, near: Near) -> Self {
        let mut counts = [1; 3];
        // There are few places for many cells, so the cells may be long along the axis that is cut.
        for further in 1..=3 {
            let axis = (geometry.axis + further) % 3;
            let most = MOST_CELLS / counts.iter().product::<usize>();
            counts[axis] = trunc_to_usize(geometry.size[axis] / near.along(axis)).min(1024).min(most).max(1);
        }
        let per_width = Vector::from_fn(|axis, _| counts[axis] as f64 / geometry.size[axis].max(f64::MIN_POSITIVE));
        Self {
            near,
            periods: geometry.periods,
            lower: geometry.lower,
            per_width,
            counts,
            first: vec![NONE; counts.iter().product()],
            filled: Vec::new(),
            entries: Vec::new(),
            held: Marks::default(),
            listed: Vec::new(),
            deepest: 0.0,
        }
    }

    pub fn clear(&mut self) {
        for cell in self.filled.drain(..) {
            self.first[cell] = NONE;
        }
        for particle in self.listed.drain(..) {
            self.held.put(particle, false);
        }
        self.entries.clear();
        self.deepest = 0.0;
    }

    pub fn hold(&mut self, particle: u32) {
        self.held.put(particle, true);
        self.listed.push(particle);
    }

    #[inline]
    pub fn holds(&self, particle: u32) -> bool {
        self.held.has(particle)
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the numbers of the cell at a place along the axes. Places outside the box are in the outermost cells.
    fn cell(&self, at: &Vector) -> [usize; 3] {
        std::array::from_fn(|axis| {
            let number = (at[axis] - self.lower[axis]) * self.per_width[axis];
            // Places just outside the box are within the outermost cells or, along periodic axes, at their outer faces.
            trunc_to_usize(number).min(self.counts[axis] - 1)
        })
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.counts[1] + y) * self.counts[2] + z
    }

    pub fn add(&mut self, at: &Vector, time: f64, depth: f64) {
        let cell = self.number(self.cell(at));
        if self.first[cell] == NONE {
            self.filled.push(cell);
        }
        let number = u32::try_from(self.entries.len()).unwrap_or(NONE);
        self.entries.push(Entry { at: *at, time, next: self.first[cell] });
        self.first[cell] = number;
        self.deepest = self.deepest.max(depth);
    }

    /// Whether the set has an entry near the position `at`, with the time `since` or later.
    pub fn has_near(&self, at: &Vector, since: f64) -> bool {
        if self.entries.is_empty() {
            return false;
        }
        let cell = self.cell(at);
        let [xs, ys, zs] = [0, 1, 2].map(|axis| around(cell[axis], self.counts[axis]));
        for &x in xs.some() {
            for &y in ys.some() {
                for &z in zs.some() {
                    let mut number = self.first[self.number([x, y, z])];
                    while let Some(entry) = self.entries.get(number as usize) {
                        if entry.time >= since && self.near.has(&self.apart(at, &entry.at)) {
                            return true;
                        }
                        number = entry.next;
                    }
                }
            }
        }
        false
    }

    fn apart(&self, a: &Vector, b: &Vector) -> Vector {
        Vector::from_fn(|k, _| {
            let apart = (a[k] - b[k]).abs();
            apart.min((self.periods[k] - apart).abs())
        })
    }
}

/// Up to three neighbouring cells along an axis.
struct Cells([usize; 3], usize);

impl Cells {
    fn some(&self) -> &[usize] {
        &self.0[..self.1]
    }
}

/// Returns a cell and its neighbours along an axis with `count` cells.
fn around(cell: usize, count: usize) -> Cells {
    let (before, after) = (if cell == 0 { count - 1 } else { cell - 1 }, if cell + 1 == count { 0 } else { cell + 1 });
    Cells([cell, after, before], count.min(3))
}
