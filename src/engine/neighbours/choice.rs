//! Choice of the neighbour search: cells, or lists and their skin.

mod density;
mod mixture;

use super::Search;
use super::ranges::Ranges;
use super::verlet::VerletLists;
use crate::Vector;
use crate::engine::images::ImagePolicy;
use crate::engine::pairs::rows::Rows;
use crate::model::Scene;
use crate::model::space::{Boundary, Space};
use density::local_density;
use mixture::Mixture;

/// Number of particles beyond the interaction range that a Verlet list should contain, in one, two and three
/// dimensions. More particles slow down predictions, and fewer cause more rebuilds. The third number was measured in
/// hard-sphere fluids, crystals and square wells. With half or twice this number, runs are about a tenth slower.
const LISTED: [f64; 3] = [1.5, 5.5, 11.0];

/// Largest reach of Verlet lists at which lists are faster than cells, in units of the interaction range. This value is
/// the reach at a packing fraction of 0.36. The measured limit is a packing fraction of 0.35 for 11,000 hard spheres,
/// 0.38 for ten times as many, and a reach of 1.66 for square wells.
const WORTHWHILE: f64 = 1.69;

/// Replaces [`WORTHWHILE`] in boxes with up to three cells along a period, where particles are candidates in several
/// images. It is the reach at a packing fraction of 0.14. The measured limit for ten hard spheres is 0.1 to 0.15.
const WORTHWHILE_IN_SMALL_BOX: f64 = 2.2;

/// The search method changes only if the limit is passed by this fraction.
const HYSTERESIS: f64 = 0.05;

/// The half skin is replaced only if the new value differs from it by at least this fraction.
const DIFFERENT: f64 = 0.3;

/// Up to this number of particles, Verlet lists are cheap even if each list contains all particles.
const FEW: usize = 32;

/// Half skin, in units of the interaction range, for a few particles in a box longer than [`LONG`] ranges. A wide skin
/// avoids rebuilds when particles fly far. But contacts are predicted at distances of up to four half skins, and the
/// error of the overlap function grows with the square of this distance. The largest error is about `1e5` ulp.
const WIDE: f64 = 100.0;
const LONG: f64 = 1e4;

/// The half skin is at most this fraction of the largest half skin that the box allows.
const WITHIN: f64 = 0.95;

/// Smallest half skin as a fraction of the interaction range.
const THINNEST: f64 = 0.08;

impl Search {
    /// Chooses the search method at the start of a scene.
    #[must_use]
    pub fn of(scene: &Scene, rows: &Rows, ranges: &Ranges) -> Self {
        if !ImagePolicy::stay(scene) {
            // Verlet lists do not support the sliding images of sheared boxes.
            return Self::Cells;
        }
        let particles = || scene.particles.iter().map(|particle| (particle.position, rows.row_of(particle)));
        Self::choose(&scene.space, (ranges, 1.0), particles, None)
    }

    /// Chooses the search method for particles with given positions and rows. All ranges are multiplied by `factor`.
    /// The `current` method is kept if the density is close to the limit between the methods.
    #[must_use]
    pub fn choose<I: Iterator<Item = (Vector, u16)>>(
        space: &Space,
        (ranges, factor): (&Ranges, f64),
        particles: impl Fn() -> I,
        current: Option<Self>,
    ) -> Self {
        let range = ranges.largest() * factor;
        let widest = VerletLists::widest_half_skin(space, range);
        let positions = || particles().map(|(position, _)| position);
        if positions().count() <= FEW && range > 0.0 && range < widest {
            let is_long = (0..3).all(|k| space.boundary[k] == Boundary::Flat || space.size[k] >= LONG * range);
            return Self::Lists { half_skin: if is_long { WIDE * range } else { range } };
        }
        if ranges.level_count() > 1 {
            return Self::choose_for_levels(space, (ranges, factor), particles, (current, widest));
        }
        let reach = reach_of_lists(space, range, local_density(space, range, positions));
        // Even a thin skin, as in a small box, is better than testing all images of all particles.
        let half_skin = (0.5 * (reach - range)).min(WITHIN * widest).max(THINNEST * range).max(ranges.sleep_distance);
        // Without particles or a range, the reach is NaN, and cells are chosen.
        if !(reach < worthwhile(space, range, current) * range && half_skin < widest) {
            return Self::Cells;
        }
        Self::lists_like(half_skin, (current, widest))
    }

