//! Contacts: every event that changes velocities takes the same path.
//!
//! | step | file | content |
//! |---|---|---|
//! | frame | [`frame`] | two particles: the line of centres, the relative velocity |
//! | | [`super::sources::surface`] | a particle and a surface |
//! | law | [`law`] | velocities after the contact: potential steps, restitution, TC model |
//! | | [`super::sources::surface`] | random velocities from a thermal surface |
//! | | [`super::sources::andersen`] | random velocities from a heat bath |
//! | apply | [`apply`] | writes velocities, voids predictions, counts, reports the event |
//! | ledger | [`super::ledger`] | sums of exchanged energy and momentum |
//!
//! Only [`apply`] changes velocities and spins by impulses. Four other functions write them: `stream` moves accelerated
//! particles. `cross_sliding_side` replaces a particle by its image in a sheared box. Records restore whole particles.
//! `fall_asleep` removes the rounding error of the spin.

pub(super) mod apply;
pub(super) mod frame;
pub(super) mod law;
pub(in crate::engine) mod rough;
