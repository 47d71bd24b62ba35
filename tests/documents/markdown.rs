//! Reads the headings, links, code and tables of the Markdown documents.

use std::fs;
use std::path::{Path, PathBuf};

pub struct Page {
    /// Path from the root of the repository.
    pub path: String,
    pub text: String,
}

/// A code block, either fenced or indented by four spaces.
pub struct Block {
    /// Text after the opening fence, such as `toml`. Empty for an indented block.
    pub info: String,
    pub text: String,
    /// Line number of the first line of code, from 1.
    pub line: usize,
}

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn pages() -> Vec<Page> {
    let mut paths = vec![PathBuf::from("README.md")];
    let mut folder: Vec<PathBuf> = fs::read_dir(root().join("docs"))
        .unwrap()
        .map(|entry| Path::new("docs").join(entry.unwrap().file_name()))
        .collect();
    folder.sort();
    paths.extend(folder.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "md")));
    let page = |path: PathBuf| Page {
        text: fs::read_to_string(root().join(&path)).unwrap(),
        path: path.to_str().unwrap().to_owned(),
    };
    paths.into_iter().map(page).collect()
}

impl Page {
    pub fn of(path: &str) -> Self {
        pages().into_iter().find(|page| page.path == path).unwrap_or_else(|| panic!("there is no {path}"))
    }

    pub fn prose(&self) -> Vec<(usize, &str)> {
        let mut is_code = false;
        let mut lines = Vec::new();
        for (index, line) in self.text.lines().enumerate() {
            if line.starts_with("```") {
                is_code = !is_code;
            } else if !is_code && !line.starts_with("    ") {
                lines.push((index + 1, line));
            }
        }
        lines
    }

    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let (mut fence, mut was_indented) = (false, false);
        for (index, line) in self.text.lines().enumerate() {
            let is_indented = !fence && line.starts_with("    ");
            if let Some(info) = line.strip_prefix("```") {
                fence = !fence;
                if fence {
                    blocks.push(Block { info: info.to_owned(), text: String::new(), line: index + 2 });
                }
            } else if fence || is_indented {
                if is_indented && !was_indented {
                    blocks.push(Block { info: String::new(), text: String::new(), line: index + 1 });
                }
                let text = &mut blocks.last_mut().unwrap().text;
                text.push_str(if fence { line } else { &line[4..] });
                text.push('\n');
            }
            was_indented = is_indented;
        }
        blocks
    }

    pub fn spans(&self) -> Vec<(usize, &str)> {
        let mut spans = Vec::new();
        for (line, text) in self.prose() {
            let parts: Vec<&str> = text.split('`').collect();
            assert!(parts.len() % 2 == 1, "{}:{line}: a code span runs over the end of the line", self.path);
            spans.extend(parts.into_iter().skip(1).step_by(2).map(|part| (line, part)));
        }
        spans
    }

    pub fn headings(&self) -> Vec<&str> {
        self.prose().into_iter().filter_map(|(_, line)| heading(line)).collect()
    }

    pub fn links(&self) -> Vec<(usize, &str)> {
        let mut links = Vec::new();
        for (line, text) in self.prose() {
            links.extend(text.split("](").skip(1).filter_map(|rest| Some((line, rest.split_once(')')?.0))));
        }
        links
    }
}

pub fn heading(line: &str) -> Option<&str> {
    let text = line.trim_start_matches('#');
    (line.starts_with('#') && text.starts_with(' ')).then(|| text.trim())
}

pub fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

pub fn cells(line: &str) -> Option<Vec<&str>> {
    let row = line.strip_prefix("| ")?.strip_suffix(" |")?;
    Some(row.split(" | ").map(str::trim).collect())
}
