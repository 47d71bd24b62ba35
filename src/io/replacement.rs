//! Replacement of an old run by a new run. The new run is written to a folder inside the folder of the old run. The old
//! run is unchanged until the new run is complete and sound. Then the new files replace the old files. An interrupted
//! replacement is completed when the folder is opened next. The list of the old run records the progress. Other files
//! in the folder are left alone.

use std::fs;
use std::path::{Path, PathBuf};

use super::atomic::sync_folder;
use super::checkpoints;
use super::convert::remove_converted;
use super::error::OutputError;
use super::folder::{SUMMARY, remove};
use super::owned::{self, Owned, Replacement};

pub(super) const FOLDER: &str = "replacement";

pub(super) fn within(run: &Path) -> PathBuf {
    run.join(FOLDER)
}

/// Completes a replacement that a killed program left unfinished. A complete new run replaces the old run. A new run
/// that cannot be resumed is removed. The folder must be locked.
pub(super) fn recover(run: &Path, owned: &mut Owned) -> Result<(), OutputError> {
    if owned.replacement() == Replacement::None {
        return Ok(());
    }
    let inner = within(run);
    if !inner.join(owned::FILE).exists() {
        // The user has moved or deleted the new run.
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

/// Replaces all files of the old run by the files of the complete new run.
///
/// # Errors
/// [`OutputError::Foreign`] if a file that neither run wrote is in the way, [`OutputError::Write`] if a file cannot be
/// moved.
pub(super) fn take_place(inner: &Path, new: Owned, run: &Path, old: &mut Owned) -> Result<(), OutputError> {
    let names: Vec<String> = new.names().iter().cloned().collect();
    old.claim(&names)?;
    old.set_replacement(Replacement::Complete)?;
    // From here on, files of the old run are replaced. All files of the new run are complete and synced to disk.
    remove(&run.join(SUMMARY))?;
    sync_folder(run);
    for name in names.iter().filter(|name| *name != SUMMARY) {
        move_into(&inner.join(name.trim_end_matches('/')), &run.join(name.trim_end_matches('/')))?;
    }
    let stale: Vec<String> = old.names().difference(new.names()).cloned().collect();
    old.remove(&stale)?;
    for name in &names {
        // The old run may have left unfinished files.
        old.remove_partial(name)?;
    }
    sync_folder(run);
    move_into(&inner.join(SUMMARY), &run.join(SUMMARY))?;
    sync_folder(run);
    clear(inner, new);
    old.set_replacement(Replacement::None)
}

/// Moves a file or folder. If `from` is missing, an earlier attempt has already moved it.
fn move_into(from: &Path, to: &Path) -> Result<(), OutputError> {
    let Ok(metadata) = fs::symlink_metadata(from) else { return Ok(()) };
    let write = |source| OutputError::Write { path: to.to_owned(), source };
    if !metadata.is_dir() {
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(write)?;
        }
        return fs::rename(from, to).map_err(write);
    }
    // The old folder is removed first. A single rename then moves the new folder into place. Even if the program is
    // killed, no old files are left among the new ones.
    remove_converted(to)?;
    fs::rename(from, to).map_err(write)
}

/// Removes the folder of a run if it contains only its list and empty folders.
fn clear(inner: &Path, list: Owned) {
    for folder in list.names().iter().filter_map(|name| Path::new(name).parent()) {
        if !folder.as_os_str().is_empty() {
            let _ = fs::remove_dir(inner.join(folder));
        }
    }
    drop(list);
    // The folder stays if it contains files of the user.
    let _ = fs::remove_file(inner.join(owned::FILE));
    let _ = fs::remove_dir(inner);
}
