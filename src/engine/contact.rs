//! Contacts: every event that changes velocities takes the same path.
//!
//! | step | file | content |
//! |---|---|---|
//! | frame | [`frame`] | the particles that meet, the line of centres, the relative velocity |
//! | law | [`law`] | velocities after the contact: potential steps, restitution, TC model |
//! | | [`super::sources::surface`] | random velocities from a thermal surface |
//! | | [`super::sources::andersen`] | random velocities from a heat bath |
//! | apply | [`apply`] | writes velocities, voids predictions, counts, reports the event |
//! | ledger | [`super::ledger`] | sums of exchanged energy and momentum |
//!
//! Only [`apply`] changes velocities and spins by impulses. Three other functions write velocities: `stream` moves
//! accelerated particles, `slide` in a sheared box moves a particle to the image inside the box, and records restore
//! whole particles.

pub(super) mod apply;
pub(super) mod frame;
pub(super) mod law;
pub(in crate::engine) mod rough;
