//! Contacts: every event that changes velocities takes one path.
//!
//! | step | file | what it knows |
//! |---|---|---|
//! | frame | [`frame`] | who meets whom, along which line, how fast |
//! | law | [`law`] | from a frame the velocities afterwards: steps of a potential, restitution, TC model |
//! | | [`super::sources::surface`] | velocities that a thermal surface gives, drawn at random |
//! | | [`super::sources::andersen`] | velocities that a heat bath gives, drawn at random |
//! | apply | [`apply`] | writes velocities, voids predictions, counts, shows the event |
//! | ledger | [`super::ledger`] | sums of energies and momenta that came and went |
//!
//! A law writes no velocity; [`apply`] is the only place that does.

pub(super) mod apply;
pub(super) mod frame;
pub(super) mod law;
