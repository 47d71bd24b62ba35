//! Initial states: positions and velocities of particles.
//!
//! Positions come from [`lattice`], [`packing`], [`chain`] and [`surface`] (static spheres). [`region`] defines the
//! part of the box to fill, and [`velocity`] draws the velocities. [`resting`] finds particles at rest on something
//! fixed, and [`separation`] moves particles apart. [`polydispersity`] calculates diameters, and [`composition`] the particle numbers of a mixture.

pub(crate) mod chain;
pub(crate) mod composition;
pub(crate) mod lattice;
pub(crate) mod packing;
pub(crate) mod polydispersity;
pub(crate) mod resting;
pub(crate) mod separation;
pub(crate) mod surface;
pub(crate) mod velocity;

use crate::model::PotentialError;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NoPlace {
    /// The sites of a lattice are closer together than the contact distance.
    TooTight {
        count: usize,
        spacing: f64,
        contact: f64,
    },
    NoRoom {
        placed: usize,
        count: usize,
        attempts: usize,
    },
    Jammed {
        wanted: f64,
        reached: f64,
    },
    /// A periodic axis is so short that a pair could collide through two images.
    SmallBox {
        axis: usize,
        size: f64,
        range: f64,
    },
    Potential(PotentialError),
}
