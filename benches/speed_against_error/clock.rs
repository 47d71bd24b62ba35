use std::time::Instant;

/// Measures the processor time of this thread `[s]`, which depends less on the load of the machine than wall time does.
pub struct Stopwatch {
    wall: Instant,
    processor: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), processor: processor_seconds() }
    }

    /// Time `[s]`. Short times are wall times, because the processor time is updated only every few milliseconds.
    pub fn seconds(&self) -> f64 {
        const SHORT: f64 = 0.05;
        let wall = self.wall.elapsed().as_secs_f64();
        match (self.processor, processor_seconds()) {
            (Some(start), Some(now)) if wall > SHORT => now - start,
            _ => wall,
        }
    }
}

/// Processor time of this thread `[s]`: the first number in `schedstat`, which is in nanoseconds.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}
