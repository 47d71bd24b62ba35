//! Rust code in the documents is taken from the programs in `examples/`, which are compiled and tested.

use std::fs;

use crate::markdown::{pages, root};

fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

/// Whether a program contains all pieces in this order. The lines of each piece must be consecutive.
fn has_pieces(program: &[&str], pieces: &[Vec<&str>]) -> bool {
    let mut rest = program;
    pieces.iter().all(|piece| {
        let at = rest.windows(piece.len()).position(|lines| lines == piece.as_slice());
        at.map(|at| rest = &rest[at + piece.len()..]).is_some()
    })
}

#[test]
fn every_block_of_rust_is_part_of_an_example() {
    let folder = fs::read_dir(root().join("examples")).unwrap();
    let programs: Vec<String> = folder.map(|entry| fs::read_to_string(entry.unwrap().path()).unwrap()).collect();
    let mut count = 0;
    for page in pages() {
        for block in page.blocks().iter().filter(|block| block.info == "rust") {
            // The comment `// ...` in a document stands for omitted code.
            let code = lines(&block.text);
            let pieces: Vec<Vec<&str>> = code.split(|line| *line == "// ...").map(<[&str]>::to_vec).collect();
            let is_there = programs.iter().any(|program| has_pieces(&lines(program), &pieces));
            assert!(is_there, "{}:{}: no example has this code", page.path, block.line);
            count += 1;
        }
    }
    assert!(count >= 3, "{count} blocks");
}
