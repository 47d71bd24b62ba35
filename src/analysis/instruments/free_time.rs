//! The mean free time of a fluid, guessed, to choose other times by.

use super::system::{Sample, SystemDescription};
use crate::analysis::published::{HardSphereFluid, collision_rate_of_disks, collision_rate_of_rods};

/// Densest fluids, by number of axes, that the collision rate is guessed for.
const DENSEST: [f64; 4] = [0.0, 0.9, 0.65, 0.5];

/// Mean time between two contacts of a particle, as if all were hard spheres of their diameters that fill the box evenly `[time]`.
///
/// A guess, good enough to choose times by. `None` where nothing moves, or everything falls.
pub(super) fn mean_free_time(system: &SystemDescription, sample: &Sample<'_>) -> Option<f64> {
    let dimensions = system.space.dimensions();
    let moving = system.moving.len() as f64;
    if system.is_accelerated || dimensions == 0 {
        return None;
    }
    let drift = system.drift(sample.velocities);
    let (mut twice_kinetic, mut diameters, mut volume) = (0.0, 0.0, 0.0);
    for &id in &system.moving {
        let diameter = system.diameters[system.species[id as usize] as usize];
        let mut velocity = sample.velocities[id as usize] - drift;
        if system.shear_rate != 0.0 {
            velocity -= system.streaming_velocity(&sample.positions[id as usize]);
        }
        twice_kinetic += system.masses[id as usize] * velocity.norm_squared();
        diameters += diameter;
        volume += match dimensions {
            1 => diameter,
            2 => std::f64::consts::FRAC_PI_4 * diameter * diameter,
            _ => std::f64::consts::FRAC_PI_6 * diameter * diameter * diameter,
        };
    }
    let (temperature, diameter) = (twice_kinetic / (moving * dimensions as f64), diameters / moving);
    let mass = system.moving_mass() / moving;
    let packing_fraction = (volume / system.space.volume()).min(DENSEST[dimensions]);
    let rate = match dimensions {
        1 => collision_rate_of_rods(packing_fraction, diameter, mass, temperature),
        2 => collision_rate_of_disks(packing_fraction, diameter, mass, temperature),
        _ => HardSphereFluid { packing_fraction, diameter, mass, temperature }.collision_rate(),
    };
    Some(1.0 / rate).filter(|time| time.is_finite() && *time > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_free_time_is_that_of_hard_spheres() {
        let (system, simulation) = super::super::test_system::hard_spheres(108, 0.3);
        let snapshot = simulation.snapshot();
        // The temperature is 1 with N - 1 particles to share it, here with N.
        let expected = (108.0_f64 / 107.0).sqrt() / HardSphereFluid::reduced(0.3).collision_rate();
        let time = mean_free_time(&system, &Sample::of(&snapshot)).unwrap();
        assert!((time / expected - 1.0).abs() < 1e-9, "{time} {expected}");
    }
}
