use crate::base::numbers::{trunc_to_i32, trunc_to_u32};
use crate::model::space::{Boundary, Space};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::f64::consts::PI;

pub(super) const MOST_SHELLS: f64 = 60.0;

/// Largest wave number in units of the smallest one. It limits the number of tabulated powers.
const MOST_MULTIPLES: f64 = 4096.0;

/// Number of directions in which each shell is searched for wave vectors, at three radii each.
const DIRECTIONS: u32 = 64;

/// Wave vectors of about the same length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Shell {
    /// Mean length of the wave vectors `[1 / length]`.
    pub wave_number: f64,
    /// The vectors as multiples of the wave vectors along the axes. Of `q` and `-q`, only one is listed.
    pub vectors: Vec<[i32; 3]>,
}

/// The reciprocal lattice of a box: `2 pi (n_x / L_x, (n_y - n_x d / L_x) / L_y, n_z / L_z)`. The periodic image above
/// the box is displaced by `d` along x.
#[derive(Debug, Clone, Copy)]
struct Reciprocal {
    /// `2 pi / L` along periodic axes, 0 along other axes `[1 / length]`.
    units: [f64; 3],
    /// `d / L_x`.
    slope: f64,
}

impl Reciprocal {
    fn new(space: &Space, displacement: f64) -> Self {
        let is_periodic = |k: usize| space.boundary[k] == Boundary::Periodic;
        let units = std::array::from_fn(|k| if is_periodic(k) { 2.0 * PI / space.size[k] } else { 0.0 });
        Self { units, slope: if displacement == 0.0 { 0.0 } else { displacement / space.size.x } }
    }

    fn length(&self, n: &[i32; 3]) -> f64 {
        let [x, y, z] = n.map(f64::from);
        let [x, y, z] = [x * self.units[0], (y - x * self.slope) * self.units[1], z * self.units[2]];
        (x * x + y * y + z * z).sqrt()
    }

    /// Multiples `n` of the wave vector that is closest to a given vector.
    fn nearest(&self, vector: [f64; 3]) -> [i32; 3] {
        let multiple = |k: usize| if self.units[k] > 0.0 { vector[k] / self.units[k] } else { 0.0 };
        let x = multiple(0).round();
        [x, (multiple(1) + x * self.slope).round(), multiple(2).round()].map(trunc_to_i32)
    }
}

/// Returns the nonempty shells, with at most `most` wave vectors each. Wave numbers are at most `largest`, and at most
/// 4096 times the smallest wave number.
pub(super) fn shells(space: &Space, largest: f64, most: usize) -> Vec<Shell> {
    let mut shells = all_shells(space, 0.0, largest, most);
    shells.retain(|shell| !shell.vectors.is_empty());
    shells
}

/// Shells of a sheared box, including empty ones. `displacement` is the shift of the periodic image above the box. The
/// number and the bounds of the shells do not depend on the displacement.
pub(super) fn all_shells(space: &Space, displacement: f64, largest: f64, most: usize) -> Vec<Shell> {
    let lattice = Reciprocal::new(space, displacement);
    // The smallest unit is the smallest wave number, for any displacement. Along the axis of the first nonzero number
    // among `n_x`, `n_y` and `n_z`, the wave vector has at least one unit.
    let smallest = lattice.units.into_iter().filter(|&unit| unit > 0.0).fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() {
        return Vec::new();
    }
    let largest = largest.min(MOST_MULTIPLES * smallest);
    let width = (largest / MOST_SHELLS).max(smallest);
    let count = trunc_to_u32(largest / width * (1.0 + 1e-9));
    let shell = |index: u32| {
        let middle = f64::from(index) * width;
        let bounds = [middle - 0.5 * width, (middle + 0.5 * width).min(largest * (1.0 + 1e-9))];
        Shell::new(&lattice, bounds, most)
    };
    (1..=count).map(shell).collect()
}

impl Shell {
    fn new(lattice: &Reciprocal, bounds: [f64; 2], most: usize) -> Self {
        let mut vectors = symmetric(lattice, bounds);
        thin(&mut vectors, most);
        let mut others = scattered(lattice, bounds);
        others.retain(|n| !vectors.contains(n));
        thin(&mut others, most - vectors.len());
        vectors.extend(others);
        let sum: f64 = vectors.iter().map(|n| lattice.length(n)).sum();
        Self { wave_number: sum / vectors.len().max(1) as f64, vectors }
    }
}

fn is_within([from, to]: [f64; 2], length: f64) -> bool {
    from <= length && length < to
}

/// Returns `n` or `-n`, so that the last nonzero component is positive.
fn upper(n: [i32; 3]) -> [i32; 3] {
    if n.iter().rev().find(|&&n| n != 0).is_some_and(|&n| n < 0) { n.map(|n| -n) } else { n }
}

