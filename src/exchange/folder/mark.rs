//! The file that marks the folder of an exchange. It is locked while an exchange writes to the folder.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use crate::exchange::ExchangeFolderError;
use crate::io::{OutputError, plain};

const MARK: &str = ".exchange";
const HEADER: &str = "the folder of a replica exchange of carom\n";

pub(super) fn is_there(folder: &Path) -> bool {
    plain::read(&folder.join(MARK), HEADER.len() as u64 + 1).is_ok_and(|bytes| bytes == HEADER.as_bytes())
}

pub(super) fn locked(path: &Path) -> Result<File, ExchangeFolderError> {
    plain::make_folder(path)?;
    let no_folder = |source| OutputError::Folder { path: path.to_owned(), source };
    if !path.join(MARK).exists() && fs::read_dir(path).map_err(no_folder)?.next().is_some() {
        return Err(ExchangeFolderError::Occupied(path.to_owned()));
    }
    let (mut file, text) = plain::lock(path, MARK)?;
    let Some(rest) = HEADER.as_bytes().strip_prefix(text.as_slice()) else {
        return Err(ExchangeFolderError::Occupied(path.to_owned()));
    };
    file.write_all(rest).and_then(|()| file.sync_data()).map_err(OutputError::write(&path.join(MARK)))?;
    Ok(file)
}