    /// Chooses the search method for particles of very different sizes. Cells must be as large as the largest range, so
    /// small particles may have many candidates. Lists are built from separate cells for each level of sizes.
    fn choose_for_levels<I: Iterator<Item = (Vector, u16)>>(
        space: &Space,
        (ranges, factor): (&Ranges, f64),
        particles: impl Fn() -> I,
        (current, widest): (Option<Self>, f64),
    ) -> Self {
        // In a thin gas, a particle may have flown through several periods since its latest event.
        let particles = || particles().map(|(position, row)| (space.wrapped(position), row));
        let mixture = Mixture::of(space, (ranges, factor), &particles);
        let smallest = factor * ranges.smallest();
        let thinnest = (THINNEST * smallest).max(ranges.sleep_distance);
        let half_skin = mixture.half_skin(LISTED[space.dimensions() - 1], thinnest);
        let half_skin = half_skin.min(WIDE * smallest).min(WITHIN * widest).max(thinnest);
        let [of_cells, of_lists] = mixture.costs(LISTED[space.dimensions() - 1], half_skin);
        let preference = match current {
            None => 1.0,
            Some(Self::Cells) => 1.0 - 2.0 * HYSTERESIS,
            Some(Self::Lists { .. }) => 1.0 + 2.0 * HYSTERESIS,
        };
        if half_skin < widest && of_lists < of_cells * preference {
            Self::lists_like(half_skin, (current, widest))
        } else {
            Self::Cells
        }
    }

    /// Lists with about this half skin. The current half skin is kept if it is similar.
    fn lists_like(half_skin: f64, (current, widest): (Option<Self>, f64)) -> Self {
        match current {
            Some(Self::Lists { half_skin: old }) if (half_skin - old).abs() < DIFFERENT * old && old < widest => {
                Self::Lists { half_skin: old }
            }
            _ => Self::Lists { half_skin },
        }
    }
}

/// Returns the reach `[length]` at which Verlet lists are fastest, for a given number density.
fn reach_of_lists(space: &Space, range: f64, density: f64) -> f64 {
    let dimensions = space.dimensions();
    let volume = LISTED[dimensions - 1] / density;
    match dimensions {
        3 => libm::cbrt(range * range * range + volume / (4.0 / 3.0 * std::f64::consts::PI)),
        2 => (range * range + volume / std::f64::consts::PI).sqrt(),
        _ => range + 0.5 * volume,
    }
}

