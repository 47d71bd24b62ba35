//! Independent checks: the reference engine, the proof of a run event by event, and the comparison with published results.

pub mod reference;
pub mod validate;
pub mod verify;
