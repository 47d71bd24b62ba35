//! The distribution of the distance between two particles with different diameters. Between walls, the larger particle
//! has less space for its centre.

use crate::model::space::{Boundary, Face, Space};
use std::f64::consts::{FRAC_PI_2, PI};

/// Number of pieces of each interval between two kinks. Each piece is integrated by Gauss's rule.
const PIECES: usize = 3;

/// Nodes and weights of Gauss's rule on (-1, 1).
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

#[derive(Debug, Clone)]
pub(super) struct Rooms {
    axes: Vec<Axis>,
}

/// The period, or the lower and upper limit of each of the two centres `[length]`.
#[derive(Debug, Clone, Copy)]
enum Axis {
    Periodic(f64),
    Bounded([[f64; 2]; 2]),
}

impl Rooms {
    pub fn new(space: &Space, diameters: [f64; 2]) -> Self {
        let axis = |k: usize| match space.boundary[k] {
            Boundary::Flat => None,
            Boundary::Periodic => Some(Axis::Periodic(space.size[k])),
            Boundary::Bounded { lower, upper } => {
                let margin =
                    |face: Face, diameter: f64| if matches!(face, Face::Wall(_)) { 0.5 * diameter } else { 0.0 };
                Some(Axis::Bounded(diameters.map(|d| {
                    let ends = [margin(lower, d), space.size[k] - margin(upper, d)];
                    // A species too large for the box has no particles, so any length will do.
                    if ends[1] > ends[0] { ends } else { [0.0, space.size[k]] }
                })))
            }
        };
        Self { axes: (0..3).filter_map(axis).collect() }
    }

    pub fn probability(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let shell = |(node, weight): (f64, f64)| {
            let r = middle + half * node;
            let surface = match self.axes.len() {
                3 => 4.0 * PI * r * r,
                2 => 2.0 * PI * r,
                _ => 2.0,
            };
            weight * surface * self.mean_density(r)
        };
        half * GAUSS.into_iter().map(shell).sum::<f64>()
    }

    /// Averages the density of separations of length `r` over their directions. The densities along the axes have
    /// kinks. Gauss's rule integrates between these kinks, so a very narrow slit is as accurate as a wide one.
    fn mean_density(&self, r: f64) -> f64 {
        match self.axes.as_slice() {
            [x, y, z] => {
                // The outer integral is over the angle to z, and the inner integral is over the angle around z. The
                // inner integral is not smooth where the distance from the z axis equals a kink of x or y.
                let within =
                    |axis: &Axis| axis.kinks().into_iter().filter(|kink| *kink < r).map(|kink| kink / r).collect();
                let [of_x, of_y, of_z]: [Vec<f64>; 3] = [x, y, z].map(within);
                let kinks = of_x.into_iter().chain(of_y).map(libm::asin).chain(of_z.into_iter().map(libm::acos));
                integral(FRAC_PI_2, kinks, |angle| {
                    let (across, along) = (libm::sin(angle), libm::cos(angle));
                    across * z.density(r * along) * around(*x, *y, r * across)
                })
            }
            [x, y] => around(*x, *y, r),
            [x] => x.density(r),
            _ => 0.0,
        }
    }
}

/// Averages the density of separations of length `r` over their directions in a plane.
fn around(x: Axis, y: Axis, r: f64) -> f64 {
    if let (Axis::Periodic(x), Axis::Periodic(y)) = (x, y) {
        return 1.0 / (x * y);
    }
    let of_x = x.kinks().into_iter().filter(|kink| *kink < r).map(|kink| libm::acos(kink / r));
    let of_y = y.kinks().into_iter().filter(|kink| *kink < r).map(|kink| libm::asin(kink / r));
    let density = |angle: f64| x.density(r * libm::cos(angle)) * y.density(r * libm::sin(angle));
    integral(FRAC_PI_2, of_x.chain(of_y), density) / FRAC_PI_2
}

fn integral(end: f64, kinks: impl Iterator<Item = f64>, function: impl Fn(f64) -> f64) -> f64 {
    let mut ends: Vec<f64> = kinks.filter(|kink| (0.0..end).contains(kink)).chain([0.0, end]).collect();
    ends.sort_by(f64::total_cmp);
    let pieces = ends.windows(2).flat_map(|pair| {
        let width = (pair[1] - pair[0]) / PIECES as f64;
        (0..PIECES).map(move |k| (pair[0] + (k as f64 + 0.5) * width, 0.5 * width))
    });
    let piece = |(middle, half): (f64, f64)| {
        half * GAUSS.iter().map(|(node, weight)| weight * function(middle + half * node)).sum::<f64>()
    };
    pieces.filter(|(_, half)| *half > 0.0).map(piece).sum()
}

