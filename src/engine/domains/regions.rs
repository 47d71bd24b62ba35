//! Cuts the box into blocks, one for each domain. Finds the domains that own a particle, copy the particle, or read the
//! particle in predictions.

use crate::base::numbers::{trunc_to_u32, trunc_to_usize};
use crate::engine::neighbours::{Neighbours, Place};
use crate::engine::parts::Engine;
use crate::model::space::Boundary;

/// Number of columns per range of the neighbour lists.
const COLUMNS_PER_REACH: f64 = 8.0;

/// Largest number of columns of an axis, because every cut visits all columns.
const MOST_COLUMNS: f64 = 65_536.0;
const MOST_COLUMNS_PER_PARTICLE: f64 = 64.0;

const SAMPLE: usize = 20_000;

/// Widths of the layers around a region, in units of the range of the neighbour search.
#[derive(Debug, Clone, Copy)]
pub struct Halo {
    /// Largest distance of an owned particle from its region.
    pub slack: f64,
    /// Width of the outermost layer. Its particles are too far away to affect an owned particle directly.
    pub margin: f64,
}

/// Columns of a particle along the axes that are cut.
pub type Columns = [u32; 3];

/// Blocks of the box, which are the intersections of slabs along one or more axes.
///
/// The place of a particle is its cell, or the centre of its neighbour list.
#[derive(Debug, Clone)]
pub struct Regions {
    axes: Vec<Axis>,
}

#[derive(Debug, Clone)]
struct Axis {
    axis: usize,
    lower: f64,
    per_width: f64,
    is_periodic: bool,
    last: u32,
    /// Predictions read other particles up to this distance, in columns.
    reach: f64,
    load: Vec<usize>,
    slabs: Slabs,
}

/// Sets of domains for each column of an axis, one bit per domain. The set for a place in the box is the intersection
/// of the sets along all axes.
#[derive(Debug, Clone, Default)]
struct Slabs {
    /// Domains whose regions contain the column.
    owners: Vec<u64>,
    /// Domains that may own a particle in this column.
    near: Vec<u64>,
    /// Domains in which predictions may read a particle in this column.
    readers: Vec<u64>,
    /// Domains that hold a copy of a particle in this column when the system is cut.
    holders: Vec<u64>,
}

impl Regions {
    /// Divides the box into regions of up to 64 domains. The division minimises the number of particles in the largest
    /// domain, copies included.
    pub fn of<const FALLING: bool, const TABLE: bool>(
        engine: &Engine<FALLING, TABLE>,
        domains: usize,
        halo: Halo,
    ) -> Self {
        let axes: Vec<Option<Axis>> = (0..3).map(|axis| Axis::of(engine, axis)).collect();
        let mut best: Option<(usize, Self)> = None;
        for numbers in factors(domains) {
            let cut = (0..3).filter(|&axis| numbers[axis] > 1);
            let cut = cut.map(|axis| axes[axis].as_ref().map(|axis| axis.cut(numbers, halo)));
            let Some(axes) = cut.collect::<Option<Vec<Axis>>>() else { continue };
            let regions = Self { axes };
            let largest = regions.largest(engine, domains);
            if best.as_ref().is_none_or(|(smallest, _)| largest < *smallest) {
                best = Some((largest, regions));
            }
        }
        best.map_or_else(|| Self { axes: Vec::new() }, |(_, regions)| regions)
    }

    /// Returns the number of sampled particles in the largest domain, copies included.
    fn largest<const FALLING: bool, const TABLE: bool>(
        &self,
        engine: &Engine<FALLING, TABLE>,
        domains: usize,
    ) -> usize {
        let mut counts = vec![0; domains];
        let step = (engine.particles().len() / SAMPLE).max(1);
        for particle in engine.particles().step_by(step) {
            let mut holders = self.holders(self.columns(engine, particle));
            while holders != 0 && domains > 1 {
                counts[holders.trailing_zeros() as usize] += 1;
                holders &= holders - 1;
            }
        }
        counts.into_iter().max().unwrap_or(0)
    }

    #[inline]
    pub fn columns<const FALLING: bool, const TABLE: bool>(
        &self,
        engine: &Engine<FALLING, TABLE>,
        particle: u32,
    ) -> Columns {
        let mut columns = [0; 3];
        for (column, axis) in columns.iter_mut().zip(&self.axes) {
            *column = axis.column(engine, particle);
        }
        columns
    }

    #[inline]
    pub fn owner(&self, columns: Columns) -> u8 {
        #[expect(clippy::cast_possible_truncation, reason = "a number of a bit")]
        let owner = self.common(columns, |slabs| &slabs.owners).trailing_zeros() as u8;
        owner
    }

