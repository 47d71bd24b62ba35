//! Processor time: what others do on the machine counts less than in the time on the wall.

use std::time::Instant;

/// Measures the processor time of this thread `[s]`, or the time on the wall where the system does not tell.
pub struct Stopwatch {
    wall: Instant,
    processor: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), processor: processor_seconds() }
    }

    /// The system counts in intervals of some milliseconds: a time that short is taken from the wall.
    pub fn seconds(&self) -> f64 {
        const SHORT: f64 = 0.05;
        let wall = self.wall.elapsed().as_secs_f64();
        match (self.processor, processor_seconds()) {
            (Some(start), Some(now)) if wall > SHORT => now - start,
            _ => wall,
        }
    }
}

/// Linux: nanoseconds on the processor are the first number of this file.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}
