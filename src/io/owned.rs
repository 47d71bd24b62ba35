//! List of all files that Carom wrote in the folder of a run. A folder with a list is recognized as the
//! folder of a run. Only listed files are replaced or removed. The list also records the progress of a run
//! that is to replace this run, so that no other folder is mistaken for the replacement.

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

/// The list, in the folder. It is locked while a run writes to the folder.
pub(super) const FILE: &str = ".carom";

/// Its first line.
const HEADER: &str = "carom lists here what it wrote in this folder; nothing else will be replaced or removed\n";

/// Beginning of a line with the progress of a run that is to replace this run.
const REPLACEMENT: &str = "replacement ";

/// Progress of a run that is to replace the run in a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Replacement {
    /// There is none.
    #[default]
    None,
    /// It has been begun.
    Begun,
    /// It is complete, and is taking the place of the old run.
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

/// Names of files in the folder of a run, and of folders with all files of a format, with a trailing `/`.
#[derive(Debug)]
pub(super) struct Owned {
    folder: PathBuf,
    file: File,
    names: BTreeSet<String>,
    replacement: Replacement,
}

/// Whether a folder belongs to a run: by its list, or by a checkpoint if the list is missing.
pub(super) fn is_run(folder: &Path) -> bool {
    let start = plain::read(&folder.join(FILE), HEADER.len() as u64);
    let has_list = start.is_ok_and(|bytes| bytes == HEADER.as_bytes());
    has_list || Checkpoint::is_one(&checkpoints::newest(folder))
}

/// Progress of a run that is to replace the run in a folder, from the list of the old run.
pub(super) fn replacement_of(folder: &Path) -> Replacement {
    read(folder).map(|list| list.replacement).unwrap_or_default()
}

/// The formats of other programs requested for a run's trajectory, or to which it was converted.
pub(super) fn listed_formats(folder: &Path) -> Vec<Format> {
    let names = read(folder).map(|list| list.names).unwrap_or_default();
    Format::ALL.into_iter().filter(|format| names.contains(&format.listed())).collect()
}

/// Whether a list is all that remains of a run killed at its beginning.
pub(super) fn is_begun(list: &Path) -> bool {
    plain::read(list, HEADER.len() as u64 + 1).is_ok_and(|bytes| HEADER.as_bytes().starts_with(&bytes))
}

impl Owned {
    /// Takes possession of a folder, which must be empty or belong to a run, until this is dropped.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if another run writes to it; [`OutputError::NotPlain`] if a link, or anything
    /// other than a plain file, has the name of one of its files; [`OutputError::Foreign`] if the file of its
    /// list is not a list. Nothing is changed then.
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
            // For a run whose list is lost, or a new run.
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

    /// Records the progress of a run that is to replace this run.
    pub fn set_replacement(&mut self, state: Replacement) -> Result<(), OutputError> {
        if self.replacement != state {
            self.append(&format!("{REPLACEMENT}{}\n", state.word()))?;
            self.replacement = state;
        }
        Ok(())
    }

    /// Adds names to the list, before their files are created.
    ///
    /// # Errors
    /// [`OutputError::Foreign`] if something not written by Carom has one of the names.
    pub fn claim(&mut self, names: &[String]) -> Result<(), OutputError> {
        self.allow(names)?;
        self.list(names)
    }

    /// Checks that nothing foreign has one of the names, and that the folders among them contain nothing
    /// foreign.
    ///
    /// # Errors
    /// [`OutputError::Foreign`] otherwise.
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

    /// Removes files that Carom wrote, including unfinished ones, and removes their names from the list.
    pub fn remove(&mut self, names: &[String]) -> Result<(), OutputError> {
        for name in names {
            let path = self.folder.join(name.trim_end_matches('/'));
            if name.ends_with('/') {
                convert::remove_converted(&path)?;
            } else {
                remove(&path)?;
            }
            self.remove_partial(name)?;
            // A folder that is now empty is removed too.
            if let Some(parent) = path.parent().filter(|parent| *parent != self.folder) {
                let _ = fs::remove_dir(parent);
            }
        }
        self.append(&names.iter().map(|name| format!("- {name}\n")).collect::<String>())?;
        self.names.retain(|name| !names.contains(name));
        Ok(())
    }

