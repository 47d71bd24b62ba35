//! A small JSON Schema validator for the keywords in the schema of scene files. It panics for other keywords.

use serde_json::Value;

pub fn schema() -> Value {
    serde_json::from_str(&carom::scene::schema()).unwrap()
}

pub fn mistakes(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, value, "scene", &mut found);
    found
}

fn is_valid(schema: &Value, value: &Value) -> bool {
    mistakes(schema, value).is_empty()
}

fn check(schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let rules = match schema {
        Value::Bool(true) => return,
        Value::Bool(false) => return found.push(format!("{place} has no place here")),
        Value::Object(rules) => rules,
        other => panic!("{other} is no schema"),
    };
    for (keyword, rule) in rules {
        if !holds(rules, keyword, rule, value, place, found) {
            found.push(format!("{place} is {value}, not of {keyword} {rule}"));
        }
    }
}

/// Returns whether a value obeys a rule. Adds errors of nested rules to `found`.
fn holds(
    rules: &serde_json::Map<String, Value>,
    keyword: &str,
    rule: &Value,
    value: &Value,
    place: &str,
    found: &mut Vec<String>,
) -> bool {
    let number =
        |is_good: fn(f64, f64) -> bool| value.as_f64().is_none_or(|value| is_good(value, rule.as_f64().unwrap()));
    let length = |is_good: fn(u64, u64) -> bool| {
        let length = match value {
            Value::Array(items) if keyword.ends_with("Items") => items.len(),
            Value::String(text) if keyword.ends_with("Length") => text.chars().count(),
            _ => return true,
        };
        is_good(length as u64, rule.as_u64().unwrap())
    };
    match keyword {
        "$id" | "$schema" | "title" | "description" | "default" | "then" => true,
        "type" => match rule {
            Value::Array(types) => types.iter().any(|one| is_of(one.as_str().unwrap(), value)),
            one => is_of(one.as_str().unwrap(), value),
        },
        "enum" => rule.as_array().unwrap().contains(value),
        "const" => rule == value,
        "minimum" => number(|value, limit| value >= limit),
        "maximum" => number(|value, limit| value <= limit),
        "exclusiveMinimum" => number(|value, limit| value > limit),
        "exclusiveMaximum" => number(|value, limit| value < limit),
        "minItems" | "minLength" => length(|length, limit| length >= limit),
        "maxItems" | "maxLength" => length(|length, limit| length <= limit),
        "pattern" => value.as_str().is_none_or(|text| fits(rule.as_str().unwrap(), text)),
        "anyOf" => rule.as_array().unwrap().iter().any(|one| is_valid(one, value)),
        "allOf" => {
            rule.as_array().unwrap().iter().for_each(|one| check(one, value, place, found));
            true
        }
        "if" => {
            if is_valid(rule, value) {
                check(&rules["then"], value, place, found);
            }
            true
        }
        "items" => {
            for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                check(rule, item, &format!("{place}.{index}"), found);
            }
            true
        }
        "properties" | "additionalProperties" => {
            for (key, item) in value.as_object().into_iter().flatten() {
                let known = rules.get("properties").and_then(|properties| properties.get(key));
                match (keyword, known) {
                    ("properties", Some(property)) => check(property, item, &format!("{place}.{key}"), found),
                    ("additionalProperties", None) => check(rule, item, &format!("{place}.{key}"), found),
                    _ => {}
                }
            }
            true
        }
        "minProperties" => value.as_object().is_none_or(|table| table.len() as u64 >= rule.as_u64().unwrap()),
        "required" => value
            .as_object()
            .is_none_or(|table| rule.as_array().unwrap().iter().all(|key| table.contains_key(key.as_str().unwrap()))),
        other => panic!("{other} is unknown to this validator"),
    }
}

fn is_of(name: &str, value: &Value) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "null" => value.is_null(),
        other => panic!("{other} is no type"),
    }
}

/// Returns whether a text matches a pattern of the schema.
fn fits(pattern: &str, text: &str) -> bool {
    // Characters beyond ASCII are treated as letters.
    let letters = |c: char| c.is_ascii_alphanumeric() || !c.is_ascii();
    let marks = |c: char| letters(c) || "_.+()-".contains(c);
    let ascii = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    let count = text.chars().count();
    match pattern {
        r"^[^\x00-/:-@\[-`{-\x7f][^\x00-'*,/:-@\[-\^`{-\x7f]{0,63}$" => {
            text.starts_with(letters) && text.chars().all(marks) && count <= 64
        }
        r"^[^\x00-/:-@\[-`{-\x7f]([^\x00-\x1f!-'*,/:-@\[-\^`{-\x7f]{0,98}[^\x00-'*,/:-@\[-\^`{-\x7f])?$" => {
            let is_inner = text.chars().all(|c| marks(c) || c == ' ');
            text.starts_with(letters) && is_inner && !text.ends_with(' ') && count <= 100
        }
        "^[A-Za-z0-9_-]{1,100}$" => text.chars().all(ascii) && (1..=100).contains(&count),
        r"^[^\x00-@\[-`{-\x7f]{1,16}$" => {
            text.chars().all(|c| c.is_ascii_alphabetic() || !c.is_ascii()) && (1..=16).contains(&count)
        }
        "^[A-Za-z0-9_-]{1,50}$" => text.chars().all(ascii) && (1..=50).contains(&count),
        "^crc32:[0-9a-f]{8}$" => {
            let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
            text.strip_prefix("crc32:").is_some_and(|digits| digits.len() == 8 && digits.chars().all(is_digit))
        }
        other => panic!("{other} is a pattern unknown to this validator"),
    }
}
