//! Compares whole simulations with exact and published results.
//!
//! Statistical tolerances are four standard errors, estimated from blocks of the run. Seeds are fixed, so a test always
//! passes or always fails. Tolerances for round-off are derived where they are used.

mod chains;
mod conservation;
mod dense_starts;
mod driven;
mod enduring_contacts;
mod errors;
mod exchange;
mod few_particles;
mod granular;
mod growth;
mod hard_spheres;
mod heat_flux;
mod hopper;
mod impact_speed;
mod in_plane;
mod invariance;
mod isobaric;
mod measure;
mod moving;
mod multicanonical;
mod pauses;
mod rates;
mod rough;
mod rough_cooling;
mod sheared;
mod single_bodies;
mod sleep;
mod starts_in_contact;
mod steps;
mod stress;
mod surface_velocity;
mod swaps;
mod umbrella;
mod unbounded;
mod walls;
