use crate::model::space::{Boundary, Face, Space};
use std::f64::consts::PI;

/// Distribution of the distance between two random points in the part of a box that particle centres can reach.
///
/// The separation `s` of two points has the density `prod_k (1 - |s_k| / L_k) / V` along axes that are not periodic,
/// and `1 / V` within half a period along periodic axes. Up to the shortest edge, the mean over all directions is a
/// polynomial in `r`. The coefficients contain the means of `|u_x|`, `|u_x u_y|` and `|u_x u_y u_z|` over the unit
/// sphere (1/2, 2/(3 pi), 1/(4 pi)) or circle (2/pi, 1/pi).
#[derive(Debug, Clone)]
pub(super) struct Room {
    dimensions: usize,
    /// Length accessible to the centre of a particle along each axis that is not periodic `[length]`.
    edges: Vec<f64>,
    volume: f64,
}

impl Room {
    pub fn new(space: &Space, diameter: f64) -> Self {
        let (mut edges, mut volume) = (Vec::new(), 1.0);
        for k in 0..3 {
            match space.boundary[k] {
                Boundary::Flat => {}
                Boundary::Periodic => volume *= space.size[k],
                Boundary::Bounded { lower, upper } => {
                    let walls = [lower, upper].iter().filter(|face| matches!(face, Face::Wall(_))).count();
                    let left = space.size[k] - 0.5 * diameter * walls as f64;
                    let edge = if left > 0.0 { left } else { space.size[k] };
                    volume *= edge;
                    edges.push(edge);
                }
            }
        }
        Self { dimensions: space.dimensions(), edges, volume }
    }

    /// The shortest edge along axes that are not periodic, or infinity.
    pub fn shortest(&self) -> f64 {
        self.edges.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The probability that the distance of two points is more than `from` and at most `to`.
    pub fn probability(&self, from: f64, to: f64) -> f64 {
        let (surface, means) = match self.dimensions {
            3 => (4.0 * PI, [0.5, 2.0 / (3.0 * PI), 0.25 / PI]),
            2 => (2.0 * PI, [2.0 / PI, 1.0 / PI, 0.0]),
            _ => (2.0, [1.0, 0.0, 0.0]),
        };
        let mut total = self.power(from, to, 0);
        for (order, (mean, products)) in means.iter().zip(self.products()).enumerate() {
            let sign = if order % 2 == 0 { -1.0 } else { 1.0 };
            total += sign * mean * products * self.power(from, to, order + 1);
        }
        surface * total / self.volume
    }

    /// Integrates `r^(D - 1 + order)` over a distance bin, in `D` dimensions.
    fn power(&self, from: f64, to: f64, order: usize) -> f64 {
        let exponent = self.dimensions + order;
        // Repeated multiplication is reproducible on all machines, unlike a library function for powers.
        let power = |x: f64| (0..exponent).fold(1.0, |product, _| product * x);
        (power(to) - power(from)) / exponent as f64
    }

    /// Sums of all products of one, two and three inverse edges.
    fn products(&self) -> [f64; 3] {
        let mut sums = [1.0, 0.0, 0.0, 0.0];
        for edge in &self.edges {
            for order in (1..4).rev() {
                sums[order] += sums[order - 1] / edge;
            }
        }
        [sums[1], sums[2], sums[3]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    #[test]
    fn shells_of_periodic_boxes_are_exact() {
        let cube = Room::new(&Space::periodic_cube(2.0), 1.0);
        assert!((cube.probability(0.5, 1.0) - 4.0 / 3.0 * PI * (1.0 - 0.125) / 8.0).abs() < 1e-15);
        assert_eq!(cube.shortest(), f64::INFINITY);
        let mut square = Space::periodic_cube(2.0);
        (square.boundary[2], square.size[2]) = (Boundary::Flat, 0.0);
        assert!((Room::new(&square, 1.0).probability(0.5, 1.0) - PI * 0.75 / 4.0).abs() < 1e-15);
        (square.boundary[0], square.size[0]) = (Boundary::Flat, 0.0);
        assert!((Room::new(&square, 1.0).probability(0.5, 1.0) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn points_on_a_line_have_a_triangular_distribution() {
        let boundary = [Boundary::walls(1.0), Boundary::Flat, Boundary::Flat];
        let line = Space { lower: Vector::zeros(), size: Vector::new(5.0, 0.0, 0.0), boundary };
        let room = Room::new(&line, 1.0);
        assert_eq!(room.shortest(), 4.0);
        assert!((room.probability(0.0, 4.0) - 1.0).abs() < 1e-15);
        assert!((room.probability(0.0, 1.0) - (1.0 - 0.75 * 0.75)).abs() < 1e-15);
    }

    #[test]
    fn a_unit_cube_has_the_known_distribution_of_distances() {
        let space = Space { lower: Vector::zeros(), size: Vector::repeat(1.0), boundary: [Boundary::OPEN; 3] };
        // Robbins' problem: the density of distances in a unit cube is 4 pi r^2 - 6 pi r^3 + 8 r^4 - r^5 for r <= 1.
        let exact = |r: f64| 4.0 / 3.0 * PI * r.powi(3) - 1.5 * PI * r.powi(4) + 1.6 * r.powi(5) - r.powi(6) / 6.0;
        let room = Room::new(&space, 1.0);
        for r in [0.1, 0.5, 1.0] {
            assert!((room.probability(0.0, r) - exact(r)).abs() < 1e-14);
        }
        let flat = [Boundary::OPEN, Boundary::OPEN, Boundary::Flat];
        let square = Space { lower: Vector::zeros(), size: Vector::new(1.0, 1.0, 0.0), boundary: flat };
        // The density of distances in a unit square is 2 r (pi - 4 r + r^2) for r <= 1.
        let exact = |r: f64| PI * r * r - 8.0 / 3.0 * r.powi(3) + 0.5 * r.powi(4);
        assert!((Room::new(&square, 0.0).probability(0.0, 0.7) - exact(0.7)).abs() < 1e-14);
    }
}
