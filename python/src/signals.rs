//! Checks for Ctrl-C and other signals during a simulation.

use std::time::{Duration, Instant};

use pyo3::prelude::*;

const INTERVAL: Duration = Duration::from_millis(50);
/// Initial and largest number of engine steps between two readings of the clock.
const STEPS: [u64; 2] = [64, 1 << 16];

/// Reads the clock only after many engine steps, and checks for signals only after `INTERVAL`.
pub struct Signals {
    looked: Instant,
    steps: u64,
}

impl Signals {
    pub fn new() -> Self {
        Self { looked: Instant::now(), steps: STEPS[0] }
    }

    /// Number of engine steps until the next reading of the clock. The number adapts to the speed of the engine.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    pub fn is_due(&mut self) -> bool {
        let now = Instant::now();
        if now - self.looked < INTERVAL {
            if now - self.looked < INTERVAL / 4 {
                self.steps = (2 * self.steps).min(STEPS[1]);
            }
            return false;
        }
        self.steps = (self.steps / 2).max(STEPS[0]);
        self.looked = now;
        true
    }

    /// Checks for signals if a check is due. The error is the exception of the signal, such as `KeyboardInterrupt`.
    pub fn look(&mut self) -> PyResult<()> {
        if self.is_due() { Python::attach(|py| py.check_signals()) } else { Ok(()) }
    }
}
