//! `carom sweep`: folders, tables, continued sweeps and rejected inputs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Child;

use super::place::{FLUID, Place, code, errors, kill_until_done, line, send_signal, wait_until, words};

const AXES: [&str; 4] = ["--vary", "fill.0.packing_fraction=0.1,0.3", "--vary", "seed=1..3"];

fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<String>>());
    let heads = lines.next().unwrap();
    lines
        .map(|cells| {
            assert_eq!(cells.len(), heads.len(), "{cells:?}");
            heads.iter().cloned().zip(cells).collect()
        })
        .collect()
}

fn number(row: &BTreeMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name} in {row:?}"))
}

fn bits(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for run in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        for name in ["thermo.csv", "trajectory.xyz", "scene.toml"] {
            let key = format!("{}/{name}", run.file_name().unwrap().to_string_lossy());
            files.insert(key, fs::read(run.join(name)).unwrap());
        }
    }
    for name in ["sweep.csv", "sweep-mean.csv"] {
        files.insert(name.to_owned(), fs::read(folder.join(name)).unwrap());
    }
    files
}

fn sweep<'a>(more: &[&'a str]) -> Vec<&'a str> {
    ["sweep", "scene.toml", "--quiet"].into_iter().chain(AXES).chain(more.iter().copied()).collect()
}

#[test]
fn every_combination_is_a_run_and_a_row() {
    let place = Place::with(FLUID);
    let output = place.done(&sweep(&["--jobs", "2"]));
    assert!(words(&output).contains("6 of 6 runs done"), "{}", words(&output));
    let runs = rows(&place.read("runs/scene-sweep/sweep.csv"));
    assert_eq!(runs.len(), 6);
    for row in &runs {
        assert_eq!(row["state"], "done");
        let folder = format!("runs/scene-sweep/{}", row["folder"]);
        let summary = place.summary(&folder);
        assert_eq!(summary["seed"].to_string(), row["seed"]);
        let pressure = &summary["observables"]["pressure"];
        assert_eq!(pressure["mean"].as_f64(), Some(number(row, "pressure")));
        assert_eq!(pressure["standard_error"].as_f64(), Some(number(row, "pressure_error")));
    }
    let means = rows(&place.read("runs/scene-sweep/sweep-mean.csv"));
    assert_eq!(means.iter().map(|row| row["packing_fraction"].as_str()).collect::<Vec<_>>(), ["0.1", "0.3"]);
    for (at, row) in means.iter().enumerate() {
        let of = |name: &str| -> Vec<f64> { runs[3 * at..3 * at + 3].iter().map(|row| number(row, name)).collect() };
        let mean = of("pressure").iter().sum::<f64>() / 3.0;
        let error = of("pressure_error").iter().map(|error| error * error).sum::<f64>().sqrt() / 3.0;
        assert!((number(row, "pressure") / mean - 1.0).abs() < 1e-14);
        assert!((number(row, "pressure_error") / error - 1.0).abs() < 1e-14);
        assert_eq!((row["runs"].as_str(), row.contains_key("pressure_scatter")), ("3", true));
    }
    let page = place.read("runs/scene-sweep/sweep.html");
    for word in ["<svg", "mKLM", "degrees of freedom", "packing fraction", "6 runs", "Δ / σ"] {
        assert!(page.contains(word), "{word}");
    }
    for row in &runs {
        let link = format!("{}/run.html", row["folder"]);
        assert!(page.contains(&format!("href=\"{link}\"")), "{link}");
        assert!(place.read(&format!("runs/scene-sweep/{link}")).contains("Can it be trusted?"));
    }
    let first = place.path().join("runs/scene-sweep").join(&runs[0]["folder"]).join("run.html");
    let changed = || fs::metadata(&first).unwrap().modified().unwrap();
    let before = changed();
    place.done(&sweep(&[]));
    assert_eq!(changed(), before);
}

