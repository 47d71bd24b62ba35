//! `carom verify` compares the files of a run with the files of a replay.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::place::{Place, code, errors, line, run, words};
use carom::check::compare::{CompareError, Comparison, compare};
use carom::io::{Existing, Folder, read_scene};
use carom::run::{Ending, Run};
use carom::view::final_table;

const MIXTURE: &str = r#"
[[species]]
name = "large"
mass = 1.3
diameter = 1.0

[[species]]
name = "small"
mass = 0.45
diameter = 0.7

[[interaction]]
species = ["large", "large"]
potential = "hard-sphere"

[[interaction]]
species = ["large", "small"]
potential = "square-well"
lambda = 1.4
well_depth = 0.6

[[interaction]]
species = ["small", "small"]
potential = "hard-sphere"

[[fill]]
composition = { large = 1, small = 1 }
arrangement = "fcc"
count = 108
packing_fraction = 0.25
temperature = 1.7

[run]
equilibration_events = 300
until_events = 900

[output]
events = true
contacts = true
formats = ["lammps", "csv", "gsd"]
"#;

const STAGES: &str = r#"
seed = 5

[[species]]
name = "disc"
mass = 1.1
diameter = 1.0

[space]
size = [9.0, 8.0, 0.0]
z = "flat"

[[interaction]]
species = ["disc", "disc"]
potential = "hard-sphere"

[[fill]]
species = "disc"
count = 30
arrangement = "random"
temperature = 0.8

[[stage]]
name = "grow"
grow = { rate = 0.2, packing_fraction = 0.4 }

[[stage]]
name = "first"
measure = true
until_time = 4.0
thermostat = { kind = "andersen", temperature = 0.8, rate = 2.0 }

[run]
until_time = 6.0

[measure]
radial_distribution = true
speeds = true

[output]
formats = ["vtk", "npy"]
"#;

fn found(folder: &Path) -> Result<Comparison, CompareError> {
    compare(folder, &final_table::text, &mut |_| ControlFlow::Continue(()))
}

fn is_whole(folder: &Path) {
    let comparison = found(folder).unwrap();
    assert_eq!(comparison.differences, [], "{}", folder.display());
    for name in ["summary.json", "thermo.csv", "trajectory.xyz", "report.txt"] {
        assert!(comparison.equal.iter().any(|equal| equal == name), "{name}: {comparison:?}");
    }
}

fn config(name: &str) -> String {
    format!("{}/configs/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn runs(place: &Place) -> Vec<PathBuf> {
    place.write("mixture.toml", MIXTURE);
    place.write("stages.toml", STAGES);
    run(place, &["mixture.toml", "--out", "runs/mixture"]);
    run(place, &["stages.toml", "--out", "runs/stages"]);
    let (hopper, isobaric, drum) = (config("hopper"), config("isobaric_fluid"), config("vibrated_box"));
    run(place, &[&hopper, "--until-time", "0.4", "--set", "output.contacts=true", "--out", "runs/hopper"]);
    let few = ["--set", "fill.0.count=32", "--set", "run.equilibration_time=3", "--until-time", "8"];
    run(place, &[&[isobaric.as_str(), "--out", "runs/isobaric"], &few[..]].concat());
    run(place, &[&drum, "--until-time", "0.3", "--out", "runs/drum"]);
    ["mixture", "stages", "hopper", "isobaric", "drum"].map(|name| place.path().join("runs").join(name)).to_vec()
}

struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        usize::try_from((mixed ^ (mixed >> 31)) % end as u64).unwrap()
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { all.extend(files(&path)) } else { all.push(path) }
    }
    all.sort();
    all
}

fn change(file: &Path, numbers: &mut Numbers) -> String {
    let mut bytes = fs::read(file).unwrap();
    let at = numbers.below(bytes.len().max(1));
    let kind = if bytes.is_empty() { 4 } else { numbers.below(6) };
    match kind {
        0 => bytes[at] ^= 1 << numbers.below(8),
        1 => {
            let digits: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at].is_ascii_digit()).collect();
            let Some(&at) = digits.get(numbers.below(digits.len().max(1))) else { return change(file, numbers) };
            bytes[at] = b'0' + (bytes[at] - b'0' + 1 + u8::try_from(numbers.below(9)).unwrap()) % 10;
        }
        2 => drop(bytes.remove(at)),
        3 => bytes.insert(at, bytes[at]),
        4 => bytes.extend(b"0\n"),
        _ => bytes.truncate(at),
    }
    fs::write(file, bytes).unwrap();
    format!("{} changed by {kind} at {at}", file.display())
}

