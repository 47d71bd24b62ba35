//! A run on several threads has the same bits as on one thread.

use std::cell::Cell;
use std::fs;

use super::place::{FLUID, Place, kill_until_done, run, words};

/// The fluid is large enough, and its box long enough, for several threads.
fn fluid() -> Place {
    let lattice = "arrangement = \"fcc\"\ncount = 108\npacking_fraction = 0.3";
    assert!(FLUID.contains(lattice));
    let fluid = FLUID.replace(lattice, "arrangement = \"random\"\ncount = 4500");
    Place::with(&format!("[space]\nsize = [120.0, 8.0, 8.0]\n{fluid}"))
}

fn measured(place: &Place, folder: &str) -> String {
    let mut summary = place.summary(folder);
    summary.as_object_mut().unwrap().remove("speed");
    format!("{}{}{summary}", place.measured(folder), place.read(&format!("{folder}/trajectory.xyz")))
}

#[test]
fn rows_frames_contacts_and_means_are_the_same_on_any_number_of_threads() {
    let place = fluid();
    let contacts = ["scene.toml", "--until-events", "20000", "--set", "output.contacts=true"];
    run(&place, &[&contacts[..], &["--out", "one"]].concat());
    for (folder, threads) in [("two", "2"), ("five", "5"), ("auto", "auto")] {
        let asked = [format!("--threads={threads}"), format!("--set=run.threads={threads}")];
        run(&place, &[&contacts[..], &["--out", folder, &asked[usize::from(threads == "2")]]].concat());
        assert_eq!(measured(&place, folder), measured(&place, "one"), "{threads}");
        let log = |folder: &str| fs::read(place.path().join(folder).join("contacts.csv")).unwrap();
        assert!(log(folder) == log("one"), "{threads}");
        let says =
            place.read(&format!("{folder}/report.txt")).contains(" of the steps in windows near the faces of slabs");
        assert_eq!(says, threads != "auto", "{threads}");
    }
}

#[test]
fn a_run_that_is_killed_goes_on_with_another_number_of_threads() {
    let place = fluid();
    let end = ["--until-events", "400000"];
    run(&place, &[&["scene.toml", "--out", "one"], &end[..]].concat());
    let starts = Cell::new(0);
    let kills = kill_until_done(40, || {
        let threads = ["3", "1", "2", "5"][starts.replace(starts.get() + 1) % 4];
        let is_there = place.path().join("killed/checkpoint").exists();
        let what = if is_there { ["--resume", "killed"] } else { ["scene.toml", "--out=killed"] };
        let force: &[&str] = if is_there || !place.path().join("killed").exists() { &[] } else { &["--force"] };
        let more = ["--threads", threads, "--checkpoint-every", "0.01", "-q"];
        let arguments = [&["run"], &what[..], &end, &more, force].concat();
        place.start(&arguments)
    });
    assert!(kills > 2, "{kills}");
    assert_eq!(measured(&place, "killed"), measured(&place, "one"));
}

#[test]
fn scenes_that_cannot_be_threaded_run_serially_and_say_why() {
    let place = Place::with(&format!("{FLUID}threads = 2\n"));
    let sheared = ["--set", "space.shear_rate=0.1"];
    let output = place.done(&[&["run", "scene.toml"], &sheared[..]].concat());
    let report = words(&output);
    let line_of_threads = report.lines().find(|line| line.starts_with("threads ")).unwrap();
    assert!(line_of_threads.ends_with("1 of 2: the box is sheared"), "{line_of_threads}");
    let report = words(&place.carom(&["run", "scene.toml", "--force"]));
    assert!(report.contains("1 of 2: fewer than 4,000 particles move"), "{report}");
    let short = ["--set", "fill.0.count=4000", "--set", "run.until_events=4000"];
    let report = words(&place.carom(&[&["run", "scene.toml", "--force"], &short[..]].concat()));
    assert!(report.contains("1 of 2: the box cannot be cut into slabs"), "{report}");
    let says = |more: &[&str]| {
        let checked = words(&place.carom(&[&["check", "scene.toml"], more].concat()));
        checked.lines().find_map(|line| line.trim().strip_prefix("threads ").map(|text| text.trim().to_owned()))
    };
    assert_eq!(says(&sheared).as_deref(), Some("always 1: the box is sheared"));
    assert_eq!(says(&[]).as_deref(), Some("2"));
    assert_eq!(says(&["--set", "run.threads=1"]), None);
    let auto = says(&["--set", "run.threads=auto"]).unwrap();
    assert!(auto.starts_with("as many as there are cores"), "{auto}");
    for (bad, found) in
        [("0", "is 0,"), ("65", "is 65,"), ("1.5", "is 1.5,"), ("-3", "is -3,"), ("all", "is \"all\","), ("{}", "map")]
    {
        place.refused(&["check", "scene.toml", "--set", &format!("run.threads={bad}")], &[found]);
    }
    for bad in ["0", "65", "-1", "two", "1.5"] {
        let expected = ["expected a number of threads from 1 to 64, or auto"];
        place.refused(&["run", "scene.toml", "--threads", bad], &expected);
    }
}
