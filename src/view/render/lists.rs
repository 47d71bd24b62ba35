//! Lists of the bodies that extend into each cell of a grid.

use crate::base::numbers::{id, index, trunc_to_usize};

/// Maximum number of bodies in a cell. Further bodies are ignored.
const MOST_PER_CELL: u32 = 128;

/// The number of entries is at most `MOST_PER_BODY` per body, plus `MOST_BESIDES`.
const MOST_PER_BODY: usize = 160;
const MOST_BESIDES: usize = 1 << 14;

/// Lower and upper ends of a body along each axis.
pub(super) type Reach<const D: usize> = [[f32; 2]; D];

/// Lists for a grid over `[-1, 1]` along each axis.
#[derive(Debug, Default)]
pub(super) struct Lists<const D: usize> {
    size: usize,
    /// Index in `items` of the first entry of each cell. The final element is the number of all entries.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl<const D: usize> Lists<D> {
    /// Creates lists with cells of about the given width. If there would be too many entries, the cells are wider.
    pub fn of(bodies: &[(u32, Reach<D>)], width: f32) -> Self {
        let most = if D == 3 { 64 } else { 512 };
        let mut size = trunc_to_usize(2.0 / width.max(1e-6)).clamp(1, most);
        let bound = MOST_PER_BODY.saturating_mul(bodies.len()).saturating_add(MOST_BESIDES);
        while size > 1 && Self::entries(bodies, size, bound) > bound {
            size = size.div_ceil(2);
        }
        let mut lengths = vec![0_u32; size.pow(id(D))];
        for (_, reach) in bodies {
            Self::for_each_cell(reach, size, |cell| lengths[cell] = (lengths[cell] + 1).min(MOST_PER_CELL));
        }
        let mut starts = Vec::with_capacity(lengths.len() + 1);
        let mut sum = 0;
        starts.push(0);
        for length in &lengths {
            sum += length;
            starts.push(sum);
        }
        let mut items = vec![0; index(u64::from(sum))];
        lengths.fill(0);
        for (body, reach) in bodies {
            Self::for_each_cell(reach, size, |cell| {
                if lengths[cell] < MOST_PER_CELL {
                    items[(starts[cell] + lengths[cell]) as usize] = *body;
                    lengths[cell] += 1;
                }
            });
        }
        Self { size, starts, items }
    }

    pub fn at(&self, place: [f32; D]) -> &[u32] {
        let mut cell = 0;
        for x in place {
            let along = (x + 1.0) * (0.5 * self.size as f32);
            if !(along >= 0.0 && along < self.size as f32) {
                return &[];
            }
            cell = cell * self.size + trunc_to_usize(along);
        }
        match (self.starts.get(cell), self.starts.get(cell + 1)) {
            (Some(from), Some(to)) => self.items.get(*from as usize..*to as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Counts the entries of all cells, up to about `bound`.
    fn entries(bodies: &[(u32, Reach<D>)], size: usize, bound: usize) -> usize {
        let mut sum = 0_usize;
        for (_, reach) in bodies {
            let cells = reach.iter().map(|range| cells(range, size)).map(|[from, to]| to - from);
            sum = sum.saturating_add(cells.product());
            if sum > bound {
                break;
            }
        }
        sum
    }

    fn for_each_cell(reach: &Reach<D>, size: usize, mut visit: impl FnMut(usize)) {
        let ranges = reach.map(|range| cells(&range, size));
        if ranges.iter().any(|[from, to]| from >= to) {
            return;
        }
        let mut place = ranges.map(|[from, _]| from);
        loop {
            visit(place.iter().fold(0, |cell, along| cell * size + along));
            let Some(axis) = (0..D).rev().find(|&axis| place[axis] + 1 < ranges[axis][1]) else { return };
            place[axis] += 1;
            (axis + 1..D).for_each(|behind| place[behind] = ranges[behind][0]);
        }
    }
}

/// Returns the first cell that overlaps a range, and one past the last cell.
fn cells([from, to]: &[f32; 2], size: usize) -> [usize; 2] {
    // A range outside the grid, or with a NaN, has no cells. Conversions to integers saturate.
    let place = |x: f32| (x + 1.0) * (0.5 * size as f32);
    if !(place(*to) >= 0.0 && place(*from) < size as f32) {
        return [0, 0];
    }
    [trunc_to_usize(place(*from)), trunc_to_usize(place(*to)).saturating_add(1).min(size)]
}

pub(super) fn numbered<T>(bodies: &[T]) -> impl Iterator<Item = (u32, &T)> {
    bodies.iter().enumerate().map(|(place, body)| (id(place), body))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_is_listed_in_every_cell_it_covers() {
        let reach = |x: f32, y: f32, half: f32| [[x - half, x + half], [y - half, y + half]];
        let bodies = [
            (0, reach(-0.9, 0.1, 0.2)),
            (1, reach(0.0, 0.0, 0.05)),
            (2, reach(5.0, 0.0, 0.1)),
            (3, reach(f32::NAN, 0.0, 0.1)),
        ];
        let lists = Lists::of(&bodies, 0.1);
        assert_eq!(lists.at([-0.95, 0.0]), [0]);
        assert_eq!(lists.at([0.01, -0.01]), [1]);
        assert!(
            lists.at([0.5, 0.5]).is_empty() && lists.at([7.0, 0.0]).is_empty() && lists.at([f32::NAN, 0.0]).is_empty()
        );
    }

    #[test]
    fn scene_sized_bodies_keep_lists_short() {
        let bodies: Vec<(u32, Reach<3>)> = (0..10_000).map(|body| (body, [[-9.0, 9.0]; 3])).collect();
        let lists = Lists::of(&bodies, 0.01);
        assert!(lists.items.len() <= MOST_PER_BODY * bodies.len() + MOST_BESIDES);
        assert_eq!(lists.at([0.3; 3]).len(), MOST_PER_CELL as usize);
        assert_eq!(lists.at([0.3; 3])[0], 0);
    }
}
