//! Splits the text of a mesh file into words with line numbers.

use super::error::{MeshFileProblem, Place, shorten};
use crate::model::triangle_mesh::LARGEST_COORDINATE;

#[derive(Debug, Clone, Copy)]
pub(super) struct Word<'a> {
    pub text: &'a [u8],
    pub line: usize,
}

impl Word<'_> {
    pub fn is(&self, keyword: &str) -> bool {
        self.text.eq_ignore_ascii_case(keyword.as_bytes())
    }

    pub fn unexpected(&self, expected: &'static str) -> MeshFileProblem {
        MeshFileProblem::Unexpected { line: self.line, found: shorten(self.text), expected }
    }

    pub fn coordinate(&self) -> Result<f64, MeshFileProblem> {
        let text = std::str::from_utf8(self.text).ok();
        let Some(x) = text.and_then(|text| text.parse::<f64>().ok()) else {
            return Err(self.unexpected("a coordinate, such as -1.5e-3"));
        };
        if x.abs() <= LARGEST_COORDINATE {
            return Ok(x);
        }
        Err(MeshFileProblem::Coordinate { place: Place::Line(self.line), found: shorten(self.text) })
    }
}

#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    /// Starts at the beginning of a file and skips its byte order mark.
    pub fn of(content: &'a [u8]) -> Self {
        Self { rest: content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content), line: 1 }
    }

    pub fn line(&self) -> usize {
        self.line
    }

    pub fn next(&mut self) -> Option<Word<'a>> {
        let blanks = self.rest.iter().position(|byte| !is_blank(*byte)).unwrap_or(self.rest.len());
        let (before, rest) = self.rest.split_at(blanks);
        self.line += line_ends(before);
        let length = rest.iter().position(|byte| is_blank(*byte)).unwrap_or(rest.len());
        let (text, rest) = rest.split_at(length);
        self.rest = rest;
        (length > 0).then_some(Word { text, line: self.line })
    }

    /// Returns the next word on the line, or `None`. A backslash at the end of a line continues the line.
    pub fn next_on_line(&mut self) -> Option<Word<'a>> {
        loop {
            let blanks =
                self.rest.iter().position(|byte| !is_blank(*byte) || is_line_end(*byte)).unwrap_or(self.rest.len());
            self.rest = self.rest.split_at(blanks).1;
            match self.rest {
                [b'\\', b'\r', b'\n', rest @ ..] | [b'\\', b'\n' | b'\r', rest @ ..] => {
                    self.line += 1;
                    self.rest = rest;
                }
                [] | [b'\n' | b'\r', ..] => return None,
                rest => {
                    let length =
                        1 + rest.iter().skip(1).position(|b| is_blank(*b) || *b == b'\\').unwrap_or(rest.len() - 1);
                    let (text, rest) = rest.split_at(length);
                    self.rest = rest;
                    return Some(Word { text, line: self.line });
                }
            }
        }
    }

    /// Skips the rest of the line. Returns false at the end of the text. A backslash does not continue the line here,
    /// because a comment may end with a path such as `c:\`.
    pub fn skip_line(&mut self) -> bool {
        let end = self.rest.iter().position(|byte| is_line_end(*byte));
        let rest = end.map_or(&[][..], |end| self.rest.split_at(end).1);
        self.rest = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
        self.line += usize::from(end.is_some());
        end.is_some()
    }
}

fn is_line_end(byte: u8) -> bool {
    byte == b'\n' || byte == b'\r'
}

/// Counts the line ends LF, CR LF and CR.
fn line_ends(text: &[u8]) -> usize {
    let is_end = |at: usize| text[at] == b'\n' || (text[at] == b'\r' && text.get(at + 1) != Some(&b'\n'));
    (0..text.len()).filter(|&at| is_end(at)).count()
}

fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b'\x0b'
}