/// `CAROM_CHANGES` sets the number of changes.
#[test]
fn verify_finds_any_change_or_names_the_file_as_not_compared() {
    let place = Place::with("");
    let runs = runs(&place);
    runs.iter().for_each(|run| is_whole(run));
    let changes: usize = std::env::var("CAROM_CHANGES").map_or(30, |number| number.parse().unwrap());
    let mut numbers = Numbers(11);
    let mut outcomes = [0; 3];
    for number in 0..changes {
        let run = &runs[number % runs.len()];
        let all = files(run);
        let file = &all[numbers.below(all.len())];
        let name = file.strip_prefix(run).unwrap().to_string_lossy().into_owned();
        let original = fs::read(file).unwrap();
        let what = change(file, &mut numbers);
        match found(run) {
            Err(_) => outcomes[0] += 1,
            Ok(comparison) if !comparison.differences.is_empty() => outcomes[1] += 1,
            Ok(comparison) => {
                let why = comparison.not_compared.iter().find(|(other, _)| *other == name);
                assert!(why.is_some(), "{what} is not found");
                outcomes[2] += 1;
            }
        }
        fs::write(file, original).unwrap();
    }
    println!(
        "of {changes} changes: no replay {}, found {}, named as not compared {}",
        outcomes[0], outcomes[1], outcomes[2]
    );
    assert!(outcomes[1] > changes / 2, "{outcomes:?}");
}

#[test]
fn a_run_that_was_interrupted_anywhere_has_the_files_of_its_replay() {
    // The run has far too many events to finish within a few progress calls.
    let place = Place::with(&MIXTURE.replace("until_events = 900", "until_events = 40000"));
    let scene = || read_scene(place.path().join("scene.toml"), &[]).unwrap();
    let text = scene().record(place.path().join("scene.toml"), &[]).unwrap();
    for asked in [1, 2, 3, 5, 8] {
        let target = place.path().join(format!("after-{asked}"));
        let mut folder = Folder::create(&target, &scene(), Existing::Keep).unwrap();
        folder.keep_scene(&text).unwrap();
        let mut left = asked;
        let finished = Run::new(scene()).execute(&mut folder, &mut |_| {
            left -= 1;
            if left > 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let finished = finished.unwrap();
        folder.complete(&finished, &final_table::text(&finished)).unwrap();
        assert_eq!(finished.ending, Ending::Interrupted, "after {asked} questions");
        is_whole(&target);
    }
}

#[test]
fn a_run_that_went_on_to_a_later_end_has_the_files_of_its_replay() {
    let place = Place::with(STAGES);
    // The first run plans rows, frames and samples for its own end, not for the later end.
    run(&place, &["scene.toml"]);
    run(&place, &["--resume", "runs/scene", "--until-time", "23"]);
    is_whole(&place.path().join("runs/scene"));
    place.write("other.toml", MIXTURE);
    run(&place, &["other.toml", "--out", "runs/other"]);
    for events in ["2000", "5000"] {
        run(&place, &["--resume", "runs/other", "--until-events", events]);
        is_whole(&place.path().join("runs/other"));
    }
}

#[test]
fn the_program_names_the_file_and_the_place_that_was_changed() {
    let place = Place::with(MIXTURE);
    run(&place, &["scene.toml"]);
    let verify = |more: &[&str]| place.carom(&[&["verify", "runs/scene", "-q", "--events", "50"], more].concat());
    let output = verify(&[]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(words(&output).contains("files compared with a replay"), "{}", words(&output));
    let rows = place.read("runs/scene/thermo.csv");
    let number = rows.lines().count();
    let last = rows.lines().last().unwrap();
    place.write("runs/scene/thermo.csv", &rows.replace(last, &last.replace(",measurement", "0,measurement")));
    let output = verify(&[]);
    let told = line(&output);
    assert_eq!(code(&output), 1, "{told}");
    assert!(told.contains(&format!("thermo.csv differs from the file of the replay: line {number} is")), "{told}");
    assert!(words(&output).contains("PROVEN"), "the events are right: {}", words(&output));
    assert_eq!(code(&verify(&["--no-files"])), 0);
    place.write("runs/scene/thermo.csv", &rows);
    assert_eq!(code(&verify(&[])), 0);
    fs::remove_file(place.path().join("runs/scene/contacts.csv")).unwrap();
    let output = verify(&[]);
    assert!(
        errors(&output).contains("contacts.csv differs from the file of the replay: it is missing"),
        "{}",
        errors(&output)
    );
}
