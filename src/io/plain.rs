//! Access to Carom's own files. Symbolic links are not followed, because they may lead to foreign files.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::draft::remove_abandoned;
use super::error::OutputError;
use super::occupied::run_around;
use super::partial::partial_of;

/// Creates an empty file. First removes an existing file, which may be a link to a foreign file.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Opens a plain file. Rejects links, folders, devices and pipes.
pub(crate) fn open(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    {
        // `O_NOFOLLOW` rejects links, and `O_NONBLOCK` avoids blocking on a pipe.
        std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    // Other systems reject links only here. Linux also rejects a link that is created after this check.
    if fs::symlink_metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a plain file"));
    }
    let file = options.open(path)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::ErrorKind::InvalidInput.into()) }
}

/// Returns the content of a plain file, up to `most` bytes.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(OpenOptions::new().read(true), path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens or creates the file that marks a folder as Carom's, and locks it. Also returns the content of the file.
pub(crate) fn lock(folder: &Path, name: &str) -> Result<(File, Vec<u8>), OutputError> {
    let path = folder.join(name);
    refuse(&path, false)?;
    let mut file =
        open(OpenOptions::new().read(true).append(true).create(true), &path).map_err(OutputError::write(&path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => return Err(OutputError::Busy(folder.to_owned())),
        // On a system without file locks, two processes can write to the folder at the same time.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(OutputError::write(&path))?;
    Ok((file, bytes))
}

/// Creates an output folder if it is missing. Removes drafts of killed commands from it. Fails inside a run folder.
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

/// Rejects links and special files at the temporary path and at the final path. A name that ends with `/` is a folder.
pub(crate) fn refuse_others(folder: &Path, name: &str) -> Result<(), OutputError> {
    refuse_links_to(folder, name)?;
    let path = folder.join(name.trim_end_matches('/'));
    refuse(&partial_of(&path), name.ends_with('/'))?;
    refuse(&path, name.ends_with('/'))
}

/// Rejects symbolic links in the path from `folder` to a file.
pub(crate) fn refuse_links_to(folder: &Path, name: &str) -> Result<(), OutputError> {
    let path = folder.join(name.trim_end_matches('/'));
    let mut parents = path.ancestors().skip(1).take_while(|parent| *parent != folder);
    parents.try_for_each(|parent| refuse(parent, true))
}

/// Checks that a path is missing or is a plain file. With `is_folder`, a folder is expected instead of a file.
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
