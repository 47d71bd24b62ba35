//! The first difference between two files.

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use crate::io::Folder;

/// Difference between a file of a run and the file of its replay.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Difference {
    /// The file is missing.
    Missing,
    /// The file is damaged. The text describes how.
    Damaged(String),
    /// A line of a text differs.
    Line {
        /// Line number, counted from 1.
        number: u64,
        /// Text of the line near the difference; `None` past the end of the file.
        found: Option<String>,
        /// Text of the replay at the same position; `None` past the end of the file.
        expected: Option<String>,
    },
    /// A byte differs.
    Byte {
        /// Offset of the byte, counted from 0.
        offset: u64,
        /// Byte of the file; `None` past the end of the file.
        found: Option<u8>,
        /// Byte of the replay at the same position; `None` past the end of the file.
        expected: Option<u8>,
    },
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = |text: &Option<String>| text.as_ref().map_or("the end".to_owned(), |text| format!("`{text}`"));
        let byte = |byte: &Option<u8>| byte.map_or("the end".to_owned(), |byte| format!("{byte:#04x}"));
        match self {
            Self::Missing => f.write_str("it is missing"),
            Self::Damaged(why) => f.write_str(why),
            Self::Line { number, found, expected } => {
                write!(f, "line {number} is {}, but {} in the replay", line(found), line(expected))
            }
            Self::Byte { offset, found, expected } => {
                write!(f, "byte {offset} is {}, but {} in the replay", byte(found), byte(expected))
            }
        }
    }
}

#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    Equal,
    Different(Difference),
    /// The report was not written by the program.
    OtherText,
}

const TEXTS: [&str; 6] = ["csv", "json", "txt", "xyz", "lammpstrj", "pvd"];

/// Number of characters shown before and after a difference.
const SHOWN: [usize; 2] = [24, 40];

/// Keys of the summary whose values depend on the clock, the machine or the version.
const FREE_KEYS: [&str; 6] =
    ["version", "engine", "wall_seconds", "events_per_second", "contacts_per_second", "peak_memory_bytes"];

/// Report lines that begin with these words may differ between a run and its replay.
const FREE_LINES: [&str; 3] = ["engine ", "threads ", "measured "];

/// Every report written by the program starts with these bytes.
const HEAD: &[u8] = b"scene    ";

/// If `ends_itself` is true, a user's instrument ended the run, and lines about the ending may differ.
pub(super) fn compare(name: &str, found: &Path, expected: &Path, ends_itself: bool) -> io::Result<Found> {
    let mut found = BufReader::new(File::open(found)?);
    let mut expected = BufReader::new(File::open(expected)?);
    if name == Folder::REPORT && !found.fill_buf()?.starts_with(HEAD) {
        return Ok(Found::OtherText);
    }
    let is_text = Path::new(name).extension().is_some_and(|it| TEXTS.iter().any(|text| it == *text));
    let difference = if is_text {
        let lines = |text| Lines::of(text, free_lines(name, ends_itself));
        first_line(lines(found), lines(expected))?
    } else {
        first_byte(&mut found, &mut expected)?
    };
    Ok(difference.map_or(Found::Equal, Found::Different))
}

/// Whether a line may differ. Must be called for every line in order, as the answer may depend on earlier lines.
type IsFree = Box<dyn FnMut(&[u8]) -> bool>;

fn free_lines(name: &str, ends_itself: bool) -> IsFree {
    match name {
        Folder::SUMMARY => Box::new(move |line| {
            let key =
                line.trim_ascii_start().strip_prefix(b"\"").and_then(|rest| rest.split(|byte| *byte == b'"').next());
            key.is_some_and(|key| {
                FREE_KEYS.iter().any(|free| free.as_bytes() == key) || (ends_itself && key == b"ending")
            })
        }),
        Folder::REPORT => {
            let mut is_free = false;
            Box::new(move |line| {
                // An indented line is treated like the line above it.
                if !line.starts_with(b" ") {
                    is_free = FREE_LINES.iter().any(|free| line.starts_with(free.as_bytes()))
                        || (ends_itself && line.starts_with(b"ended "));
                }
                is_free
            })
        }
        _ => Box::new(|_| false),
    }
}