#[test]
fn keys_that_change_together_are_one_curve_of_the_page() {
    let place = Place::with(FLUID);
    let together = "fill.0.packing_fraction=0.1,0.3; run.until_events=2000,3000";
    place.done(&["sweep", "scene.toml", "--vary", together, "--out", "s"]);
    let page = place.read("s/sweep.html");
    assert!(page.contains("measured") && !page.contains("until events = "), "{page}");
}

#[test]
fn the_number_of_jobs_and_of_tasks_changes_no_bit() {
    let place = Place::with(FLUID);
    for (out, jobs) in [("one", "1"), ("four", "4")] {
        place.done(&sweep(&["--jobs", jobs, "--out", out]));
    }
    for task in ["2/3", "1/3", "3/3"] {
        place.done(&sweep(&["--array", task, "--out", "tasks"]));
    }
    let one = bits(&place.path().join("one"));
    assert!(one == bits(&place.path().join("four")));
    assert!(one == bits(&place.path().join("tasks")));
    let alone =
        ["run", "scene.toml", "--quiet", "--seed", "2", "--set", "fill.0.packing_fraction=0.3", "--out", "alone"];
    place.done(&alone);
    assert!(place.read("alone/trajectory.xyz") == place.read("one/packing_fraction-0.3_seed-2/trajectory.xyz"));
}

fn start(place: &Place, out: &str) -> Child {
    let jobs = ["--jobs", "2", "--checkpoint-every", "0.005", "--set", "run.until_events=40000", "--out", out];
    place.start(&sweep(&jobs))
}

#[test]
fn a_sweep_that_is_killed_again_and_again_comes_to_the_same_bits() {
    let place = Place::with(FLUID);
    assert!(start(&place, "whole").wait().unwrap().success());
    let kills = kill_until_done(20, || start(&place, "killed"));
    assert!(bits(&place.path().join("whole")) == bits(&place.path().join("killed")), "after {kills} kills");
    assert!(kills > 0);
}

#[test]
fn sweep_with_more_values_keeps_the_finished_runs() {
    let place = Place::with(FLUID);
    place.done(&["sweep", "scene.toml", "--vary", "seed=1..2", "--out", "s"]);
    let before = fs::metadata(place.path().join("s/seed-1/summary.json")).unwrap().modified().unwrap();
    let output = place.done(&["sweep", "scene.toml", "--vary", "seed=1..4", "--out", "s"]);
    assert!(words(&output).contains("4 of 4 runs done, 2 were there already"), "{}", words(&output));
    assert!(
        !errors(&output).contains("seed-1: done") && errors(&output).contains("seed-4: done"),
        "{}",
        errors(&output)
    );
    assert_eq!(fs::metadata(place.path().join("s/seed-1/summary.json")).unwrap().modified().unwrap(), before);
    assert_eq!(rows(&place.read("s/sweep.csv")).len(), 4);
    let output = place.carom(&["sweep", "s", "--quiet"]);
    assert!(words(&output).contains("4 of 4 runs done"), "{}{}", words(&output), errors(&output));
    let file = "scene = \"scene.toml\"\nvary = [\"fill.0.packing_fraction=0.1,0.2; run.until_events=1000,2000\"]\n";
    place.write("study.toml", file);
    place.done(&["sweep", "study.toml", "--quiet"]);
    let events: Vec<f64> =
        rows(&place.read("runs/study-sweep/sweep.csv")).iter().map(|row| number(row, "events")).collect();
    assert_eq!(events, [1000.0, 2000.0]);
}

#[test]
fn a_run_that_fails_is_named_and_the_others_go_on() {
    let place = Place::with(FLUID);
    let arguments = ["sweep", "scene.toml", "--vary", "fill.0.packing_fraction=0.1,0.8,0.2", "--out", "s"];
    let output = place.carom(&arguments);
    assert_eq!(code(&output), 1);
    assert!(
        errors(&output).contains("1 of 3 runs failed") && errors(&output).contains("packing_fraction-0.8: "),
        "{}",
        errors(&output)
    );
    assert!(words(&output).contains("2 of 3 runs done, 1 failed"), "{}", words(&output));
    let text = place.read("s/sweep.csv");
    let states: Vec<&str> = text.lines().skip(1).map(|line| line.split(',').nth(1).unwrap()).collect();
    assert!(states[0] == "done" && states[1].contains("failed: ") && states[2] == "done", "{states:?}");
    assert!(place.read("s/sweep.html").contains("1 of 3 runs failed"));
    assert_eq!(code(&place.carom(&arguments)), 1);
}

