//! Axes of a sweep, written as `KEY=VALUES`.
//!
//! | values | meaning |
//! |---|---|
//! | `0.1,0.2,0.5` | a list of values, as in the scene |
//! | `1..5` | integers, both ends included |
//! | `0.05..0.49/12` | a number of equidistant values, both ends included |
//! | `1e-3..10/9/log` | a number of values with constant ratios, both ends included |
//! | `1..3,10` | a list may contain ranges |
//!
//! `KEY=VALUES; KEY=VALUES` describes keys that change together, value by value.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::value::plain;

/// Maximum number of values of an axis. A sweep has the same maximum number of points.
pub(super) const MOST: usize = 100_000;

/// Significant digits of a value computed from a range. Rounding hides errors such as 0.30000000000000004.
const DIGITS: usize = 12;

/// Axis of a sweep: keys of the scene that change together, and their values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Axis {
    keys: Vec<String>,
    values: Vec<Vec<String>>,
}

/// Error in the text of an axis.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum AxisError {
    /// The text lacks `=`, the key or the values.
    #[error("`{0}` is not KEY=VALUES, such as fill.0.packing_fraction=0.1..0.4/4 or seed=1..3")]
    Form(String),
    /// A list has an empty value.
    #[error("`{0}` has an empty value")]
    Empty(String),
    /// An end of a range is not a finite number.
    #[error("`{0}` is not a range: expected two finite numbers, such as 0.1..0.5/9")]
    Ends(String),
    /// The ends of a range are not in ascending order.
    #[error("the range `{0}` runs backwards, or its ends are the same: write the smaller end first")]
    Backwards(String),
    /// A range needs a number of values, because its ends are not integers.
    #[error("the range `{0}` does not say how many values it has: write {0}/5 for five, both ends included")]
    Uncounted(String),
    /// The number of values is too large, or is not an integer of at least 2.
    #[error("`{0}` has a number of values that is not a whole number from 2 to {MOST}")]
    Count(String),
    /// A logarithmic range has an end that is not positive.
    #[error("the range `{0}` is logarithmic, and its ends are not positive")]
    Logarithmic(String),
    /// The word after a range is not `log`.
    #[error("`{word}` in `{range}`: expected nothing or log")]
    Spacing {
        /// Text of the range.
        range: String,
        /// The word after the range.
        word: String,
    },
    /// Keys that change together have different numbers of values.
    #[error(
        "`{first}` has {expected} values and `{other}` has {found}: keys that change together need the same number of values"
    )]
    Uneven {
        /// The first of the keys.
        first: String,
        /// Number of values of the first key.
        expected: usize,
        /// A key with a different number of values.
        other: String,
        /// Number of values of the other key.
        found: usize,
    },
}

impl Axis {
    /// Keys of the scene that the axis varies together, such as `fill.0.packing_fraction`.
    #[must_use]
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// Number of values of the axis.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// Whether the axis has no values. A parsed axis has at least one value.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn settings(&self, at: usize) -> impl Iterator<Item = (String, String)> {
        self.keys.iter().zip(&self.values).map(move |(key, values)| (key.clone(), values[at].clone()))
    }
}

impl FromStr for Axis {
    type Err = AxisError;

    fn from_str(text: &str) -> Result<Self, AxisError> {
        let (mut keys, mut values) = (Vec::new(), Vec::new());
        for part in split(text, ';') {
            let (key, list) = part.split_once('=').ok_or_else(|| AxisError::Form(part.trim().to_owned()))?;
            let (key, list) = (key.trim(), list.trim());
            if key.is_empty() || list.is_empty() {
                return Err(AxisError::Form(part.trim().to_owned()));
            }
            keys.push(key.to_owned());
            values.push(values_of(list)?);
        }
        let lengths = values.iter().map(Vec::len);
        if let Some((other, found)) = keys.iter().zip(lengths).find(|(_, found)| *found != values[0].len()) {
            let (first, other, expected) = (keys[0].clone(), other.clone(), values[0].len());
            return Err(AxisError::Uneven { first, expected, other, found });
        }
        Ok(Self { keys, values })
    }
}

