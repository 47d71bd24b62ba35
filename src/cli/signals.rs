//! Ctrl-C and SIGTERM.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Set by the first signal.
static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Whether the work checks for signals.
static IS_ASKED: AtomicBool = AtomicBool::new(false);

/// Work that leaves no files is ended if it has not checked for a signal within this time.
const PATIENCE: Duration = Duration::from_secs(1);

/// The first signal ends the work in good order, the second one immediately. Before the work has begun, the
/// first one also ends it immediately.
pub fn watch() {
    listen(|| {});
}

/// Ends work that leaves no files soon after the first signal, whether it checks or not.
pub fn watch_without_traces() {
    listen(|| {
        IS_ASKED.store(false, Ordering::Relaxed);
        std::thread::sleep(PATIENCE);
        if !IS_ASKED.load(Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
}

fn listen(then: fn()) {
    // Without a handler, a signal ends the program by default.
    let _ = ctrlc::set_handler(move || {
        let is_working = IS_ASKED.load(Ordering::Relaxed);
        if IS_STOPPED.swap(true, Ordering::Relaxed) || !is_working {
            std::process::exit(1);
        }
        then();
    });
}

/// Breaks after a signal.
pub fn flow() -> ControlFlow<()> {
    IS_ASKED.store(true, Ordering::Relaxed);
    if IS_STOPPED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
