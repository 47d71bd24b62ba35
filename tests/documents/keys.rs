//! Compares the tables of `docs/scene.md` with the JSON Schema of scene files.

use std::collections::BTreeMap;

use carom::scene::EXCLUSIONS;
use serde_json::{Map, Value};

use crate::markdown::{Page, cells, heading};
use crate::validator::schema;

#[derive(Debug, PartialEq)]
struct Key {
    kind: String,
    unit: String,
    default: String,
}

const HEAD: [&str; 5] = ["key", "type", "unit", "default", "meaning"];

/// Returns the table names in a heading, which are formatted as code. A heading without code describes the top level. A
/// name such as `*.restitution` stands for the tables of this name everywhere, here `all`.
fn tables(heading: &str, all: &[String]) -> Vec<String> {
    let names = heading.split('`').skip(1).step_by(2).map(|name| name.trim_matches(['[', ']']).to_owned());
    let names: Vec<String> = names
        .flat_map(|name| match name.strip_prefix('*') {
            Some(end) => all.iter().filter(|path| path.ends_with(end)).cloned().collect(),
            None => vec![name],
        })
        .collect();
    if names.is_empty() { vec![String::new()] } else { names }
}

/// Returns the documented keys by path, each with its description and its line number.
fn documented() -> BTreeMap<String, (Key, String, usize)> {
    let page = Page::of("docs/scene.md");
    let mut of_schema = BTreeMap::new();
    expected(&schema(), "", &mut of_schema);
    let all: Vec<String> = of_schema.into_keys().collect();
    let mut keys = BTreeMap::new();
    let (mut places, mut is_of_keys) = (Vec::new(), false);
    for (line, text) in page.prose() {
        if let Some(heading) = heading(text) {
            places = tables(heading, &all);
        }
        let Some(row) = cells(text) else {
            is_of_keys &= text.starts_with('|');
            continue;
        };
        if row == HEAD {
            is_of_keys = true;
            continue;
        }
        if !is_of_keys {
            continue;
        }
        let [key, kind, unit, default, meaning] = row.as_slice() else {
            panic!("line {line} has no five cells: {text}")
        };
        let key = key.trim_matches('`');
        for place in &places {
            let path = if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") };
            let said = Key { kind: (*kind).to_owned(), unit: (*unit).to_owned(), default: (*default).to_owned() };
            let earlier = keys.insert(path.clone(), (said, (*meaning).to_owned(), line));
            assert!(earlier.is_none(), "line {line}: {path} is documented twice");
        }
    }
    keys
}

/// Adds the keys of a schema by path, each with its schema, and with true if the key is required.
fn expected(schema: &Value, path: &str, keys: &mut BTreeMap<String, (Value, bool)>) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten().filter(|(_, rules)| rules.is_object())
    {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let is_required = schema["required"].as_array().is_some_and(|required| required.iter().any(|name| name == key));
        expected(property, &path, keys);
        expected(&property["items"], &path, keys);
        keys.insert(path, (property.clone(), is_required));
    }
    for branch in schema["anyOf"].as_array().into_iter().flatten() {
        expected(branch, path, keys);
    }
}

/// Returns the limits of a number in the notation of the documents, such as `> 0, <= 1`.
fn range(rules: &Map<String, Value>) -> String {
    let limits = [("exclusiveMinimum", ">"), ("minimum", ">="), ("exclusiveMaximum", "<"), ("maximum", "<=")];
    let limits = limits.iter().filter_map(|(key, sign)| {
        let limit = rules.get(*key)?.as_f64()?;
        Some(if limit >= 1e12 { format!("{sign} {limit:e}") } else { format!("{sign} {limit}") })
    });
    limits.collect::<Vec<_>>().join(", ")
}

fn kind(schema: &Value) -> String {
    let rules = schema.as_object().unwrap();
    if let Some(choices) = rules.get("anyOf").and_then(Value::as_array) {
        return choices.iter().map(kind).collect::<Vec<_>>().join(" or ");
    }
    if rules.contains_key("enum") {
        return "word".to_owned();
    }
    let name = match &rules["type"] {
        Value::Array(names) => names.iter().find(|name| *name != "null").unwrap(),
        name => name,
    };
    match name.as_str().unwrap() {
        "object" => "table".to_owned(),
        "array" if rules["items"]["properties"].is_object() => "tables".to_owned(),
        "array" => {
            let one = kind(&rules["items"]);
            let (word, range) =
                one.split_once(' ').map_or((one.as_str(), String::new()), |(word, rest)| (word, format!(" {rest}")));
            let number = rules.get("minItems").filter(|least| Some(*least) == rules.get("maxItems"));
            match (word, number) {
                ("number" | "integer" | "string" | "word", Some(number)) => format!("{number} {word}s{range}"),
                ("number" | "integer" | "string" | "word", None) => format!("list of {word}s{range}"),
                _ => format!("list of lists of {one}"),
            }
        }
        name @ ("number" | "integer") => format!("{name} {}", range(rules)).trim_end().to_owned(),
        name => name.to_owned(),
    }
}

