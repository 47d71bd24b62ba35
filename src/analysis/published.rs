//! Exact and published results to compare measurements with.
//!
//! Notation for hard particles: diameter `sigma`, mass `m`, temperature `T` (`k_B = 1`), packing fraction `phi`, number
//! density `rho`. Each function is valid only for the densities that its source covers.

mod equation_of_state;
pub(crate) mod finite_size;
mod granular;
mod heat_flux;
mod kinetic_theory;
mod maxwell;
mod of_mixture;
mod of_system;
mod outflow;
mod scaled_particle;
mod steps;
mod velocity_tail;

pub use equation_of_state::{carnahan_starling, face_centred_cubic, hard_disks, hard_spheres, tonks};
pub use granular::{haff_temperature, haff_time};
pub use heat_flux::GasBetweenPlates;
pub(crate) use kinetic_theory::{FITTED_SPHERES, is_hydrodynamic, mean_free_path_of_diffusion};
pub use kinetic_theory::{
    HardSphereFluid, collision_rate_of_disks, collision_rate_of_rods, contact_value, contact_value_of_disks,
    finite_size_of_diffusion, viscosity_of_disks,
};
pub use maxwell::{maxwell_speed_below, maxwell_speed_density};
pub use of_mixture::of_mixture;
#[cfg(test)]
pub(crate) use of_system::CRYSTAL_LABEL;
pub use of_system::{PublishedValue, of_system};
pub use outflow::beverloo;
pub(crate) use outflow::of_flows;
pub use scaled_particle::HardMixture;
pub use steps::{bounces_per_release, second_virial_of_square_well, third_virial_of_square_well};
pub(crate) use velocity_tail::VelocityTail;