#[test]
fn means_over_seeds_are_those_of_sound_runs() {
    let place = Place::with(FLUID);
    let arguments = ["sweep", "scene.toml", "--vary", "seed=1..4", "--out", "s", "--quiet"];
    place.done(&arguments);
    // Results of runs that failed the audit or ended irregularly must not enter the means.
    let summary = place.read("s/seed-2/summary.json");
    let faulty = summary.replacen("\"faults\":[]", "\"faults\":[\"the energy is wrong\"]", 1);
    let faulty = faulty.replacen("\"faults\": []", "\"faults\": [\"the energy is wrong\"]", 1);
    assert_ne!(faulty, summary);
    place.write("s/seed-2/summary.json", &faulty);
    fs::create_dir(place.path().join("s/failures")).unwrap();
    place.write("s/failures/seed-3.txt", "the equilibration did not come to an end\n");
    assert_eq!(code(&place.carom(&arguments)), 1);
    let runs = rows(&place.read("s/sweep.csv"));
    let states: Vec<&str> = runs.iter().map(|row| row["state"].as_str()).collect();
    let expected = ["done", "failed: the energy is wrong", "failed: the equilibration did not come to an end", "done"];
    assert_eq!(states, expected);
    let of = |name: &str| [0, 3].map(|at: usize| number(&runs[at], name));
    let [one, four] = of("pressure");
    let errors = of("pressure_error");
    let means = rows(&place.read("s/sweep-mean.csv"));
    let [mean] = means.as_slice() else { panic!("{means:?}") };
    assert_eq!(mean["runs"], "2");
    let is_near = |name: &str, expected: f64| {
        let value = number(mean, name);
        assert!((value / expected - 1.0).abs() < 1e-12, "{name}: {value}, not {expected}");
    };
    is_near("pressure", 0.5 * (one + four));
    is_near("pressure_error", 0.5 * errors[0].hypot(errors[1]));
    is_near("pressure_scatter", 0.5 * (one - four).abs());
}

#[cfg(unix)]
#[test]
fn a_run_that_was_interrupted_by_hand_is_not_a_finished_point() {
    let place = Place::with(FLUID);
    let until = ["--set", "run.until_events=1000000"];
    let sweep = |seeds: &str, more: &[&str]| {
        place.done(&[&["sweep", "scene.toml", "--vary", seeds], until.as_slice(), more].concat())
    };
    sweep("seed=1..2", &["--out", "whole"]);
    let whole = bits(&place.path().join("whole"));
    for signal in ["-INT", "-KILL"] {
        sweep("seed=1", &["--out", "s"]);
        let arguments = ["run", "scene.toml", "-q", "--seed", "2", "--checkpoint-every", "0.01", "--out", "s/seed-2"];
        let mut child = place.start(&[&arguments, until.as_slice()].concat());
        let checkpoint = place.path().join("s/seed-2/checkpoint");
        wait_until(|| checkpoint.exists() || child.try_wait().unwrap().is_some());
        send_signal(&child, signal);
        assert!(!child.wait().unwrap().success(), "{signal}: it had come to its end already");
        assert_eq!(place.path().join("s/seed-2/summary.json").exists(), signal == "-INT");
        // Another task of the job array lists this run as started, without results.
        sweep("seed=1..2", &["--out", "s", "--array", "1/2"]);
        let runs = rows(&place.read("s/sweep.csv"));
        assert_eq!((runs[1]["state"].as_str(), runs[1]["pressure"].as_str()), ("begun", ""), "{signal}");
        assert_eq!(rows(&place.read("s/sweep-mean.csv"))[0]["runs"], "1", "{signal}");
        let output = sweep("seed=1..2", &["--out", "s"]);
        assert!(words(&output).contains("2 of 2 runs done, 1 were there already"), "{signal}: {}", words(&output));
        assert!(bits(&place.path().join("s")) == whole, "{signal}");
        fs::remove_dir_all(place.path().join("s")).unwrap();
    }
}

