//! The list of files that Carom wrote in a run folder. Carom replaces or removes only listed files.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Component, Path, PathBuf};

use super::convert;
use super::error::OutputError;
use super::folder::{
    CONTACTS, PAGE, PARTICLES, PICTURE, REPORT, SCENE, SMALL_PAGE, SUMMARY, THERMO, TRAJECTORY, remove,
};
use super::partial::partial_of;
use super::{checkpoints, measurements, plain, replacement};
use crate::base::durability;
use crate::model::Format;
use crate::run::checkpoint::Checkpoint;

/// Name of the list. A run locks this file while it writes to the folder.
pub(super) const FILE: &str = ".carom";

const HEADER: &str = "carom lists here what it wrote in this folder; nothing else will be replaced or removed\n";

/// Prefix of lines that record the progress of a replacement.
const REPLACEMENT: &str = "replacement ";

/// Progress in replacing an old run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Replacement {
    #[default]
    None,
    Begun,
    /// The new run is complete. Its files are being moved to the folder of the old run.
    Complete,
}

impl Replacement {
    const WORDS: [(Self, &'static str); 3] =
        [(Self::None, "over"), (Self::Begun, "begun"), (Self::Complete, "complete")];

    fn from_word(word: &str) -> Option<Self> {
        Self::WORDS.into_iter().find(|(_, known)| *known == word).map(|(state, _)| state)
    }

    fn word(self) -> &'static str {
        Self::WORDS.into_iter().find(|(state, _)| *state == self).map_or("", |(_, word)| word)
    }
}

/// List of Carom's files in a run folder. A name that ends with `/` is a folder with files of one format.
#[derive(Debug)]
pub(super) struct Owned {
    folder: PathBuf,
    file: File,
    names: BTreeSet<String>,
    replacement: Replacement,
}

/// Whether a folder contains a list of files or a checkpoint.
pub(super) fn is_run(folder: &Path) -> bool {
    let start = plain::read(&folder.join(FILE), HEADER.len() as u64);
    let has_list = start.is_ok_and(|bytes| bytes == HEADER.as_bytes());
    has_list || Checkpoint::is_one(&checkpoints::newest(folder))
}

pub(super) fn replacement_of(folder: &Path) -> Replacement {
    read(folder).map(|list| list.replacement).unwrap_or_default()
}

pub(super) fn listed_formats(folder: &Path) -> Vec<Format> {
    let names = read(folder).map(|list| list.names).unwrap_or_default();
    Format::ALL.into_iter().filter(|format| names.contains(&format.listed())).collect()
}

/// Whether a list contains only its first line or a part of this line. A run that is killed early leaves such a list.
pub(super) fn is_begun(list: &Path) -> bool {
    plain::read(list, HEADER.len() as u64 + 1).is_ok_and(|bytes| HEADER.as_bytes().starts_with(&bytes))
}

impl Owned {
    /// Locks an empty folder or a run folder until the list is dropped.
    pub fn lock(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(FILE);
        let is_run = is_run(folder);
        let (file, text) = plain::lock(folder, FILE)?;
        let found = List::of(&text);
        if found.is_none() && !HEADER.as_bytes().starts_with(&text) {
            return Err(OutputError::Foreign(path));
        }
        let lost: Vec<String> = if found.is_none() && is_run { known_in(folder) } else { Vec::new() };
        let (List { names, replacement }, whole) = found.unwrap_or_default();
        names.iter().chain(&lost).try_for_each(|name| plain::refuse_others(folder, name))?;
        if replacement != Replacement::None {
            plain::refuse(&replacement::within(folder), true)?;
        }
        let mut owned = Self { folder: folder.to_owned(), file, names, replacement };
        if whole < text.len() {
            owned.file.set_len(whole as u64).map_err(OutputError::write(&path))?;
        }
        if whole == 0 {
            // The run is new, or its list was lost.
            owned.append(HEADER)?;
            owned.list(&lost)?;
        }
        Ok(owned)
    }

    pub fn names(&self) -> &BTreeSet<String> {
        &self.names
    }

    pub fn replacement(&self) -> Replacement {
        self.replacement
    }

    pub fn set_replacement(&mut self, state: Replacement) -> Result<(), OutputError> {
        if self.replacement != state {
            self.append(&format!("{REPLACEMENT}{}\n", state.word()))?;
            self.replacement = state;
        }
        Ok(())
    }

    /// Adds names of files to the list, before the files are created. Fails if a foreign file has one of the names.
    pub fn claim(&mut self, names: &[String]) -> Result<(), OutputError> {
        self.allow(names)?;
        self.list(names)
    }

    /// Checks that files with these names may be written. Fails if Carom did not write an existing file or folder.
    pub fn allow(&self, names: &[String]) -> Result<(), OutputError> {
        for name in names {
            plain::refuse_links_to(&self.folder, name)?;
            let path = self.folder.join(name.trim_end_matches('/'));
            for path in [partial_of(&path), path] {
                let foreign = match Format::filling(name) {
                    _ if !self.names.contains(name) => fs::symlink_metadata(&path).is_ok().then_some(path),
                    Some(format) => convert::foreign_in(&path, format).map_err(OutputError::write(&path))?,
                    None => None,
                };
                if let Some(foreign) = foreign {
                    return Err(OutputError::Foreign(foreign));
                }
            }
        }
        Ok(())
    }

    fn list(&mut self, names: &[String]) -> Result<(), OutputError> {
        let new: Vec<&String> = names.iter().filter(|name| !self.names.contains(*name)).collect();
        if !new.is_empty() {
            self.append(&new.iter().map(|name| format!("+ {name}\n")).collect::<String>())?;
            self.names.extend(new.into_iter().cloned());
        }
        Ok(())
    }