    #[inline]
    pub fn near(&self, columns: Columns) -> u64 {
        self.common(columns, |slabs| &slabs.near)
    }

    #[inline]
    pub fn readers(&self, columns: Columns) -> u64 {
        self.common(columns, |slabs| &slabs.readers)
    }

    #[inline]
    pub fn holders(&self, columns: Columns) -> u64 {
        self.common(columns, |slabs| &slabs.holders)
    }

    /// Returns the intersection of the sets along all axes, or the first domain if the box is not cut.
    #[inline(always)]
    fn common(&self, columns: Columns, sets: impl Fn(&Slabs) -> &[u64]) -> u64 {
        if self.axes.is_empty() {
            return 1;
        }
        self.axes
            .iter()
            .zip(columns)
            .fold(u64::MAX, |common, (axis, column)| common & sets(&axis.slabs)[column as usize])
    }
}

impl Axis {
    fn of<const FALLING: bool, const TABLE: bool>(engine: &Engine<FALLING, TABLE>, axis: usize) -> Option<Self> {
        let space = &engine.state.space;
        if space.boundary[axis] == Boundary::Flat {
            return None;
        }
        let extent = space.size[axis];
        let (columns, reach) = columns_and_reach(engine, axis, extent);
        let mut of = Self {
            axis,
            lower: space.lower[axis],
            per_width: columns as f64 / extent,
            is_periodic: space.boundary[axis] == Boundary::Periodic,
            last: trunc_to_u32((columns - 1) as f64),
            reach,
            load: vec![0; columns],
            slabs: Slabs::default(),
        };
        for particle in engine.particles() {
            let column = of.column(engine, particle);
            of.load[column as usize] += 1;
        }
        Some(of)
    }

    fn cut(&self, numbers: [usize; 3], halo: Halo) -> Self {
        let columns = self.load.len();
        let none = || vec![0; columns];
        let mut slabs = Slabs { owners: none(), near: none(), readers: none(), holders: none() };
        let total = self.load.iter().sum::<usize>().max(1);
        let of_slab: Vec<u64> = (0..numbers[self.axis]).map(|slab| domains_of(numbers, self.axis, slab)).collect();
        let mut before = 0;
        for (owners, count) in slabs.owners.iter_mut().zip(&self.load) {
            // The middle particle of a column decides to which slab the column belongs.
            let slab = (2 * before + count) * numbers[self.axis] / (2 * total);
            *owners = of_slab[slab.min(numbers[self.axis] - 1)];
            before += count;
        }
        let wide = |part: f64| trunc_to_usize((part * self.reach).ceil());
        let slack = wide(halo.slack);
        let read = slack + wide(1.0);
        let held = read + wide(halo.margin);
        for (sets, width) in [(&mut slabs.near, slack), (&mut slabs.readers, read), (&mut slabs.holders, held)] {
            self.widen(&slabs.owners, width, sets);
        }
        Self { slabs, load: Vec::new(), ..self.clone() }
    }

    /// Adds the owners of each column to the sets of all columns within `width` columns. Works slab by slab, which is
    /// fast even for a halo as wide as the box.
    fn widen(&self, owners: &[u64], width: usize, sets: &mut [u64]) {
        let columns = owners.len();
        let mut begin = 0;
        for slab in owners.chunk_by(|a, b| a == b) {
            let end = begin + slab.len();
            let around = (end - begin).saturating_add(2 * width.min(columns));
            if self.is_periodic && around >= columns {
                sets.iter_mut().for_each(|set| *set |= slab[0]);
            } else if self.is_periodic {
                let from = begin + columns - width.min(columns);
                (from..from + around).for_each(|column| sets[column % columns] |= slab[0]);
            } else {
                let within = begin.saturating_sub(width)..end.saturating_add(width).min(columns);
                sets[within].iter_mut().for_each(|set| *set |= slab[0]);
            }
            begin = end;
        }
    }

    #[inline]
    fn column<const FALLING: bool, const TABLE: bool>(&self, engine: &Engine<FALLING, TABLE>, particle: u32) -> u32 {
        let column = match (engine.neighbours.place(particle), &engine.neighbours) {
            (Place::Cell(cell), Neighbours::Cells(cells)) => cells.grid.index_along(cell, self.axis),
            (Place::Centre(centre), _) => trunc_to_u32((centre[self.axis] - self.lower) * self.per_width),
            _ => 0,
        };
        column.min(self.last)
    }
}

