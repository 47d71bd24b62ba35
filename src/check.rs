//! Independent checks: reference engine, verification of events, comparisons with replays and published results.

pub mod compare;
pub mod reference;
pub mod validate;
pub mod verify;
