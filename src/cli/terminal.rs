//! Formats text for the width of the terminal.

use std::io::{self, IsTerminal};

use terminal_size::{Width, terminal_size_of};
use textwrap::{Options, WordSeparator, WordSplitter, wrap};

/// Returns the width of the terminal in columns; `None` if standard output is a file or a pipe.
fn width() -> Option<usize> {
    let stdout = io::stdout();
    let is_terminal = stdout.is_terminal();
    terminal_size_of(stdout).filter(|_| is_terminal).map(|(Width(columns), _)| usize::from(columns))
}

/// Wraps a report at the width of the terminal. Words longer than a line are not broken.
pub fn fitted(text: &str) -> String {
    width().map_or_else(|| text.to_owned(), |width| wrapped(text, width))
}

/// Returns the lines of a table with right-aligned cells. A table wider than the terminal is split into several tables.
/// The first `keys` columns are repeated in each of them.
pub fn columns(rows: &[Vec<String>], keys: usize) -> Vec<String> {
    tables(rows, keys, width().unwrap_or(usize::MAX))
}

const NARROWEST: usize = 20;

/// Breaks long lines between words. Continuation lines are indented to the second column, which follows a gap of at
/// least two spaces.
fn wrapped(text: &str, width: usize) -> String {
    let mut lines = Vec::new();
    for line in text.lines() {
        let start = line.len() - line.trim_start().len();
        let second = line[start..].find("  ").map_or(start, |end| {
            let gap = start + end;
            line.len() - line[gap..].trim_start().len()
        });
        let indent = " ".repeat(if second <= width / 2 { second } else { start.min(width / 2) });
        let options = Options::new(width.max(NARROWEST)).subsequent_indent(&indent);
        let options = options.word_separator(WordSeparator::AsciiSpace).word_splitter(WordSplitter::NoHyphenation);
        let options = options.break_words(false);
        lines.extend(wrap(line, options).into_iter().map(|line| line.into_owned() + "\n"));
    }
    lines.concat()
}

fn tables(rows: &[Vec<String>], keys: usize, width: usize) -> Vec<String> {
    let cell = |row: &Vec<String>, column: usize| row.get(column).cloned().unwrap_or_default();
    let length = |row: &Vec<String>, column: usize| row.get(column).map_or(0, |cell| cell.chars().count());
    let widest = |column: usize| rows.iter().map(|row| length(row, column)).max().unwrap_or(0);
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let keys = keys.min(count);
    let of_keys: usize = (0..keys).map(|column| GAP.len() + widest(column)).sum();
    let mut blocks: Vec<(Vec<usize>, usize)> = Vec::new();
    for column in keys..count {
        let more = GAP.len() + widest(column);
        match blocks.last_mut() {
            // A line starts with a margin of two columns. The gap between cells has three columns.
            Some((block, taken)) if *taken + more - 1 <= width => {
                block.push(column);
                *taken += more;
            }
            _ => blocks.push(((0..keys).chain([column]).collect(), of_keys + more)),
        }
    }
    if blocks.is_empty() {
        blocks.push(((0..keys).collect(), of_keys));
    }
    let line = |row: &Vec<String>, block: &[usize]| {
        let cells = block.iter().map(|&column| format!("{:>1$}", cell(row, column), widest(column)));
        format!("  {}", cells.collect::<Vec<_>>().join(GAP))
    };
    blocks.iter().flat_map(|(block, _)| rows.iter().map(|row| line(row, block))).collect()
}

const GAP: &str = "   ";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_wrap_under_their_second_column() {
        let text =
            "short\nequilibrated    unknown (too short to tell for temperature)\n  indented words that are too long\n";
        let expected = "short\nequilibrated    unknown (too\n                short to tell\n                for temperature)\n  \
             indented words that are too\n  long\n";
        assert_eq!(wrapped(text, 32), expected);
        assert_eq!(wrapped(text, 200), text);
    }

    #[test]
    fn words_that_are_wider_than_the_terminal_stay_whole() {
        let path = "The files are in /home/somebody/a/long/path/to/a/folder\n";
        assert_eq!(wrapped(path, 20).replace('\n', " "), path.replace('\n', " "));
    }

    #[test]
    fn a_wide_table_becomes_several_with_the_same_keys() {
        let rows = [["x", "first", "second", "third"], ["0.1", "1", "2", "3"]];
        let rows = rows.map(|row| row.map(str::to_owned).to_vec());
        let one = ["    x   first   second   third", "  0.1       1        2       3"];
        assert_eq!(tables(&rows, 1, 80), one);
        assert_eq!(tables(&rows, 1, one[0].len()), one);
        let narrow =
            ["    x   first", "  0.1       1", "    x   second", "  0.1        2", "    x   third", "  0.1       3"];
        assert_eq!(tables(&rows, 1, 16), narrow);
        assert_eq!(tables(&rows, 1, 1), narrow);
        assert_eq!(tables(&rows, 4, 80), one);
    }
}
