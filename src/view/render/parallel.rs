//! Work on independent parts of an image, on all cores. The result does not depend on their number.

use std::num::NonZero;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// A team of threads that draws one image.
#[derive(Debug, Clone, Copy)]
pub(in crate::view) struct Team<'a> {
    /// Number of threads.
    pub threads: usize,
    /// Set to have an image left unfinished.
    pub is_stopped: Option<&'a AtomicBool>,
}

impl Team<'_> {
    /// All cores.
    pub fn whole() -> Self {
        Self { threads: cores(), is_stopped: None }
    }

    /// Whether the image will not be finished.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

/// Number of cores that this process may use.
pub(in crate::view) fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Rows of pixels of a band: few enough that its samples stay in the cache, and that all cores have work until the end.
pub(super) fn rows_per_band(rows: usize) -> usize {
    rows.div_ceil(64).clamp(1, 8)
}

/// Runs `work` once for each part, unless the team is stopped.
pub(super) fn for_each<P: Send>(team: &Team, parts: impl Iterator<Item = P> + Send, work: impl Fn(P) + Sync) {
    let parts = Mutex::new(parts);
    let worker = || {
        while !team.is_stopped() {
            let part = parts.lock().map(|mut parts| parts.next());
            match part {
                Ok(Some(part)) => work(part),
                _ => return,
            }
        }
    };
    thread::scope(|scope| {
        for _ in 1..team.threads {
            // Without a further thread, the others do its share.
            let _ = thread::Builder::new().spawn_scoped(scope, worker);
        }
        worker();
    });
}
