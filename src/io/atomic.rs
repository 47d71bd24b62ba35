//! Atomic writes. Files and folders get their final names when they are complete.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::draft::UnnamedFile;
use super::error::OutputError;
use crate::base::durability;

/// Whether an output may replace an existing file or folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// Keeps the existing file or folder and rejects the output.
    #[default]
    Keep,
    /// Replaces the existing file or folder when the new one is complete.
    Replace,
}

/// Writes a file under a temporary name, syncs it to disk and renames it. A file with equal content may always be
/// replaced. Devices and pipes are written directly. After an error, an existing file is unchanged.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] if a different file exists and must be kept; system errors.
pub(crate) fn write_atomically(
    path: &Path,
    existing: Existing,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let metadata = fs::metadata(path).ok();
    if metadata.as_ref().is_some_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        let mut device = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        write(&mut device)?;
        return device.flush();
    }
    if metadata.is_some_and(|metadata| metadata.is_dir()) {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let (draft, file) = UnnamedFile::beside(path)?;
    let mut file = BufWriter::new(file);
    write(&mut file)?;
    file.flush()?;
    durability::sync_all(file.get_ref())?;
    drop(file);
    draft.publish(existing)
}

pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    write_atomically(path, Existing::Replace, |file| file.write_all(text.as_bytes())).map_err(OutputError::write(path))
}

pub(super) fn holds_same(one: &Path, other: &Path) -> io::Result<bool> {
    Ok(fs::metadata(one)?.len() == fs::metadata(other)?.len() && fs::read(one)? == fs::read(other)?)
}

/// Renames a complete file or folder to its final name, in one step. After an error, nothing is changed.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] if the name is taken and `existing` is [`Existing::Keep`]; system errors.
pub(crate) fn publish(from: &Path, to: &Path, existing: Existing) -> io::Result<()> {
    match existing {
        Existing::Keep => publish_new(from, to)?,
        Existing::Replace if fs::symlink_metadata(to).is_ok_and(|metadata| metadata.is_dir()) => exchange(from, to)?,
        Existing::Replace => fs::rename(from, to)?,
    }
    sync_folder(folder_of(to));
    Ok(())
}

fn publish_new(from: &Path, to: &Path) -> io::Result<()> {
    match rename_with(from, to, NO_REPLACE) {
        Err(error) if error.kind() == io::ErrorKind::Unsupported => {}
        result => return result,
    }
    // A hard link fails if the name exists. Hard links are impossible for folders and on some file systems.
    match fs::hard_link(from, to) {
        Ok(()) => return fs::remove_file(from),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => return Err(error),
        Err(_) => {}
    }
    if fs::symlink_metadata(to).is_ok() {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    fs::rename(from, to)
}

fn exchange(from: &Path, to: &Path) -> io::Result<()> {
    match rename_with(from, to, EXCHANGE) {
        // The old folder now has the temporary name. Remains of an incomplete deletion do no harm.
        Ok(()) => {
            sync_folder(folder_of(to));
            let _ = fs::remove_dir_all(from);
            return Ok(());
        }
        Err(error) if error.kind() != io::ErrorKind::Unsupported => return Err(error),
        Err(_) => {}
    }
    let mut aside = to.as_os_str().to_owned();
    aside.push(".replaced");
    let aside = PathBuf::from(aside);
    publish_new(to, &aside)?;
    if let Err(error) = fs::rename(from, to) {
        let _ = fs::rename(&aside, to);
        return Err(error);
    }
    sync_folder(folder_of(to));
    let _ = fs::remove_dir_all(&aside);
    Ok(())
}

/// Syncs the names in a folder to disk. Some systems cannot open a folder for this.
pub(crate) fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = durability::sync_all(&folder);
    }
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
use libc::{RENAME_EXCHANGE as EXCHANGE, RENAME_NOREPLACE as NO_REPLACE};

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
const NO_REPLACE: u32 = 1;
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
const EXCHANGE: u32 = 2;

/// Renames without replacing anything, or exchanges two names. Systems without this feature return `Unsupported`.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn rename_with(from: &Path, to: &Path, flags: u32) -> io::Result<()> {
    use std::ffi::CString;
    use std::os::unix::ffi::OsStrExt;

    let (from, to) = (CString::new(from.as_os_str().as_bytes())?, CString::new(to.as_os_str().as_bytes())?);
    // SAFETY: both pointers refer to null-terminated strings that outlive the call.
    let result = unsafe { libc::renameat2(libc::AT_FDCWD, from.as_ptr(), libc::AT_FDCWD, to.as_ptr(), flags) };
    if result == 0 {
        return Ok(());
    }
    let error = io::Error::last_os_error();
    match error.raw_os_error() {
        Some(libc::EINVAL | libc::ENOSYS | libc::EOPNOTSUPP) => Err(io::ErrorKind::Unsupported.into()),
        _ => Err(error),
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn rename_with(_from: &Path, _to: &Path, _flags: u32) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hello(path: &Path, existing: Existing, text: &str) -> io::Result<()> {
        write_atomically(path, existing, |file| file.write_all(text.as_bytes()))
    }

    #[test]
    fn file_is_replaced_completely_and_only_on_request() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        hello(&path, Existing::Keep, "one").unwrap();
        hello(&path, Existing::Keep, "one").unwrap();
        assert_eq!(hello(&path, Existing::Keep, "two").unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        let half = |file: &mut dyn Write| file.write_all(b"ha").and(Err(io::ErrorKind::StorageFull.into()));
        assert!(write_atomically(&path, Existing::Replace, half).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        hello(&path, Existing::Replace, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn folder_replacement_is_all_or_nothing() {
        let place = tempfile::tempdir().unwrap();
        let [from, to] = ["new", "old"].map(|name| place.path().join(name));
        for folder in [&from, &to] {
            fs::create_dir(folder).unwrap();
            fs::write(folder.join("which"), folder.file_name().unwrap().as_encoded_bytes()).unwrap();
        }
        assert!(publish(&from, &to, Existing::Keep).is_err());
        assert!(publish(&place.path().join("none"), &to, Existing::Replace).is_err());
        assert_eq!(fs::read(to.join("which")).unwrap(), b"old");
        publish(&from, &to, Existing::Replace).unwrap();
        assert_eq!(fs::read(to.join("which")).unwrap(), b"new");
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn link_target_is_replaced_and_devices_are_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["a.txt", "link"].map(|name| folder.path().join(name));
        hello(&path, Existing::Keep, "one").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        assert!(hello(&link, Existing::Keep, "two").is_err());
        hello(&link, Existing::Replace, "two").unwrap();
        assert!(link.is_symlink() && fs::read_to_string(&path).unwrap() == "two");
        hello(Path::new("/dev/null"), Existing::Keep, "anything").unwrap();
    }
}
