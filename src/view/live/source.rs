use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::packed;
use crate::model::Scene;
use crate::scene::{ConfigPath, NamedInput, SceneError, SceneErrorKind, read_text};

/// A scene for a page, with its input files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Source {
    pub(super) text: String,
    pub(super) changes: BTreeMap<String, String>,
    pub(super) files: BTreeMap<PathBuf, Vec<u8>>,
}

impl Source {
    /// Reads the scene in a file, with overrides as in [`Scene::from_file_with`]. Files of an earlier run are not
    /// included.
    ///
    /// # Errors
    /// [`SceneError`] if the text or an input file cannot be read.
    pub fn of_file(path: &Path, overrides: &[(&str, &str)]) -> Result<Self, SceneError> {
        let text = read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut files = BTreeMap::new();
        for (name, kind) in Scene::inputs_named(&text, Path::new(""), overrides)? {
            if kind == NamedInput::File {
                files.insert(name.clone(), read(&folder.join(&name))?);
            }
        }
        let changes = overrides.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        Ok(Self { text, changes, files })
    }

    pub(super) fn files(&self) -> Value {
        let file = |(name, content): (&PathBuf, &Vec<u8>)| json!({ "name": name, "content": packed::letters(content) });
        self.files.iter().map(file).collect()
    }
}

fn read(path: &Path) -> Result<Vec<u8>, SceneError> {
    let unreadable = |source| SceneErrorKind::Unreadable { path: path.to_owned(), source };
    fs::read(path).map_err(|source| SceneError::new(ConfigPath::root(), unreadable(source)))
}
