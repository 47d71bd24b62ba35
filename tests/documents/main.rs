//! Checks that the documents agree with the program: keys, links, commands, scenes and file names.

mod examples;
mod keys;
mod markdown;
mod scenes;
#[path = "../schema/validator.rs"]
mod validator;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use markdown::{Page, anchor, pages, root};

#[test]
fn the_readme_leads_to_every_page() {
    let readme = Page::of("README.md");
    let targets: BTreeSet<&str> = readme.links().into_iter().map(|(_, target)| target).collect();
    for page in pages().iter().skip(1) {
        assert!(targets.contains(page.path.as_str()), "README.md has no link to {}", page.path);
    }
}

#[test]
fn every_relative_link_leads_to_a_file_and_a_heading() {
    let pages = pages();
    let anchors: BTreeMap<String, BTreeSet<String>> = pages
        .iter()
        .map(|page| (page.path.clone(), page.headings().iter().map(|heading| anchor(heading)).collect()))
        .collect();
    let mut broken = Vec::new();
    let mut count = 0;
    for page in &pages {
        let folder = Path::new(&page.path).parent().unwrap();
        for (line, target) in page.links().into_iter().filter(|(_, target)| !target.contains("://")) {
            count += 1;
            let (file, heading) =
                target.split_once('#').map_or((target, None), |(file, heading)| (file, Some(heading)));
            let path = if file.is_empty() { page.path.clone() } else { plain(&folder.join(file)) };
            let is_there = match heading {
                None => root().join(&path).exists(),
                Some(heading) => anchors.get(&path).is_some_and(|known| known.contains(heading)),
            };
            if !is_there {
                broken.push(format!("{}:{line}: {target}", page.path));
            }
        }
    }
    assert!(broken.is_empty(), "these links lead nowhere:\n{}", broken.join("\n"));
    assert!(count > 50, "{count} links");
}

/// Resolves each `..` in a path.
fn plain(path: &Path) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.to_str().unwrap().split('/') {
        match part {
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// Returns the lines of inline code and of code blocks without a language, with their positions.
fn lines() -> Vec<(String, String)> {
    let mut lines = Vec::new();
    for page in pages() {
        for block in page.blocks().iter().filter(|block| block.info.is_empty()) {
            let numbered = block.text.lines().enumerate();
            lines.extend(numbered.map(|(k, line)| (format!("{}:{}", page.path, block.line + k), line.to_owned())));
        }
        lines.extend(page.spans().into_iter().map(|(line, code)| (format!("{}:{line}", page.path), code.to_owned())));
    }
    lines
}

/// Returns the arguments of a command up to a comment or a redirection, or `None` if the line has another command.
fn arguments<'a>(line: &'a str, command: &str) -> Option<Vec<&'a str>> {
    let words = line.strip_prefix(command)?.split_whitespace();
    Some(words.take_while(|word| !word.starts_with(['#', '>'])).collect())
}

#[test]
fn every_documented_carom_command_is_valid() {
    let mut count = 0;
    for (place, line) in lines() {
        let Some(words) = arguments(&line, "carom ").or_else(|| arguments(&line, "cargo run --release -- ")) else {
            continue;
        };
        // KIND is a placeholder. With `--help`, the program does not execute the command.
        let words: Vec<&str> = words.into_iter().filter(|word| *word != "KIND").collect();
        let output = Command::new(env!("CARGO_BIN_EXE_carom")).args(&words).arg("--help").output().unwrap();
        assert!(output.status.success(), "{place}: {line}\n{}", String::from_utf8_lossy(&output.stderr));
        for scene in words.iter().filter(|word| word.starts_with("configs/")) {
            assert!(root().join(scene).exists(), "{place}: there is no {scene}");
        }
        count += 1;
    }
    assert!(count > 20, "{count} commands");
}

#[test]
fn every_documented_option_exists() {
    let help = |command: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_carom")).args(["help", command]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let commands =
        ["run", "sweep", "check", "verify", "validate", "render", "movie", "convert", "report", "new", "schema"];
    let helps: String = commands.iter().map(|command| help(command)).collect();
    let options: BTreeSet<&str> = helps.split_whitespace().filter(|word| word.starts_with("--")).collect();
    assert!(options.len() > 15, "{options:?}");
    for (place, line) in lines().iter().filter(|(_, line)| line.starts_with("--")) {
        let option = line.split([' ', '=']).next().unwrap();
        assert!(options.contains(option), "{place}: {option} is no option of any command");
    }
}

