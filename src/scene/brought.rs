//! Reads the files of a scene, from disk or from the page in a browser.

#[cfg(not(target_family = "wasm"))]
pub(crate) use std::fs::read;

#[cfg(target_family = "wasm")]
pub use brought::bring;
#[cfg(target_family = "wasm")]
pub(crate) use brought::read;

/// Files in memory, because WebAssembly in a browser has no disk.
#[cfg(target_family = "wasm")]
mod brought {
    use std::cell::RefCell;
    use std::collections::BTreeMap;
    use std::io;
    use std::path::{Path, PathBuf};

    thread_local! {
        static BROUGHT: RefCell<BTreeMap<PathBuf, Vec<u8>>> = RefCell::default();
    }

    /// Provides the content of a file for scenes that name this path.
    pub fn bring(path: &Path, content: Vec<u8>) {
        BROUGHT.with_borrow_mut(|files| files.insert(path.to_owned(), content));
    }

    pub fn read(path: &Path) -> io::Result<Vec<u8>> {
        let content = BROUGHT.with_borrow(|files| files.get(path).cloned());
        content.ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the page does not include this file"))
    }
}
