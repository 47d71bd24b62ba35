//! Exact signs of determinants. Source: J. R. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates*, Discrete Comput. Geom. 18, 305 (1997).

use std::cmp::Ordering;

use robust::{Coord, Coord3D};

use crate::Vector;

pub(super) type Sign = Ordering;

/// Smaller coordinates are replaced by zero, because a product of three of them could underflow and lose its sign.
const SMALLEST: f64 = 1e-90;

fn flushed(x: f64) -> f64 {
    if x.abs() < SMALLEST { 0.0 } else { x }
}

fn sign(determinant: f64) -> Sign {
    determinant.partial_cmp(&0.0).unwrap_or(Sign::Equal)
}

/// Returns the side of a triangle on which a point lies. `Greater` is the side of the normal.
pub(super) fn side([a, b, c]: &[Vector; 3], point: &Vector) -> Sign {
    let of = |v: &Vector| Coord3D { x: flushed(v.x), y: flushed(v.y), z: flushed(v.z) };
    // `orient3d` is positive below a counterclockwise triangle, so the sign is reversed.
    sign(robust::orient3d(of(a), of(b), of(c), of(point))).reverse()
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    axes: [usize; 2],
}

impl Projection {
    pub const ALL: [Self; 3] = [Self { axes: [1, 2] }, Self { axes: [2, 0] }, Self { axes: [0, 1] }];

    pub fn of(self, point: &Vector) -> [f64; 2] {
        self.axes.map(|axis| flushed(point[axis]))
    }

    /// Direction in which three projected points turn: left (`Greater`), right, or straight on.
    pub fn turn(self, a: &Vector, b: &Vector, c: &Vector) -> Sign {
        let [a, b, c] = [a, b, c].map(|point| self.of(point)).map(|[x, y]| Coord { x, y });
        sign(robust::orient2d(a, b, c))
    }

    /// Returns a projection in which the triangle has an area, and the direction in which the corners turn.
    pub fn for_triangle([a, b, c]: &[Vector; 3]) -> Option<(Self, Sign)> {
        let normal = (b - a).cross(&(c - a));
        let best = normal.iamax();
        let order = [best, (best + 1) % 3, (best + 2) % 3];
        let mut found = order.iter().filter_map(|axis| Self::ALL.get(*axis)).map(|way| (*way, way.turn(a, b, c)));
        found.find(|(_, turn)| *turn != Sign::Equal)
    }
}
