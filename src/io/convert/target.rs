use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::ConvertError;
use crate::base::durability;
use crate::io::OutputError;
use crate::io::atomic::{Existing, folder_of, publish, sync_folder};
use crate::io::draft::remove_abandoned;
use crate::io::partial::partial_of;
use crate::io::plain;
use crate::model::Format;

/// Output of a conversion under a temporary name. Dropping this value removes incomplete output.
#[derive(Debug)]
pub(super) struct Target {
    path: PathBuf,
    partial: PathBuf,
    format: Format,
    existing: Existing,
}

impl Target {
    /// Checks that the target may be written. Creates the temporary folder if the format needs one.
    pub fn claim(path: &Path, format: Format, source: Option<&Path>, replace: bool) -> Result<Self, ConvertError> {
        let partial = partial_of(path);
        remove_abandoned(folder_of(path));
        // A killed run leaves its trajectory under a temporary name. The target may need the same temporary name.
        if let Some(source) = source.filter(|source| [path, &partial].into_iter().any(|path| is_same(path, source))) {
            return Err(ConvertError::Source(source.to_owned()));
        }
        // A file with the temporary name may be work in progress. Replacing it needs permission.
        for path in [path, &partial] {
            if fs::symlink_metadata(path).is_ok() && !replace {
                return Err(ConvertError::Exists(path.to_owned()));
            }
            refuse_foreign(path, format)?;
        }
        if format.folder_of().is_some() {
            remove(&partial).and_then(|()| fs::create_dir(&partial)).map_err(ConvertError::write(path))?;
        }
        let existing = if replace { Existing::Replace } else { Existing::Keep };
        Ok(Self { path: path.to_owned(), partial, format, existing })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn partial(&self) -> &Path {
        &self.partial
    }

    pub fn complete(self) -> Result<(), ConvertError> {
        if self.format.is_folder() {
            sync_folder(&self.partial);
        }
        match publish(&self.partial, &self.path, self.existing) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(ConvertError::Exists(self.path.clone())),
            result => result.map_err(ConvertError::write(&self.path)),
        }
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        // After success, the temporary name is gone. If the removal fails, a later conversion removes the file.
        let _ = remove(&self.partial);
    }
}

pub(in crate::io) type Draft = BufWriter<File>;

pub(in crate::io) fn draft(path: &Path) -> io::Result<Draft> {
    Ok(BufWriter::with_capacity(1 << 16, plain::create(path)?))
}

pub(in crate::io) fn finish(mut draft: Draft) -> io::Result<()> {
    draft.flush()?;
    durability::sync_all(draft.get_ref())
}

/// Removes converted files from a folder, and the folder if it is then empty.
pub(in crate::io) fn remove_converted(folder: &Path) -> Result<(), OutputError> {
    let endings: Vec<&str> = Format::ALL.into_iter().filter_map(Format::folder_of).flatten().copied().collect();
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|ending| endings.iter().any(|known| ending == *known)) {
            remove(&path).map_err(OutputError::write(&path))?;
        }
    }
    let _ = fs::remove_dir(folder);
    Ok(())
}

fn is_same(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

fn refuse_foreign(path: &Path, format: Format) -> Result<(), ConvertError> {
    let foreign = foreign_in(path, format).map_err(ConvertError::write(path))?;
    if foreign.is_none() { Ok(()) } else { Err(ConvertError::Foreign(path.to_owned())) }
}

/// Returns the path of a file or folder that is not from a conversion to this format.
pub(in crate::io) fn foreign_in(path: &Path, format: Format) -> io::Result<Option<PathBuf>> {
    let Ok(metadata) = fs::symlink_metadata(path) else { return Ok(None) };
    let Some(endings) = format.folder_of() else {
        return Ok((!metadata.is_file()).then(|| path.to_owned()));
    };
    if !metadata.is_dir() {
        return Ok(Some(path.to_owned()));
    }
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        let is_known = entry.path().extension().is_some_and(|ending| endings.iter().any(|known| ending == *known));
        if !(is_known && entry.file_type()?.is_file()) {
            return Ok(Some(entry.path()));
        }
    }
    Ok(None)
}

fn remove(path: &Path) -> io::Result<()> {
    let removed = match fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(error) => Err(error),
    };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
