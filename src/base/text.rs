//! Numbers, lists and names formatted for people.

use std::borrow::Cow;
use std::fmt::Display;

use super::numbers::trunc_to_usize;

/// A count with its noun: `1 wall`, `2 walls`.
#[must_use]
pub fn plural(count: impl Display + PartialEq + From<u8>, noun: &str) -> String {
    let ending = if count == 1.into() { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// At most `longest` characters of a malformed text, for an error message. Such texts can be very long or binary.
pub(crate) fn shorten(text: &str, longest: usize) -> String {
    let shown = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    let mut short: String = text.chars().take(longest).map(shown).collect();
    if text.chars().nth(longest).is_some() {
        short.push_str("...");
    }
    short
}

/// A list in words: `x`, `x and y`, `x, y and z`.
#[must_use]
pub fn listed(names: &[&str]) -> String {
    match names {
        [first @ .., second, last] if !first.is_empty() => format!("{}, {second} and {last}", first.join(", ")),
        names => names.join(" and "),
    }
}

/// A number of bytes in words: `25 MB`.
#[must_use]
pub fn size(bytes: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let (unit, name) = units.into_iter().find(|(unit, _)| bytes >= *unit).unwrap_or((1.0, "bytes"));
    let number = bytes / unit;
    format!("{number:.*} {name}", usize::from(number < 10.0 && unit > 1.0))
}

/// Replaces control characters, which could act on a terminal, except line ends and tabs. Keeps the number of bytes.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(|c: char| c.is_control() && !matches!(c, '\n' | '\t')) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        let is_end_of_line = c == '\n' || (c == '\r' && rest.as_str().starts_with('\n'));
        shown.push(match c {
            c if !c.is_control() || is_end_of_line || c == '\t' => c,
            c if c.len_utf8() == 1 => '?',
            _ => '\u{bf}',
        });
    }
    Cow::Owned(shown)
}

/// Formats a number with the fewest digits that read back as the same number, with an exponent if very large or small.
#[must_use]
pub fn shortest(number: f64) -> String {
    if number == 0.0 || (1e-5..1e16).contains(&number.abs()) { number.to_string() } else { format!("{number:e}") }
}

/// Formats a number for a reader, with about six digits, or with four digits and an exponent.
#[must_use]
pub fn digits(number: f64) -> String {
    if number == 0.0 || (1e-4..1e7).contains(&number.abs()) {
        let whole = trunc_to_usize(libm::log10(number.abs()));
        let text = format!("{number:.*}", 5_usize.saturating_sub(whole));
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{number:.3e}")
    }
}

/// Formats a small residual, such as a drift: `0`, or two digits as in `3.1e-16`.
#[must_use]
pub fn tiny(number: f64) -> String {
    if number == 0.0 { "0".to_owned() } else { format!("{number:.1e}") }
}

/// Turns a name into an identifier for a column. For example, `g(r) A,B` becomes `g_r_A_B`.
#[must_use]
pub fn identifier(name: &str) -> String {
    let words = name.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("_")
}

/// Turns names into identifiers for columns. A name whose identifier is already taken gets a number.
#[must_use]
pub fn identifiers<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for name in names {
        let name = identifier(name);
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| !name.is_empty() && !taken.contains(name));
        taken.extend(free);
    }
    taken
}

/// Returns the message of an error, followed by the messages of its causes.
#[must_use]
pub fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    causes.fold(error.to_string(), |message, cause| format!("{message}: {cause}"))
}

/// Formats a duration in seconds: `3.0 s`, `10 min`.
#[must_use]
pub fn clock(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

/// Formats a number with three digits and a letter for its magnitude: `1.23 k`.
#[must_use]
pub fn short(number: f64) -> String {
    for (unit, letter) in [(1e12, " T"), (1e9, " G"), (1e6, " M"), (1e3, " k")] {
        if number >= unit {
            let scaled = number / unit;
            let digits = if scaled < 10.0 { 2 } else { usize::from(scaled < 100.0) };
            return format!("{scaled:.digits$}{letter}");
        }
    }
    format!("{number:.0}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_durations_are_printed_short() {
        assert_eq!(short(999.0), "999");
        assert_eq!(short(1234.0), "1.23 k");
        assert_eq!(short(123_456_789.0), "123 M");
        assert_eq!(clock(3.04), "3.0 s");
        assert_eq!(clock(600.0), "10 min");
    }

    #[test]
    fn columns_have_names_that_are_identifiers_and_differ() {
        let names = ["g(r) A,B", "in the bin", "in_the_bin", "in-the-bin", "|v|", "a_b_2", "a b", "a-b"];
        let expected = ["g_r_A_B", "in_the_bin", "in_the_bin_2", "in_the_bin_3", "v", "a_b_2", "a_b", "a_b_3"];
        assert_eq!(identifiers(names), expected);
    }
}
