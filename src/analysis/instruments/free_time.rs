//! Estimates of relaxation times, which determine sampling times.

use std::f64::consts::TAU;

use super::system::{Sample, SystemDescription};
use crate::analysis::published::{
    HardSphereFluid, collision_rate_of_disks, collision_rate_of_rods, viscosity_of_disks,
};
use crate::model::scene::own_volume;

/// Highest packing fraction for an estimate of the collision rate. The index is the number of axes.
const DENSEST: [f64; 4] = [0.0, 0.9, 0.65, 0.5];

/// Temperature of the moving particles `[energy]`. Velocities are relative to the drift and the streaming velocity.
fn temperature(system: &SystemDescription, sample: &Sample<'_>) -> f64 {
    let drift = system.drift(sample.velocities);
    let mut twice_kinetic = 0.0;
    for &id in &system.moving {
        let mut velocity = sample.velocities[id as usize] - drift;
        if system.shear_rate != 0.0 {
            velocity -= system.streaming_velocity(&sample.positions[id as usize]);
        }
        twice_kinetic += system.masses[id as usize] * velocity.norm_squared();
    }
    twice_kinetic / (system.moving.len() as f64 * system.space.dimensions() as f64)
}

/// Replaces the moving particles by equal hard spheres, disks or rods that fill the box evenly. Their diameter and mass
/// are the mean values. `None` if particles accelerate or all axes are flat.
fn guess(system: &SystemDescription, temperature: f64) -> Option<HardSphereFluid> {
    let dimensions = system.space.dimensions();
    let moving = system.moving.len() as f64;
    if system.is_accelerated || dimensions == 0 {
        return None;
    }
    let (mut diameters, mut volume) = (0.0, 0.0);
    for &id in &system.moving {
        let diameter = system.diameter_of(id);
        diameters += diameter;
        volume += own_volume(diameter, dimensions);
    }
    Some(HardSphereFluid {
        packing_fraction: (volume / system.space.volume()).min(DENSEST[dimensions]),
        diameter: diameters / moving,
        mass: system.moving_mass() / moving,
        temperature,
    })
}

/// Enskog's shear viscosity of the estimated fluid, in two or three dimensions `[mass / (length^(D - 2) time)]`.
pub(super) fn viscosity(system: &SystemDescription, temperature: f64) -> Option<f64> {
    let fluid = guess(system, temperature)?;
    let HardSphereFluid { packing_fraction, diameter, mass, temperature } = fluid;
    match system.space.dimensions() {
        2 => Some(viscosity_of_disks(packing_fraction, diameter, mass, temperature)),
        3 => Some(fluid.shear_viscosity()),
        _ => None,
    }
}

/// Mean time between two contacts of a particle in the estimated fluid `[time]`.
pub(super) fn mean_free_time(system: &SystemDescription, sample: &Sample<'_>) -> Option<f64> {
    let fluid = guess(system, temperature(system, sample))?;
    let HardSphereFluid { packing_fraction, diameter, mass, temperature } = fluid;
    let rate = match system.space.dimensions() {
        1 => collision_rate_of_rods(packing_fraction, diameter, mass, temperature),
        2 => collision_rate_of_disks(packing_fraction, diameter, mass, temperature),
        _ => fluid.collision_rate(),
    };
    Some(1.0 / rate).filter(|time| is_time(*time))
}

/// Decay time of the slowest transverse flow in the box, `(L / 2 pi)^2 / nu`, where `L` is the longest period and `nu`
/// is Enskog's kinematic viscosity of the estimated fluid `[time]`.
///
/// The diffusion coefficient grows for a few of these times, because a particle drags the surrounding fluid along.
/// `None` if momentum is not conserved, and in one dimension, where there is no such flow.
pub(super) fn flow_decay_time(system: &SystemDescription, sample: &Sample<'_>) -> Option<f64> {
    let longest = system.space.periods().iter().copied().filter(|period| period.is_finite()).fold(0.0, f64::max);
    if !system.conserves_momentum || longest == 0.0 {
        return None;
    }
    let density = system.moving_mass() / system.space.volume();
    let wave = longest / TAU;
    let time = wave * wave * density / viscosity(system, temperature(system, sample))?;
    Some(time).filter(|time| is_time(*time))
}

fn is_time(time: f64) -> bool {
    time.is_finite() && time > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_free_time_is_that_of_hard_spheres() {
        let (system, simulation) = super::super::test_system::hard_spheres(108, 0.3);
        let snapshot = simulation.snapshot();
        // The scene has the temperature 1 with 3 (N - 1) degrees of freedom. `mean_free_time` assumes 3 N.
        let expected = (108.0_f64 / 107.0).sqrt() / HardSphereFluid::reduced(0.3).collision_rate();
        let time = mean_free_time(&system, &Sample::of(&snapshot)).unwrap();
        assert!((time / expected - 1.0).abs() < 1e-9, "{time} {expected}");
    }

    #[test]
    fn flow_decays_by_the_viscosity_in_the_longest_period() {
        let (mut system, simulation) = super::super::test_system::hard_spheres(108, 0.3);
        let snapshot = simulation.snapshot();
        let sample = Sample::of(&snapshot);
        let fluid = HardSphereFluid { temperature: 107.0 / 108.0, ..HardSphereFluid::reduced(0.3) };
        let viscosity = fluid.shear_viscosity() / fluid.number_density();
        let edge = system.space.size.x;
        let time = flow_decay_time(&system, &sample).unwrap();
        let expected = edge * edge / (TAU * TAU * viscosity);
        assert!((time / expected - 1.0).abs() < 1e-9, "{time} {expected}");
        system.conserves_momentum = false;
        assert_eq!(flow_decay_time(&system, &sample), None);
    }
}
