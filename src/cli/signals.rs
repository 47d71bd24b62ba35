//! Ctrl-C and SIGTERM.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Whether the work has checked for signals. [`watch_without_traces`] clears the flag at the first signal.
static IS_ASKED: AtomicBool = AtomicBool::new(false);

/// Time in which work without files must react to a signal. Otherwise, the program ends.
const PATIENCE: Duration = Duration::from_secs(1);

/// Installs the signal handler. The first signal lets the work end cleanly; a second signal, or a signal before the
/// work begins, ends the program immediately.
pub fn watch() {
    listen(|| {});
}

/// Installs a signal handler for work that leaves no files. The first signal ends the program soon, even if the work
/// does not check for signals.
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
    // If no handler can be installed, a signal ends the program, which is the default.
    let _ = ctrlc::set_handler(move || {
        let is_working = IS_ASKED.load(Ordering::Relaxed);
        if IS_STOPPED.swap(true, Ordering::Relaxed) || !is_working {
            std::process::exit(1);
        }
        then();
    });
}

pub fn flow() -> ControlFlow<()> {
    IS_ASKED.store(true, Ordering::Relaxed);
    if IS_STOPPED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}