#[test]
fn every_documented_test_benchmark_and_example_exists() {
    let mut count = 0;
    for (place, line) in lines() {
        let Some(words) = arguments(&line, "cargo ") else { continue };
        for pair in words.windows(2) {
            let folder = match pair[0] {
                "--test" => "tests",
                "--bench" => "benches",
                "--example" => "examples",
                _ => continue,
            };
            let stem = root().join(folder).join(pair[1]);
            assert!(stem.with_extension("rs").exists() || stem.join("main.rs").exists(), "{place}: {line}");
            count += 1;
        }
    }
    assert!(count > 5, "{count} commands");
}

const FOLDERS: [&str; 8] = ["tests/", "benches/", "configs/", "docs/", "examples/", "fuzz/", "src/", ".ci/"];

const LAYERS: [&str; 6] = ["analysis/", "check/", "engine/", "physics/", "prepare/", "scene/"];

#[test]
fn every_file_of_the_repository_that_is_named_is_there() {
    let mut count = 0;
    for page in pages() {
        for (line, code) in page.spans() {
            let path = code.split_whitespace().next().unwrap_or_default();
            let is_module =
                (path.ends_with(".rs") || LAYERS.iter().any(|layer| path.starts_with(layer))) && !path.contains("::");
            if is_module || FOLDERS.iter().any(|folder| path.starts_with(folder)) {
                let is_there = root().join(path).exists() || root().join("src").join(path).exists();
                assert!(is_there, "{}:{line}: there is no {path}", page.path);
                count += 1;
            }
        }
    }
    assert!(count > 20, "{count} paths");
}

/// Returns the pairs of a name and a file in texts such as "`name` in `file`".
fn names_in_files(text: &str) -> Vec<(&str, &str)> {
    let pairs = text.match_indices("` in `").filter_map(|(at, mark)| {
        let name = text[..at].rsplit('`').next()?;
        let file = text[at + mark.len()..].split('`').next()?;
        file.ends_with(".rs").then_some((name, file))
    });
    pairs.collect()
}

#[test]
fn every_name_attributed_to_a_file_occurs_in_it() {
    let mut count = 0;
    for page in pages() {
        let text = page.text.split_whitespace().collect::<Vec<_>>().join(" ");
        for (name, file) in names_in_files(&text) {
            let path = [root().join(file), root().join("src").join(file)].into_iter().find(|path| path.exists());
            let source = fs::read_to_string(path.unwrap_or_default()).unwrap_or_default();
            assert!(source.contains(name), "{}: there is no {name} in {file}", page.path);
            count += 1;
        }
    }
    assert!(count >= 10, "{count} names");
}

#[test]
fn every_scene_is_in_the_list_of_scenes() {
    let list = Page::of("docs/scenes.md").text;
    for entry in fs::read_dir(root().join("configs")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(list.contains(&format!("| `{name}` |")), "docs/scenes.md does not say what {name} shows");
    }
}

#[test]
fn every_dependency_is_explained_in_the_documents() {
    let list = Page::of("docs/dependencies.md").text;
    let manifest: toml::Table = fs::read_to_string(root().join("Cargo.toml")).unwrap().parse().unwrap();
    let tables = [
        &manifest["dependencies"],
        &manifest["dev-dependencies"],
        &manifest["target"]["cfg(target_os = \"linux\")"]["dependencies"],
    ];
    let names = tables.iter().flat_map(|table| table.as_table().unwrap().keys());
    let missing: Vec<&String> = names.filter(|name| !list.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty(), "docs/dependencies.md does not say why these are used: {missing:?}");
}

#[test]
fn every_example_is_in_the_documents() {
    let page = Page::of("docs/library.md").text;
    for entry in fs::read_dir(root().join("examples")).unwrap() {
        let name = entry.unwrap().file_name();
        let link = format!("(../examples/{})", name.to_str().unwrap());
        assert!(page.contains(&link), "docs/library.md has no link {link}");
    }
}

#[test]
fn the_citation_is_of_this_version() {
    let citation = fs::read_to_string(root().join("CITATION.cff")).unwrap();
    let version = format!("version: {}", env!("CARGO_PKG_VERSION"));
    assert!(citation.lines().any(|line| line == version), "CITATION.cff has no line `{version}`");
}
