//! Ctrl-C and SIGTERM.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the first signal.
static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Lets the first signal end the work in good order, and the second one at once.
pub fn watch() {
    // Without a handler, a signal ends the program as it does by default.
    let _ = ctrlc::set_handler(|| {
        if IS_STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
}

/// Breaks after a signal.
pub fn flow() -> ControlFlow<()> {
    if IS_STOPPED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
