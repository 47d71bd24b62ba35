use toml::{Table, Value};

use crate::base::numbers::MOST_EXACT;

/// Parses a value as TOML. A word without quotes becomes a string.
pub(super) fn value_of(text: &str) -> Value {
    let table = format!("v = {text}").parse::<Table>().ok().filter(|table| table.len() == 1);
    table.and_then(|mut table| table.remove("v")).unwrap_or_else(|| Value::String(text.trim().to_owned()))
}

/// Returns the same text for all notations of a value, such as `1`, `+1`, `0x1` and `1.0`, or a quoted and an unquoted
/// word.
pub(super) fn meaning(text: &str) -> String {
    spelled(&value_of(text))
}

/// Writes an integer in decimal digits, so that equal integers get the same folder name.
pub(super) fn plain(text: &str) -> String {
    match value_of(text) {
        Value::Integer(number) => number.to_string(),
        _ => text.to_owned(),
    }
}

pub(super) fn has_key(value: &Value, key: &str) -> bool {
    match value {
        Value::Table(table) => table.contains_key(key) || table.values().any(|value| has_key(value, key)),
        Value::Array(array) => array.iter().any(|value| has_key(value, key)),
        _ => false,
    }
}

fn spelled(value: &Value) -> String {
    match value {
        Value::Float(number) if number.fract() == 0.0 && number.abs() < MOST_EXACT => format!("{:.0}", number + 0.0),
        Value::Float(number) => format!("{number:e}"),
        Value::String(word) => format!("{word:?}"),
        Value::Array(array) => format!("[{}]", array.iter().map(spelled).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let entries = table.iter().map(|(key, value)| format!("{key} = {}", spelled(value)));
            format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_the_same_however_they_are_typed() {
        for (one, other) in [
            ("1", "+1"),
            ("1", "0x1"),
            ("16", "0x1_0"),
            ("100000", "1e5"),
            ("0.5", "5e-1"),
            ("-0.0", "0"),
            ("fcc", "\"fcc\""),
            ("'fcc'", "\"fcc\""),
            ("[1,2.50]", "[1.0, 2.5]"),
            ("{ a = 1, b = 2 }", "{b=2,a=1}"),
        ] {
            assert_eq!(meaning(one), meaning(other));
        }
        for (one, other) in [("1", "2"), ("0.1", "0.100000001"), ("fcc", "FCC"), ("1", "\"1\""), ("[1]", "1")] {
            assert_ne!(meaning(one), meaning(other));
        }
        assert_eq!(["+1", "0x10", "1_000", "0.10", "1e5", "fcc"].map(plain), ["1", "16", "1000", "0.10", "1e5", "fcc"]);
    }
}
