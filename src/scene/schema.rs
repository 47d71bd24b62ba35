//! The JSON Schema of the scene file, derived from its Rust types and the tables of words.

use std::collections::BTreeMap;

use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::{Map, Value, json};

use crate::scene::compatibility::EXCLUSIONS;
use crate::scene::file::SceneFile;

/// Returns the JSON Schema (draft 2020-12) of scene files, as JSON text.
///
/// A valid scene satisfies the schema. The reverse is not true, because the schema does not describe relations between
/// parts of a scene; see [`Scene::from_toml`](crate::model::Scene::from_toml). An infinite energy is null, because JSON
/// has no infinity.
///
/// ```
/// assert!(carom::scene::schema().contains("\"seed\""));
/// ```
#[must_use]
pub fn schema() -> String {
    format!("{:#}", schema_value())
}

pub(crate) fn schema_value() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let generator = settings.with_transform(RecursiveTransform(plain)).into_generator();
    let mut schema = generator.into_root_schema_for::<SceneFile>().to_value();
    let mut excluded: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for row in EXCLUSIONS {
        for (feature, other) in [(row.feature, row.with), (row.with, row.feature)] {
            feature.keys.iter().for_each(|key| excluded.entry(key).or_default().push(other.name));
        }
    }
    for (key, others) in excluded {
        add_note(&mut schema, key, &format!(" Cannot be combined with: {}.", others.join(", ")));
    }
    schema
}

/// Adds a note to the description of a key. `key` includes the names of its tables, such as `space.shear_rate`.
fn add_note(schema: &mut Value, key: &str, note: &str) {
    for places in ["items", "anyOf"] {
        match schema.get_mut(places) {
            Some(Value::Array(branches)) => branches.iter_mut().for_each(|branch| add_note(branch, key, note)),
            Some(items) => add_note(items, key, note),
            None => {}
        }
    }
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    match (schema.pointer_mut(&format!("/properties/{first}")), rest) {
        (Some(property), Some(rest)) => add_note(property, rest, note),
        (Some(property), None) => {
            if let Some(Value::String(description)) = property.get_mut("description") {
                description.push_str(note);
            }
        }
        (None, _) => {}
    }
}

pub(crate) fn words<T>(table: &[(&'static str, T)]) -> Vec<&'static str> {
    table.iter().map(|(word, _)| *word).collect()
}

/// Returns a rule of the schema for each kind of a table. The rule forbids the keys of other kinds.
pub(crate) fn keys_by_kind(key: &str, table: &[(&'static str, &[&'static str])]) -> Vec<Value> {
    let rule = |&(word, known): &(&'static str, &[&'static str])| {
        let others = table.iter().flat_map(|(_, keys)| *keys).filter(|other| !known.contains(other));
        let misplaced: Map<String, Value> = others.map(|other| ((*other).to_owned(), Value::Bool(false))).collect();
        let is_it = json!({ "properties": { key: { "const": word } }, "required": [key] });
        json!({ "if": is_it, "then": { "properties": misplaced } })
    };
    table.iter().map(rule).collect()
}

/// Removes Rust details without meaning in TOML: number formats, line breaks of comments, and null for missing keys.
fn plain(schema: &mut Schema) {
    schema.remove("format");
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = text.replace('\n', " ");
    }
    let properties = schema.get_mut("properties").and_then(Value::as_object_mut);
    for property in properties.into_iter().flat_map(Map::values_mut).filter_map(Value::as_object_mut) {
        given(property);
    }
}

/// Removes null from the types and the default of a property, because TOML has no null.
fn given(property: &mut Map<String, Value>) {
    // Lists of tables are empty by default, so the schema omits this default.
    let has_tables = property.get("items").is_some_and(|items| items["type"] == "object");
    if property.get("default").is_some_and(|default| default.is_null() || has_tables) {
        property.remove("default");
    }
    let null = json!({ "type": "null" });
    for (key, nothing) in [("type", &json!("null")), ("enum", &Value::Null), ("anyOf", &null)] {
        if let Some(Value::Array(choices)) = property.get_mut(key) {
            choices.retain(|choice| choice != nothing);
        }
    }
    if let Some(Value::Array(types)) = property.get("type")
        && let [only] = types.as_slice()
    {
        let only = only.clone();
        property.insert("type".to_owned(), only);
    }
    if let Some(Value::Array(choices)) = property.get("anyOf")
        && let [Value::Object(only)] = choices.as_slice()
    {
        let only = only.clone();
        property.remove("anyOf");
        for (key, value) in only {
            property.entry(key).or_insert(value);
        }
    }
}
