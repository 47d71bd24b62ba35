//! Ctrl-C and other signals, while other threads of Python run.

use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Between two looks.
const INTERVAL: Duration = Duration::from_millis(50);
/// Steps of an engine between two looks at the clock: the first time, and at most.
const STEPS: [u64; 2] = [64, 1 << 16];

/// Looks for signals now and then.
pub struct Signals {
    looked: Instant,
    steps: u64,
}

impl Signals {
    pub fn new() -> Self {
        Self { looked: Instant::now(), steps: STEPS[0] }
    }

    /// Steps of an engine until the next look at the clock. Steps can be slow, of particles with very many others near them.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether it is time for something that is done as often as signals are looked for.
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

    /// Looks for signals, if it is time to.
    ///
    /// # Errors
    /// The exception that a signal raises, such as `KeyboardInterrupt`.
    pub fn look(&mut self) -> PyResult<()> {
        if self.is_due() { Python::attach(|py| py.check_signals()) } else { Ok(()) }
    }
}
