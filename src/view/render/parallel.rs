//! Parallel drawing of an image. The result does not depend on the number of cores.

use std::num::NonZero;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Threads that draw one image together.
#[derive(Debug, Clone, Copy)]
pub(in crate::view) struct Team<'a> {
    pub threads: usize,
    /// Stops all threads. The image is then unfinished.
    pub is_stopped: Option<&'a AtomicBool>,
}

impl Team<'_> {
    pub fn whole() -> Self {
        Self { threads: cores(), is_stopped: None }
    }

    pub fn is_stopped(&self) -> bool {
        self.is_stopped.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

pub(in crate::view) fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Returns the number of pixel rows per band. Small bands fit into the cache, and keep all cores busy until the end.
pub(super) fn rows_per_band(rows: usize) -> usize {
    rows.div_ceil(64).clamp(1, 8)
}

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
            // If a thread cannot be started, other threads do its work.
            let _ = thread::Builder::new().spawn_scoped(scope, worker);
        }
        worker();
    });
}
