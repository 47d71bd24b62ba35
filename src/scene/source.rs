//! The text of a scene: the file and its overrides, with the position of every value.
//!
//! Overrides are treated as text after the file, so that every value has its own range of bytes.

mod mistakes;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use serde::Deserialize;
use serde_spanned::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use crate::scene::config_path::{ConfigPath, PathStep};
use crate::scene::diagnostic::{SceneError, SceneErrorKind, nearest};
use crate::scene::file::SceneFile;

/// An override `key=value`, which replaces or adds a value in the scene.
struct Override {
    key: String,
    value: String,
    /// Position of the override in the text of the file and all overrides.
    start: usize,
    /// The text `v=value` after spaces, which give the value its position in the whole text.
    padded: String,
}

impl Override {
    fn value_range(&self) -> Range<usize> {
        let start = self.start + self.key.len() + 1;
        start..start + self.value.len()
    }

    /// Parses the value as TOML; a value that is not TOML is a string.
    fn parsed(&self) -> Spanned<DeValue<'_>> {
        if let Ok(document) = DeTable::parse(&self.padded) {
            let mut table = document.into_inner().into_iter();
            // A text that would set further keys is a string.
            if let (Some((_, value)), None) = (table.next(), table.next()) {
                return value;
            }
        }
        Spanned::new(self.value_range(), DeValue::String(Cow::Borrowed(&self.value)))
    }
}

/// Key of the override that starts a scene from a run.
const START: &str = "start.from";

/// Tables and keys of a scene file that are ignored with the override [`START`].
const BEFORE_START: [&str; 7] = ["particle", "file", "chain", "fill", "mesh", "bond", "start_time"];

pub(crate) struct Source {
    name: String,
    text: Arc<String>,
    overrides: Vec<Override>,
}

impl Source {
    pub(crate) fn new(name: &str, text: String, overrides: &[(&str, &str)]) -> Self {
        let mut start = text.len() + 1;
        let overrides = overrides
            .iter()
            .map(|(key, value)| {
                let padding = " ".repeat((start + key.len() + 1).saturating_sub(2));
                let padded = format!("{padding}v={value}");
                let this = Override { key: (*key).to_owned(), value: (*value).to_owned(), start, padded };
                start = this.value_range().end + 1;
                this
            })
            .collect();
        Self { name: name.to_owned(), text: Arc::new(text), overrides }
    }

    pub(crate) fn read(&self) -> Result<SceneFile, SceneError> {
        let tree = self.tree()?;
        if tree.get_ref().is_empty() {
            return Err(self.at(SceneError::new(ConfigPath::root(), SceneErrorKind::Empty), 0..0));
        }
        if let Some(range) = tree.get_ref().values().find_map(too_large) {
            // A larger integer cannot be stored in the record of a run.
            let message = format!("expected a whole number up to {}", i64::MAX);
            return Err(self.at(SceneError::new(ConfigPath::root(), SceneErrorKind::Syntax { message }), range));
        }
        SceneFile::deserialize(Deserializer::from(tree)).map_err(|error| self.mistakes(&error))
    }

    pub(crate) fn located(&self, error: SceneError) -> SceneError {
        if error.has_source() {
            return error;
        }
        // Parsing the text again after an error is cheaper than keeping the tree of every valid scene.
        let range = self.tree().map_or(0..0, |tree| range_of(error.config_path(), &tree));
        self.at(error, range)
    }

