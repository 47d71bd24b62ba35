//! Number density around particles, without the empty parts of the box.

use crate::Vector;
use crate::base::numbers::{trunc_to_i32, trunc_to_usize};
use crate::model::space::{Boundary, Space};

/// Mean number density around particles `[length^-dimensions]`. Empty parts of the box do not count.
pub(super) fn local_density<I: Iterator<Item = Vector>>(space: &Space, range: f64, positions: impl Fn() -> I) -> f64 {
    /// Mean number of particles per cell. A single particle then hardly changes the density.
    const MANY: f64 = 32.0;
    let extent = |k: usize| (space.boundary[k] != Boundary::Flat).then_some(space.size[k]);
    let volume: f64 = (0..3).filter_map(extent).product();
    let mut density = positions().count() as f64 / volume;
    // If part of the box is empty, the first cells are too large. Each pass uses the density of the previous pass.
    for _ in 0..3 {
        let fair = libm::pow(MANY / density, 1.0 / space.dimensions() as f64).max(2.0 * range);
        density = density_in_cells(space, fair, &positions);
    }
    density
}

/// Returns the mean number density around particles, from counts in cells with sides of about `fair`.
fn density_in_cells<I: Iterator<Item = Vector>>(space: &Space, fair: f64, positions: impl Fn() -> I) -> f64 {
    /// Up to this number of cells, or of particles, counts are stored in a dense array.
    const SOME: usize = 4096;
    let extent = |k: usize| (space.boundary[k] != Boundary::Flat).then_some(space.size[k]);
    let along = |k: usize| extent(k).map_or(1.0, |size| (size / fair).floor().max(1.0));
    let side = Vector::from_fn(|k, _| extent(k).map_or(f64::INFINITY, |size| size / along(k)));
    let cell_of = |position: &Vector| -> [i32; 3] {
        std::array::from_fn(|k| trunc_to_i32(((position[k] - space.lower[k]) / side[k]).floor()))
    };
    let cells: f64 = (0..3).map(along).product();
    let are_few = cells <= positions().count().max(SOME) as f64;
    let numbers: [usize; 3] = std::array::from_fn(|k| if are_few { trunc_to_usize(along(k)) } else { 0 });
    let mut counts = vec![0_u32; numbers.iter().product()];
    let mut elsewhere = Vec::new();
    for position in positions() {
        let cell = cell_of(&position);
        let [x, y, z] = cell.map(|index| usize::try_from(index).unwrap_or(usize::MAX));
        if x < numbers[0] && y < numbers[1] && z < numbers[2] {
            counts[(z * numbers[1] + y) * numbers[0] + x] += 1;
        } else {
            elsewhere.push(cell);
        }
    }
    elsewhere.sort_unstable();
    let cell: f64 = side.iter().filter(|side| side.is_finite()).product();
    let others = elsewhere.chunk_by(|a, b| a == b).map(|same| same.len() as f64);
    // The sums are exact in any order, because all terms are integers.
    let (mut squares, mut all) = (0.0, 0.0);
    for n in counts.into_iter().map(f64::from).chain(others) {
        (squares, all) = (squares + n * n, all + n);
    }
    squares / all / cell
}
