//! The map of a light: the ball that each of its cells sees first.
//!
//! Balls are drawn one after the other, each over the cells that it covers. Where they are so large that each covers most of the map, that would be
//! all cells for each ball: a large one is drawn tile by tile, and not where others are known to stand before all of it.

use std::ops::Range;

use super::raster::NOTHING;
use crate::base::numbers::trunc_to_usize;

/// Cells along each side.
pub(super) const MAP_SIZE: usize = 768;

/// Cells of a tile along each side.
const TILE: usize = 16;
const TILES: usize = MAP_SIZE / TILE;

/// A ball as a light sees it: lengths across in cells, heights towards the light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    pub centre: [f32; 2],
    pub radius: f32,
    pub top: f32,
}

impl Disc {
    /// Height of the surface at a distance from the middle, where the ball has one. It falls with either part of the distance, also as it is rounded.
    fn surface(&self, dx: f32, dy: f32) -> f32 {
        let square = self.radius * self.radius - dx * dx - dy * dy;
        // Beside the ball the root is no number, and the other one is taken.
        (self.top + square.sqrt() * (2.0 / MAP_SIZE as f32)).max(f32::NEG_INFINITY)
    }

    /// The cells along an axis that it may cover. Numbers saturate, and NaN becomes 0: what is outside of the map has no cells.
    fn cells(&self, axis: usize) -> Range<usize> {
        let x = self.centre[axis];
        let low = trunc_to_usize((x - self.radius - 0.5).ceil()).min(MAP_SIZE);
        low..trunc_to_usize(x + self.radius + 0.5).min(MAP_SIZE)
    }

    /// The least distance along an axis from its middle to the middle of a cell.
    fn nearest(&self, axis: usize, cells: &Range<usize>) -> f32 {
        let x = self.centre[axis];
        let (low, high) = (cells.start as f32 + 0.5 - x, (cells.end - 1) as f32 + 0.5 - x);
        if low > 0.0 { low } else { high.min(0.0) }
    }
}

/// A map while balls are drawn.
pub(super) struct LightMap {
    height: Vec<f32>,
    first: Vec<u32>,
    /// A height below that of all cells of each tile.
    floor: Vec<f32>,
}

impl LightMap {
    pub fn empty() -> Self {
        Self {
            height: vec![f32::NEG_INFINITY; MAP_SIZE * MAP_SIZE],
            first: vec![NOTHING; MAP_SIZE * MAP_SIZE],
            floor: vec![f32::NEG_INFINITY; TILES * TILES],
        }
    }

    /// Draws a ball with an index, over what is lower; with how many cells it was compared.
    pub fn add(&mut self, index: u32, disc: &Disc) -> usize {
        let (columns, rows) = (disc.cells(0), disc.cells(1));
        if columns.is_empty() || rows.is_empty() {
            return 0;
        }
        if disc.radius < TILE as f32 {
            self.draw(index, disc, &columns, &rows);
            return columns.len() * rows.len();
        }
        let mut compared = 0;
        for tile_row in rows.start / TILE..rows.end.div_ceil(TILE) {
            for tile_column in columns.start / TILE..columns.end.div_ceil(TILE) {
                let part =
                    |tile: usize, cells: &Range<usize>| cells.start.max(tile * TILE)..cells.end.min((tile + 1) * TILE);
                let (columns, rows) = (part(tile_column, &columns), part(tile_row, &rows));
                let highest = disc.surface(disc.nearest(0, &columns), disc.nearest(1, &rows));
                let floor = self.floor[tile_row * TILES + tile_column];
                if highest <= floor {
                    continue;
                }
                compared += columns.len() * rows.len();
                let lowest = self.draw(index, disc, &columns, &rows);
                if columns.len() * rows.len() == TILE * TILE {
                    self.floor[tile_row * TILES + tile_column] = floor.max(lowest);
                }
            }
        }
        compared
    }

    /// Draws a ball in some cells; the height of its lowest one.
    fn draw(&mut self, index: u32, disc: &Disc, columns: &Range<usize>, rows: &Range<usize>) -> f32 {
        let mut lowest = f32::INFINITY;
        for row in rows.clone() {
            let dy = row as f32 + 0.5 - disc.centre[1];
            let cells = row * MAP_SIZE + columns.start..row * MAP_SIZE + columns.end;
            let (heights, firsts) = (&mut self.height[cells.clone()], &mut self.first[cells]);
            for ((column, height), first) in columns.clone().zip(heights).zip(firsts) {
                let surface = disc.surface(column as f32 + 0.5 - disc.centre[0], dy);
                lowest = lowest.min(surface);
                if surface > *height {
                    *height = surface;
                    *first = index;
                }
            }
        }
        lowest
    }

    /// Index of the ball that each cell sees first.
    pub fn into_first(self) -> Vec<u32> {
        self.first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    /// Discs with their middles in the inner third of the map.
    fn discs(count: usize, radii: Range<f32>) -> Vec<Disc> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut between = |low: f32, high: f32| low + (high - low) * (random.next_u32() >> 8) as f32 / (1 << 24) as f32;
        let third = MAP_SIZE as f32 / 3.0;
        let mut disc = || Disc {
            centre: [between(third, 2.0 * third), between(third, 2.0 * third)],
            radius: between(radii.start, radii.end),
            top: between(-0.3, 0.3),
        };
        (0..count).map(|_| disc()).collect()
    }

    fn drawn(discs: &[Disc]) -> (LightMap, usize) {
        let mut map = LightMap::empty();
        let compared = (0..).zip(discs).map(|(index, disc)| map.add(index, disc)).sum();
        (map, compared)
    }

    #[test]
    fn each_cell_sees_the_highest_ball_and_of_equal_ones_the_first() {
        for radii in [0.2..3.0, 10.0..60.0, 200.0..900.0, 1e5..1e7, 1e30..f32::INFINITY] {
            let mut discs = discs(40, radii);
            discs.extend_from_within(..20);
            discs.push(Disc { centre: [f32::NAN, 5.0], radius: 300.0, top: 0.1 });
            discs.push(Disc { centre: [300.0, 300.0], radius: 300.0, top: f32::NAN });
            let (map, _) = drawn(&discs);
            for cell in (0..MAP_SIZE * MAP_SIZE).step_by(7) {
                let at = [cell % MAP_SIZE, cell / MAP_SIZE];
                let (mut highest, mut first) = (f32::NEG_INFINITY, NOTHING);
                for (index, disc) in
                    (0..).zip(&discs).filter(|(_, disc)| (0..2).all(|k| disc.cells(k).contains(&at[k])))
                {
                    let [dx, dy] = [0, 1].map(|k| at[k] as f32 + 0.5 - disc.centre[k]);
                    let surface = disc.surface(dx, dy);
                    if surface > highest {
                        (highest, first) = (surface, index);
                    }
                }
                assert_eq!((map.first[cell], map.height[cell]), (first, highest), "{at:?}");
            }
        }
    }

    #[test]
    fn balls_larger_than_the_map_are_not_compared_with_all_its_cells() {
        for (radii, most) in [(350.0..400.0, 0.25), (3000.0..4000.0, 0.06), (1e5..1e6, 0.05)] {
            let discs = discs(256, radii.clone());
            let covered: usize = discs.iter().map(|disc| disc.cells(0).len() * disc.cells(1).len()).sum();
            let compared = drawn(&discs).1 as f64 / covered as f64;
            assert!(compared < most, "{radii:?}: {compared}");
        }
    }
}
