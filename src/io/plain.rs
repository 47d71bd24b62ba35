//! Files of Carom's own: plain files in plain folders. No link is followed to them: what it leads to is not Carom's, nor what has another
//! name as well.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::error::OutputError;
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

/// Content of a plain file, up to so many bytes.
///
/// # Errors
/// Those of [`open`], and those of reading.
pub(crate) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(OpenOptions::new().read(true), path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
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
