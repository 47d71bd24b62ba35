//! Work on independent parts of an image, on all cores. The result does not depend on their number.

use std::num::NonZero;
use std::sync::Mutex;
use std::thread;

/// Rows of a band: small enough that all cores have work until the end.
pub(super) fn rows_per_band(rows: usize) -> usize {
    rows.div_ceil(64).max(1)
}

/// Runs `work` once for each part.
pub(super) fn for_each<P: Send>(parts: impl Iterator<Item = P> + Send, work: impl Fn(P) + Sync) {
    let parts = Mutex::new(parts);
    let worker = || {
        loop {
            let part = parts.lock().map(|mut parts| parts.next());
            match part {
                Ok(Some(part)) => work(part),
                _ => return,
            }
        }
    };
    let others = thread::available_parallelism().map_or(1, NonZero::get) - 1;
    thread::scope(|scope| {
        for _ in 0..others {
            // Without a further thread, the others do its share.
            let _ = thread::Builder::new().spawn_scoped(scope, worker);
        }
        worker();
    });
}
