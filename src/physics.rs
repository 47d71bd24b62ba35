//! Free flight, overlap functions, event detection and response. All are pure functions of a relative state.

pub mod detection;
pub(crate) mod kinetics;
pub mod motion;
pub mod overlap;
pub mod response;
pub mod restitution;
pub mod rough;