    /// Returns the file with the overrides. An override that starts from a run removes the particles.
    pub(crate) fn tree(&self) -> Result<Spanned<DeTable<'_>>, SceneError> {
        let mut document = DeTable::parse(&self.text).map_err(|error| self.refused(&error))?;
        let is_started = self.is_started();
        if is_started {
            BEFORE_START.iter().for_each(|key| drop(document.get_mut().remove(*key)));
        }
        for this in &self.overrides {
            let keys: Vec<&str> = this.key.split('.').map(str::trim).collect();
            let key_range = this.start..this.start + this.key.len();
            let result = match keys.first() {
                Some(first) if is_started && BEFORE_START.contains(first) => {
                    Err("particles, bonds and time come from the run in [start]".to_owned())
                }
                _ => set(document.get_mut(), &keys, this.parsed(), &key_range),
            };
            result.map_err(|problem| {
                let kind = SceneErrorKind::Override { key: this.key.clone(), problem };
                self.at(SceneError::new(ConfigPath::root(), kind), key_range.clone())
            })?;
        }
        Ok(document)
    }

    fn is_started(&self) -> bool {
        self.overrides.iter().any(|this| this.key.split('.').map(str::trim).eq(START.split('.')))
    }

    #[cfg(feature = "cli")]
    pub(crate) fn left_out(&self) -> Vec<&'static str> {
        let Some(document) = DeTable::parse(&self.text).ok().filter(|_| self.is_started()) else { return Vec::new() };
        BEFORE_START.into_iter().filter(|key| document.get_ref().contains_key(*key)).collect()
    }

    /// Splits a key into parts, with an index in place of the name of an entry. Different keys of a value then have
    /// equal parts.
    pub(crate) fn place(&self, key: &str) -> Vec<String> {
        let tree = self.tree().ok();
        let mut parts = key.split('.').map(|part| part.trim().to_owned());
        let Some(first) = parts.next() else { return Vec::new() };
        let mut at = tree.as_ref().and_then(|tree| tree.get_ref().get(first.as_str()));
        let mut place = vec![first];
        for part in parts {
            let value = at.map(Spanned::get_ref);
            let index = value.and_then(DeValue::as_array).and_then(|array| index_of(array, &part));
            at = match (value, index) {
                (Some(DeValue::Table(table)), _) => table.get(part.as_str()),
                (Some(DeValue::Array(array)), Some(index)) => array.get(index),
                _ => None,
            };
            place.push(index.map_or(part, |index| index.to_string()));
        }
        place
    }

    fn refused(&self, error: &toml::de::Error) -> SceneError {
        let range = error.span().unwrap_or(0..0);
        let kind = kind_of(error.message(), self.text.get(range.clone()).unwrap_or_default());
        self.at(SceneError::new(ConfigPath::root(), kind), range)
    }

    /// Adds the file or the override that contains `range` to an error.
    fn at(&self, error: SceneError, range: Range<usize>) -> SceneError {
        match self.overrides.iter().rev().find(|this| range.start >= this.start) {
            Some(this) => {
                let text = format!("{}={}", this.key, this.value);
                let start = (range.start - this.start).min(text.len());
                let end = range.end.saturating_sub(this.start).clamp(start, text.len());
                error.in_source("override", Arc::new(text), start..end)
            }
            None => {
                let end = range.end.min(self.text.len());
                error.in_source(&self.name, Arc::clone(&self.text), range.start.min(end)..end)
            }
        }
    }
}

/// Sets a value at a path. Entries of arrays are selected by index or by `name`.
fn set<'t>(
    table: &mut DeTable<'t>,
    keys: &[&str],
    value: Spanned<DeValue<'t>>,
    key_range: &Range<usize>,
) -> Result<(), String> {
    let Some((&key, rest)) = keys.split_first() else { return Err("the key is empty".to_owned()) };
    if key.is_empty() {
        return Err("a part of the key is empty".to_owned());
    }
    if !table.contains_key(key) {
        let empty = Spanned::new(key_range.clone(), DeValue::Table(DeTable::new()));
        table.insert(Spanned::new(key_range.clone(), Cow::Owned(key.to_owned())), empty);
    }
    let Some(entry) = table.get_mut(key) else { return Err(format!("there is no `{key}`")) };
    set_in(entry, key, rest, value, key_range)
}

