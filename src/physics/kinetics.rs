//! Volumes, cross sections and free paths of kinetic theory in one, two and three dimensions.

use std::f64::consts::PI;

/// Volume of a ball: a length in one dimension, an area in two.
pub fn volume_of_ball(radius: f64, dimensions: usize) -> f64 {
    match dimensions {
        3 => 4.0 / 3.0 * PI * radius * radius * radius,
        2 => PI * radius * radius,
        _ => 2.0 * radius,
    }
}

/// Cross section for collisions of particles that meet at a distance `range`: a number in one dimension, a length in
/// two.
pub fn cross_section(range: f64, dimensions: usize) -> f64 {
    match dimensions {
        3 => PI * range * range,
        2 => 2.0 * range,
        _ if range > 0.0 => 1.0,
        _ => 0.0,
    }
}

/// Mean free path in a gas. `collisions_per_length` is the sum of number density times cross section over all species.
pub fn free_path(collisions_per_length: f64) -> f64 {
    std::f64::consts::FRAC_1_SQRT_2 / collisions_per_length
}
