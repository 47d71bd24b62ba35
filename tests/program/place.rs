use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use super::files::files;
use carom::io::OutputError;
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

/// Without the TC model, the bounces of the ball end in an inelastic collapse.
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

    /// Starts the program without its output.
    pub fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// Runs the program and asserts that it succeeds.
    #[track_caller]
    pub fn done(&self, arguments: &[&str]) -> Output {
        let output = self.carom(arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", errors(&output));
        output
    }

    /// Runs the program and asserts that it rejects its input with a message that contains each expected text.
    #[track_caller]
    pub fn refused(&self, arguments: &[&str], expected: &[&str]) {
        let output = self.carom(arguments);
        let message = line(&output);
        assert_eq!(code(&output), 2, "{arguments:?}: {message}");
        expected.iter().for_each(|text| assert!(message.contains(text), "{arguments:?} lacks `{text}`: {message}"));
    }

    pub fn write(&self, file: &str, text: &str) {
        fs::write(self.path().join(file), text).unwrap();
    }

    pub fn read(&self, file: &str) -> String {
        fs::read_to_string(self.path().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    pub fn measured(&self, folder: &str) -> String {
        let thermo = self.read(&format!("{folder}/thermo.csv"));
        let is_wanted = |(index, line): &(usize, &str)| *index == 0 || line.ends_with(",measurement");
        thermo.lines().enumerate().filter(is_wanted).map(|(_, line)| format!("{line}\n")).collect()
    }

    /// The rows of `thermo.csv`: cells by the name of their column.
    pub fn thermo(&self, folder: &str) -> Vec<BTreeMap<String, String>> {
        let text = self.read(&format!("{folder}/thermo.csv"));
        let mut lines = text.lines().map(|line| line.split(','));
        let heads: Vec<&str> = lines.next().unwrap().collect();
        lines.map(|row| heads.iter().zip(row).map(|(head, cell)| ((*head).into(), cell.into())).collect()).collect()
    }

    pub fn summary(&self, folder: &str) -> Value {
        serde_json::from_str(&self.read(&format!("{folder}/summary.json"))).unwrap()
    }
}

pub fn run(place: &Place, arguments: &[&str]) {
    place.done(&[&["run", "-q"], arguments].concat());
}

/// Starts and kills a program until it finishes before the kill. Returns the number of kills. After `patience` kills,
/// the time before the next kill is doubled each time, so that the program finishes on any machine.
pub fn kill_until_done(patience: u64, start: impl Fn() -> Child) -> u64 {
    let (mut kills, mut wait) = (0, 20);
    loop {
        let mut child = start();
        std::thread::sleep(Duration::from_millis(wait));
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success());
            return kills;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
        wait = if kills < patience { 20 + 13 * (kills % 7) } else { 2 * wait };
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

/// Returns all files in a folder except `.carom`.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut contents = files(folder);
    contents.retain(|name, _| name.rsplit('/').next() != Some(".carom"));
    contents
}

pub fn line(output: &Output) -> String {
    errors(output).replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Starts a long run and waits for its first checkpoint.
pub fn begun(place: &Place, more: &[&str]) -> Child {
    let folder = if more.contains(&"--force") { "runs/scene/replacement" } else { "runs/scene" };
    let checkpoint = place.path().join(folder).join("checkpoint");
    let before = std::fs::read(&checkpoint).ok();
    let mut arguments = vec!["run", "scene.toml", "-q", "--until-time", "1e6", "--checkpoint-every", "0.01"];
    arguments.extend(["--set", "output.thermo_interval=10.0"]);
    arguments.extend(more);
    let child = place.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until(|| std::fs::read(&checkpoint).is_ok_and(|now| Some(&now) != before.as_ref()));
    child
}

pub fn send_signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// Waits for a condition, at most for about five minutes. Returns whether it is true.
pub fn wait_until(mut is_true: impl FnMut() -> bool) -> bool {
    (0..60_000).any(|_| {
        std::thread::sleep(Duration::from_millis(5));
        is_true()
    })
}

pub fn killed(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

pub fn ended(place: &Place, folder: &str) -> Output {
    let to = |events: u64| place.carom(&["run", "--resume", folder, "--until-events", &events.to_string()]);
    let output = to(1);
    let message = line(&output);
    let measured = message.split_once("has measured ").and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
    measured.map_or(output, |events: u64| to(events + 1))
}

/// Opens files, and tries again while the files are locked. When another test starts a program, the new process
/// inherits the locks for a short time.
pub fn when_free<T>(open: impl Fn() -> Result<T, OutputError>) -> T {
    for _ in 0..1000 {
        match open() {
            Err(OutputError::Busy(_)) => std::thread::sleep(Duration::from_millis(5)),
            opened => return opened.unwrap(),
        }
    }
    open().unwrap()
}