/// Wave vectors along axes, face diagonals and space diagonals, where aligned crystals have their strongest peaks.
fn symmetric(lattice: &Reciprocal, bounds: [f64; 2]) -> Vec<[i32; 3]> {
    let mut found = BTreeSet::new();
    for code in 0..27 {
        let direction = [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1];
        let step = lattice.length(&direction);
        let has_axes = (0..3).all(|k| direction[k] == 0 || lattice.units[k] > 0.0);
        if upper(direction) != direction || step == 0.0 || !has_axes {
            continue;
        }
        let first = trunc_to_i32((bounds[0] / step).floor()).max(1);
        let multiples = (first..).map(|times| direction.map(|n| n * times));
        let until = multiples.take_while(|n| lattice.length(n) < bounds[1]);
        found.extend(until.filter(|n| is_within(bounds, lattice.length(n))));
    }
    found.into_iter().collect()
}

/// Wave vectors close to points spread evenly over half of the shell. The other half contains the opposite vectors.
fn scattered(lattice: &Reciprocal, bounds: [f64; 2]) -> Vec<[i32; 3]> {
    let axes: Vec<usize> = (0..3).filter(|&k| lattice.units[k] > 0.0).collect();
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let mut found = BTreeSet::new();
    for index in 0..DIRECTIONS {
        let height = (f64::from(index) + 0.5) / f64::from(DIRECTIONS);
        let (sine, cosine) = libm::sincos(if axes.len() == 2 { PI * height } else { golden_angle * f64::from(index) });
        let radius = (1.0 - height * height).sqrt();
        let direction = match axes.len() {
            3 => [radius * cosine, radius * sine, height],
            2 => [cosine, sine, 0.0],
            _ => [1.0, 0.0, 0.0],
        };
        for part in [0.2, 0.5, 0.8] {
            let wanted = bounds[0] + part * (bounds[1] - bounds[0]);
            let mut vector = [0.0; 3];
            for (&axis, component) in axes.iter().zip(direction) {
                vector[axis] = wanted * component;
            }
            let n = lattice.nearest(vector);
            if is_within(bounds, lattice.length(&n)) {
                found.insert(upper(n));
            }
        }
    }
    found.into_iter().collect()
}

fn thin(vectors: &mut Vec<[i32; 3]>, most: usize) {
    let count = vectors.len();
    if count > most {
        *vectors = (0..most).map(|k| vectors[k * count / most]).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    #[test]
    fn shells_hold_enough_distinct_vectors_of_their_length() {
        for edge in [3.0, 8.0, 200.0] {
            let space = Space::periodic_cube(edge);
            let unit = 2.0 * PI / edge;
            let all = shells(&space, 20.0, 20);
            assert!(all.len() <= 60 && all.len() as f64 >= (20.0 / unit).min(60.0).floor() - 1.0, "{}", all.len());
            let mut last = 0.0;
            for shell in &all {
                let lattice = Reciprocal::new(&space, 0.0);
                let lengths = shell.vectors.iter().map(|n| lattice.length(n));
                assert!(lengths.clone().all(|q| q > last && q <= 20.0 * (1.0 + 1e-9)));
                last = lengths.fold(0.0, f64::max);
                let both: BTreeSet<[i32; 3]> = shell.vectors.iter().flat_map(|n| [*n, n.map(|n| -n)]).collect();
                assert_eq!(both.len(), 2 * shell.vectors.len());
                assert!(shell.vectors.len() <= 20 && (shell.vectors.len() >= 13 || shell.wave_number < 2.1 * unit));
            }
        }
    }

    #[test]
    fn sheared_box_has_equally_many_full_shells() {
        let space = Space { size: Vector::new(6.0, 8.0, 7.0), ..Space::periodic_cube(1.0) };
        let rest = all_shells(&space, 0.0, 15.0, 20);
        for displacement in [0.4, -1.7, 3.0] {
            let lattice = Reciprocal::new(&space, displacement);
            let all = all_shells(&space, displacement, 15.0, 20);
            assert_eq!(all.len(), rest.len());
            let width = 2.0 * PI / 8.0;
            for (index, shell) in (1..).zip(&all) {
                let middle = f64::from(index) * width;
                let within = |q: f64| (q - middle).abs() <= 0.5 * width * (1.0 + 1e-9);
                assert!(shell.vectors.iter().all(|n| within(lattice.length(n))), "{index}");
                assert!(shell.vectors.len() >= 13 || index < 3, "{index}: {}", shell.vectors.len());
            }
        }
    }

    #[test]
    fn the_first_shell_of_a_cube_is_complete() {
        // The first shell, from 1/2 to 3/2 of the smallest wave number, has three vectors along axes and six along face
        // diagonals.
        assert_eq!(shells(&Space::periodic_cube(1.0), 20.0, 20)[0].vectors.len(), 9);
    }

    #[test]
    fn only_periodic_axes_have_wave_vectors() {
        let mut space = Space::periodic_cube(5.0);
        space.boundary[1] = Boundary::walls(1.0);
        (space.boundary[2], space.size) = (Boundary::Flat, Vector::new(5.0, 5.0, 0.0));
        let all = shells(&space, 13.0, 20);
        assert_eq!(all.len(), 10);
        assert!(all.iter().zip(1..).all(|(shell, n)| shell.vectors == [[n, 0, 0]]));
        space.boundary[0] = Boundary::OPEN;
        assert_eq!(shells(&space, 13.0, 20), []);
        assert_eq!(shells(&Space::periodic_cube(1.0), 1.0, 20), [], "all wave numbers exceed the limit");
    }
}
