//! Starts: positions and velocities of the particles of a model, before anything moves.
//!
//! Positions come from [`lattice`], from [`packing`] (random insertion, compression), from [`chain`] and from [`surface`] (static spheres);
//! [`region`] has what a fill takes of the box,
//! [`velocity`] draws the velocities, [`polydispersity`] has the diameters of the classes of a distribution, and [`composition`] the numbers
//! of a mixture. Nothing here depends on a file or a key that a user typed: what goes wrong is an error of its own, such as
//! [`packing::NoRoom`], from which `scene` makes a message.

pub(crate) mod chain;
pub(crate) mod composition;
pub(crate) mod lattice;
pub(crate) mod packing;
pub(crate) mod polydispersity;
pub(crate) mod region;
pub(crate) mod surface;
pub(crate) mod velocity;
