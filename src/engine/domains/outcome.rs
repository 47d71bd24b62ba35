//! Outcome of a window in a domain. All processes receive the outcomes of all domains.

use crate::engine::parts::Counts;
use crate::engine::progress::{Seen, Times};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Tally {
    /// Number of engine steps of owned particles in this window, and total number of engine steps.
    pub done: u64,
    pub done_in_all: u64,
    /// Time of the last step of an owned particle in this window.
    pub latest: f64,
    pub events: Vec<Seen>,
    /// Times of events and transitions of owned particles.
    pub times: Times,
}

impl Tally {
    pub fn new() -> Self {
        Self { done: 0, done_in_all: 0, latest: f64::NEG_INFINITY, events: Vec::new(), times: Times::default() }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Outcome {
    /// Time of the first step in which an owned particle differs from a copy that may have affected other particles.
    pub difference: Option<f64>,
    pub counts: Box<Counts>,
    pub tally: Tally,
    /// True if the number of copies exceeds its limit. The box must then be divided again.
    pub has_grown: bool,
}
