//! Checks that all dependencies have licences compatible with Carom's, and that `THIRD-PARTY.md` lists all crates in
//! the program and the Python package. After a change of `Cargo.lock`, `CAROM_WRITE_NOTICE=1 cargo test --test
//! licences` rewrites `THIRD-PARTY.md`.

#![cfg(target_os = "linux")]

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Licences that require at most that copies keep a notice.
const PERMISSIVE: [&str; 14] = [
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unicode-DFS-2016",
    "Unlicense",
    "Zlib",
    "bzip2-1.0.6",
];

/// Licences that also require changes to the licensed files to be published.
const BY_FILE: [(&str, &str); 1] = [("priority-queue", "MPL-2.0")];

const NOTICE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/THIRD-PARTY.md");

#[derive(Debug, Clone)]
struct Crate {
    name: String,
    version: String,
    licence: String,
    authors: String,
    source: String,
    folder: String,
    is_built_in: bool,
}

/// Returns all dependencies on Linux, sorted by name and version.
fn dependencies() -> Vec<Crate> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let arguments = "metadata --format-version 1 --locked --filter-platform x86_64-unknown-linux-gnu";
    let ask = |more: &[&str]| {
        let words = arguments.split(' ').chain(more.iter().copied());
        Command::new(&cargo).args(words).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
    };
    // The first attempt is offline. The second attempt may download crates for the Python package.
    let offline = ask(&["--offline"]);
    let output = if offline.status.success() { offline } else { ask(&[]) };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let nodes: HashMap<String, &Value> =
        metadata["resolve"]["nodes"].as_array().unwrap().iter().map(|node| (text(&node["id"]), node)).collect();
    let own: BTreeSet<String> = metadata["workspace_members"].as_array().unwrap().iter().map(text).collect();
    let mut built_in = own.clone();
    let mut open: Vec<String> = own.iter().cloned().collect();
    while let Some(id) = open.pop() {
        for dependency in nodes[&id]["deps"].as_array().unwrap() {
            // Normal dependencies have the kind `null`. Dependencies of tests and build scripts have other kinds.
            let is_normal = dependency["dep_kinds"].as_array().unwrap().iter().any(|kind| kind["kind"].is_null());
            let id = text(&dependency["pkg"]);
            if is_normal && built_in.insert(id.clone()) {
                open.push(id);
            }
        }
    }
    let packages = metadata["packages"].as_array().unwrap().iter();
    let used =
        packages.filter(|package| nodes.contains_key(&text(&package["id"])) && !own.contains(&text(&package["id"])));
    let mut crates: Vec<Crate> = used
        .map(|package| Crate {
            name: text(&package["name"]),
            version: text(&package["version"]),
            licence: text(&package["license"]),
            authors: package["authors"].as_array().unwrap().iter().map(text).collect::<Vec<_>>().join(", "),
            source: text(&package["repository"]),
            folder: Path::new(&text(&package["manifest_path"])).parent().unwrap().to_string_lossy().into_owned(),
            is_built_in: built_in.contains(&text(&package["id"])),
        })
        .collect();
    crates.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    crates
}

/// Returns whether the licences satisfy an expression such as `(MIT OR Apache-2.0) AND Unicode-3.0`.
fn is_met(expression: &str, licences: &[&str]) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let is_met = any(&words, &mut at, licences);
    is_met && at == words.len()
}

fn any(words: &[&str], at: &mut usize, licences: &[&str]) -> bool {
    let mut is_met = all(words, at, licences);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        is_met |= all(words, at, licences);
    }
    is_met
}

fn all(words: &[&str], at: &mut usize, licences: &[&str]) -> bool {
    let mut is_met = one(words, at, licences);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        is_met &= one(words, at, licences);
    }
    is_met
}

fn one(words: &[&str], at: &mut usize, licences: &[&str]) -> bool {
    let Some(word) = words.get(*at) else { return false };
    *at += 1;
    if *word == "(" {
        let is_met = any(words, at, licences);
        *at += 1;
        return is_met;
    }
    if words.get(*at) == Some(&"WITH") {
        // An exception after `WITH` only grants more rights.
        *at += 2;
    }
    licences.contains(word)
}

fn line(it: &Crate) -> String {
    format!("| {} | {} | {} | {} |", it.name, it.version, it.licence, it.source)
}

