//! Which ball each cell of a light's plane sees first.

use super::raster::NOTHING;
use crate::base::numbers::trunc_to_usize;

/// The part of a light's plane that balls cover, with a rim of one cell.
#[derive(Debug, Default)]
pub(super) struct Map {
    /// The middle of the first cell, along a row and along a column, from the centre of the plane.
    start: [f32; 2],
    /// Length of a row.
    columns: usize,
    /// The last cell along a row and along a column.
    last: [f32; 2],
    /// Index of the ball that each cell sees first.
    first_seen: Vec<u32>,
}

/// A ball as a light sees it, in cells.
pub(super) struct Disc {
    index: u32,
    x: f32,
    y: f32,
    /// How near to the light its centre is.
    top: f32,
    radius: f32,
    /// The cells that it may cover: the first, and the one behind the last.
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Map {
    /// Draws discs into a plane of `size` cells along each side.
    pub fn of(discs: &[Disc], size: usize) -> Self {
        let range = |cells: fn(&Disc) -> [usize; 2]| {
            let low = discs.iter().map(|disc| cells(disc)[0]).min().unwrap_or(0);
            let high = discs.iter().map(|disc| cells(disc)[1]).max().unwrap_or(0);
            [low.saturating_sub(1), (high + 1).min(size)]
        };
        let ([left, right], [top, bottom]) = (range(|disc| disc.columns), range(|disc| disc.rows));
        let columns = right - left;
        let middles: Vec<f32> = (left..right).map(|column| column as f32 + 0.5).collect();
        let mut height = vec![f32::NEG_INFINITY; columns * (bottom - top)];
        let mut first_seen = vec![NOTHING; height.len()];
        for disc in discs {
            let [low, high] = disc.columns.map(|column| column - left);
            for row in disc.rows[0]..disc.rows[1] {
                let start = (row - top) * columns;
                let cells = start + low..start + high;
                let cells = (&mut height[cells.clone()], &mut first_seen[cells]);
                disc.draw_row(row as f32 + 0.5 - disc.y, cells, &middles[low..high]);
            }
        }
        Self {
            start: [left, top].map(|cells| cells as f32 + 0.5 - 0.5 * size as f32),
            columns,
            last: [columns, bottom - top].map(|cells| cells.saturating_sub(1) as f32),
            first_seen,
        }
    }

    /// Bodies seen by the four cells around a place, given from the centre of the plane: first two that are across from each other. `None` where no
    /// ball is.
    pub fn around(&self, [x, y]: [f32; 2]) -> Option<[u32; 4]> {
        let (x, y) = (x - self.start[0], y - self.start[1]);
        if !(x >= 0.0 && y >= 0.0 && x < self.last[0] && y < self.last[1]) {
            return None;
        }
        let corner = trunc_to_usize(y) * self.columns + trunc_to_usize(x);
        let (upper, lower) = (self.first_seen.get(corner..)?, self.first_seen.get(corner + self.columns..)?);
        match (upper, lower) {
            (&[a, b, ..], &[c, d, ..]) => Some([a, d, b, c]),
            _ => None,
        }
    }

    /// The number of cells.
    #[cfg(test)]
    pub fn cells(&self) -> usize {
        self.first_seen.len()
    }
}

impl Disc {
    /// A disc around a place from the centre of a plane of `size` cells along each side; `None` where it covers none.
    pub fn of(index: u32, from_centre: [f32; 2], top: f32, radius: f32, size: usize) -> Option<Self> {
        let [x, y] = from_centre.map(|x| x + 0.5 * size as f32);
        // Numbers saturate, and NaN becomes 0: what is outside of the map has no cells.
        let cells = |x: f32| {
            let low = trunc_to_usize((x - radius - 0.5).ceil()).min(size);
            [low, trunc_to_usize(x + radius + 0.5).min(size)]
        };
        let (columns, rows) = (cells(x), cells(y));
        let is_seen = columns[0] < columns[1] && rows[0] < rows[1];
        is_seen.then_some(Self { index, x, y, top, radius, columns, rows })
    }

    /// Draws cells of a row with given middles, `from_row` away from the centre. Where the disc does not cover a cell, the root is not a number,
    /// which is higher than nothing: without a branch, several cells are drawn at once.
    fn draw_row(&self, from_row: f32, (heights, first_seen): (&mut [f32], &mut [u32]), middles: &[f32]) {
        let square = self.radius * self.radius - from_row * from_row;
        if square < 0.0 {
            return;
        }
        for ((height, first_seen), middle) in heights.iter_mut().zip(first_seen).zip(middles) {
            let from_column = middle - self.x;
            let surface = self.top + (square - from_column * from_column).sqrt();
            let is_higher = surface > *height;
            *height = if is_higher { surface } else { *height };
            *first_seen = if is_higher { self.index } else { *first_seen };
        }
    }
}
