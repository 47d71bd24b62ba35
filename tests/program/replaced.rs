//! A finished run with `--force` replaces all files of the old run, and no other files.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use carom::io::{Existing, Folder};
use carom::model::Scene;
use carom::run::{Run, run};

use super::place::{COLLAPSE, FLUID, Place, begun, code, contents, ended, errors, line, send_signal, when_free, words};

fn is_as_before(before: &std::collections::BTreeMap<String, Vec<u8>>, folder: &Path) -> bool {
    let now = contents(folder);
    before.iter().all(|(name, bytes)| now.get(name) == Some(bytes))
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_replaces_nothing_until_it_is_finished() {
    let place = Place::with(FLUID);
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml", "--seed", "7"]);
    let before = contents(&folder);
    // The second run discards the replacement of the first run.
    for _ in 0..2 {
        let child = begun(&place, &["--force"]);
        send_signal(&child, "-INT");
        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), 1, "{}", errors(&output));
        assert!(is_as_before(&before, &folder), "{}", errors(&output));
        let text = words(&output);
        assert!(text.contains("The files are in runs/scene/replacement\n"), "{text}");
        assert!(
            text.contains("`carom run --resume runs/scene --checkpoint-every 0.01 --force --quiet`")
                && text.contains("--force"),
            "{text}"
        );
        assert!(folder.join("replacement/summary.json").exists() && !folder.join("replacement/replacement").exists());
        let output = place.carom(&["run", "scene.toml"]);
        assert!(code(&output) == 2 && line(&output).contains("--resume"), "{}", errors(&output));
        assert!(is_as_before(&before, &folder));
    }
    let output = ended(&place, "runs/scene");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(place.summary("runs/scene")["seed"], 1);
    assert!(!folder.join("replacement").exists());
}

#[test]
fn failed_run_does_not_replace_a_successful_one() {
    let place = Place::with(COLLAPSE);
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml", "--until-time", "1"]);
    let before = contents(&folder);
    for _ in 0..3 {
        let output = place.carom(&["run", "scene.toml", "--force"]);
        assert_eq!(code(&output), 1, "{}", errors(&output));
        assert!(errors(&output).contains("dynamical arrest") && is_as_before(&before, &folder), "{}", errors(&output));
        assert!(words(&output).contains("move runs/scene/replacement elsewhere"), "{}", words(&output));
        assert!(!folder.join("replacement/replacement").exists());
    }
    assert!(place.read("runs/scene/replacement/report.txt").contains("FAILED"));
    place.done(&["run", "scene.toml", "--force", "--until-time", "2"]);
    assert_eq!(place.summary("runs/scene")["time"], 2.0);
    assert!(!folder.join("replacement").exists());

    let place = Place::with(FLUID);
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml"]);
    let before = contents(&folder);
    let output = place.carom(&["run", "scene.toml", "--force", "--set", "audit.overlap=1e-17"]);
    assert!(code(&output) == 1 && is_as_before(&before, &folder), "{}", errors(&output));
    fs::rename(folder.join("replacement"), place.path().join("elsewhere")).unwrap();
    assert_eq!(place.summary("elsewhere")["faults"].as_array().unwrap().len(), 1);
    place.done(&["run", "--resume", "runs/scene", "--until-events", "4100"]);
    assert_eq!(place.summary("runs/scene")["events"]["total"], 4100);
}

#[test]
fn no_file_of_a_replaced_run_stays_in_a_converted_folder() {
    let large = "[measure]\nbond_order = true\n[output]\nframe_interval = 0.005\nformats = [\"npy\", \"vtk\"]\n";
    let small = "[output]\nframe_interval = 0.05\nformats = [\"vtk\", \"npy\"]\n";
    let fluid = FLUID.replace("4000", "60").replace("500", "10");
    let place = Place::with(&format!("{fluid}{large}"));
    fs::write(place.path().join("small.toml"), format!("{fluid}{small}").replace("108", "32")).unwrap();
    place.done(&["run", "scene.toml", "--out", "replaced"]);
    assert!(place.path().join("replaced/trajectory-npy/q6.npy").exists());
    place.done(&["run", "small.toml", "--out", "replaced", "--force"]);
    place.done(&["run", "small.toml", "--out", "new"]);
    for name in ["trajectory-npy", "trajectory-vtk"] {
        let [replaced, new] = ["replaced", "new"].map(|run| contents(&place.path().join(run).join(name)));
        assert_eq!(replaced.keys().collect::<Vec<_>>(), new.keys().collect::<Vec<_>>(), "{name}");
        assert!(replaced == new, "{name}");
    }
}

#[test]
fn foreign_replacement_folder_is_rejected_and_left_unchanged() {
    let place = Place::with(FLUID);
    let folder = place.path().join("runs/scene");
    for (seed, out) in [("1", "runs/scene"), ("2", "other")] {
        place.done(&["run", "scene.toml", "--seed", seed, "--out", out]);
    }
    for inside in ["runs/scene/replacement", "runs/scene/a/b"] {
        place.refused(&["run", "scene.toml", "--out", inside], &["the folder of a run"]);
        assert!(!place.path().join(inside).exists());
    }
    fs::rename(place.path().join("other"), folder.join("replacement")).unwrap();
    let before = contents(&folder);
    for (force, cure) in [(&[][..], "--force"), (&["--force"], "runs/scene/replacement")] {
        place.refused(&[&["run", "scene.toml"], force].concat(), &[cure]);
        assert!(contents(&folder) == before, "{force:?}");
    }
    place.done(&["run", "--resume", "runs/scene", "--until-events", "4100"]);
    assert_eq!(place.summary("runs/scene")["seed"], 1);
    assert_eq!(place.summary("runs/scene/replacement")["events"]["total"], 4000);
}

