//! Processor time, which depends less on other work of the machine than wall time.

use std::time::Instant;

/// Measures the processor time of this thread `[s]`, or wall time if the system does not report it.
pub struct Stopwatch {
    wall: Instant,
    processor: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), processor: processor_seconds() }
    }

    /// The system counts in intervals of a few milliseconds, so shorter times are wall times.
    pub fn seconds(&self) -> f64 {
        const SHORT: f64 = 0.05;
        let wall = self.wall.elapsed().as_secs_f64();
        match (self.processor, processor_seconds()) {
            (Some(start), Some(now)) if wall > SHORT => now - start,
            _ => wall,
        }
    }
}

/// Linux: the first number in this file is the time on the processor in nanoseconds.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}