/// Returns the largest reach, in units of the interaction range, at which lists are chosen.
fn worthwhile(space: &Space, range: f64, current: Option<Search>) -> f64 {
    let has_few_cells = (0..3).any(|k| space.boundary[k] == Boundary::Periodic && space.size[k] < 4.0 * range);
    let worthwhile = if has_few_cells { WORTHWHILE_IN_SMALL_BOX } else { WORTHWHILE };
    match current {
        None => worthwhile,
        Some(Search::Cells) => worthwhile * (1.0 - HYSTERESIS),
        Some(Search::Lists { .. }) => worthwhile * (1.0 + HYSTERESIS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chooses the search for equal particles.
    fn choose_equal(space: &Space, range: f64, positions: &[Vector], current: Option<Search>) -> Search {
        let particles = || positions.iter().map(|position| (*position, 0));
        Search::choose(space, (&Ranges::of_equal(range), 1.0), particles, current)
    }

    /// Chooses the search for particles on a lattice, which are some periods outside of the box. Of 50 particles, one
    /// is of row 2, one of row 0, and the others are of row 1.
    fn choose_unlike(between: &[f64], spacing: f64, periods: u32) -> Search {
        let (space, mut positions) = lattice(10, spacing);
        for (position, k) in positions.iter_mut().zip(0..) {
            position.x += 10.0 * spacing * f64::from(k % (periods + 1));
        }
        let row = |k: u32| match k % 50 {
            0 => 2,
            1 => 0,
            _ => 1,
        };
        let particles = || positions.iter().zip(0..).map(|(position, k)| (*position, row(k)));
        Search::choose(&space, (&Ranges::of_matrix(between.to_vec()), 1.0), particles, None)
    }

    #[test]
    fn unlike_sizes_have_lists_unless_they_are_thin() {
        // Row 0 meets no particle.
        let between = [-1.0, -1.0, -1.0, -1.0, 1.0, 3.0, -1.0, 3.0, 5.0];
        let chosen = choose_unlike(&between, 1.5, 0);
        assert!(matches!(chosen, Search::Lists { half_skin } if (0.2..0.6).contains(&half_skin)), "{chosen:?}");
        assert_eq!(choose_unlike(&between, 1.5, 30), chosen);
        assert_eq!(choose_unlike(&between, 20.0, 0), Search::Cells);
        // Only particles that meet no others.
        let (space, positions) = lattice(10, 1.5);
        let alone = || positions.iter().map(|position| (*position, 0));
        assert_eq!(Search::choose(&space, (&Ranges::of_matrix(between.to_vec()), 1.0), alone, None), Search::Cells);
    }

    fn lattice(n: u32, spacing: f64) -> (Space, Vec<Vector>) {
        let at = |k: u32| (f64::from(k) + 0.5) * spacing;
        let positions = (0..n * n * n).map(|k| Vector::new(at(k % n), at(k / n % n), at(k / n / n))).collect();
        (Space::periodic_cube(f64::from(n) * spacing), positions)
    }

    #[test]
    fn a_dense_system_has_lists_and_a_thin_or_small_one_cells() {
        let choose = |n, spacing: f64| {
            let (space, positions) = lattice(n, spacing);
            choose_equal(&space, 1.0, &positions, None)
        };
        assert!(
            matches!(choose(12, 1.0), Search::Lists { half_skin } if (0.2..0.3).contains(&half_skin)),
            "{:?}",
            choose(12, 1.0)
        );
        assert_eq!(choose(12, 1.5), Search::Cells);
        assert_eq!(choose(2, 1.2), Search::Cells);
        assert_eq!(choose_equal(&Space::periodic_cube(9.0), 1.0, &[], None), Search::Cells);
    }

    #[test]
    fn few_particles_in_long_box_use_lists_with_wide_skin() {
        let at = [Vector::repeat(1.0), Vector::repeat(3.0)];
        for (size, half_skin) in [(20.0, 1.0), (9e3, 1.0), (1e4, WIDE), (1e9, WIDE)] {
            let mut space = Space::periodic_cube(size);
            assert_eq!(choose_equal(&space, 1.0, &at, None), Search::Lists { half_skin });
            space.size.x = 1e9;
            assert_eq!(choose_equal(&space, 1.0, &at, None), Search::Lists { half_skin });
        }
    }

    #[test]
    fn a_small_box_has_lists_with_a_skin_that_fits() {
        for (n, spacing) in [(3, 1.0), (3, 1.3), (2, 1.5), (4, 1.0)] {
            let (space, positions) = lattice(n, spacing);
            let chosen = choose_equal(&space, 1.0, &positions, None);
            let Search::Lists { half_skin } = chosen else { panic!("{n} {spacing}") };
            assert!(half_skin >= THINNEST && space.size[0] > 2.0 * (1.0 + 4.0 * half_skin), "{half_skin}");
            assert_eq!(choose_equal(&space, 1.0, &positions, Some(chosen)), chosen);
            // A skin that is too thick for the box is replaced, even if the change is small.
            let wider = Search::Lists { half_skin: 1.1 * half_skin };
            assert_eq!(choose_equal(&space, 1.0, &positions, Some(wider)), chosen);
        }
    }

    #[test]
    fn local_density_ignores_empty_parts_of_the_box() {
        let (mut space, positions) = lattice(12, 1.0);
        assert!((local_density(&space, 1.0, || positions.iter().copied()) - 1.0).abs() < 0.1);
        space.size *= 4.0;
        assert!((local_density(&space, 1.0, || positions.iter().copied()) - 1.0).abs() < 0.3);
    }

    #[test]
    fn a_search_changes_only_with_the_density() {
        let (space, positions) = lattice(12, 1.0);
        let first = choose_equal(&space, 1.0, &positions, None);
        assert_eq!(choose_equal(&space, 1.0, &positions, Some(first)), first);
        let (space, wider) = lattice(12, 1.02);
        assert_eq!(choose_equal(&space, 1.0, &wider, Some(first)), first);
        let (space, far) = lattice(12, 1.9);
        assert_eq!(choose_equal(&space, 1.0, &far, Some(first)), Search::Cells);
    }
}
