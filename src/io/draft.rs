//! Drafts: files with temporary names. The process that writes a draft locks it. The next command in the folder removes
//! the drafts of killed processes.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use super::atomic::{Existing, folder_of, holds_same, publish};
use super::plain;

/// Names of drafts contain the process id and a number, such as `.carom-4711-0.partial`.
const PREFIX: &str = ".carom-";
const SUFFIX: &str = ".partial";

/// A file with a temporary name. Dropping this value removes the file unless it has been published.
pub(crate) struct UnnamedFile {
    temporary: TemporaryFile,
    target: PathBuf,
}

impl UnnamedFile {
    pub fn beside(path: &Path) -> io::Result<(Self, File)> {
        // If the path is a link, the link is kept and its target is replaced.
        let target = if path.is_symlink() { fs::canonicalize(path)? } else { path.to_owned() };
        remove_abandoned(folder_of(&target));
        let (temporary, file) = TemporaryFile::beside(&target)?;
        Ok((Self { temporary, target }, file))
    }

    pub fn path(&self) -> &Path {
        &self.temporary.path
    }

    /// Gives the file its final name. A file with equal content may always be replaced.
    ///
    /// # Errors
    /// [`io::ErrorKind::AlreadyExists`] if a file with other content exists and must be kept; system errors.
    pub fn publish(self, existing: Existing) -> io::Result<()> {
        let Self { temporary, target } = self;
        if existing == Existing::Keep && target.exists() && holds_same(&target, &temporary.path)? {
            return Ok(());
        }
        publish(&temporary.path, &target, existing)
    }
}

struct TemporaryFile {
    path: PathBuf,
    /// Keeps the file locked until this value is dropped, even if another program writes to the file.
    _lock: File,
}

impl TemporaryFile {
    fn beside(path: &Path) -> io::Result<(Self, File)> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let folder = folder_of(path);
        loop {
            let number = COUNT.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!("{PREFIX}{}-{number}{SUFFIX}", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                // Another process may have treated the unlocked file as abandoned.
                Ok(file) if is_lost(&file) => {}
                Ok(file) => return Ok((Self { path, _lock: file.try_clone()? }, file)),
                // A killed process with the same id may have left the file.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Removes all drafts in a folder, except locked drafts. Without file locks, no draft is removed.
pub(crate) fn remove_abandoned(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| is_draft(&entry.file_name())) {
        let path = entry.path();
        let Ok(file) = plain::open(OpenOptions::new().write(true), &path) else { continue };
        // `is_abandoned` locks `file` until the draft is removed. Otherwise, a process that has just created the draft
        // could lock it and start to write.
        if is_abandoned(&file) {
            let _ = fs::remove_file(path);
        }
    }
}

pub(crate) fn is_draft(name: &OsStr) -> bool {
    let inner = name.to_str().and_then(|name| name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    inner.and_then(|inner| inner.split_once('-')).is_some_and(|(process, count)| is_number(process) && is_number(count))
}

/// Locks a new draft. Returns whether another process has treated the draft as abandoned.
#[cfg(unix)]
fn is_lost(file: &File) -> bool {
    matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) || !has_name(file)
}

/// Tries to lock a draft. Returns whether the lock succeeded and the draft still exists.
#[cfg(unix)]
fn is_abandoned(file: &File) -> bool {
    file.try_lock().is_ok() && has_name(file)
}

#[cfg(unix)]
fn has_name(file: &File) -> bool {
    file.metadata().is_ok_and(|metadata| std::os::unix::fs::MetadataExt::nlink(&metadata) > 0)
}

/// Outside Unix, drafts are not locked, because a lock would prevent ffmpeg from writing to the file.
#[cfg(not(unix))]
fn is_lost(_file: &File) -> bool {
    false
}

#[cfg(not(unix))]
fn is_abandoned(_file: &File) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_draft_is_removed_when_its_process_is_gone_and_never_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let (draft, _file) = UnnamedFile::beside(&path("a.png")).unwrap();
        for name in [".carom-4711-0.partial", ".carom-notes.partial", ".carom-1-2-3.partial", "mine"] {
            fs::write(path(name), "").unwrap();
        }
        std::os::unix::fs::symlink(path("mine"), path(".carom-4711-1.partial")).unwrap();
        remove_abandoned(folder.path());
        assert!(draft.path().exists(), "one that is written");
        assert!(!path(".carom-4711-0.partial").exists(), "one that nobody writes");
        let others = [".carom-notes.partial", ".carom-1-2-3.partial", "mine", ".carom-4711-1.partial"];
        assert!(others.iter().all(|name| path(name).exists()));
        let at = draft.path().to_owned();
        drop(draft);
        assert!(!at.exists());
    }
}