struct Lines<R> {
    text: R,
    is_free: IsFree,
    line: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Lines<R> {
    fn of(text: R, is_free: IsFree) -> Self {
        Self { text, is_free, line: Vec::new(), number: 0 }
    }

    fn advance(&mut self) -> io::Result<bool> {
        loop {
            self.line.clear();
            self.number += 1;
            if self.text.read_until(b'\n', &mut self.line)? == 0 {
                return Ok(false);
            }
            if !(self.is_free)(&self.line) {
                return Ok(true);
            }
        }
    }
}

fn first_line<R: BufRead>(mut found: Lines<R>, mut expected: Lines<R>) -> io::Result<Option<Difference>> {
    loop {
        let (has_one, has_other) = (found.advance()?, expected.advance()?);
        if !has_one && !has_other {
            return Ok(None);
        }
        if has_one && has_other && found.line == expected.line {
            continue;
        }
        let at = found.line.iter().zip(&expected.line).take_while(|(one, other)| one == other).count();
        let number = found.number;
        let [found, expected] =
            [(has_one, found.line), (has_other, expected.line)].map(|(has, line)| has.then(|| near(&line, at)));
        return Ok(Some(Difference::Line { number, found, expected }));
    }
}

fn near(line: &[u8], at: usize) -> String {
    let text = line.trim_ascii_end();
    let [before, after] = SHOWN;
    let (start, end) = (at.min(text.len()).saturating_sub(before), (at + after).min(text.len()));
    let dots = |is_cut: bool| if is_cut { "..." } else { "" };
    format!("{}{}{}", dots(start > 0), String::from_utf8_lossy(&text[start..end]), dots(end < text.len()))
}

fn first_byte(found: &mut impl BufRead, expected: &mut impl BufRead) -> io::Result<Option<Difference>> {
    let mut offset = 0;
    loop {
        let (one, other) = (found.fill_buf()?, expected.fill_buf()?);
        if one.is_empty() && other.is_empty() {
            return Ok(None);
        }
        let both = one.len().min(other.len());
        let same = one.iter().zip(other).take_while(|(one, other)| one == other).count();
        if same < both || both == 0 {
            let offset = offset + same as u64;
            let (found, expected) = (one.get(same).copied(), other.get(same).copied());
            return Ok(Some(Difference::Byte { offset, found, expected }));
        }
        offset += both as u64;
        found.consume(both);
        expected.consume(both);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(name: &str, found: &str, expected: &str) -> Option<Difference> {
        let lines = |text| Lines::of(text, free_lines(name, false));
        first_line(lines(found.as_bytes()), lines(expected.as_bytes())).unwrap()
    }

    #[test]
    fn the_first_line_that_differs_is_shown_near_the_difference() {
        assert_eq!(lines("thermo.csv", "a\nb\n", "a\nb\n"), None);
        let long = format!("{}1{}", "x".repeat(100), "y".repeat(100));
        let found = lines("x.json", &long, &long.replace('1', "2"));
        let shown = |digit| Some(format!("...{}{digit}{}...", "x".repeat(24), "y".repeat(39)));
        assert_eq!(found, Some(Difference::Line { number: 1, found: shown(1), expected: shown(2) }));
        for (found, expected) in [("a\n", "a\nb\n"), ("a\nb\n", "a\n"), ("a\nb", "a\nb\n"), ("a\nb\n\n", "a\nb\n")] {
            assert!(
                matches!(lines("thermo.csv", found, expected), Some(Difference::Line { number: 2 | 3, .. })),
                "{found:?}"
            );
        }
    }

    #[test]
    fn only_clock_dependent_fields_may_differ() {
        let summary =
            |seconds: &str, mean: &str| format!("{{\n  \"mean\": {mean},\n  \"wall_seconds\": {seconds}\n}}\n");
        assert_eq!(lines("summary.json", &summary("1.5", "2.5"), &summary("1.25", "2.5")), None);
        assert!(lines("summary.json", &summary("1.5", "2.5"), &summary("1.5", "2.25")).is_some());
        assert!(lines("other.json", &summary("1.5", "2.5"), &summary("1.25", "2.5")).is_some());
        let renamed = summary("1.5", "2.5").replace("wall_seconds", "wall_secondS");
        assert!(lines("summary.json", &renamed, &summary("1.5", "2.5")).is_some());
        let report = |rate: &str, why: &str, mean: &str| {
            format!("scene   x\nengine  cells\n        {why}\nended   {mean}\nmeasured {rate}\n")
        };
        assert_eq!(lines("report.txt", &report("1", "a", "m"), &report("2", "b", "m")), None);
        assert!(lines("report.txt", &report("1", "a", "m"), &report("1", "a", "n")).is_some());
    }

    #[test]
    fn bytes_are_compared_across_buffers_of_any_size() {
        let bytes: Vec<u8> = (0..200).collect();
        let mut changed = bytes.clone();
        changed[151] ^= 1;
        let first = |one: &[u8], other: &[u8]| {
            let (mut one, mut other) = (BufReader::with_capacity(7, one), BufReader::with_capacity(13, other));
            first_byte(&mut one, &mut other).unwrap()
        };
        assert_eq!(first(&bytes, &bytes), None);
        assert_eq!(
            first(&changed, &bytes),
            Some(Difference::Byte { offset: 151, found: Some(150), expected: Some(151) })
        );
        assert_eq!(first(&bytes[..90], &bytes), Some(Difference::Byte { offset: 90, found: None, expected: Some(90) }));
        assert_eq!(first(&bytes, &bytes[..90]), Some(Difference::Byte { offset: 90, found: Some(90), expected: None }));
    }
}
