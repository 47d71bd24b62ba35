//! A folder of its own in which the program is called.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

pub const FLUID: &str = r#"
[[species]]
name = "sphere"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["sphere", "sphere"]
potential = "hard-sphere"

[[fill]]
species = "sphere"
arrangement = "fcc"
count = 108
packing_fraction = 0.3
temperature = 1.0

[run]
equilibration_events = 500
until_events = 4000
"#;

/// A ball that collapses onto the floor: nothing makes its contacts elastic.
pub const COLLAPSE: &str = r#"
[space]
size = [4.0, 4.0, 4.0]
x = "open"
y = "open"
z = { lower = "wall", upper = "open", restitution = 0.5 }

[dynamics]
gravity = [0.0, 0.0, -1.0]

[[species]]
name = "ball"
mass = 1.0
diameter = 1.0

[[particle]]
species = "ball"
position = [2.0, 2.0, 1.5]

[run]
until_time = 10.0

[output]
thermo_interval = 0.5
"#;

pub struct Place(tempfile::TempDir);

impl Place {
    /// A folder of its own with a scene in it.
    pub fn with(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        Self(folder)
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(arguments).current_dir(self.path()).env("NO_COLOR", "1");
        command
    }

    pub fn carom(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    pub fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    /// `thermo.csv` of a run with the rows of its measured stretch only.
    pub fn measured(&self, folder: &str) -> String {
        let thermo = self.read(&format!("{folder}/thermo.csv"));
        let is_wanted = |(index, line): &(usize, &str)| *index == 0 || line.ends_with(",measurement");
        thermo.lines().enumerate().filter(is_wanted).map(|(_, line)| format!("{line}\n")).collect()
    }

    pub fn summary(&self, folder: &str) -> Value {
        serde_json::from_str(&self.read(&format!("{folder}/summary.json"))).unwrap()
    }
}

pub fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

pub fn sorted(mut words: Vec<&str>) -> Vec<&str> {
    words.sort_unstable();
    words
}
