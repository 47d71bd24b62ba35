//! A run that replaces another one: it is written in a folder within the other's, which stays as it is until all of the new one is
//! complete and sound. Its files then take their places; what was killed meanwhile is finished when the folder is opened next. The list of
//! the other run says how far that has come: what else is in such a folder is left alone.

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

/// The folder of the run that is to replace the one in a folder.
pub(super) fn within(run: &Path) -> PathBuf {
    run.join(FOLDER)
}

/// Finishes what a killed program began: puts a complete run in the place of the one that it replaces, and removes one that came to nothing.
/// The folder is locked.
pub(super) fn recover(run: &Path, owned: &mut Owned) -> Result<(), OutputError> {
    if owned.replacement() == Replacement::None {
        return Ok(());
    }
    let inner = within(run);
    if !inner.join(owned::FILE).exists() {
        // It was moved away, or removed.
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

/// Puts all files of a complete run into the place of those of the run that it replaces.
///
/// # Errors
/// [`OutputError::Foreign`] if there is a file that neither of them wrote; [`OutputError::Write`].
pub(super) fn take_place(inner: &Path, new: Owned, run: &Path, old: &mut Owned) -> Result<(), OutputError> {
    let names: Vec<String> = new.names().iter().cloned().collect();
    old.claim(&names)?;
    old.set_replacement(Replacement::Complete)?;
    // From here on the old files are replaced; all new ones are complete and safe.
    remove(&run.join(SUMMARY))?;
    sync_folder(run);
    for name in names.iter().filter(|name| *name != SUMMARY) {
        move_into(&inner.join(name.trim_end_matches('/')), &run.join(name.trim_end_matches('/')))?;
    }
    let stale: Vec<String> = old.names().difference(new.names()).cloned().collect();
    old.remove(&stale)?;
    for name in &names {
        // Files of a replaced run that had not ended.
        old.remove_partial(name)?;
    }
    sync_folder(run);
    move_into(&inner.join(SUMMARY), &run.join(SUMMARY))?;
    sync_folder(run);
    clear(inner, new);
    old.set_replacement(Replacement::None)
}

/// Renames a file, or a folder with all files of a format; what is not there any more has been moved before.
fn move_into(from: &Path, to: &Path) -> Result<(), OutputError> {
    let Ok(metadata) = fs::symlink_metadata(from) else { return Ok(()) };
    let write = |source| OutputError::Write { path: to.to_owned(), source };
    if !metadata.is_dir() {
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(write)?;
        }
        return fs::rename(from, to).map_err(write);
    }
    // None of the old files stays among the new ones, also where a kill comes between: all new ones arrive at once.
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
    // The user's own files stay, and the folder with them.
    let _ = fs::remove_file(inner.join(owned::FILE));
    let _ = fs::remove_dir(inner);
}
