//! Checks names for characters that are unsafe in files, tables, pages and terminals.

use std::collections::HashMap;

use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse};

const LONGEST_WORD: usize = 64;
const LONGEST_WORDS: usize = 100;

/// Regular expressions for names in the JSON Schema, in a syntax that all validators support. They accept all non-ASCII
/// characters, because these may be letters.
pub(crate) const WORD: &str = r"^[^\x00-/:-@\[-`{-\x7f][^\x00-'*,/:-@\[-\^`{-\x7f]{0,63}$";
pub(crate) const WORDS: &str =
    r"^[^\x00-/:-@\[-`{-\x7f]([^\x00-\x1f!-'*,/:-@\[-\^`{-\x7f]{0,98}[^\x00-'*,/:-@\[-\^`{-\x7f])?$";
pub(crate) const UNIT: &str = r"^[^\x00-@\[-`{-\x7f]{1,16}$";
pub(crate) const SCENE: &str = "^[A-Za-z0-9_-]{1,100}$";

#[derive(Default)]
pub(crate) struct Taken<'n>(HashMap<&'n str, ConfigPath>);

impl<'n> Taken<'n> {
    pub fn take(&mut self, name: &'n str, entry: &ConfigPath) -> Result<(), SceneError> {
        let Some(first) = self.0.insert(name, entry.clone()) else { return Ok(()) };
        Err(SceneError::new(entry.key("name"), SceneErrorKind::Duplicate { name: name.to_owned(), first }))
    }
}

/// Requires a one-word name, for lists separated by spaces. Names begin with a letter or a digit, so that a spreadsheet
/// does not read them as formulas.
pub(crate) fn word(name: &str, at: &ConfigPath) -> Result<(), SceneError> {
    let expected = format!(
        "a name of up to {LONGEST_WORD} letters, digits and any of `_ - + . ( )` that begins with a letter or a digit"
    );
    check(is_name(name, LONGEST_WORD, |_| false), name, expected, at)
}

/// Requires a name of one or several words for messages and column headers.
pub(crate) fn words(name: &str, at: &ConfigPath) -> Result<(), SceneError> {
    let expected = format!(
        "a name of up to {LONGEST_WORDS} letters, digits, blanks and any of `_ - + . ( )` that begins with a letter or a digit"
    );
    check(is_name(name, LONGEST_WORDS, |c| c == ' ') && !name.ends_with(' '), name, expected, at)
}

fn is_name(name: &str, longest: usize, is_allowed: impl Fn(char) -> bool) -> bool {
    let is_good = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '+' | '.' | '(' | ')') || is_allowed(c);
    name.starts_with(char::is_alphanumeric) && name.chars().all(is_good) && name.chars().count() <= longest
}

fn check(is_good: bool, name: &str, expected: String, at: &ConfigPath) -> Result<(), SceneError> {
    if is_good {
        return Ok(());
    }
    let mut shown: String = name.chars().take(40).flat_map(char::escape_debug).collect();
    if name.chars().nth(40).is_some() {
        shown += "...";
    }
    refuse(at.clone(), format!("\"{shown}\""), expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_special_meaning_are_rejected() {
        let at = ConfigPath::root().key("name");
        for good in ["A", "bead-12", "Na+", "\u{e9}t\u{e9}", "(x)".trim_start_matches('('), "2.5", &"a".repeat(64)] {
            assert!(word(good, &at).is_ok(), "{good}");
        }
        let long = "a".repeat(65);
        for bad in [
            "",
            "a b",
            "a\"b",
            "a\\b",
            "a\u{1b}[31mb",
            "=1+cmd",
            "+x",
            "-x",
            "@x",
            "a,b",
            "a/b",
            "a\tb",
            "\u{202e}a",
            &long,
        ] {
            let error = word(bad, &at).unwrap_err().to_string();
            assert!(error.contains("expected a name of up to 64 letters"), "{error}");
            assert!(!error.chars().any(char::is_control) && error.len() < 400, "{error:?}");
        }
        assert!(words("front side", &at).is_ok());
        for bad in ["", " a", "a ", "a,b", "a\"b", "=a b", &"a".repeat(101)] {
            assert!(words(bad, &at).is_err(), "{bad}");
        }
    }
}
