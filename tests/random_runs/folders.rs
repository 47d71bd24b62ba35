//! Runs, sweeps and exchanges in folders with links, damaged files and files of the user. Nothing outside the folder
//! may change, and each call must finish or return an error.

use std::collections::BTreeMap;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use carom::exchange::{ExchangeFolder, Opened};
use carom::io::{Existing, Folder, OutputError};
use carom::model::Scene;
use carom::run::Run;
use carom::sweep::{Axis, Orders, Results, Share, Sweep, SweepFolder};
use carom::view::{final_table, report};

use super::choices::{Choices, temporary};

const SCENE: &str = "
name = \"balls\"
[space]
size = [4.0, 4.0, 4.0]
[[species]]
name = \"ball\"
mass = 1.0
diameter = 1.0
[[interaction]]
species = [\"ball\", \"ball\"]
potential = \"hard-sphere\"
[[particle]]
species = \"ball\"
position = [1.0, 2.0, 2.0]
velocity = [1.0, 0.25, 0.0]
[[particle]]
species = \"ball\"
position = [3.0, 2.0, 2.0]
";

const RUN: &str = "
[run]
until_time = 20.0
[measure]
radial_distribution = true
[output]
frame_interval = 5.0
contacts = true
events = true
formats = [\"csv\", \"npy\"]
";

const EXCHANGE: &str = "
[run]
until_time = 4.0
[exchange]
temperatures = [1.0, 1.5]
interval = 1.0
rate = 1.0
";

const NAMES: [&str; 34] = [
    ".carom",
    ".exchange",
    "checkpoint",
    "checkpoint.previous",
    "checkpoint.partial",
    "thermo.csv",
    "thermo.csv.partial",
    "trajectory.xyz",
    "trajectory.xyz.partial",
    "contacts.csv",
    "contacts.csv.partial",
    "events",
    "events/time.npy",
    "measurements",
    "measurements.json",
    "measurements.json.partial",
    "scene.toml",
    "scene.toml.partial",
    "summary.json",
    "summary.json.partial",
    "summary.json.before",
    "report.txt",
    "report.txt.partial",
    "report.html",
    "report.html.partial",
    "trajectory.csv",
    "npy",
    "sweep.toml",
    "sweep.csv",
    "failures",
    "seed-1",
    "seed-1/.carom",
    "exchange.checkpoint",
    "exchange.csv.partial",
];

const WRITTEN: [&str; 8] = [
    ".carom",
    "checkpoint.partial",
    "summary.json.partial",
    "report.txt.partial",
    "thermo.csv.partial",
    "exchange.checkpoint.partial",
    "exchange.csv.partial",
    ".exchange",
];

/// Files of the user outside the folder, which are the targets of links.
const OTHERS: [&str; 3] = ["thesis.tex", "data/rows.csv", "data/.carom"];

/// A change of a file between two calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    Nothing,
    Remove,
    Cut,
    Flip,
    Foreign,
    Folder,
    Link,
    LinkToFolder,
    LinkToNothing,
}

impl Change {
    pub const ALL: [Self; 9] = [
        Self::Nothing,
        Self::Remove,
        Self::Cut,
        Self::Flip,
        Self::Foreign,
        Self::Folder,
        Self::Link,
        Self::LinkToFolder,
        Self::LinkToNothing,
    ];
}

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(temporary());
        fs::create_dir_all(place.outside().join("data")).expect("a folder");
        for name in OTHERS {
            fs::write(place.outside().join(name), format!("years of work: {name}\n")).expect("a file");
        }
        place
    }

    fn outside(&self) -> PathBuf {
        self.0.path().join("home")
    }

    fn out(&self) -> PathBuf {
        self.0.path().join("out")
    }

    fn others(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut found = BTreeMap::new();
        let mut folders = vec![self.0.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
                let path = entry.path();
                if path == self.out() {
                    continue;
                }
                let is_folder = path.is_dir();
                if is_folder {
                    folders.push(path.clone());
                }
                found.insert(path.clone(), (!is_folder).then(|| fs::read(&path).unwrap_or_default()));
            }
        }
        found
    }

    fn change(&self, choices: &mut Choices<'_>, changes: &[Change]) -> (&'static str, Change) {
        let name = if choices.once_in(2) { choices.pick(&WRITTEN) } else { choices.pick(&NAMES) };
        let change = choices.pick(changes);
        let path = self.out().join(name);
        let parent = path.parent().unwrap_or(&path).to_owned();
        if parent.is_symlink() {
            // A temporary file in a linked folder would be outside of `out`.
            return (name, Change::Nothing);
        }
        let content = if path.is_symlink() { None } else { fs::read(&path).ok() };
        if change != Change::Nothing {
            let _ = fs::create_dir_all(parent);
            if change != Change::Folder || path.is_symlink() || !path.is_dir() {
                let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
            }
        }
        let other = self.outside().join(choices.pick(&OTHERS));
        let at = choices.byte();
        match change {
            Change::Nothing | Change::Remove => {}
            Change::Cut => {
                let content = content.unwrap_or_default();
                let _ = fs::write(&path, &content[..content.len() * usize::from(at) / 256]);
            }
            Change::Flip => {
                let mut content = content.unwrap_or_else(|| vec![0; 64]);
                let place = content.len() * usize::from(at) / 256;
                if let Some(byte) = content.get_mut(place) {
                    *byte ^= 0x11;
                }
                let _ = fs::write(&path, content);
            }
            Change::Foreign => drop(fs::write(&path, "something else\n")),
            Change::Folder => {
                let _ = fs::create_dir_all(&path);
                if at % 2 == 1 {
                    let _ = fs::write(path.join("kept.txt"), "kept");
                }
            }
            Change::Link => link(&other, &path),
            Change::LinkToFolder => link(&self.outside().join("data"), &path),
            Change::LinkToNothing => link(&self.outside().join("nothing.txt"), &path),
        }
        (name, change)
    }
}