#[test]
fn conversions_of_a_run_are_replaced_with_it() {
    let place = Place::with(FLUID);
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml"]);
    let all = ["lammps", "gsd", "vtk", "npy", "csv", "xyz"];
    for format in all {
        place.done(&["convert", "runs/scene", "--to", format]);
    }
    place.done(&["convert", "runs/scene", "--to", "csv", "--out", "runs/scene/mine.csv"]);
    let gsd = ["run", "scene.toml", "--force", "--seed", "2", "--set", "output.formats=[\"gsd\"]"];
    place.done(&gsd);
    place.done(&["convert", "runs/scene", "--to", "gsd", "--out", "new.gsd"]);
    let mut now = contents(&folder);
    // Whether this file exists depends on timing.
    now.remove("checkpoint.previous");
    assert!(now["trajectory.gsd"] == fs::read(place.path().join("new.gsd")).unwrap());
    let names = ["checkpoint", "mine.csv", "report.txt", "scene.toml", "summary.json", "thermo.csv", "trajectory.gsd"];
    assert_eq!(now.keys().collect::<Vec<_>>(), [&names[..], &["trajectory.xyz"]].concat());
    fs::write(folder.join("trajectory.csv"), "mine").unwrap();
    let before = contents(&folder);
    let output = place.carom(&["run", "scene.toml", "--force", "--set", "output.formats=[\"csv\"]"]);
    assert!(code(&output) == 2 && contents(&folder) == before, "{}", errors(&output));
    assert!(!folder.join("replacement").exists());
}

#[test]
fn users_file_in_a_converted_folder_is_reported_before_the_run() {
    let place = Place::with(&format!("{FLUID}[output]\nformats = [\"npy\"]\n"));
    let folder = place.path().join("runs/scene");
    place.done(&["run", "scene.toml"]);
    fs::write(folder.join("trajectory-npy/notes.txt"), "mine").unwrap();
    let before = contents(&folder);
    for arguments in
        [&["run", "scene.toml", "--force"][..], &["run", "--resume", "runs/scene", "--until-events", "4100"]]
    {
        place.refused(arguments, &["notes.txt"]);
        assert!(contents(&folder) == before, "{arguments:?}");
    }
}

#[test]
fn a_run_whose_conversion_fails_is_complete_but_replaces_nothing() {
    let place = Place::with(&format!("{FLUID}[output]\nformats = [\"npy\", \"gsd\"]\n"));
    let scene = Scene::from_file(place.path().join("scene.toml")).unwrap();
    let target = place.path().join("run");
    // The target is empty in the first round. Then it contains the finished run.
    for (path, kept) in [(target.clone(), None), (target.join("replacement"), Some(target.clone()))] {
        let mut folder = when_free(|| Folder::create(&target, &scene, Existing::Replace));
        fs::create_dir(path.join("trajectory-npy")).unwrap();
        fs::write(path.join("trajectory-npy/notes.txt"), "mine").unwrap();
        let finished = run(scene.clone(), &mut folder, &mut |_| ControlFlow::Continue(())).unwrap();
        let done = folder.complete(&finished, "").unwrap();
        assert_eq!((&done.folder, &done.kept, done.failures.len()), (&path, &kept, 1), "{:?}", done.failures);
        assert!(path.join("summary.json").exists() && path.join("trajectory.gsd").exists());
        assert_eq!(fs::read_to_string(path.join("trajectory-npy/notes.txt")).unwrap(), "mine");
        // When the user's file is gone, the failed conversion is repeated.
        fs::remove_file(path.join("trajectory-npy/notes.txt")).unwrap();
        let (mut folder, checkpoint) = when_free(|| Folder::resume(&target, None));
        let result = Run::resume(checkpoint).execute(&mut folder, &mut |_| ControlFlow::Continue(()));
        let done = folder.complete(&result.unwrap(), "").unwrap();
        assert_eq!((&done.folder, &done.kept, done.failures.len()), (&target, &None, 0), "{:?}", done.failures);
        assert!(target.join("trajectory-npy/positions.npy").exists() && !target.join("replacement").exists());
    }
}

#[test]
fn end_that_has_passed_is_rejected_without_changes() {
    let place = Place::with(FLUID);
    let scene = ["run", "scene.toml", "--until-time", "2", "--set", "run.equilibration_events=100"];
    place.done(&scene);
    let folder = place.path().join("runs/scene");
    let before = contents(&folder);
    for end in [["--until-time", "1.5"], ["--until-events", "5"]] {
        place.refused(&[&["run", "--resume", "runs/scene"], &end[..]].concat(), &["expected a later end than"]);
        assert!(contents(&folder) == before, "{end:?}");
    }
    for end in ["2", "2.5"] {
        place.done(&["run", "--resume", "runs/scene", "--until-time", end]);
        assert!(place.read("runs/scene/scene.toml").contains(&format!("until_time = {end}")));
    }
}

#[cfg(unix)]
#[test]
fn link_to_a_run_folder_counts_as_the_folder() {
    let place = Place::with(FLUID);
    place.done(&["run", "scene.toml"]);
    std::os::unix::fs::symlink("runs/scene", place.path().join("link")).unwrap();
    let output = place.carom(&["run", "scene.toml", "--out", "link/new"]);
    assert!(code(&output) == 2 && line(&output).contains("the folder of a run"), "{}", errors(&output));
    place.done(&["run", "scene.toml", "--out", "link", "--force", "--seed", "2"]);
    assert_eq!(place.summary("runs/scene")["seed"], 2);
}
