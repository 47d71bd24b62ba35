//! A switch that turns off syncing files to disk.
//!
//! A file survives a crash of the machine only if it is synced, but syncing can take longer than a short run. Files in
//! a temporary folder need not survive a crash.

use std::cell::Cell;
use std::fs::File;
use std::io;

thread_local! {
    static IS_OFF: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work` without syncing the files that it writes on this thread.
pub fn without_sync<T>(work: impl FnOnce() -> T) -> T {
    /// Restores the previous setting when `work` ends, even if it panics.
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            IS_OFF.set(self.0);
        }
    }
    let _before = Before(IS_OFF.replace(true));
    work()
}

pub(crate) fn sync_all(file: &File) -> io::Result<()> {
    if IS_OFF.get() { Ok(()) } else { file.sync_all() }
}

pub(crate) fn sync_data(file: &File) -> io::Result<()> {
    if IS_OFF.get() { Ok(()) } else { file.sync_data() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_sync_applies_only_within_its_closure() {
        assert!(!IS_OFF.get());
        without_sync(|| {
            assert!(IS_OFF.get());
            without_sync(|| ());
            assert!(IS_OFF.get());
        });
        assert!(!IS_OFF.get());
        let _ = std::panic::catch_unwind(|| without_sync(|| panic!("stop")));
        assert!(!IS_OFF.get());
    }
}
