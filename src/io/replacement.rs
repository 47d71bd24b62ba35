//! Replacement of an old run by a new run. The new run writes to a folder inside the old folder. When it is complete
//! and sound, its files replace the old files. If the program is killed, the next command completes the replacement.

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

/// Completes an interrupted replacement. Removes a new run that cannot be resumed.
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

/// Moves the files of a complete new run to the folder of the old run. Fails if a foreign file is in the way.
pub(super) fn take_place(inner: &Path, new: Owned, run: &Path, old: &mut Owned) -> Result<(), OutputError> {
    let names: Vec<String> = new.names().iter().cloned().collect();
    old.claim(&names)?;
    old.set_replacement(Replacement::Complete)?;
    // The old files are replaced from here on. The new files are complete and on disk.
    remove(&run.join(SUMMARY))?;
    sync_folder(run);
    for name in names.iter().filter(|name| *name != SUMMARY) {
        move_into(&inner.join(name.trim_end_matches('/')), &run.join(name.trim_end_matches('/')))?;
    }
    let stale: Vec<String> = old.names().difference(new.names()).cloned().collect();
    old.remove(&stale)?;
    for name in &names {
        old.remove_partial(name)?;
    }
    sync_folder(run);
    move_into(&inner.join(SUMMARY), &run.join(SUMMARY))?;
    sync_folder(run);
    clear(inner, new);
    old.set_replacement(Replacement::None)
}

/// Moves a file or folder. If the source is missing, a killed program has moved it.
fn move_into(from: &Path, to: &Path) -> Result<(), OutputError> {
    let Ok(metadata) = fs::symlink_metadata(from) else { return Ok(()) };
    let write = |source| OutputError::Write { path: to.to_owned(), source };
    if !metadata.is_dir() {
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent).map_err(write)?;
        }
        return fs::rename(from, to).map_err(write);
    }
    // The folder is moved in one step, so old and new files are never mixed.
    remove_converted(to)?;
    fs::rename(from, to).map_err(write)
}

fn clear(inner: &Path, list: Owned) {
    for folder in list.names().iter().filter_map(|name| Path::new(name).parent()) {
        if !folder.as_os_str().is_empty() {
            let _ = fs::remove_dir(inner.join(folder));
        }
    }
    drop(list);
    // `remove_dir` fails if the folder contains files of the user.
    let _ = fs::remove_file(inner.join(owned::FILE));
    let _ = fs::remove_dir(inner);
}
