//! Links, folders and pipes with the names of Carom's files. Carom writes nothing through them.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use super::exchange::CHAIN;
use super::place::{FLUID, Place, code, contents, errors, line, run};

const WORK: &str = "years of work";

fn replaced(path: &Path, put: impl FnOnce(&Path)) {
    if path.exists() {
        fs::remove_file(path).unwrap();
    }
    put(path);
}

fn refused(place: &Place, arguments: &[&str], name: &str) {
    let before = contents(place.path());
    place.refused(arguments, &[name, "expected"]);
    assert!(contents(place.path()) == before, "{arguments:?}, {name}: something was changed");
}

/// Calls `then` with a copy of the folder for each name. The user's file must stay unchanged.
fn each(scene: &str, command: &[&str], names: &[&str], then: impl Fn(&Place, &str)) {
    let place = Place::with(scene);
    place.write("thesis.tex", WORK);
    place.done(command);
    for name in names {
        let copy = Place::with(scene);
        let status = Command::new("cp").arg("-r").arg(place.path().join(".")).arg(copy.path()).status().unwrap();
        assert!(status.success());
        then(&copy, name);
        assert_eq!(copy.read("thesis.tex"), WORK, "{name}");
    }
}

#[test]
fn no_run_writes_through_a_link() {
    let names = [
        ".carom",
        "checkpoint",
        "checkpoint.partial",
        "summary.json",
        "summary.json.partial",
        "report.txt",
        "report.txt.partial",
        "thermo.csv",
        "trajectory.xyz",
        "scene.toml.partial",
        "contacts.csv.partial",
    ];
    let scene = format!("{FLUID}[output]\ncontacts = true\n");
    each(&scene, &["run", "scene.toml", "-q"], &names, |place, name| {
        let folder = place.path().join("runs/scene");
        replaced(&folder.join(name), |path| symlink(place.path().join("thesis.tex"), path).unwrap());
        for arguments in [
            &["run", "scene.toml", "--force", "--seed", "2"][..],
            &["run", "--resume", "runs/scene", "--until-events", "4100"],
        ] {
            // Without the checkpoint, a run cannot be resumed.
            if name != "checkpoint" || !arguments.contains(&"--resume") {
                refused(place, arguments, name.trim_end_matches(".partial"));
            }
        }
        assert_eq!(code(&place.carom(&["run", "scene.toml"])), 2);
    });
}

#[test]
fn folder_or_pipe_in_place_of_a_file_is_rejected_before_replacing() {
    let names = ["trajectory.xyz", "thermo.csv.partial", "checkpoint.partial", "report.txt"];
    each(FLUID, &["run", "scene.toml", "-q"], &names, |place, name| {
        let path = place.path().join("runs/scene").join(name);
        let resume = ["run", "--resume", "runs/scene", "--until-events", "4100"];
        for arguments in [&["run", "scene.toml", "--force", "--seed", "2"][..], &resume] {
            replaced(&path, |path| fs::create_dir(path).unwrap());
            refused(place, arguments, name);
            assert_eq!(place.summary("runs/scene")["events"]["total"], 4000);
            fs::remove_dir(&path).unwrap();
        }
        if Command::new("mkfifo").arg(&path).status().is_ok_and(|status| status.success()) {
            let output = place.carom(&["run", "scene.toml", "--force", "--seed", "2"]);
            assert!(code(&output) == 2 && line(&output).contains("a device or a pipe"), "{}", errors(&output));
        }
    });
}

#[test]
fn linked_subfolder_of_a_run_is_rejected() {
    let scene = format!("{FLUID}[output]\nevents = true\n");
    each(&scene, &["run", "scene.toml", "-q"], &["events", "replacement"], |place, name| {
        let folder = place.path().join("runs/scene");
        fs::create_dir_all(place.path().join("mine")).unwrap();
        if name == "events" {
            fs::rename(folder.join(name), place.path().join("mine/events")).unwrap();
            symlink(place.path().join("mine/events"), folder.join(name)).unwrap();
        } else {
            symlink(place.path().join("mine"), folder.join(name)).unwrap();
        }
        let before = contents(place.path());
        let output = place.carom(&["run", "scene.toml", "--force", "--seed", "2"]);
        assert!(code(&output) == 2 && line(&output).contains(name), "{}", errors(&output));
        assert!(contents(place.path()) == before, "{name}");
    });
}

#[test]
fn hard_links_of_partial_files_are_not_written_through() {
    each(FLUID, &["run", "scene.toml", "-q"], &["checkpoint.partial", "summary.json.partial"], |place, name| {
        let thesis = place.path().join("thesis.tex");
        fs::hard_link(&thesis, place.path().join("runs/scene").join(name)).unwrap();
        run(place, &["--resume", "runs/scene", "--until-events", "4100"]);
        fs::hard_link(&thesis, place.path().join("out.csv.partial")).unwrap();
        place.done(&["convert", "runs/scene", "--to", "csv", "--out", "out.csv", "--force"]);
    });
}

#[test]
fn no_exchange_writes_through_a_link() {
    let names = [
        ".exchange",
        "exchange.checkpoint.partial",
        "exchange.csv",
        "energies.csv",
        "energies.csv.partial",
        "curves.csv",
        "curves.csv.partial",
        "density_of_states.csv",
        "measurements",
        "potential_of_mean_force.csv",
        "trajectory-2.xyz.partial",
        "exchange.html",
        "scene.toml",
    ];
    let begin =
        ["exchange", "scene.toml", "-q", "--out", "pair", "--until-time", "30", "--set", "run.equilibration_time=3"];
    each(CHAIN, &begin, &names, |place, name| {
        let path = place.path().join("pair").join(name);
        // The link has a target with the correct content, so only the link is wrong.
        let target = place.path().join("target");
        fs::write(&target, fs::read(&path).unwrap_or_default()).unwrap();
        replaced(&path, |path| symlink(&target, path).unwrap());
        let name = name.trim_end_matches(".partial");
        let later = begin.map(|argument| if argument == "30" { "60" } else { argument });
        refused(place, &later, name);
        if name == "exchange.html" {
            refused(place, &["exchange", "pair", "-q"], name);
            refused(place, &["report", "pair", "--force"], name);
        }
    });
}

#[test]
fn no_sweep_and_no_page_is_written_through_a_link() {
    let begin = ["sweep", "scene.toml", "--vary", "seed=1,2", "--out", "s", "-q", "--set", "run.until_events=600"];
    each(FLUID, &begin, &["sweep.toml", "sweep.csv", "sweep-mean.csv", "sweep.html", "failures"], |place, name| {
        let path = place.path().join("s").join(name);
        let target = place.path().join("target");
        fs::write(&target, fs::read(&path).unwrap_or_default()).unwrap();
        replaced(&path, |path| symlink(&target, path).unwrap());
        let before = fs::read(&target).unwrap();
        let output = place.carom(&["sweep", "s", "-q"]);
        assert!(code(&output) == 2 && line(&output).contains(name), "{name}: {}", errors(&output));
        assert!(fs::read(&target).unwrap() == before && path.is_symlink(), "{name}");
        let run = place.path().join("s/seed-1");
        for (command, name) in [("report", "report.html"), ("render", "picture.png")] {
            symlink(place.path().join("thesis.tex"), run.join(name)).unwrap();
            refused(place, &[command, "s/seed-1", "--force"], name);
        }
    });
}
