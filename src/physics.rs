//! Free flight, overlap functions, detection of the next event of a pair, and the response. All are pure functions of a
//! relative state.

pub mod detection;
pub mod motion;
pub mod overlap;
pub mod response;
