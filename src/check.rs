//! Independent checks: the reference engine, the proof of a run event by event, the comparison of its files with a
//! replay, and the comparison with published results.

pub mod compare;
pub mod reference;
pub mod validate;
pub mod verify;
