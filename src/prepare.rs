//! Initial states: positions and velocities of the particles of a model.
//!
//! Positions come from [`lattice`], [`packing`] (random insertion, compression), [`chain`] and [`surface`] (static
//! spheres). [`region`] defines the part of the box to fill, and [`velocity`] draws the velocities. [`resting`] finds
//! particles at rest in contact with something fixed. [`polydispersity`] calculates the diameters of the classes of a
//! distribution, and [`composition`] the particle numbers of a mixture.
//!
//! Nothing here depends on a file or on a key in a user's input. `scene` converts failures, [`NoPlace`], to messages.

pub(crate) mod chain;
pub(crate) mod composition;
pub(crate) mod lattice;
pub(crate) mod packing;
pub(crate) mod polydispersity;
pub(crate) mod region;
pub(crate) mod resting;
pub(crate) mod surface;
pub(crate) mod velocity;

use crate::model::PotentialError;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NoPlace {
    /// The sites of a lattice are closer together than the contact distance of the particles.
    TooTight { count: usize, spacing: f64, contact: f64 },
    /// Random insertion found no place for another particle.
    NoRoom { placed: usize, count: usize, attempts: usize },
    /// Growing spheres jam before they reach their final size.
    Jammed { wanted: f64, reached: f64 },
    /// A periodic axis is so short that a pair could collide through two images.
    SmallBox { axis: usize, size: f64, range: f64 },
    /// The potential of the growing spheres could not be constructed.
    Potential(PotentialError),
}
