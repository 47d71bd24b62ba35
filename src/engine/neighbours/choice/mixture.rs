//! Estimates of the costs of cells and of lists for particles of very different sizes.

use super::density::local_density;
use crate::Vector;
use crate::engine::neighbours::ranges::Ranges;
use crate::model::space::Space;
use crate::physics::kinetics::{cross_section, free_path, volume_of_ball};

/// Costs of a pair test, of a cell transition, and of a list rebuild per level, in nanoseconds. The costs were fitted
/// to mixtures of spheres with size ratios of 2 to 10 at packing fractions of 1e-4 to 0.5.
const PAIR: f64 = 8.0;
const TRANSITION: f64 = 100.0;
const NEW_LIST: f64 = 300.0;

/// Numbers and local densities of particles of different sizes.
pub(super) struct Mixture<'a> {
    ranges: &'a Ranges,
    /// Factor by which all ranges are multiplied.
    factor: f64,
    dimensions: usize,
    contents: Vec<Content>,
}

/// The particles of a row.
struct Content {
    row: usize,
    /// Number of these particles, if they move.
    moving: f64,
    /// Their share of the number density around particles of their level `[length^-dimensions]`. The same density is
    /// assumed around particles of other levels, as if all levels were evenly mixed.
    density: f64,
}

impl<'a> Mixture<'a> {
    pub fn of<I: Iterator<Item = (Vector, u16)>>(
        space: &Space,
        (ranges, factor): (&'a Ranges, f64),
        particles: &impl Fn() -> I,
    ) -> Self {
        let rows = ranges.levels().len();
        let mut numbers = vec![0.0; rows];
        particles().for_each(|(_, row)| numbers[usize::from(row)] += 1.0);
        let level_of = |row: usize| ranges.levels()[row];
        let of_level = |level: u8| {
            let number: f64 = (0..rows).filter(|&row| level_of(row) == level).map(|row| numbers[row]).sum();
            let own = ranges.occurring().filter(|&row| level_of(row) == level).map(|row| ranges.at(row, row));
            let positions =
                || particles().filter(|(_, row)| level_of(usize::from(*row)) == level).map(|(position, _)| position);
            let density = if number > 0.0 { local_density(space, own.fold(0.0, f64::max), positions) } else { 0.0 };
            density / number.max(1.0)
        };
        let levels: Vec<f64> = (0..=u8::MAX).take(ranges.level_count()).map(of_level).collect();
        let content = |row: usize| Content {
            row,
            moving: if ranges.moves(row) { numbers[row] } else { 0.0 },
            density: numbers[row] * levels[usize::from(level_of(row))],
        };
        let contents = (0..rows).filter(|&row| numbers[row] > 0.0).map(content).collect();
        Self { ranges, factor, dimensions: space.dimensions(), contents }
    }

    fn range(&self, a: &Content, b: &Content) -> f64 {
        self.ranges.at(a.row, b.row) * self.factor
    }

    /// Returns the half skin at which a list contains `aim` particles beyond the interaction range, on average over the
    /// moving particles. The result is at least `thinnest`. It is infinite if lists never become that long.
    pub fn half_skin(&self, aim: f64, thinnest: f64) -> f64 {
        let volume = |radius: f64| volume_of_ball(radius, self.dimensions);
        let all: f64 = self.contents.iter().map(|content| content.moving).sum();
        let listed = |half_skin: f64| {
            let beyond = |range: f64| {
                if range < 0.0 { 0.0 } else { volume(range + 2.0 * half_skin) - volume(range) }
            };
            let of = |a: &Content| self.contents.iter().map(|b| b.density * beyond(self.range(a, b))).sum::<f64>();
            let moving = self.contents.iter().filter(|content| content.moving > 0.0);
            moving.map(|a| a.moving * of(a)).sum::<f64>() / all
        };
        let (mut lower, mut upper) = (thinnest, thinnest);
        while listed(upper) < aim {
            (lower, upper) = (upper, 2.0 * upper);
            if upper == f64::INFINITY {
                return upper;
            }
        }
        for _ in 0..20 {
            let middle = 0.5 * (lower + upper);
            if listed(middle) < aim { lower = middle } else { upper = middle }
        }
        upper
    }

    /// Estimates the time per event with cells, and with lists of `listed` particles, in nanoseconds. Between two
    /// events, a particle flies one mean free path. The number of transitions is proportional to this path.
    pub fn costs(&self, listed: f64, half_skin: f64) -> [f64; 2] {
        let axes = self.dimensions as f64;
        let density: f64 = self.contents.iter().map(|content| content.density).sum();
        let free_path = self.free_path();
        let side = (self.ranges.largest() * self.factor).max(0.8 * libm::pow(density, -1.0 / axes));
        let held = density * libm::pow(side, axes);
        let around = libm::pow(3.0, axes);
        // With velocities in all directions, a particle crosses about half a side along each axis.
        let transitions = 0.5 * axes * free_path / side;
        let of_cells = around * held * PAIR + transitions * (TRANSITION + around / 3.0 * held * PAIR);
        let of_lists = listed * PAIR + free_path / half_skin * NEW_LIST * self.ranges.level_count() as f64;
        [2.0 * of_cells, 2.0 * of_lists]
    }

    /// Mean free path of the moving particles `[length]`, estimated for hard spheres with Enskog's factor. Particles
    /// without interactions are excluded.
    fn free_path(&self) -> f64 {
        let range = |a: &Content, b: &Content| self.range(a, b).max(0.0);
        let filled =
            |content: &Content| content.density * volume_of_ball(0.5 * range(content, content), self.dimensions);
        let filled: f64 = self.contents.iter().map(filled).sum();
        let crowding = libm::pow(1.0 - filled.min(0.6), -0.5 * (self.dimensions as f64 + 2.0));
        let (mut all, mut sum) = (0.0, 0.0);
        for a in self.contents.iter().filter(|content| content.moving > 0.0) {
            let met: f64 = self.contents.iter().map(|b| b.density * cross_section(range(a, b), self.dimensions)).sum();
            if met > 0.0 {
                all += a.moving;
                sum += a.moving * free_path(met * crowding);
            }
        }
        sum / all
    }
}
