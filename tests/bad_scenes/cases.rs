//! Reads `cases.toml` and the scenes in `base`.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

pub const FOLDER: &str = "tests/bad_scenes";

pub struct Case {
    pub scene: String,
    pub line: usize,
    pub message: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    base: Option<String>,
    #[serde(default)]
    replace: Vec<(String, String)>,
    #[serde(default)]
    insert: Vec<(String, String)>,
    add: Option<String>,
    scene: Option<String>,
    at: Option<String>,
    line: Option<usize>,
    message: String,
}

impl Entry {
    fn case(self, name: &str, bases: &BTreeMap<String, String>) -> Case {
        let scene = match (&self.base, &self.scene) {
            (Some(base), None) => {
                let text = bases.get(base).unwrap_or_else(|| panic!("{name}: there is no base `{base}`"));
                self.changed(name, text)
            }
            (None, Some(scene)) => scene.clone(),
            _ => panic!("{name}: expected either `base` or `scene`"),
        };
        let line = match (&self.at, self.line) {
            (Some(at), None) => index_of(at, &scene, name) + 1,
            (None, Some(line)) => line,
            _ => panic!("{name}: expected either `at` or `line`"),
        };
        Case { scene, line, message: self.message }
    }

    fn changed(&self, name: &str, base: &str) -> String {
        let mut scene = base.to_owned();
        for (old, new) in &self.replace {
            assert_eq!(scene.matches(old).count(), 1, "{name}: `{old}` must occur once in the base");
            scene = scene.replace(old, new);
        }
        for (line, inserted) in &self.insert {
            let index = index_of(line, &scene, name);
            let mut lines: Vec<&str> = scene.lines().collect();
            lines.insert(index + 1, inserted);
            scene = lines.join("\n") + "\n";
        }
        match &self.add {
            Some(add) => format!("{scene}\n{add}"),
            None => scene,
        }
    }
}

fn index_of(line: &str, scene: &str, name: &str) -> usize {
    let indices: Vec<usize> = (0..).zip(scene.lines()).filter(|(_, other)| *other == line).map(|(i, _)| i).collect();
    assert_eq!(indices.len(), 1, "{name}: the line `{line}` must occur once in\n{scene}");
    indices[0]
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

pub fn bases() -> BTreeMap<String, String> {
    let paths = std::fs::read_dir(Path::new(FOLDER).join("base")).unwrap().map(|entry| entry.unwrap().path());
    paths.map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), read(&path))).collect()
}

pub fn cases() -> BTreeMap<String, Case> {
    let entries: BTreeMap<String, Entry> = toml::from_str(&read(&Path::new(FOLDER).join("cases.toml"))).unwrap();
    let bases = bases();
    entries
        .into_iter()
        .map(|(name, entry)| {
            let case = entry.case(&name, &bases);
            (name, case)
        })
        .collect()
}
