//! A folder with runs and other files of a user. Commands with faults run in copies of this folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::files::files;
use super::scenarios::Scenario;

/// A run with all kinds of output files. With 256 spheres, frames are written by a separate thread.
const SCENE: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "fcc"
count = 256
packing_fraction = 0.2
temperature = 1.0
[run]
equilibration_events = 100
until_time = 2.0
[measure]
pressure_tensor = true
radial_distribution = true
[output]
thermo_interval = 0.1
frame_interval = 0.5
contacts = true
events = true
formats = ["gsd", "npy"]
"#;

const PAIR: &str = r#"
[[species]]
name = "A"
mass = 1.3
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[fill]]
species = "A"
arrangement = "sc"
count = 8
number_density = 0.05
[exchange]
temperatures = [0.5, 1.0]
interval = 1.0
rate = 1.0
[run]
until_time = 20.0
[output]
frame_interval = 5.0
"#;

/// The kind of fault (`shim.c`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Kill,
    Fail,
    Torn,
    Full,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Kill, Self::Fail, Self::Torn, Self::Full];
}

pub type Files = BTreeMap<String, Vec<u8>>;

pub struct Place {
    folder: tempfile::TempDir,
    shim: PathBuf,
    /// Each trial starts with a copy of this folder.
    template: PathBuf,
}

impl Place {
    /// Prepares the runs, exchanges and other files that the commands need. Returns `None` if there is no C compiler.
    pub fn new() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let shim = folder.path().join("shim.so");
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults/shim.c");
        let mut compile = Command::new("cc");
        compile.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&shim).arg(source).arg("-ldl");
        let output = compile.output().ok()?;
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let template = folder.path().join("template");
        fs::create_dir(&template).unwrap();
        let place = Self { folder, shim, template };
        fs::write(place.template.join("scene.toml"), SCENE).unwrap();
        fs::write(place.template.join("pair.toml"), PAIR).unwrap();
        fs::write(place.template.join("thesis.tex"), "years of work").unwrap();
        let run = |seed, out| words(&format!("run scene.toml -q --seed {seed} --out {out} --checkpoint-every 0.001"));
        for (seed, out) in [("1", "one"), ("2", "two"), ("3", "cut"), ("3", "whole"), ("1", "long")] {
            place.done(&place.template, &run(seed, out));
        }
        // A new run with the later end would have other sampling times, because sampling times depend on the end.
        place.done(&place.template, &words("run -q --resume long --until-time 3.0"));
        place.cut();
        fs::write(place.template.join("one/notes.txt"), "my notes").unwrap();
        for (format, out) in [("vtk", "old-vtk"), ("npy", "old-npy"), ("csv", "old.csv")] {
            place.done(&place.template, &words(&format!("convert two --to {format} --out {out}")));
        }
        place.done(&place.template, &words("exchange pair.toml -q --jobs 1 --out pair"));
        place.done(&place.template, &words("exchange pair.toml -q --jobs 1 --out later --until-time 40"));
        place.done(
            &place.template,
            &words("sweep scene.toml -q --jobs 1 --vary seed=1,2 --set output.formats=[] --out sweep"),
        );
        place.done(&place.template, &words("report two --out old.html"));
        place.done(&place.template, &words("render two --size 64x48 --out old.png"));
        Some(place)
    }

    /// Changes a finished run as if it was killed just before its last files were renamed.
    fn cut(&self) {
        let cut = self.template.join("cut");
        fs::remove_file(cut.join("summary.json")).unwrap();
        for name in ["thermo.csv", "trajectory.xyz", "contacts.csv", "scene.toml", "events/time.npy"] {
            fs::rename(cut.join(name), cut.join(format!("{name}.partial"))).unwrap();
        }
    }

    fn command(&self, folder: &Path, arguments: &[String]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(arguments).current_dir(folder).env("NO_COLOR", "1");
        command
    }

    fn done(&self, folder: &Path, arguments: &[String]) -> Output {
        let output = self.command(folder, arguments).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {message}");
        output
    }

    /// Returns how often a command changes the disk, for example by a write or a rename.
    pub fn calls_of(&self, scenario: &Scenario) -> u64 {
        let (folder, log) = (self.copy(), self.folder.path().join("log"));
        let mut command = self.command(&folder, &words(scenario.command));
        command.env("LD_PRELOAD", &self.shim).env("FAULT_LOG", &log);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}: {}", scenario.name, String::from_utf8_lossy(&output.stderr));
        let calls = fs::read_to_string(&log).unwrap().parse().unwrap();
        assert!(calls > 2, "{}: {calls} calls", scenario.name);
        calls
    }

    fn copy(&self) -> PathBuf {
        let folder = self.folder.path().join("trial");
        let _ = fs::remove_dir_all(&folder);
        copy(&self.template, &folder);
        folder
    }

    /// Runs a command with a fault at one call. Checks that existing files are kept and that work can continue. Returns
    /// whether the command failed.
    pub fn meet(&self, scenario: &Scenario, kind: Kind, at: u64) -> bool {
        let what = format!("{}, {kind:?} at call {at}", scenario.name);
        let folder = self.copy();
        let before = files(&folder);
        let mut command = self.command(&folder, &words(scenario.command));
        command.env("LD_PRELOAD", &self.shim).env("FAULT_AT", at.to_string());
        let output = command.env("FAULT_KIND", format!("{kind:?}").to_lowercase()).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!message.contains("panicked"), "{what}: {message}");
        assert!(matches!(output.status.code(), None | Some(0..=2)), "{what}: {message}");
        let after = files(&folder);
        for (name, bytes) in &before {
            let is_touched =
                scenario.touches.iter().any(|touched| name.starts_with(touched)) && !name.ends_with("notes.txt");
            assert!(is_touched || after.get(name) == Some(bytes), "{what}: {name} is lost: {message}");
        }
        (scenario.kept)(&before, &after, &what);
        (scenario.go_on)(self, &folder, &what);
        let left = files(&folder);
        (scenario.check)(&left, &what);
        let draft = left.keys().find(|name| name.rsplit('/').next().is_some_and(|name| name.starts_with(".carom-")));
        assert!(draft.is_none(), "{what}: {draft:?} is left");
        !output.status.success()
    }

    pub fn try_to(&self, folder: &Path, command: &str) -> Output {
        self.command(folder, &words(command)).output().unwrap()
    }
}

pub fn words(text: &str) -> Vec<String> {
    text.split(' ').map(str::to_owned).collect()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}