fn set_in<'t>(
    entry: &mut Spanned<DeValue<'t>>,
    key: &str,
    rest: &[&str],
    value: Spanned<DeValue<'t>>,
    key_range: &Range<usize>,
) -> Result<(), String> {
    let Some((&next, after)) = rest.split_first() else {
        *entry = value;
        return Ok(());
    };
    match entry.get_mut() {
        DeValue::Table(table) => set(table, rest, value, key_range),
        DeValue::Array(array) => {
            let (index, length) = (index_of(array, next), array.len());
            let Some(element) = index.and_then(|index| array.get_mut(index)) else {
                return Err(format!("`{key}` has {length} entries, none named or numbered `{next}` (from 0)"));
            };
            set_in(element, next, after, value, key_range)
        }
        other => Err(format!("`{key}` is a {}, so there is no `{next}` in it", other.type_str())),
    }
}

fn index_of(array: &[Spanned<DeValue<'_>>], word: &str) -> Option<usize> {
    let named = |element: &Spanned<DeValue<'_>>| {
        let table = element.get_ref().as_table();
        table.and_then(|table| table.get("name")).and_then(|name| name.get_ref().as_str()) == Some(word)
    };
    array.iter().position(named).or_else(|| word.parse().ok())
}

/// Returns the position of the first integer in `value` that does not fit into an `i64`.
fn too_large(value: &Spanned<DeValue<'_>>) -> Option<Range<usize>> {
    match value.get_ref() {
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix()).is_err().then(|| value.span()),
        DeValue::Array(array) => array.iter().find_map(too_large),
        DeValue::Table(table) => table.values().find_map(too_large),
        _ => None,
    }
}

/// Range of bytes of the value at a config path, or of the deepest part of the path that exists.
fn range_of(at: &ConfigPath, tree: &Spanned<DeTable<'_>>) -> Range<usize> {
    let mut found: Option<&Spanned<DeValue<'_>>> = None;
    for (depth, step) in at.steps().iter().enumerate() {
        let next = match (step, found) {
            (PathStep::Key(key), None) if depth == 0 => tree.get_ref().get(key.as_ref()),
            (PathStep::Key(key), Some(value)) => value.get_ref().as_table().and_then(|table| table.get(key.as_ref())),
            (PathStep::Index(index), Some(value)) => value.get_ref().as_array().and_then(|array| array.get(*index)),
            _ => None,
        };
        match next {
            Some(value) => found = Some(value),
            None => break,
        }
    }
    found.map_or(0..0, Spanned::span)
}

/// Converts an error message of TOML or serde. In a message about an unknown key, the first word in backticks is the
/// unknown key, and the other words in backticks are the known keys.
fn kind_of(message: &str, text: &str) -> SceneErrorKind {
    if message.starts_with("unknown field") {
        let mut words = message.split('`').skip(1).step_by(2).map(str::to_owned);
        if let Some(key) = words.next() {
            let known: Vec<String> = words.collect();
            return SceneErrorKind::UnknownKey { nearest: nearest(&key, &known), key, known };
        }
    }
    let mut message = message.trim().to_owned();
    // The text has one table such as `[species]` instead of a list of tables.
    if message.starts_with("invalid type: map, expected a sequence") && text.starts_with('[') {
        let list = format!("`{text}` is one table, expected a list of tables: each begins with `[{text}]`");
        return SceneErrorKind::Syntax { message: list };
    }
    for (rust, words) in [
        ("expected f64", "expected a number"),
        ("expected u64", "expected a whole number, at least 0"),
        ("expected i64", "expected a whole number"),
        ("expected usize", "expected a whole number, at least 0"),
        ("expected u32", "expected a whole number from 0 to 4294967295"),
        ("expected an array of length 3", "expected three numbers, [x, y, z]"),
        ("expected an array of length 2", "expected two values, [a, b]"),
        ("expected a sequence", "expected a list in brackets"),
        ("invalid float, expected nothing", "this is not a number; put text in quotes, such as \"1.0.0\""),
        ("expected a boolean", "expected true or false"),
        ("expected a map", "expected a table"),
        ("missing field", "missing key"),
    ] {
        message = message.replace(rust, words);
    }
    if let Some(start) = message.find("expected struct ") {
        message.replace_range(start.., "expected a table");
    }
    SceneErrorKind::Syntax { message }
}
