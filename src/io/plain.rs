//! Carom's own files: plain files in plain folders. Symbolic links are not followed, because their targets may
//! not belong to Carom. Files with more than one hard link are not used.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::draft::remove_abandoned;
use super::error::OutputError;
use super::occupied::run_around;
use super::partial::partial_of;

/// Replaces an existing file by an empty one, so that no link or second name redirects its bytes.
///
/// # Errors
/// System errors, also if a folder exists at the path.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Opens a file with the given options, unless it is a link, a folder or a device.
///
/// # Errors
/// System errors, including the error for a link; [`io::ErrorKind::InvalidInput`] for a device or a pipe.
pub(crate) fn open(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    {
        // Pipes do not block either.
        std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    // On other systems this is the only check. On Linux, the flags also cover a link created in between.
    if fs::symlink_metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a plain file"));
    }
    let file = options.open(path)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::ErrorKind::InvalidInput.into()) }
}

/// Content of a plain file, up to a number of bytes.
///
/// # Errors
/// The errors of [`open`], and errors of reading.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(OpenOptions::new().read(true), path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens or creates the file that identifies a folder as Carom's, locked for this process until it is
/// dropped; also returns its content.
///
/// # Errors
/// [`OutputError::Busy`] if another process has locked it, [`OutputError::NotPlain`] or
/// [`OutputError::Write`] if it cannot be opened.
pub(crate) fn lock(folder: &Path, name: &str) -> Result<(File, Vec<u8>), OutputError> {
    let path = folder.join(name);
    refuse(&path, false)?;
    let mut file =
        open(OpenOptions::new().read(true).append(true).create(true), &path).map_err(OutputError::write(&path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => return Err(OutputError::Busy(folder.to_owned())),
        // On systems without locks, nothing separates two processes.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(OutputError::write(&path))?;
    Ok((file, bytes))
}

/// Creates a folder for the output of a command, unless it exists, and removes drafts of killed commands in
/// it.
///
/// # Errors
/// [`OutputError::WithinRun`] inside the folder of a run, [`OutputError::NotFolder`] or
/// [`OutputError::Folder`] if it cannot exist.
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

/// Rejects anything but a plain file at the path of one of Carom's files, complete or not; anything but a
/// folder if the name ends with `/`; and links on the way to it.
///
/// # Errors
/// [`OutputError::NotPlain`]. A missing file is fine.
pub(crate) fn refuse_others(folder: &Path, name: &str) -> Result<(), OutputError> {
    refuse_links_to(folder, name)?;
    let path = folder.join(name.trim_end_matches('/'));
    refuse(&partial_of(&path), name.ends_with('/'))?;
    refuse(&path, name.ends_with('/'))
}

/// Rejects anything but plain folders on the way to a file.
///
/// # Errors
/// [`OutputError::NotPlain`].
pub(crate) fn refuse_links_to(folder: &Path, name: &str) -> Result<(), OutputError> {
    let path = folder.join(name.trim_end_matches('/'));
    let mut parents = path.ancestors().skip(1).take_while(|parent| *parent != folder);
    parents.try_for_each(|parent| refuse(parent, true))
}

/// Rejects anything but a plain file, or a plain folder if `is_folder`.
///
/// # Errors
/// [`OutputError::NotPlain`]. A missing file is fine.
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