    /// Removes complete and incomplete files, and their names in the list.
    pub fn remove(&mut self, names: &[String]) -> Result<(), OutputError> {
        for name in names {
            let path = self.folder.join(name.trim_end_matches('/'));
            if name.ends_with('/') {
                convert::remove_converted(&path)?;
            } else {
                remove(&path)?;
            }
            self.remove_partial(name)?;
            // `remove_dir` fails unless the folder is empty.
            if let Some(parent) = path.parent().filter(|parent| *parent != self.folder) {
                let _ = fs::remove_dir(parent);
            }
        }
        self.append(&names.iter().map(|name| format!("- {name}\n")).collect::<String>())?;
        self.names.retain(|name| !names.contains(name));
        Ok(())
    }

    pub fn remove_all(&mut self) -> Result<(), OutputError> {
        let names: Vec<String> = self.names.iter().cloned().collect();
        self.remove(&names)
    }

    pub fn remove_partial(&self, name: &str) -> Result<(), OutputError> {
        let partial = partial_of(&self.folder.join(name.trim_end_matches('/')));
        if name.ends_with('/') { convert::remove_converted(&partial) } else { remove(&partial) }
    }

    fn append(&mut self, text: &str) -> Result<(), OutputError> {
        let written = self.file.write_all(text.as_bytes()).and_then(|()| durability::sync_data(&self.file));
        written.map_err(OutputError::write(&self.folder.join(FILE)))
    }
}

/// Pages and pictures that commands add to a run folder.
const ABOUT: [&str; 3] = [PAGE, SMALL_PAGE, PICTURE];

/// Adds a page, a picture or a converted trajectory with the default name to the list of its run.
pub(crate) fn note(path: &Path) {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else { return };
    let conversions = Format::ALL.map(Format::listed);
    let is_it = |listed: &&str| listed.trim_end_matches('/') == name;
    let Some(listed) = ABOUT.into_iter().chain(conversions.iter().map(String::as_str)).find(is_it) else { return };
    if read(folder).is_some_and(|list| !list.names.contains(listed)) {
        // Errors are ignored. A replacement of the run keeps unlisted files.
        if let Ok(mut file) = plain::open(OpenOptions::new().append(true), &folder.join(FILE)) {
            let _ = file.write_all(format!("+ {listed}\n").as_bytes());
        }
    }
}

#[derive(Debug, Default)]
struct List {
    names: BTreeSet<String>,
    replacement: Replacement,
}

impl List {
    /// Returns a list and the length of its complete lines `[bytes]`. An incomplete last line is ignored.
    fn of(text: &[u8]) -> Option<(Self, usize)> {
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let lines = text[..whole].strip_prefix(HEADER.as_bytes())?;
        let mut list = Self::default();
        for line in String::from_utf8_lossy(lines).lines() {
            if let Some(name) = line.strip_prefix("+ ").filter(|name| is_inside(name)) {
                list.names.insert(name.to_owned());
            } else if let Some(name) = line.strip_prefix("- ") {
                list.names.remove(name);
            } else if let Some(state) = line.strip_prefix(REPLACEMENT).and_then(Replacement::from_word) {
                list.replacement = state;
            }
        }
        Some((list, whole))
    }
}

fn read(folder: &Path) -> Option<List> {
    let text = plain::read(&folder.join(FILE), u64::MAX).ok()?;
    List::of(&text).map(|(list, _)| list)
}

/// Returns the names of the standard files that exist in a run folder, to restore a lost list.
fn known_in(folder: &Path) -> Vec<String> {
    let known = [SCENE, PARTICLES, THERMO, TRAJECTORY, CONTACTS, REPORT, SUMMARY, measurements::FILE];
    let known = known.into_iter().chain(checkpoints::NAMES).map(str::to_owned);
    let is_there = |path: PathBuf| fs::symlink_metadata(path).is_ok();
    known.filter(|name| is_there(folder.join(name)) || is_there(partial_of(&folder.join(name)))).collect()
}

fn is_inside(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    !name.is_empty() && parts.all(|part| matches!(part, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn owned_list_accepts_its_own_files_and_rejects_others() {
        let folder = tempfile::tempdir().unwrap();
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let mut owned = Owned::lock(folder.path()).unwrap();
        assert!(matches!(Owned::lock(folder.path()), Err(OutputError::Busy(_))));
        owned.claim(&names(&["a", "b"])).unwrap();
        fs::write(folder.path().join("b.partial"), "half").unwrap();
        fs::write(folder.path().join("mine"), "years").unwrap();
        assert!(matches!(owned.claim(&names(&["c", "mine"])), Err(OutputError::Foreign(_))));
        owned.remove(&names(&["b"])).unwrap();
        drop(owned);
        // A power failure can truncate the last line of the list.
        OpenOptions::new().append(true).open(folder.path().join(FILE)).unwrap().write_all(b"+ mi").unwrap();
        let owned = Owned::lock(folder.path()).unwrap();
        assert_eq!(owned.names().iter().collect::<Vec<_>>(), ["a"]);
        assert!(!folder.path().join("b.partial").exists() && folder.path().join("mine").exists());
    }

    #[test]
    fn owned_list_ignores_paths_outside_its_folder() {
        let text = format!("{HEADER}+ ../x\n+ /etc/x\n+ events/time.npy\n+ \n+ ./y\n");
        assert_eq!(List::of(text.as_bytes()).unwrap().0.names.len(), 1);
    }
}
