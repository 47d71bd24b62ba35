//! A run that replaces an old run. The new run is written to a folder inside the folder of the old run. The
//! old run is unchanged until the new run is complete and sound. Then the new files replace the old files. An
//! interrupted replacement is completed when the folder is opened next. The list of the old run records the
//! progress; anything else in such a folder is left alone.

use std::fs;
use std::path::{Path, PathBuf};

use super::atomic::sync_folder;
use super::checkpoints;
use super::convert::remove_converted;
use super::error::OutputError;
use super::folder::{SUMMARY, remove};
use super::owned::{self, Owned, Replacement};

/// Name of the folder of a replacement, inside the folder of the old run.
pub(super) const FOLDER: &str = "replacement";

/// The folder of the run that is to replace the run in a folder.
pub(super) fn within(run: &Path) -> PathBuf {
    run.join(FOLDER)
}

/// Completes the work of a killed program: replaces the old run by a complete new run, or removes an unusable
/// new run. The folder is locked.
pub(super) fn recover(run: &Path, owned: &mut Owned) -> Result<(), OutputError> {
    if owned.replacement() == Replacement::None {
        return Ok(());
    }
    let inner = within(run);
    if !inner.join(owned::FILE).exists() {
        // It was moved or deleted.
        return owned.set_replacement(Replacement::None);
    }
    let mut new = Owned::lock(&inner)?;
    let has_ended = inner.join(SUMMARY).exists();
    if has_ended && owned.replacement() == Replacement::Complete {
        return take_place(&inner, new, run, owned);
    }
    if has_ended || checkpoints::has_any(&inner) {
        return Ok(());
    }
    new.remove_all()?;
    clear(&inner, new);
    owned.set_replacement(Replacement::None)
}

/// Replaces all files of the old run by the files of a complete new run.
///
/// # Errors
/// [`OutputError::Foreign`] if a file exists that neither run wrote; [`OutputError::Write`].
pub(super) fn take_place(inner: &Path, new: Owned, run: &Path, old: &mut Owned) -> Result<(), OutputError> {
    let names: Vec<String> = new.names().iter().cloned().collect();
    old.claim(&names)?;
    old.set_replacement(Replacement::Complete)?;
    // From here on, old files are replaced. All new ones are complete and synced.
    remove(&run.join(SUMMARY))?;
    sync_folder(run);
    for name in names.iter().filter(|name| *name != SUMMARY) {
        move_into(&inner.join(name.trim_end_matches('/')), &run.join(name.trim_end_matches('/')))?;
    }
    let stale: Vec<String> = old.names().difference(new.names()).cloned().collect();
    old.remove(&stale)?;
    for name in &names {
        // Files of an old run that was unfinished.
        old.remove_partial(name)?;
    }
    sync_folder(run);
    move_into(&inner.join(SUMMARY), &run.join(SUMMARY))?;
    sync_folder(run);
    clear(inner, new);
    old.set_replacement(Replacement::None)
}

/// Renames a file, or a folder with all files of a format. A missing file or folder has been moved before.
fn move_into(from: &Path, to: &Path) -> Result<(), OutputError> {
    let Ok(metadata) = fs::symlink_metadata(from) else { return Ok(()) };
    let write = |source| OutputError::Write { path: to.to_owned(), source };
    if !metadata.is_dir() {
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(write)?;
        }
        return fs::rename(from, to).map_err(write);
    }
    // No old file remains among the new ones, even after a kill, because all new ones arrive in one step.
    remove_converted(to)?;
    fs::rename(from, to).map_err(write)
}

/// Removes the folder of a run if only its list is left.
fn clear(inner: &Path, list: Owned) {
    for folder in list.names().iter().filter_map(|name| Path::new(name).parent()) {
        if !folder.as_os_str().is_empty() {
            let _ = fs::remove_dir(inner.join(folder));
        }
    }
    drop(list);
    // The user's own files stay, and so does the folder.
    let _ = fs::remove_file(inner.join(owned::FILE));
    let _ = fs::remove_dir(inner);
}
