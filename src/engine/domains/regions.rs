//! Regions: slabs of the box across one axis, and which domains have to do with which place.

use crate::base::numbers::{trunc_to_u32, trunc_to_usize};
use crate::engine::neighbours::{Neighbours, Place};
use crate::engine::parts::Engine;
use crate::model::space::Boundary;

/// Columns for each range of the neighbour search: places are known as finely as this.
const COLUMNS_PER_REACH: f64 = 8.0;

/// No more columns than these, however long the box is.
const MOST_COLUMNS: f64 = 65_536.0;

/// Slabs of the box across one axis, in columns: those of the cells, or fine ones for the centres of lists.
///
/// A place is a cell or the centre of a list. Of each column there are sets of domains, as bits.
#[derive(Debug, Clone)]
pub struct Regions {
    axis: usize,
    lower: f64,
    per_width: f64,
    /// The domain whose region the column is in.
    pub owner: Vec<u8>,
    /// The domains of which an owned particle may be there.
    pub near: Vec<u64>,
    /// The domains of which an owned particle may read one that is there.
    pub readers: Vec<u64>,
    /// The domains that begin with a copy of one that is there.
    pub holders: Vec<u64>,
}

/// Widths of the layers around a region, in ranges of the neighbour search.
#[derive(Debug, Clone, Copy)]
pub struct Halo {
    /// How far owned particles may leave their region.
    pub slack: f64,
    /// How far copies reach beyond what owned particles can read.
    pub margin: f64,
}

impl Regions {
    /// Regions of a number of domains with about as many particles each.
    pub fn of<const FALLING: bool, const TABLE: bool>(
        engine: &Engine<FALLING, TABLE>,
        domains: usize,
        halo: Halo,
    ) -> Self {
        let space = &engine.state.space;
        let extent = |axis: usize| if space.boundary[axis] == Boundary::Flat { 0.0 } else { space.size[axis] };
        let axis = (0..3).fold(0, |longest, axis| if extent(axis) > extent(longest) { axis } else { longest });
        // The columns that one can be read across, and those of the slack and of the margin.
        // Partners that are held together may be further apart than those that are searched for.
        let longest = engine.ranges.longest;
        let further = (longest - engine.ranges.of_cells).max(0.0);
        let (columns, reach) = match &engine.neighbours {
            Neighbours::Cells(cells) => {
                let columns = cells.grid.counts()[axis];
                let next = if further > 0.0 { (longest / extent(axis) * f64::from(columns)).floor() } else { 0.0 };
                (columns as usize, next + 1.0)
            }
            Neighbours::Lists(verlet) => {
                let range = verlet.reaches.iter().copied().fold(f64::MIN_POSITIVE, f64::max) + further;
                let columns = (extent(axis) / range * COLUMNS_PER_REACH).clamp(1.0, MOST_COLUMNS).floor();
                // One more, because centres are anywhere in their columns.
                (trunc_to_usize(columns), (range * columns / extent(axis)).ceil() + 1.0)
            }
        };
        let wide = |part: f64| trunc_to_usize((part * reach).ceil());
        let slack = wide(halo.slack);
        let read = slack + wide(1.0);
        let held = read + wide(halo.margin);
        let mut regions = Self {
            axis,
            lower: space.lower[axis],
            per_width: columns as f64 / extent(axis),
            owner: vec![0; columns],
            near: vec![0; columns],
            readers: vec![0; columns],
            holders: vec![0; columns],
        };
        let mut load = vec![0_usize; columns];
        for particle in engine.particles() {
            load[regions.column(engine, particle)] += 1;
        }
        let total = load.iter().sum::<usize>().max(1);
        let mut before = 0;
        for (column, count) in load.iter().enumerate() {
            // By the middle of the column.
            let domain = (2 * before + count) * domains / (2 * total);
            regions.owner[column] = u8::try_from(domain.min(domains - 1)).unwrap_or(u8::MAX);
            before += count;
        }
        let is_periodic = space.boundary[axis] == Boundary::Periodic;
        for column in 0..columns {
            for (set, width) in [(&mut regions.near, slack), (&mut regions.readers, read), (&mut regions.holders, held)]
            {
                let around = (0..=2 * width.min(columns)).map(|k| column + columns * 2 + k - width.min(columns));
                for other in around {
                    let is_inside = (2 * columns..3 * columns).contains(&other);
                    if is_inside || is_periodic {
                        set[column] |= 1 << regions.owner[other % columns];
                    }
                }
            }
        }
        regions
    }

    /// The column of a particle's place.
    #[inline]
    pub fn column<const FALLING: bool, const TABLE: bool>(
        &self,
        engine: &Engine<FALLING, TABLE>,
        particle: u32,
    ) -> usize {
        let column = match (engine.neighbours.place(particle), &engine.neighbours) {
            (Place::Cell(cell), Neighbours::Cells(cells)) => cells.grid.index_along(cell, self.axis),
            (Place::Centre(centre), _) => trunc_to_u32((centre[self.axis] - self.lower) * self.per_width),
            _ => 0,
        };
        (column as usize).min(self.owner.len() - 1)
    }
}
