//! Names of keys in tables, and of the folders of points.

use std::fmt::Write;

use toml::Value;

use super::value::value_of;
use crate::base::checksum::checksum;

const LONGEST: usize = 120;

const LONGEST_LIST: usize = 28;

/// Last words of keys that also name measured quantities. The preceding word is added, as in `barostat_pressure`.
const MEASURED: [&str; 2] = ["pressure", "temperature"];

/// Last words of keys that name measured quantities only in runs with a barostat.
const MEASURED_AT_CONSTANT_PRESSURE: [&str; 3] = ["volume", "number_density", "packing_fraction"];

/// See [`Sweep::short_names`](super::Sweep::short_names).
pub(super) fn short_names(keys: &[&str], has_barostat: bool) -> Vec<String> {
    let is_word = |part: &str| part.starts_with(|c: char| c.is_ascii_alphabetic());
    let last = |key: &str| {
        let parts: Vec<&str> = key.split('.').map(str::trim).collect();
        let first = parts.iter().rposition(|part| is_word(part)).unwrap_or(0);
        let is_measured =
            MEASURED.contains(&parts[first]) || has_barostat && MEASURED_AT_CONSTANT_PRESSURE.contains(&parts[first]);
        let first = if is_measured { first.saturating_sub(1) } else { first };
        parts[first..].join("_")
    };
    let is_alone = |name: &str| keys.iter().filter(|key| last(key) == name).count() == 1;
    let short = |key: &&str| {
        let name = last(key);
        if is_word(&name) && is_alone(&name) { name } else { key.replace('.', "_") }
    };
    keys.iter().map(short).collect()
}

/// Returns the name of a point's folder, such as `packing_fraction-0.1_seed-2` or `size-12x12x9.5`. A path is shortened
/// to its last part. Characters that some file systems or shells reject are replaced. A name that is shortened or taken
/// ends with a checksum of the settings.
pub(super) fn folder_name(names: &[String], settings: &[(String, String)], is_taken: bool) -> String {
    let (mut exact, mut is_whole) = (String::new(), true);
    for (at, (name, (_, value))) in names.iter().zip(settings).enumerate() {
        let (value, is_all) = short_value(value);
        is_whole &= is_all;
        // Writing to a string cannot fail.
        let _ = write!(exact, "{}{name}-{value}", if at == 0 { "" } else { "_" });
    }
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_' | '+');
    let plain: String = exact.chars().take(LONGEST).map(|c| if is_plain(c) { c } else { '_' }).collect();
    if plain == exact && is_whole && !is_taken {
        return plain;
    }
    let all: Vec<String> = settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
    format!("{plain}-{:08x}", checksum(all.join(";").as_bytes()))
}

/// Shortens a value for a folder name. Also returns whether the short form is unambiguous.
fn short_value(text: &str) -> (String, bool) {
    match value_of(text) {
        value @ (Value::Array(_) | Value::Table(_)) => {
            let mut parts = Vec::new();
            let is_flat = matches!(&value, Value::Array(list) if !list.iter().any(|it| it.is_array() || it.is_table()));
            gather(&value, &mut parts);
            let joined = parts.join("x");
            let short: String = joined.chars().take(LONGEST_LIST).collect();
            let is_all = is_flat && short == joined && !parts.iter().any(|part| part.contains('x'));
            (short, is_all)
        }
        Value::String(path) if path.contains(['/', '\\']) => {
            let last = path.trim_end_matches(['/', '\\']).rsplit(['/', '\\']).next().unwrap_or_default();
            (last.to_owned(), false)
        }
        _ => (text.trim_matches(['"', '\'']).to_owned(), true),
    }
}

fn gather(value: &Value, parts: &mut Vec<String>) {
    match value {
        Value::Array(list) => list.iter().for_each(|it| gather(it, parts)),
        Value::Table(table) => table.values().for_each(|it| gather(it, parts)),
        Value::String(word) => parts.push(word.clone()),
        other => parts.push(other.to_string().trim_end_matches(".0").to_owned()),
    }
}