impl Axis {
    /// Separations at which the density is not smooth.
    fn kinks(self) -> Vec<f64> {
        match self {
            Self::Periodic(_) => Vec::new(),
            Self::Bounded([a, b]) => {
                let ends = [a[0] - b[0], a[0] - b[1], a[1] - b[0], a[1] - b[1]].map(f64::abs);
                ends.into_iter().filter(|kink| *kink > 0.0).collect()
            }
        }
    }

    /// Mean of the densities of the separations `s` and `-s`.
    fn density(self, s: f64) -> f64 {
        match self {
            Self::Periodic(period) => 1.0 / period,
            Self::Bounded([a, b]) => {
                let overlap = |s: f64| (a[1].min(b[1] + s) - a[0].max(b[0] + s)).max(0.0);
                0.5 * (overlap(s) + overlap(-s)) / ((a[1] - a[0]) * (b[1] - b[0]))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::room::Room;
    use super::*;
    use crate::Vector;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn box_between_walls() -> Space {
        let boundary = [Boundary::walls(1.0), Boundary::Periodic, Boundary::walls(1.0)];
        Space { lower: Vector::zeros(), size: Vector::new(6.0, 5.0, 4.0), boundary }
    }

    #[test]
    fn equal_diameters_match_the_closed_form() {
        let (space, one) = (box_between_walls(), [0.8; 2]);
        for [from, to] in [[0.1, 0.3], [1.0, 1.1], [2.0, 2.4]] {
            let ratio = Rooms::new(&space, one).probability(from, to) / Room::new(&space, 0.8).probability(from, to);
            assert!((ratio - 1.0).abs() < 1e-4, "{from} {to} {ratio}");
        }
    }

    #[test]
    fn a_slit_has_the_distances_along_it() {
        // The slit has edges of 30, and centres can move by 0.2 across it. At a distance r, the mean of max(0, 1 - r
        // |u_x| / 0.2) / 0.2 over all unit vectors u is 1 / (2 r).
        let boundary = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic];
        let space = Space { lower: Vector::zeros(), size: Vector::new(1.2, 30.0, 30.0), boundary };
        for diameters in [[1.0; 2], [1.0, 1.0 + 1e-9]] {
            let rooms = Rooms::new(&space, diameters);
            for [from, to] in [[0.3, 0.4], [1.0, 1.02], [3.9, 4.0]] {
                let expected = PI * (to * to - from * from) / (30.0 * 30.0);
                let ratio = rooms.probability(from, to) / expected;
                // The integration is least accurate near the kink of the inner integral.
                assert!((ratio - 1.0).abs() < 1e-3, "{from}: {ratio}");
            }
        }
        // In a narrow channel along a periodic axis of length L, the density of distances is 2 / L.
        let boundary = [Boundary::walls(1.0), Boundary::walls(1.0), Boundary::Periodic];
        let channel = Space { lower: Vector::zeros(), size: Vector::new(1.2, 1.1, 30.0), boundary };
        let ratio = Rooms::new(&channel, [1.0; 2]).probability(8.0, 8.1) / (2.0 * 0.1 / 30.0);
        assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    }

    #[test]
    fn unequal_diameters_match_random_points() {
        let (space, diameters, count) = (box_between_walls(), [0.6, 1.6], 400_000);
        let rooms = Rooms::new(&space, diameters);
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mut place = |d: f64| {
            let walled = |edge: f64, u: f64| 0.5 * d + (edge - d) * u;
            [walled(6.0, uniform()), 5.0 * uniform(), walled(4.0, uniform())]
        };
        let edges = [0.0, 0.5, 1.0, 1.5, 2.0];
        let mut counts = [0_u32; 4];
        for _ in 0..count {
            let (a, b) = (place(diameters[0]), place(diameters[1]));
            let y = (a[1] - b[1]).abs();
            let square = (a[0] - b[0]).powi(2) + y.min(5.0 - y).powi(2) + (a[2] - b[2]).powi(2);
            if let Some(bin) = edges.windows(2).position(|two| (two[0]..two[1]).contains(&square.sqrt())) {
                counts[bin] += 1;
            }
        }
        for (bin, count_in_bin) in counts.into_iter().enumerate() {
            let expected = f64::from(count) * rooms.probability(edges[bin], edges[bin + 1]);
            // Four standard deviations of the Poisson distribution, plus the error of the numerical integration.
            let bound = 4.0 * expected.sqrt() + 2e-4 * expected;
            assert!((f64::from(count_in_bin) - expected).abs() < bound, "{bin}: {count_in_bin} but {expected}");
        }
    }
}