#[test]
fn measured_stages_have_rows_of_their_own() {
    let stage = "[[stage]]\nname = \"cold\"\nmeasure = true\nuntil_events = 3000\n\
        thermostat = { kind = \"rescaling\", temperature = 0.25, interval = 0.125 }\n[measure]\npressure_tensor = true\n";
    let place = Place::with(&format!("{FLUID}{stage}"));
    place.done(&sweep(&["--out", "s", "--array", "1/2"]));
    let runs = rows(&place.read("s/sweep.csv"));
    let states: Vec<[&str; 2]> = runs.iter().map(|row| ["state", "stage"].map(|name| row[name].as_str())).collect();
    assert_eq!(states[..4], [["done", "cold"], ["done", "measurement"], ["missing", ""], ["done", "cold"]]);
    let output = place.done(&sweep(&["--out", "s"]));
    assert!(words(&output).contains("6 of 6 runs done") && words(&output).contains("  cold  "), "{}", words(&output));
    let runs = rows(&place.read("s/sweep.csv"));
    assert_eq!(runs.len(), 12);
    for (at, row) in runs.iter().enumerate() {
        let folder = format!("s/{}", row["folder"]);
        let (summary, text) = (place.summary(&folder), place.read(&format!("{folder}/measurements.json")));
        let measurements: serde_json::Value = serde_json::from_str(&text).unwrap();
        let (name, results, measured) = match at % 2 {
            0 => ("cold", &summary["stages"][0], &measurements["stages"][0]),
            _ => ("measurement", &summary, &measurements),
        };
        assert_eq!(row["stage"], name);
        assert_eq!(results["events"]["total"].as_f64(), Some(number(row, "events")));
        assert_eq!(results["measured"]["duration"].as_f64(), Some(number(row, "duration")));
        assert_eq!(results["observables"]["temperature"]["mean"].as_f64(), Some(number(row, "temperature")));
        let numbers = measured["numbers"].as_array().unwrap();
        let stress = numbers.iter().find(|number| number["name"] == "pressure_xx").unwrap();
        assert_eq!(stress["mean"].as_f64(), Some(number(row, "pressure_xx")));
    }
    let means = rows(&place.read("s/sweep-mean.csv"));
    let points: Vec<[&str; 3]> =
        means.iter().map(|row| ["packing_fraction", "stage", "runs"].map(|name| row[name].as_str())).collect();
    let stages = ["cold", "measurement"];
    let expected = ["0.1", "0.3"].map(|fraction| stages.map(|stage| [fraction, stage, "3"]));
    assert_eq!(points, expected.concat());
    for (at, row) in means.iter().enumerate() {
        let seeds = [0, 2, 4].map(|seed| &runs[6 * (at / 2) + at % 2 + seed]);
        let mean = seeds.iter().map(|run| number(run, "pressure_xx")).sum::<f64>() / 3.0;
        assert!((number(row, "pressure_xx") / mean - 1.0).abs() < 1e-14, "{row:?}");
    }
    let page = place.read("s/sweep.html");
    for word in ["<th scope=\"row\" data-head=\"stage\">cold</th>", "</svg>cold</li>", "6 runs"] {
        assert!(page.contains(word), "{word}");
    }
    assert!(place.read("s/sweep-columns.csv").contains("\nstage,,"));
}

