//! The file by which the folder of an exchange is known. It is locked as long as an exchange writes there.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::Path;

use crate::exchange::ExchangeFolderError;
use crate::io::draft::remove_abandoned;
use crate::io::occupied::run_around;
use crate::io::{OutputError, plain};

const MARK: &str = ".exchange";
const HEADER: &str = "the folder of a replica exchange of carom\n";

/// Whether a folder has it.
pub(super) fn is_there(folder: &Path) -> bool {
    plain::read(&folder.join(MARK), HEADER.len() as u64 + 1).is_ok_and(|bytes| bytes == HEADER.as_bytes())
}

/// Makes the folder, or opens that of an exchange, for this process alone.
pub(super) fn locked(path: &Path) -> Result<File, ExchangeFolderError> {
    if let Some(run) = run_around(path) {
        return Err(OutputError::WithinRun { target: path.to_owned(), run }.into());
    }
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_dir()) {
        return Err(OutputError::NotFolder(path.to_owned()).into());
    }
    let no_folder = |source| OutputError::Folder { path: path.to_owned(), source };
    fs::create_dir_all(path).map_err(no_folder)?;
    remove_abandoned(path);
    let mark = path.join(MARK);
    if !mark.exists() && fs::read_dir(path).map_err(no_folder)?.next().is_some() {
        return Err(ExchangeFolderError::Occupied(path.to_owned()));
    }
    plain::refuse(&mark, false)?;
    let wrong = |source| OutputError::Write { path: mark.clone(), source };
    let mut file = plain::open(OpenOptions::new().read(true).append(true).create(true), &mark).map_err(wrong)?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => return Err(OutputError::Busy(path.to_owned()).into()),
        // Where the system has no locks, nothing keeps two of them apart.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    let mut text = Vec::new();
    file.read_to_end(&mut text).map_err(wrong)?;
    let Some(rest) = HEADER.as_bytes().strip_prefix(text.as_slice()) else {
        return Err(ExchangeFolderError::Occupied(path.to_owned()));
    };
    file.write_all(rest).and_then(|()| file.sync_data()).map_err(wrong)?;
    Ok(file)
}
