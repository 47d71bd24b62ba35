//! Doc comments begin with the noun that they are about.

use std::fs;
use std::path::Path;

use crate::markdown::root;

/// Words that stand for a noun which is not there.
const VAGUE: [&str; 3] = ["What", "Those", "The same"];

/// Whether a paragraph begins with one of these words.
fn is_vague(paragraph: &str) -> bool {
    let after = |word| paragraph.strip_prefix(word).map(|rest: &str| rest.chars().next());
    VAGUE.into_iter().filter_map(after).any(|next| next.is_none_or(|letter| !letter.is_alphanumeric()))
}

/// Line numbers and texts of the paragraphs of doc comments in a Rust source.
fn in_rust(text: &str) -> Vec<(usize, &str)> {
    let (mut found, mut is_within) = (Vec::new(), false);
    for (number, line) in (1..).zip(text.lines().map(str::trim_start)) {
        let comment = line.strip_prefix("/// ").or_else(|| line.strip_prefix("//! "));
        found.extend(comment.filter(|_| !is_within).map(|begin| (number, begin)));
        is_within = comment.is_some();
    }
    found
}

/// Line numbers and texts of the docstrings in a Python source.
fn in_python(text: &str) -> Vec<(usize, &str)> {
    let lines = (1..).zip(text.lines().map(str::trim_start));
    lines.filter_map(|(number, line)| line.strip_prefix("\"\"\"").map(|begin| (number, begin))).collect()
}

/// Vague comments in all sources below a folder.
fn collect(folder: &Path, found: &mut Vec<(String, usize)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if !name.starts_with('.') && name != "target" {
                collect(&path, found);
            }
            continue;
        }
        let read = || fs::read_to_string(&path).unwrap();
        let text = if name.ends_with(".rs") || name.ends_with(".py") { read() } else { continue };
        let paragraphs = if name.ends_with(".rs") { in_rust(&text) } else { in_python(&text) };
        let vague = paragraphs.into_iter().filter(|(_, paragraph)| is_vague(paragraph));
        found.extend(vague.map(|(line, _)| (path.display().to_string(), line)));
    }
}

#[test]
fn doc_comments_begin_with_a_noun() {
    let mut found = Vec::new();
    for folder in ["src", "tests", "benches", "examples", "python", "fuzz"] {
        collect(&root().join(folder), &mut found);
    }
    assert!(found.is_empty(), "begin with the noun, not with {VAGUE:?}: {found:#?}");
}

#[test]
fn a_vague_comment_would_be_noticed() {
    let rust = "    /// What it is.\n    ///\n    /// Those too.\n    /// What goes on.\n//! The same.\n/// Whatever\n";
    let vague = |found: Vec<(usize, &str)>| -> Vec<usize> {
        found.into_iter().filter(|(_, text)| is_vague(text)).map(|(line, _)| line).collect()
    };
    assert_eq!(vague(in_rust(rust)), [1, 3]);
    assert_eq!(vague(in_rust("//! The same\n\n/// A\n/// What\n")), [1]);
    assert_eq!(vague(in_python("\"\"\"What it is.\"\"\"\n    \"\"\"Thoseness\n    What\n")), [1]);
}