#[test]
fn bad_sweep_input_is_rejected_with_help_before_writing_files() {
    let place = Place::with(FLUID);
    place.refused(
        &["sweep", "scene.toml", "--vary", "fill.0.packing_fractoin=0.1,0.2"],
        &["packing_fractoin", "packing_fraction"],
    );
    place.refused(&["sweep", "scene.toml", "--vary", "fill.3.count=1,2"], &["fill.3.count", "override:1"]);
    place.refused(&["sweep", "scene.toml", "--vary", "run.until_events=10,many"], &["many"]);
    place.refused(&["sweep", "scene.toml", "--vary", "fill.0.packing_fraction=0.49..0.05/12"], &["runs backwards"]);
    place.refused(&["sweep", "scene.toml", "--vary", "seed"], &["KEY=VALUES"]);
    place.refused(&["sweep", "scene.toml", "--vary", "seed=1,1"], &["twice"]);
    place.refused(&["sweep", "scene.toml", "--seed", "1", "--vary", "seed=1,2"], &["more than once"]);
    place.refused(&["sweep", "scene.toml"], &["--vary"]);
    place.refused(&["sweep", "nothing.toml", "--vary", "seed=1,2"], &["nothing.toml"]);
    place.refused(&["sweep", "scene.toml", "--vary", "seed=1,2", "--array", "4/3"], &["K/N"]);
    place.refused(&["sweep", "scene.toml", "--vary", "fill.0.packing_fraction=0.8,0.9"], &["packing"]);
    assert!(!place.path().join("runs").exists());
    place.done(&["sweep", "scene.toml", "--vary", "seed=1,2", "--out", "s", "--quiet"]);
    place.refused(
        &["sweep", "scene.toml", "--vary", "fill.0.count=4,32", "--out", "s"],
        &["another sweep", "varies seed", "--out"],
    );
    place.write("other.toml", &FLUID.replace("0.3", "0.2"));
    place.refused(
        &["sweep", "other.toml", "--vary", "seed=1,2", "--out", "s"],
        &["is not the scene of the sweep", "--out"],
    );
    fs::create_dir(place.path().join("full")).unwrap();
    place.write("full/thesis.tex", "");
    place.refused(&["sweep", "scene.toml", "--vary", "seed=1,2", "--out", "full"], &["not a sweep", "--out"]);
}

#[test]
fn jammed_run_counts_as_failed_without_a_stored_reason() {
    let place = Place::with(FLUID);
    let grow = "\n[[stage]]\nname = \"compress\"\ngrow = { rate = 2.0, packing_fraction = 0.3 }\n\
                thermostat = { kind = \"rescaling\", temperature = 1.0, interval = 0.2 }\n";
    let scene = fs::read_to_string(place.path().join("scene.toml"))
        .unwrap()
        .replace("packing_fraction = 0.3", "packing_fraction = 0.2")
        .replace("\"fcc\"", "\"random\"");
    fs::write(place.path().join("scene.toml"), scene.replace("[run]", &format!("{grow}[run]"))).unwrap();
    let vary = ["sweep", "scene.toml", "--vary", "stage.0.grow.packing_fraction=0.3,0.73", "--out", "s"];
    let first = place.carom(&vary);
    assert_eq!(code(&first), 1, "{}", words(&first));
    assert!(errors(&first).contains("1 of 2 runs failed"), "{}", errors(&first));
    // Without the stored reason, the sweep must find out that the run failed.
    fs::remove_dir_all(place.path().join("s/failures")).unwrap();
    let again = place.carom(&vary);
    assert_eq!(code(&again), 1, "{}", words(&again));
    let text = place.read("s/sweep.csv");
    let lines: Vec<&str> = text.lines().skip(1).collect();
    assert!(lines[0].contains(",done,") && lines[1].contains("failed: growing spheres jam"), "{text}");
}

#[test]
fn run_resume_rejects_the_folder_of_a_sweep() {
    let place = Place::with(FLUID);
    let until = ["--set", "run.until_events=600", "--out", "s", "-q"];
    place.done(&[&["sweep", "scene.toml", "--vary", "seed=1,2"], &until[..]].concat());
    let output = place.carom(&["run", "--resume", "s"]);
    assert_eq!(code(&output), 2, "{}", errors(&output));
    for expected in ["s is the folder of a sweep", "carom sweep s;", "carom run --resume s/RUN"] {
        assert!(line(&output).contains(expected), "{}", line(&output));
    }
    place.done(&["run", "-q", "--resume", "s/seed-1", "--until-events", "700"]);
}
