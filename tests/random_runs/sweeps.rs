//! Tests of sweeps with axes as users may type them, and of sweeps that change between or during calls.

use std::collections::BTreeSet;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::thread;
use std::time::Duration;

use carom::io::read_scene;
use carom::sweep::{Axis, Fate, Orders, Results, Share, Standing, Sweep, SweepError, SweepFolder};
use carom::view::{final_table, report};

use super::choices::{Choices, temporary};

const KEYS: [&str; 10] = [
    "seed",
    "species.0.mass",
    "run.until_events",
    "species.0.diameter",
    "particle.0.velocity",
    "interaction.0.restitution",
    "species.ball.mass",
    "name",
    "run.until_tmie",
    "seed; species.0.mass",
];

const VALUES: [&str; 24] = [
    "1",
    "2",
    "1..3",
    "0.5",
    "0.5..2.0/3",
    "1e-3..10/5/log",
    "7,9",
    "1.0",
    "1e1",
    "3..1",
    "1..1",
    "",
    ",",
    "1,,2",
    "x",
    "\"x\"",
    "[1, 0, 0]",
    "{ a = 1 }",
    "inf",
    "-1",
    "9223372036854775808",
    "..",
    "0.1..0.2/1000000",
    "1..3,2",
];

const SPELLED: [&str; 5] = ["+1", "0x1", "1_0", "01", "1.00"];

/// A scene of two balls. A replaced scene has another mass.
fn scene(mass: u8) -> String {
    format!(
        "name = \"balls\"\n[space]\nsize = [4.0, 4.0, 4.0]\n[[species]]\nname = \"ball\"\nmass = {mass}.0\ndiameter = 1.0\n\
        [[interaction]]\nspecies = [\"ball\", \"ball\"]\npotential = \"hard-sphere\"\n\
        [[particle]]\nspecies = \"ball\"\nposition = [1.0, 2.0, 2.0]\nvelocity = [1.0, 0.0, 0.0]\n\
        [[particle]]\nspecies = \"ball\"\nposition = [3.0, 2.0, 2.0]\n[run]\nuntil_events = 20\n"
    )
}

pub fn axes(choices: &mut Choices<'_>) -> Vec<String> {
    let count = choices.pick(&[1, 2, 3]);
    let list = |choices: &mut Choices<'_>| {
        let words: Vec<&str> = (0..choices.pick(&[1, 2, 3]))
            .map(|_| if choices.once_in(8) { choices.pick(&SPELLED) } else { choices.pick(&VALUES) })
            .collect();
        words.join(",")
    };
    let axis = |_| {
        let keys = choices.pick(&KEYS);
        let parts: Vec<String> = keys.split("; ").map(|key| format!("{key}={}", list(choices))).collect();
        parts.join("; ")
    };
    (0..count).map(axis).collect()
}

/// Plans a sweep with axes chosen by `bytes`, and returns the number of points. Panics if the text of an axis is parsed
/// to another axis, or if two points share a scene or a folder.
pub fn plan(bytes: &[u8]) -> Option<usize> {
    let axes: Vec<Axis> = axes(&mut Choices::new(bytes)).iter().filter_map(|text| text.parse().ok()).collect();
    for axis in &axes {
        assert_eq!(axis.to_string().parse().as_ref(), Ok(axis));
    }
    let sweep = Sweep::of_text(scene(1), "balls.toml", &[], axes).ok()?;
    let mut folders = BTreeSet::new();
    for point in sweep.points() {
        let name = point.folder();
        let is_plain =
            !name.is_empty() && !name.starts_with('.') && name.len() < 256 && !name.contains(['/', '\\', '\0']);
        assert!(is_plain, "a folder {name:?}");
        assert!(folders.insert(name.to_lowercase()), "the folder {name} twice");
    }
    sweep.check().ok()?;
    let scenes: Vec<String> =
        sweep.points().iter().take(50).filter_map(|point| Some(format!("{:?}", sweep.scene_at(point).ok()?))).collect();
    let different: BTreeSet<&String> = scenes.iter().collect();
    assert_eq!(different.len(), scenes.len(), "runs that are the same count as independent: {:?}", sweep.axes());
    Some(sweep.points().len())
}