    /// Removes all files of the run.
    pub fn remove_all(&mut self) -> Result<(), OutputError> {
        let names: Vec<String> = self.names.iter().cloned().collect();
        self.remove(&names)
    }

    /// Removes an unfinished file or folder, if it exists.
    pub fn remove_partial(&self, name: &str) -> Result<(), OutputError> {
        let partial = partial_of(&self.folder.join(name.trim_end_matches('/')));
        if name.ends_with('/') { convert::remove_converted(&partial) } else { remove(&partial) }
    }

    fn append(&mut self, text: &str) -> Result<(), OutputError> {
        let written = self.file.write_all(text.as_bytes()).and_then(|()| durability::sync_data(&self.file));
        written.map_err(OutputError::write(&self.folder.join(FILE)))
    }
}

/// Files that commands add to the folder of a run by default.
const ABOUT: [&str; 3] = [PAGE, SMALL_PAGE, PICTURE];

/// Records that Carom has written a page or an image to the folder of a run, or has converted its trajectory,
/// under the default name. A run that replaces this run then removes the file.
pub(crate) fn note(path: &Path) {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else { return };
    let conversions = Format::ALL.map(Format::listed);
    let is_it = |listed: &&str| listed.trim_end_matches('/') == name;
    let Some(listed) = ABOUT.into_iter().chain(conversions.iter().map(String::as_str)).find(is_it) else { return };
    if read(folder).is_some_and(|list| !list.names.contains(listed)) {
        // Without the record, the file merely outlives the run.
        if let Ok(mut file) = plain::open(OpenOptions::new().append(true), &folder.join(FILE)) {
            let _ = file.write_all(format!("+ {listed}\n").as_bytes());
        }
    }
}

/// Content of a list.
#[derive(Debug, Default)]
struct List {
    /// The names that were added and not removed.
    names: BTreeSet<String>,
    replacement: Replacement,
}

impl List {
    /// The list in a file, and the number of bytes of complete lines; a truncated last line is ignored.
    /// `None` if the file is not a list.
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

/// The list in a folder, if there is one.
fn read(folder: &Path) -> Option<List> {
    let text = plain::read(&folder.join(FILE), u64::MAX).ok()?;
    List::of(&text).map(|(list, _)| list)
}

/// The files that every run writes, for a folder whose list is lost.
fn known_in(folder: &Path) -> Vec<String> {
    let known = [SCENE, PARTICLES, THERMO, TRAJECTORY, CONTACTS, REPORT, SUMMARY, measurements::FILE];
    let known = known.into_iter().chain(checkpoints::NAMES).map(str::to_owned);
    let is_there = |path: PathBuf| fs::symlink_metadata(path).is_ok();
    known.filter(|name| is_there(folder.join(name)) || is_there(partial_of(&folder.join(name)))).collect()
}

/// Whether a name stays inside the folder.
fn is_inside(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    !name.is_empty() && parts.all(|part| matches!(part, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_remembers_what_was_written_and_refuses_what_was_not() {
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
        // A truncated line, as after a power failure.
        OpenOptions::new().append(true).open(folder.path().join(FILE)).unwrap().write_all(b"+ mi").unwrap();
        let owned = Owned::lock(folder.path()).unwrap();
        assert_eq!(owned.names().iter().collect::<Vec<_>>(), ["a"]);
        assert!(!folder.path().join("b.partial").exists() && folder.path().join("mine").exists());
    }

    #[test]
    fn no_list_leads_out_of_its_folder() {
        let text = format!("{HEADER}+ ../x\n+ /etc/x\n+ events/time.npy\n+ \n+ ./y\n");
        assert_eq!(List::of(text.as_bytes()).unwrap().0.names.len(), 1);
    }
}