/// Returns the number of columns of an axis, and the distance in columns up to which predictions can read.
///
/// Captured partners may be further apart than the range of the neighbour search.
fn columns_and_reach<const FALLING: bool, const TABLE: bool>(
    engine: &Engine<FALLING, TABLE>,
    axis: usize,
    extent: f64,
) -> (usize, f64) {
    let longest = engine.ranges.longest;
    let further = (longest - engine.ranges.of_cells).max(0.0);
    match &engine.neighbours {
        Neighbours::Cells(cells) => {
            let columns = cells.grid.counts()[axis];
            let next = if further > 0.0 { (longest / extent * f64::from(columns)).floor() } else { 0.0 };
            (columns as usize, next + 1.0)
        }
        Neighbours::Lists(verlet) => {
            let range = verlet.levels.largest_reach().max(f64::MIN_POSITIVE) + further;
            let most = MOST_COLUMNS.min(MOST_COLUMNS_PER_PARTICLE * engine.particles().len() as f64).max(1.0);
            let columns = (extent / range * COLUMNS_PER_REACH).clamp(1.0, most).floor();
            // One column is added, because a list centre may be anywhere in its column.
            (trunc_to_usize(columns), (range * columns / extent).ceil() + 1.0)
        }
    }
}

/// Returns all ordered triples of numbers with the given product. Triples with more ones come first.
fn factors(product: usize) -> Vec<[usize; 3]> {
    let divisors = |of: usize| (1..=of).filter(move |divisor| of.is_multiple_of(*divisor));
    let with = |x: usize| divisors(product / x).map(move |y| [x, y, product / x / y]);
    let mut factors: Vec<[usize; 3]> = divisors(product).flat_map(with).collect();
    factors.sort_by_key(|numbers| numbers.iter().filter(|number| **number > 1).count());
    factors
}

fn domains_of(numbers: [usize; 3], axis: usize, slab: usize) -> u64 {
    let [_, ny, nz] = numbers;
    let block = |domain: usize| [domain / (ny * nz), domain / nz % ny, domain % nz];
    let domains = 0..numbers.iter().product();
    domains.filter(|&domain| block(domain)[axis] == slab).fold(0, |set, domain| set | 1 << domain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::columns::tests::spheres;
    use crate::model::potential::Potential;

    #[test]
    fn each_position_has_one_owner_whose_halo_holds_it() {
        let scene = spheres(Potential::hard_sphere(1.0).unwrap(), 0.3, 32_000).build().unwrap();
        let engine = Engine::<false, false>::new(&scene);
        for (domains, axes) in [(1, 0), (2, 1), (8, 2), (13, 1)] {
            let regions = Regions::of(&engine, domains, Halo { slack: 0.2, margin: 1.1 });
            assert_eq!(regions.axes.len(), axes, "{domains}");
            let mut owned = vec![0; domains];
            for particle in engine.particles() {
                let columns = regions.columns(&engine, particle);
                let owner = regions.owner(columns);
                owned[usize::from(owner)] += 1;
                let sets = [regions.near(columns), regions.readers(columns), regions.holders(columns)];
                assert!(sets.iter().all(|set| set & 1 << owner != 0 && *set < 1 << domains), "{domains} {sets:?}");
                assert_eq!((sets[0] & !sets[1], sets[1] & !sets[2]), (0, 0), "{domains} {sets:?}");
            }
            // The domains own equal numbers of particles, to within one lattice plane.
            let is_fair = |count: &usize| count.abs_diff(32_000 / domains) <= 800;
            assert!(owned.iter().all(is_fair), "{owned:?}");
        }
    }

    #[test]
    fn a_halo_holds_every_column_within_its_width() {
        let scene = spheres(Potential::hard_sphere(1.0).unwrap(), 0.3, 32_000).build().unwrap();
        let engine = Engine::<false, false>::new(&scene);
        let mut axis = Axis::of(&engine, 0).unwrap();
        let owners: Vec<u64> = [1, 1, 1, 2, 4, 4, 4, 4, 4, 8, 8].to_vec();
        for (is_periodic, width) in [(false, 0), (false, 2), (false, 40), (true, 0), (true, 1), (true, 4), (true, 40)] {
            axis.is_periodic = is_periodic;
            let mut sets = vec![0; owners.len()];
            axis.widen(&owners, width, &mut sets);
            for (column, set) in sets.iter().enumerate() {
                let is_near = |other: usize| {
                    let apart = column.abs_diff(other);
                    apart <= width || is_periodic && owners.len() - apart <= width
                };
                let expected = (0..owners.len()).filter(|&other| is_near(other)).fold(0, |all, at| all | owners[at]);
                assert_eq!(*set, expected, "column {column}, width {width}, periodic {is_periodic}");
            }
        }
    }

    #[test]
    fn factors_lists_all_block_grids() {
        assert_eq!(factors(4).len(), 6);
        assert_eq!(factors(64).len(), 28);
        assert!(factors(12).iter().all(|[x, y, z]| x * y * z == 12));
    }
}
