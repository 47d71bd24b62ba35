//! No file is replaced without a request, and no file is lost during a replacement.

use std::fs;
use std::ops::ControlFlow;

use carom::io::{Existing, Folder};
use carom::model::{Scene, Until};
use carom::run::{Ending, Progress, Run, run};

use super::place::{FLUID, Place, begun, code, contents, ended, errors, killed, line, send_signal, when_free, words};

#[test]
fn no_command_replaces_anything_unasked() {
    let place = Place::with(FLUID);
    let run = ["run", "scene.toml", "--until-events", "300", "--set", "output.contacts=true"];
    place.done(&run);
    for command in ["report", "render"] {
        place.done(&[command, "runs/scene"]);
        assert_eq!(code(&place.carom(&[command, "runs/scene"])), 0, "the same bytes are no replacement");
    }
    place.done(&["convert", "runs/scene", "--to", "csv"]);
    fs::write(place.path().join("thesis.tex"), "years of work").unwrap();
    fs::write(place.path().join("runs/scene/notes.txt"), "my notes").unwrap();
    let before = contents(place.path());
    for (arguments, cures) in [
        (&["run", "scene.toml"][..], &["--resume", "--out", "--force"][..]),
        (&["run", "scene.toml", "--out", "."], &["--out"]),
        (&["run", "scene.toml", "--out", ".", "--force"], &["--out"]),
        (&["report", "runs/scene", "--out", "thesis.tex"], &["--out", "--force"]),
        (&["report", "runs/scene", "--out", "runs/scene/trajectory.xyz"], &["--out"]),
        (&["render", "runs/scene", "--out", "thesis.tex"], &["--out", "--force"]),
        (&["render", "runs/scene", "--size", "40x40"], &["--out", "--force"]),
        (&["convert", "runs/scene", "--to", "csv"], &["--out", "--force"]),
        (&["convert", "runs/scene", "--to", "gsd", "--out", "thesis.tex"], &["--out", "--force"]),
    ] {
        let output = place.carom(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", errors(&output));
        for cure in cures {
            assert!(errors(&output).contains(cure), "{arguments:?}: {}", errors(&output));
        }
        assert!(contents(place.path()) == before, "{arguments:?} changed something");
    }
    place.done(&["report", "runs/scene", "--out", "thesis.tex", "--force"]);
    assert!(place.read("thesis.tex").contains("</html>"));
    place.done(&["run", "scene.toml", "--force", "--until-events", "200"]);
    let mut names: Vec<String> = contents(&place.path().join("runs/scene")).into_keys().collect();
    names.sort();
    // The new run has removed all derived files of the replaced run.
    let left = ["checkpoint", "notes.txt", "report.txt", "scene.toml", "summary.json", "thermo.csv", "trajectory.xyz"];
    assert_eq!(names, left);
    assert_eq!(place.summary("runs/scene")["events"]["total"], 200);
}

#[test]
fn a_summary_does_not_make_a_folder_a_run() {
    let place = Place::with(FLUID);
    let mine = place.path().join("mine");
    fs::create_dir(&mine).unwrap();
    for name in ["summary.json", "thermo.csv", "report.html", "thermo.csv.partial", "checkpoint"] {
        fs::write(mine.join(name), "{}").unwrap();
    }
    let before = contents(&mine);
    for force in [&[][..], &["--force"]] {
        place.refused(&[&["run", "scene.toml", "--out", "mine"], force].concat(), &["not a run of carom"]);
        assert!(contents(&mine) == before);
    }
    assert_eq!(code(&place.carom(&["run", "--resume", "mine"])), 2);
    assert!(contents(&mine) == before);
    assert!(!mine.join(".carom").exists());
}

#[test]
fn run_is_unchanged_until_its_replacement_is_complete() {
    let place = Place::with(FLUID);
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml", "--seed", "7", "--set", "output.events=true"]);
    fs::write(folder.join("notes.txt"), "my notes").unwrap();
    let before = contents(&folder);
    let is_as_before = || {
        let now = contents(&folder);
        before.iter().all(|(name, bytes)| now.get(name) == Some(bytes))
    };
    killed(begun(&place, &["--force", "--seed", "8"]));
    assert!(is_as_before());
    // Without `--force`, a new run does not replace an unfinished replacement.
    let output = place.carom(&["run", "scene.toml"]);
    assert!(code(&output) == 2 && is_as_before(), "{}", errors(&output));
    let output = place.carom(&["report", "runs/scene"]);
    assert!(code(&output) == 0 && is_as_before(), "{}", errors(&output));
    // A user's file that is in the way is kept and reported at the start. No simulated data are lost.
    let arguments = ["run", "scene.toml", "--force", "--set", "output.contacts=true"];
    for is_late in [false, true] {
        let child = is_late.then(|| begun(&place, &arguments[2..]));
        fs::write(folder.join("contacts.csv"), "mine").unwrap();
        child.into_iter().for_each(killed);
        let resume = ["run", "--resume", "runs/scene", "--until-time", "1e9"];
        let output = place.carom(if is_late { &resume } else { &arguments });
        assert_eq!(code(&output), 2, "{}", errors(&output));
        assert!(is_as_before() && line(&output).contains("not written by carom"), "{}", errors(&output));
        fs::remove_file(folder.join("contacts.csv")).unwrap();
    }
    let output = ended(&place, "runs/scene");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(words(&output).ends_with("The files are in runs/scene\n"), "{}", words(&output));
    assert_eq!(place.summary("runs/scene")["seed"], 1);
    let now = contents(&folder);
    assert!(now.contains_key("notes.txt") && now.contains_key("contacts.csv") && !now.contains_key("events/time.npy"));
    assert!(!now.keys().any(|name| name.contains("replacement") || name.contains("partial")), "{:?}", now.keys());
}

#[test]
fn an_interrupted_run_is_protected_like_a_killed_one() {
    let place = Place::with(FLUID);
    for signal in ["-TERM", "-KILL"] {
        let mut child = begun(&place, &[]);
        send_signal(&child, signal);
        child.wait().unwrap();
        let before = contents(&place.path().join("runs/scene"));
        place.refused(&["run", "scene.toml"], &["--resume", "--out"]);
        assert!(contents(&place.path().join("runs/scene")) == before, "{signal}");
        fs::remove_dir_all(place.path().join("runs")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn interrupted_run_prints_a_resume_command_with_all_options() {
    let place = Place::with(FLUID);
    let child = begun(&place, &["--threads", "1"]);
    send_signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let again = "carom run --resume runs/scene --threads 1 --checkpoint-every 0.01 --quiet continues it";
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(line(&output).contains(again), "{}", line(&output));
}

#[test]
fn two_runs_in_one_folder_exclude_each_other() {
    let place = Place::with(FLUID);
    let child = begun(&place, &[]);
    for arguments in [&["run", "scene.toml"][..], &["run", "scene.toml", "--force"], &["run", "--resume", "runs/scene"]]
    {
        place.refused(arguments, &["another run writes to runs/scene"]);
    }
    killed(child);
    assert_eq!(code(&ended(&place, "runs/scene")), 0);
}

#[test]
fn a_run_killed_between_its_last_renamings_is_a_run_and_goes_on() {
    let place = Place::with(FLUID);
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml", "--quiet"]);
    let files = ["scene.toml", "thermo.csv", "trajectory.xyz", "report.txt", "summary.json"];
    let whole = files.map(|name| place.read(&format!("runs/scene/{name}")));
    // A run renames its finished files in this order. Here it was killed after renaming some files.
    for done in 0..files.len() {
        for name in &files[done..] {
            fs::rename(folder.join(name), folder.join(format!("{name}.partial"))).unwrap();
        }
        place.refused(&["run", "scene.toml", "--quiet"], &["--resume"]);
        let output = place.carom(&["run", "--resume", "runs/scene", "--quiet"]);
        assert_eq!(code(&output), 0, "{done}: {}", errors(&output));
        for (name, text) in files[..3].iter().zip(&whole) {
            assert_eq!(place.read(&format!("runs/scene/{name}")), *text, "{done}: {name}");
        }
    }
}

#[test]
fn run_requires_force_before_filling_the_disk() {
    let interval = ["scene.toml", "--set", "output.thermo_interval=1e-3"];
    let place = Place::with(&FLUID.replace("until_events = 4000", "until_time = 1e10"));
    place.refused(&[&["run"], &interval[..]].concat(), &["TB", "--force"]);
    assert!(!place.path().join("runs").exists());
    let text = words(&place.carom(&[&["check"], &interval[..]].concat()));
    assert!(text.contains("requires --force"), "{text}");
    let place = Place::with(FLUID);
    let both = [&interval[..], &["--set", "run.until_time=1e10"]].concat();
    place.done(&[&["run"], &both[..]].concat());
    let text = words(&place.carom(&[&["check"], &both[..]].concat()));
    assert!(text.contains("rows and") && text.contains("of memory") && text.contains("4500 events"), "{text}");
    assert!(!text.contains("--force"), "{text}");
}

#[test]
fn run_over_its_size_estimate_stops_and_resumes_to_identical_bits() {
    let place = Place::with(FLUID);
    let scene = Scene::from_file(place.path().join("scene.toml")).unwrap();
    let [limited, whole] = ["limited", "whole"].map(|name| place.path().join(name));
    let go_on = |_: &Progress| ControlFlow::Continue(());
    let mut folder = Folder::create(&limited, &scene, Existing::Keep).unwrap().at_most(60_000.0);
    let finished = run(scene.clone(), &mut folder, &mut go_on.clone()).unwrap();
    assert_eq!(finished.ending, Ending::Interrupted);
    let excess = folder.excess().unwrap();
    assert!(excess.to_string().contains("more than the 60 kB that"), "{excess}");
    folder.complete(&finished, "").unwrap();
    let written = fs::metadata(limited.join("trajectory.xyz")).unwrap().len();
    assert!((30_000..120_000).contains(&written), "{written}");
    let (mut folder, checkpoint) = when_free(|| Folder::resume(&limited, None));
    let finished = Run::resume(checkpoint).execute(&mut folder, &mut go_on.clone()).unwrap();
    assert!(finished.is_sound());
    folder.complete(&finished, "").unwrap();
    let mut folder = Folder::create(&whole, &scene, Existing::Keep).unwrap();
    let finished = run(scene, &mut folder, &mut go_on.clone()).unwrap();
    folder.complete(&finished, "").unwrap();
    for name in ["thermo.csv", "trajectory.xyz"] {
        assert_eq!(fs::read(limited.join(name)).unwrap(), fs::read(whole.join(name)).unwrap(), "{name}");
    }
}

#[test]
fn new_end_is_stored_before_the_run_continues() {
    let place = Place::with(FLUID);
    let scene = Scene::from_file(place.path().join("scene.toml")).unwrap();
    let path = place.path().join("run");
    let mut folder = Folder::create(&path, &scene, Existing::Keep).unwrap();
    folder.keep_scene(&fs::read_to_string(place.path().join("scene.toml")).unwrap()).unwrap();
    let finished = run(scene.clone(), &mut folder, &mut |_: &Progress| ControlFlow::Continue(())).unwrap();
    folder.complete(&finished, "").unwrap();
    let events = 8_000;
    // `Folder::resume` stores the new end. Dropping the folder has the same effect as killing the run.
    drop(when_free(|| Folder::resume(&path, Some(Until::events(events)))));
    let (_, checkpoint) = when_free(|| Folder::resume(&path, None));
    assert_eq!(checkpoint.simulation.scene().run().limit, Until::events(events));
    let kept = fs::read_to_string(path.join("scene.toml.partial")).unwrap();
    assert!(kept.contains(&format!("until_events = {events}")), "{kept}");
}

#[test]
fn run_stopped_early_and_given_a_nearer_end_has_enough_rows() {
    let place = Place::with(FLUID);
    let scene = |events: u64| {
        let until = format!("run.until_events={events}");
        let text = fs::read_to_string(place.path().join("scene.toml")).unwrap();
        let text = text.replace("until_events = 4000", &until.replace("run.until_events=", "until_events = "));
        fs::write(place.path().join("scene.toml"), text.replace("equilibration_events = 500\n", "")).unwrap();
        Scene::from_file(place.path().join("scene.toml")).unwrap()
    };
    let far = scene(1_000_000_000);
    let path = place.path().join("run");
    let mut folder = Folder::create(&path, &far, Existing::Keep).unwrap();
    folder.keep_scene(&fs::read_to_string(place.path().join("scene.toml")).unwrap()).unwrap();
    let mut stop = |progress: &Progress| match progress.events {
        0..100_000 => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    };
    let finished = run(far, &mut folder, &mut stop).unwrap();
    assert_eq!(finished.ending, Ending::Interrupted);
    folder.complete(&finished, "").unwrap();
    let events = finished.simulation.event_counts().physical() + 50_000;
    let (mut folder, checkpoint) = when_free(|| Folder::resume(&path, Some(Until::events(events))));
    let finished = Run::resume(checkpoint).execute(&mut folder, &mut |_| ControlFlow::Continue(())).unwrap();
    folder.complete(&finished, "").unwrap();
    // A run with the final limit from the start would have two hundred rows.
    let rows =
        fs::read_to_string(path.join("thermo.csv")).unwrap().lines().filter(|line| !line.starts_with('#')).count();
    assert!(rows > 40, "{rows}");
    let (_, temperature) = finished.observables[0];
    assert!(temperature.standard_error.is_some());
}
