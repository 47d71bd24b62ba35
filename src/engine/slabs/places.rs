//! A set of places with times, sorted into columns of cells along the axis that is cut.

use super::geometry::{Geometry, Near};
use crate::Vector;
use crate::base::numbers::trunc_to_usize;
use crate::engine::marks::Marks;

const NONE: u32 = u32::MAX;

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
    /// The two axes across the axis that is cut, with the lower end, the inverse width and the number of cells of each.
    across: [(usize, f64, f64, usize); 2],
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
        let across = [1, 2].map(|further| {
            let axis = (geometry.axis + further) % 3;
            let size = geometry.size[axis];
            let count = trunc_to_usize(size / near.along(axis)).clamp(1, 1024);
            (axis, geometry.lower[axis], count as f64 / size.max(f64::MIN_POSITIVE), count)
        });
        Self {
            near,
            periods: geometry.periods,
            first: vec![NONE; across[0].3 * across[1].3],
            across,
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

    /// Returns the numbers of the cell at a place along the two axes. Places outside the box are in the outermost cells.
    fn cell(&self, at: &Vector) -> [usize; 2] {
        self.across.map(|(axis, lower, per_width, count)| {
            let number = (at[axis] - lower) * per_width;
            // Places just outside the box are within the outermost cells or, along periodic axes, at their outer faces.
            trunc_to_usize(number).min(count - 1)
        })
    }

    pub fn add(&mut self, at: &Vector, time: f64, depth: f64) {
        let [y, z] = self.cell(at);
        let cell = y * self.across[1].3 + z;
        if self.first[cell] == NONE {
            self.filled.push(cell);
        }
        let number = u32::try_from(self.entries.len()).unwrap_or(NONE);
        self.entries.push(Entry { at: *at, time, next: self.first[cell] });
        self.first[cell] = number;
        self.deepest = self.deepest.max(depth);
    }

    /// Whether the set has a place near `at` with a time of at least `since`.
    pub fn has_near(&self, at: &Vector, since: f64) -> bool {
        if self.entries.is_empty() {
            return false;
        }
        let [y, z] = self.cell(at);
        let [rows, columns] = [self.around(y, 0), self.around(z, 1)];
        for &row in &rows {
            for &column in &columns {
                let mut number = self.first[row * self.across[1].3 + column];
                while let Some(entry) = self.entries.get(number as usize) {
                    if entry.time >= since && self.near.has(&self.apart(at, &entry.at)) {
                        return true;
                    }
                    number = entry.next;
                }
            }
        }
        false
    }

    /// Returns a cell and its neighbours along one of the two axes. Cells may be repeated.
    fn around(&self, cell: usize, k: usize) -> [usize; 3] {
        let count = self.across[k].3;
        [if cell == 0 { count - 1 } else { cell - 1 }, cell, if cell + 1 == count { 0 } else { cell + 1 }]
    }

    fn apart(&self, a: &Vector, b: &Vector) -> Vector {
        Vector::from_fn(|k, _| {
            let apart = (a[k] - b[k]).abs();
            apart.min((self.periods[k] - apart).abs())
        })
    }
}