/// Makes two to four sweep calls in a folder, some at the same time if `has_races` is true. Axes and scenes change, and
/// files are removed or damaged between calls. Panics if a finished point contains the run of another point.
pub fn calls(bytes: &[u8], has_races: bool) -> usize {
    let choices = &mut Choices::new(bytes);
    let place = temporary();
    let (file, folder) = (place.path().join("balls.toml"), place.path().join("sweep"));
    fs::write(&file, scene(1)).expect("a scene");
    let mut over = 0;
    for _ in 0..choices.pick(&[2, 3, 4]) {
        if choices.once_in(4) {
            fs::write(&file, scene(choices.pick(&[1, 2]))).expect("a scene");
        }
        let mut sweep = || {
            let axes = choices.pick(&["seed=1..2", "seed=2..3", "species.0.mass=1,3", "species.0.mass=2", "seed=1..2"]);
            Sweep::new(&file, &[], axes.parse::<Axis>().into_iter().collect()).expect("a sweep")
        };
        let (first, second) = (sweep(), sweep());
        let is_race = choices.once_in(3) && has_races;
        let ends = thread::scope(|scope| {
            let other = is_race.then(|| scope.spawn(|| execute(&second, &folder)));
            let one = execute(&first, &folder);
            [Some(one), other.map(|thread| thread.join().expect("a sweep that does not panic"))]
        });
        let sweeps = [&first, &second];
        let done: Vec<&Sweep> = sweeps
            .into_iter()
            .zip(&ends)
            .filter(|(_, end)| matches!(end, Some(Ok(_))))
            .map(|(sweep, _)| sweep)
            .collect();
        over += done.len();
        if let Ok(kept) = Sweep::from_file(SweepFolder::file_in(&folder)) {
            check(&kept, &folder);
        }
        if let [one, other] = done[..] {
            assert_eq!(one.keys(), other.keys(), "two sweeps of different keys are in one folder");
        }
        damage(choices, &folder);
    }
    over
}

fn execute(sweep: &Sweep, folder: &Path) -> Result<Vec<(usize, Fate)>, SweepError> {
    let opened = SweepFolder::open(folder, sweep)?;
    let orders = Orders {
        jobs: 1,
        share: Share::ALL,
        checkpoint_every: Duration::from_millis(1),
        most_bytes: f64::INFINITY,
        report: &final_table::text,
        instruments: &|run| run,
        instrument_names: &[],
    };
    let fates = opened.execute(sweep, &orders, &|_, _| ControlFlow::Continue(()))?;
    let results = Results::read(&opened, sweep);
    opened.write_tables(sweep, &results)?;
    let _ = report::sweep_page(&opened, sweep, &results);
    Ok(fates)
}

/// Asserts that each finished run has the seed and the mass of its point.
fn check(sweep: &Sweep, folder: &Path) {
    let Ok(opened) = SweepFolder::existing(folder) else { return };
    for (point, result) in sweep.points().iter().zip(Results::read(&opened, sweep).points) {
        if result.standing != Standing::Done {
            continue;
        }
        let (asked, kept) = (sweep.scene_at(point), read_scene(opened.of(point).join("scene.toml"), &[]));
        let (Ok(asked), Ok(kept)) = (asked, kept) else { continue };
        let of = |scene: &carom::model::Scene| (scene.seed(), scene.species()[0].mass);
        assert_eq!(of(&asked), of(&kept), "{} holds another run", point.folder());
    }
}

fn damage(choices: &mut Choices<'_>, folder: &Path) {
    let mut files: Vec<_> = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.sort();
    let Some(mut path) = (!files.is_empty()).then(|| files[choices.below(files.len())].clone()) else { return };
    if path.is_dir() {
        let names = ["summary.json", "checkpoint", ".carom", "thermo.csv", "scene.toml", "measurements.json"];
        path = path.join(choices.pick(&names));
    }
    match choices.pick(&["nothing", "nothing", "remove", "cut"]) {
        "remove" => drop(fs::remove_file(&path)),
        "cut" => {
            if let Ok(content) = fs::read(&path) {
                let length = content.len() * choices.below(4) / 4;
                drop(fs::write(&path, &content[..length]));
            }
        }
        _ => {}
    }
}