/// Returns the unit in brackets in the description of a key.
fn unit(schema: &Value) -> String {
    let description = schema["description"].as_str().unwrap_or_default();
    description.split("`[").nth(1).and_then(|rest| rest.split("]`").next()).unwrap_or_default().to_owned()
}

/// Returns the allowed words of a value, or of each item of a list.
fn words(schema: &Value) -> Vec<&str> {
    let branches = schema["anyOf"].as_array().into_iter().flatten().flat_map(words);
    let own = schema["enum"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let items = schema.get("items").map(words).unwrap_or_default();
    branches.chain(own).chain(items).collect()
}

fn is_default(cell: &str, value: &Value) -> bool {
    let Some(text) = cell.strip_prefix('`').and_then(|cell| cell.strip_suffix('`')) else { return false };
    let Ok(table) = format!("value = {text}").parse::<toml::Table>() else { return false };
    same(&serde_json::to_value(&table["value"]).unwrap(), value)
}

/// Numbers such as 1 and 1.0 are equal.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (a, b) => a == b,
    }
}

#[test]
fn every_key_of_the_schema_is_documented_and_no_other() {
    let mut keys = BTreeMap::new();
    expected(&schema(), "", &mut keys);
    let documented = documented();
    assert!(keys.len() > 150, "{} keys", keys.len());
    let missing: Vec<&String> = keys.keys().filter(|key| !documented.contains_key(*key)).collect();
    assert!(missing.is_empty(), "docs/scene.md lacks {missing:?}");
    let unknown: Vec<&String> = documented.keys().filter(|key| !keys.contains_key(*key)).collect();
    assert!(unknown.is_empty(), "the schema lacks {unknown:?}");
}

#[test]
fn types_units_and_defaults_are_those_of_the_schema() {
    let mut keys = BTreeMap::new();
    expected(&schema(), "", &mut keys);
    let mut wrong = Vec::new();
    for (path, (said, _, line)) in documented() {
        let Some((rules, is_required)) = keys.get(&path) else { continue };
        let default = &rules["default"];
        let is_right = match (is_required, default.is_null()) {
            (true, _) => said.default == "required",
            (false, true) => !said.default.is_empty() && said.default != "required",
            (false, false) => is_default(&said.default, default),
        };
        if !is_right {
            wrong.push(format!("line {line}: the default of {path} is {default}, required: {is_required}"));
        }
        for (what, said, right) in [("type", &said.kind, kind(rules)), ("unit", &said.unit, unit(rules))] {
            if *said != right {
                wrong.push(format!("line {line}: the {what} of {path} is `{right}`, not `{said}`"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_word_of_the_schema_is_documented() {
    let mut keys = BTreeMap::new();
    expected(&schema(), "", &mut keys);
    let mut count = 0;
    for (path, (_, meaning, line)) in documented() {
        // The words for `space.y` and `space.z` are documented at `space.x`.
        let Some((rules, _)) = keys.get(&path).filter(|_| !["space.y", "space.z"].contains(&path.as_str())) else {
            continue;
        };
        for word in words(rules) {
            assert!(meaning.contains(&format!("`\"{word}\"`")), "line {line}: {path} can be {word}");
            count += 1;
        }
    }
    assert!(count > 50, "{count} words");
}

#[test]
fn the_table_of_exclusions_is_that_of_the_program() {
    let page = Page::of("docs/scene.md");
    let section = page.text.split("\n## ").find(|section| section.starts_with("Features that exclude each other\n"));
    let said: Vec<&str> = section.unwrap().lines().filter(|line| line.starts_with('|')).skip(2).collect();
    let row = |feature: &str, with: &str, expected: String| format!("| {feature} | {with} | {expected} |");
    let rows = EXCLUSIONS.iter().map(|it| row(it.feature.name, it.with.name, it.expected().replace('`', "")));
    let right: Vec<String> = rows.collect();
    assert!(said == right, "the table must be:\n{}", right.join("\n"));
}

#[test]
fn the_schema_describes_exclusions() {
    let mut keys = BTreeMap::new();
    expected(&schema(), "", &mut keys);
    for row in EXCLUSIONS {
        for (feature, other) in [(row.feature, row.with), (row.with, row.feature)] {
            for key in feature.keys {
                let (rules, _) = keys.get(*key).unwrap_or_else(|| panic!("the schema has no {key}"));
                let description = rules["description"].as_str().unwrap();
                let (_, others) = description.split_once(" Cannot be combined with: ").unwrap();
                assert!(others.contains(other.name), "{key}: {description}");
            }
        }
    }
}