/// Writes the axis with all its values, as on the command line.
impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, (key, values)) in self.keys.iter().zip(&self.values).enumerate() {
            write!(f, "{}{key}={}", if at == 0 { "" } else { "; " }, values.join(","))?;
        }
        Ok(())
    }
}

fn values_of(list: &str) -> Result<Vec<String>, AxisError> {
    let mut values = Vec::new();
    for part in split(list, ',') {
        let part = part.trim();
        if part.is_empty() {
            return Err(AxisError::Empty(list.to_owned()));
        }
        match part.split_once("..") {
            Some((low, rest)) if !part.starts_with(['"', '\'', '[', '{']) => values.extend(range(part, low, rest)?),
            _ => values.push(plain(part)),
        }
        if values.len() > MOST {
            return Err(AxisError::Count(list.to_owned()));
        }
    }
    Ok(values)
}

fn range(text: &str, low: &str, rest: &str) -> Result<Vec<String>, AxisError> {
    let owned = || text.to_owned();
    let mut parts = rest.split('/').map(str::trim);
    let (high, count, spacing) = (parts.next().unwrap_or_default(), parts.next(), parts.next());
    let number = |end: &str| end.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let (Some(first), Some(last)) = (number(low), number(high)) else { return Err(AxisError::Ends(owned())) };
    if first >= last {
        return Err(AxisError::Backwards(owned()));
    }
    let Some(count) = count else {
        let (Ok(first), Ok(last)) = (low.trim().parse::<i64>(), high.parse::<i64>()) else {
            return Err(AxisError::Uncounted(owned()));
        };
        let is_short = usize::try_from(last.abs_diff(first)).is_ok_and(|length| length < MOST);
        return if is_short {
            Ok((first..=last).map(|x| x.to_string()).collect())
        } else {
            Err(AxisError::Count(owned()))
        };
    };
    let count = count.parse::<usize>().ok().filter(|count| (2..=MOST).contains(count));
    let count = count.ok_or_else(|| AxisError::Count(owned()))?;
    if let Some(word) = spacing.filter(|word| *word != "log").or_else(|| parts.next()) {
        return Err(AxisError::Spacing { range: owned(), word: word.to_owned() });
    }
    if spacing.is_some() && first <= 0.0 {
        return Err(AxisError::Logarithmic(owned()));
    }
    let value = |k: usize| {
        let part = k as f64 / (count - 1) as f64;
        if k == 0 {
            first
        } else if k == count - 1 {
            last
        } else if spacing.is_some() {
            rounded(libm::exp(libm::log(first) + part * (libm::log(last) - libm::log(first))))
        } else {
            rounded(first + part * (last - first))
        }
    };
    Ok((0..count).map(|k| value(k).to_string()).collect())
}

fn rounded(x: f64) -> f64 {
    format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x)
}

