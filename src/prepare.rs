//! Starts: positions and velocities of the particles of a model, before anything moves.
//!
//! Positions come from [`lattice`], from [`packing`] (random insertion, compression), from [`chain`] and from [`surface`] (static spheres);
//! [`region`] has what a fill takes of the box,
//! [`velocity`] draws the velocities, [`resting`] finds particles at rest in contact with something fixed, [`polydispersity`] has the diameters of the classes of a distribution, and [`composition`] the numbers
//! of a mixture. Nothing here depends on a file or a key that a user typed: what goes wrong is an error of its own, [`NoPlace`],
//! from which `scene` makes a message.

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

/// Why particles have no places.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NoPlace {
    /// The sites of a lattice are closer than the particles on them may be.
    TooTight { count: usize, spacing: f64, contact: f64 },
    /// Random insertion found no place for one more.
    NoRoom { placed: usize, count: usize, attempts: usize },
    /// Growing spheres jam before they have their size.
    Jammed { wanted: f64, reached: f64 },
    /// A periodic axis on which a pair would meet twice.
    SmallBox { axis: usize, size: f64, range: f64 },
    /// Spheres that grow have no potential.
    Potential(PotentialError),
}