/// Returns the licence texts and notices of a crate. Prefers MIT, then MPL-2.0, then Apache-2.0.
fn texts(it: &Crate) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(&it.folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| {
            ["LICENSE", "LICENCE", "COPYING", "NOTICE", "COPYRIGHT"]
                .iter()
                .any(|word| name.to_uppercase().starts_with(word))
        })
        .filter(|name| Path::new(&it.folder).join(name).is_file())
        .collect();
    names.sort();
    let is_enough = |word: &str| is_met(&it.licence, &[word]);
    for (word, part) in [("MIT", "MIT"), ("MPL-2.0", "MPL"), ("Apache-2.0", "APACHE")] {
        if is_enough(word) && names.iter().any(|name| name.to_uppercase().contains(part)) {
            names.retain(|name| name.to_uppercase().contains(part) || name.to_uppercase().starts_with("NOTICE"));
            break;
        }
    }
    let read = |name: &String| fs::read_to_string(Path::new(&it.folder).join(name)).unwrap_or_default();
    names.iter().map(read).map(|text| text.trim_end().replace("\r\n", "\n")).filter(|text| !text.is_empty()).collect()
}

fn notice(crates: &[Crate]) -> String {
    let mut text = "# Third-party software\n\n\
        The program `carom` and the Python package are built from these crates, each under its own licence; where several are joined by `OR`, Carom uses the first \
        of MIT, MPL-2.0 and Apache-2.0 that is among them. `priority-queue` is used as published: its source is at the address beside it. \
        The list is for a build on Linux; on other systems, a few crates for the operating system differ.\n\n\
        Letters in pictures and movies are a part of the font Inter, (c) The Inter Project Authors, under the SIL Open Font License 1.1: \
        `src/view/render/letters/OFL.txt`.\n\n\
        Written by `CAROM_WRITE_NOTICE=1 cargo test --test licences`.\n\n\
        | crate | version | licence | source |\n|---|---|---|---|\n"
        .to_owned();
    let mut users: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for it in crates.iter().filter(|it| it.is_built_in) {
        text += &(line(it) + "\n");
        let mut texts = texts(it);
        if texts.is_empty() {
            let addresses: Vec<String> = (it.licence.split_whitespace())
                .filter(|word| !["OR", "AND", "WITH"].contains(word))
                .map(|word| format!("https://spdx.org/licenses/{}.html", word.trim_matches(['(', ')'])))
                .collect();
            texts.push(format!(
                "{}, by {}. The package has no text of it; it is at {}. The source of the crate is at {}",
                it.licence,
                it.authors,
                addresses.join(" and "),
                it.source
            ));
        }
        for licence in texts {
            users.entry(licence).or_default().push(it.name.clone());
        }
    }
    let mut groups: Vec<(Vec<String>, String)> = users.into_iter().map(|(licence, users)| (users, licence)).collect();
    groups.sort();
    for (users, licence) in groups {
        text += &format!("\n## {}\n\n````text\n{licence}\n````\n", users.join(", "));
    }
    text
}

#[test]
fn expressions_of_licences_are_understood() {
    let mit = ["MIT"];
    assert!(is_met("MIT", &mit) && is_met("MIT OR Apache-2.0", &mit) && is_met("Apache-2.0/MIT", &mit));
    assert!(!is_met("MIT AND Apache-2.0", &mit) && !is_met("GPL-3.0", &mit) && !is_met("", &mit));
    assert!(!is_met("(MIT OR Apache-2.0) AND Unicode-3.0", &mit));
    assert!(is_met("(MIT OR Apache-2.0) AND Unicode-3.0", &["Apache-2.0", "Unicode-3.0"]));
    assert!(is_met("Apache-2.0 WITH LLVM-exception OR MIT", &mit));
}

#[test]
fn every_dependency_has_a_licence_that_is_allowed() {
    for it in dependencies() {
        let by_file = BY_FILE.iter().filter(|(name, _)| *name == it.name).map(|(_, licence)| *licence);
        let allowed: Vec<&str> = PERMISSIVE.into_iter().chain(by_file).collect();
        assert!(is_met(&it.licence, &allowed), "{} {} is under {:?}", it.name, it.version, it.licence);
    }
}

#[test]
fn the_notice_names_all_that_the_program_is_built_from() {
    let crates = dependencies();
    if std::env::var_os("CAROM_WRITE_NOTICE").is_some() {
        fs::write(NOTICE, notice(&crates)).unwrap();
    }
    let text = fs::read_to_string(NOTICE).unwrap();
    let found: BTreeSet<&str> =
        text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| crate ")).collect();
    let lines: Vec<String> = crates.iter().filter(|it| it.is_built_in).map(line).collect();
    let expected: BTreeSet<&str> = lines.iter().map(String::as_str).collect();
    assert!(expected.len() > 20, "{expected:?}");
    assert!(
        found == expected,
        "CAROM_WRITE_NOTICE=1 cargo test --test licences writes it again\nmissing: {:#?}\ntoo many: {:#?}",
        expected.difference(&found).collect::<Vec<_>>(),
        found.difference(&expected).collect::<Vec<_>>()
    );
    for it in crates.iter().filter(|it| it.is_built_in) {
        let heads = text.lines().filter_map(|line| line.strip_prefix("## "));
        assert!(heads.flat_map(|line| line.split(", ")).any(|name| name == it.name), "no text for {}", it.name);
    }
}