/// Splits a text at separators outside brackets and quotes.
fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut quote) = (Vec::new(), 0, 0_i64, None);
    for (at, c) in text.char_indices() {
        match quote {
            Some(open) if c == open => quote = None,
            Some(_) => {}
            None => match c {
                '"' | '\'' => quote = Some(c),
                '[' | '{' => depth += 1,
                ']' | '}' => depth -= 1,
                c if c == separator && depth <= 0 => {
                    parts.push(&text[start..at]);
                    start = at + c.len_utf8();
                }
                _ => {}
            },
        }
    }
    parts.push(&text[start..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn values(text: &str) -> Vec<String> {
        let axis: Axis = format!("a.b={text}").parse().unwrap();
        assert_eq!(axis.keys(), ["a.b"]);
        (0..axis.len()).map(|at| axis.settings(at).next().unwrap().1).collect()
    }

    #[test]
    fn lists_and_ranges_expand_to_round_values() {
        assert_eq!(values("0.1, 0.2,0.5"), ["0.1", "0.2", "0.5"]);
        assert_eq!(values("1..4"), ["1", "2", "3", "4"]);
        assert_eq!(values("-2..0, 7"), ["-2", "-1", "0", "7"]);
        assert_eq!(values("0.1..0.5/5"), ["0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(values("100..1000/4"), ["100", "400", "700", "1000"]);
        assert_eq!(values("1e-3..10/5/log"), ["0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(values("[0, 0, -1], [0, 0, -2]"), ["[0, 0, -1]", "[0, 0, -2]"]);
        assert_eq!(values("\"a,b\",fcc"), ["\"a,b\"", "fcc"]);
        assert_eq!(values("\"../start.xyz\""), ["\"../start.xyz\""]);
    }

    #[test]
    fn keys_varied_together_need_equally_many_values() {
        let axis: Axis = "a=1..2; b.0.c=x,y".parse().unwrap();
        assert_eq!(axis.keys(), ["a", "b.0.c"]);
        let settings: Vec<(String, String)> = axis.settings(1).collect();
        assert_eq!(settings, [("a".into(), "2".into()), ("b.0.c".into(), "y".into())]);
        assert_eq!(axis.to_string(), "a=1,2; b.0.c=x,y");
        let error = "a=1..2; b=1..3".parse::<Axis>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "`a` has 2 values and `b` has 3: keys that change together need the same number of values"
        );
    }

    #[test]
    fn invalid_axes_are_rejected() {
        let kinds = [
            ("seed", AxisError::Form("seed".into())),
            ("=1", AxisError::Form("=1".into())),
            ("a=", AxisError::Form("a=".into())),
            ("a=1,,2", AxisError::Empty("1,,2".into())),
            ("a=x..3", AxisError::Ends("x..3".into())),
            ("a=1..inf/3", AxisError::Ends("1..inf/3".into())),
            ("a=0.49..0.05/12", AxisError::Backwards("0.49..0.05/12".into())),
            ("a=2..2", AxisError::Backwards("2..2".into())),
            ("a=0.1..0.5", AxisError::Uncounted("0.1..0.5".into())),
            ("a=0..1/1", AxisError::Count("0..1/1".into())),
            ("a=0..1/1000000", AxisError::Count("0..1/1000000".into())),
            ("a=0..1000000000000", AxisError::Count("0..1000000000000".into())),
            ("a=0..1/3/log", AxisError::Logarithmic("0..1/3/log".into())),
            ("a=1..2/3/lin", AxisError::Spacing { range: "1..2/3/lin".into(), word: "lin".into() }),
            ("a=1..2/3/log/4", AxisError::Spacing { range: "1..2/3/log/4".into(), word: "4".into() }),
        ];
        for (text, expected) in kinds {
            assert_eq!(text.parse::<Axis>(), Err(expected), "{text}");
        }
    }

    proptest! {
        #[test]
        fn arbitrary_text_does_not_panic(text in "\\PC{0,60}") {
            let _ = text.parse::<Axis>();
        }

        #[test]
        fn a_range_begins_and_ends_where_it_says(low in -1e3..1e3_f64, width in 1e-3..1e3_f64, count in 2_usize..50) {
            let high = low + width;
            let all = values(&format!("{low}..{high}/{count}"));
            prop_assert_eq!(all.len(), count);
            let numbers: Vec<f64> = all.iter().map(|x| x.parse().unwrap()).collect();
            prop_assert_eq!((numbers[0], numbers[count - 1]), (low, high));
            for (k, x) in numbers.iter().enumerate() {
                let exact = low + width * k as f64 / (count - 1) as f64;
                prop_assert!((x - exact).abs() <= 1e-11 * low.abs().max(high.abs()), "{} {}", x, exact);
            }
        }
    }
}