#[cfg(unix)]
fn link(to: &Path, path: &Path) {
    let _ = std::os::unix::fs::symlink(to, path);
}

#[cfg(not(unix))]
fn link(_to: &Path, _path: &Path) {}

#[derive(Debug, Clone, Copy)]
enum Call {
    Run,
    Replace,
    Resume,
    Sweep,
    Exchange,
    CutRun,
}

/// Makes two or three calls chosen by `bytes`, and changes files in between. Returns the number of finished calls.
/// Panics if a call panics, or if files outside the folder have changed.
pub fn judge(bytes: &[u8], changes: &[Change]) -> usize {
    let choices = &mut Choices::new(bytes);
    let place = Place::new();
    let before = place.others();
    let mut story = Vec::new();
    let mut over = 0;
    for _ in 0..choices.pick(&[2, 3]) {
        let calls = [Call::Run, Call::CutRun, Call::Sweep, Call::Exchange, Call::Replace, Call::Resume, Call::Replace];
        let call = choices.pick(&calls);
        let end = make(call, &place.out(), choices.pick(&[1, 3, 1000]));
        over += usize::from(end.is_ok());
        story.push(format!("{call:?}: {end:?}"));
        assert!(place.others() == before, "what is outside of the folder has changed: {story:#?}");
        for _ in 0..choices.pick(&[1, 2, 3]) {
            story.push(format!("{:?}", place.change(choices, changes)));
        }
    }
    over
}

fn make(call: Call, out: &Path, looks: u32) -> Result<(), String> {
    let made = |text: &str| (Scene::from_toml(text, "balls.toml").expect("a scene"), text.to_owned());
    match call {
        Call::Run | Call::CutRun | Call::Replace => {
            let (scene, text) = made(&format!("{SCENE}{RUN}"));
            let existing = if matches!(call, Call::Replace) { Existing::Replace } else { Existing::Keep };
            let begun = || -> Result<Folder, OutputError> {
                let mut folder = Folder::create(out, &scene, existing)?;
                folder.keep_scene(&text)?;
                Ok(folder)
            };
            let folder = begun().map_err(words)?;
            finish(out, folder, Run::new(scene.clone()), if matches!(call, Call::CutRun) { 0 } else { looks })
        }
        Call::Resume => {
            let (folder, checkpoint) = Folder::resume(out, None).map_err(words)?;
            finish(out, folder, Run::resume(checkpoint), looks)
        }
        Call::Sweep => {
            let (_, text) = made(&format!("{SCENE}{RUN}"));
            let axes = "seed=1..2".parse::<Axis>().into_iter().collect();
            let sweep = Sweep::of_text(text, "balls.toml", &[], axes).map_err(words)?;
            let opened = SweepFolder::open(out, &sweep).map_err(words)?;
            let orders = Orders {
                jobs: 1,
                share: Share::ALL,
                checkpoint_every: Duration::from_millis(1),
                most_bytes: f64::INFINITY,
                report: &final_table::text,
                instruments: &|run| run,
                instrument_names: &[],
            };
            opened.execute(&sweep, &orders, &|_, _| ControlFlow::Continue(())).map_err(words)?;
            let results = Results::read(&opened, &sweep);
            opened.write_tables(&sweep, &results).map_err(words)?;
            let page = report::sweep_page(&opened, &sweep, &results);
            report::write(&page, &report::sweep_page_in(out), Existing::Replace).map_err(words)
        }
        Call::Exchange => {
            let (scene, text) = made(&format!("{SCENE}{EXCHANGE}"));
            if let Opened::UnderWay(begun) = ExchangeFolder::open(out, scene, &text).map_err(words)? {
                let (mut folder, exchange) = *begun;
                let mut looks = looks;
                let exchange = exchange.execute(1, &mut folder, &mut |_| next(&mut looks)).map_err(words)?;
                folder.complete(&exchange).map_err(words)?;
            }
            let page = report::exchange_page(out).map_err(words)?;
            report::write(&page, &report::exchange_page_in(out), Existing::Replace).map_err(words)
        }
    }
}

fn finish(out: &Path, mut folder: Folder, run: Run, mut looks: u32) -> Result<(), String> {
    let is_killed = looks == 0;
    let finished = run.execute(&mut folder, &mut |_| next(&mut looks)).map_err(words)?;
    if is_killed {
        return Ok(());
    }
    folder.complete(&finished, &final_table::text(&finished)).map_err(words)?;
    let page = report::page(out).map_err(words)?;
    report::write(&page, &out.join("report.html"), Existing::Replace).map_err(words)
}

fn next(looks: &mut u32) -> ControlFlow<()> {
    *looks = looks.saturating_sub(1);
    if *looks == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

fn words(error: impl std::error::Error) -> String {
    carom::base::text::with_causes(&error)
}
