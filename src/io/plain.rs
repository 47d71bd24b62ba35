//! Files of Carom's own: plain files in plain folders. No link is followed to them: what it leads to is not Carom's, nor what has another
//! name as well.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::draft::remove_abandoned;
use super::error::OutputError;
use super::occupied::run_around;
use super::partial::partial_of;

/// An empty file, in the place of one that was there: neither a link nor a second name leads its bytes elsewhere.
///
/// # Errors
/// Those of the system, also if a folder is there.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Opens a file as the options say, unless it is a link, a folder or a device.
///
/// # Errors
/// Those of the system; [`io::ErrorKind::InvalidInput`] for a device or a pipe, and what the system says of a link.
pub(crate) fn open(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    {
        // Nor is a pipe waited for.
        std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    // Elsewhere this is all; on Linux the flags hold also where a link appears in between.
    if fs::symlink_metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a plain file"));
    }
    let file = options.open(path)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::ErrorKind::InvalidInput.into()) }
}

/// Content of a plain file, up to a number of bytes.
///
/// # Errors
/// Those of [`open`], and those of reading.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(OpenOptions::new().read(true), path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens the file by which a folder of Carom's is known, or makes it, for this process alone until it is dropped; and what it holds.
///
/// # Errors
/// [`OutputError::Busy`] if another process has it, [`OutputError::NotPlain`] or [`OutputError::Write`] if it cannot be opened.
pub(crate) fn lock(folder: &Path, name: &str) -> Result<(File, Vec<u8>), OutputError> {
    let path = folder.join(name);
    refuse(&path, false)?;
    let mut file =
        open(OpenOptions::new().read(true).append(true).create(true), &path).map_err(OutputError::write(&path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => return Err(OutputError::Busy(folder.to_owned())),
        // Where the system has no locks, nothing keeps two processes apart.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(OutputError::write(&path))?;
    Ok((file, bytes))
}

/// Makes a folder in which a command writes, unless there is one, and removes what killed commands have left there.
///
/// # Errors
/// [`OutputError::WithinRun`] in the folder of a run, [`OutputError::NotFolder`] or [`OutputError::Folder`] if there can be none.
pub(crate) fn make_folder(path: &Path) -> Result<(), OutputError> {
    if let Some(run) = run_around(path) {
        return Err(OutputError::WithinRun { target: path.to_owned(), run });
    }
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_dir()) {
        return Err(OutputError::NotFolder(path.to_owned()));
    }
    fs::create_dir_all(path).map_err(|source| OutputError::Folder { path: path.to_owned(), source })?;
    remove_abandoned(path);
    Ok(())
}

/// Refuses whatever is under the name of a file of Carom's, complete or not, and no plain file; of a folder with all files of a format,
/// whose name ends with `/`, no folder; and links on the way to it.
///
/// # Errors
/// [`OutputError::NotPlain`]. What is not there is fine.
pub(crate) fn refuse_others(folder: &Path, name: &str) -> Result<(), OutputError> {
    refuse_links_to(folder, name)?;
    let path = folder.join(name.trim_end_matches('/'));
    refuse(&partial_of(&path), name.ends_with('/'))?;
    refuse(&path, name.ends_with('/'))
}

/// Refuses what is not a plain folder on the way to a file.
///
/// # Errors
/// [`OutputError::NotPlain`].
pub(crate) fn refuse_links_to(folder: &Path, name: &str) -> Result<(), OutputError> {
    let path = folder.join(name.trim_end_matches('/'));
    let mut parents = path.ancestors().skip(1).take_while(|parent| *parent != folder);
    parents.try_for_each(|parent| refuse(parent, true))
}

/// Refuses what is neither a plain file nor, where one is to be there, a plain folder.
///
/// # Errors
/// [`OutputError::NotPlain`]. What is not there is fine.
pub(crate) fn refuse(path: &Path, is_folder: bool) -> Result<(), OutputError> {
    let Ok(metadata) = fs::symlink_metadata(path) else { return Ok(()) };
    let kind = metadata.file_type();
    if if is_folder { kind.is_dir() } else { kind.is_file() } {
        return Ok(());
    }
    let found = match (kind.is_symlink(), kind.is_dir(), kind.is_file()) {
        (true, _, _) => "a link",
        (_, true, _) => "a folder",
        (_, _, true) => "a file",
        _ => "a device or a pipe",
    };
    let expected = if is_folder { "a folder" } else { "a plain file" };
    Err(OutputError::NotPlain { path: PathBuf::from(path), found, expected })
}
