//! Commands that run with a fault, and checks of the files after the fault.

use std::path::Path;

use super::place::{Files, Place};

pub struct Scenario {
    pub name: &'static str,
    pub command: &'static str,
    /// Files may change if their paths begin with one of these strings.
    pub touches: &'static [&'static str],
    /// Checks the files directly after the fault.
    pub kept: fn(&Files, &Files, &str),
    /// Runs the command with which a user would continue after the fault.
    pub go_on: fn(&Place, &Path, &str),
    /// Checks the files after the user has continued.
    pub check: fn(&Files, &str),
}

pub const SCENARIOS: [Scenario; 12] = [
    Scenario {
        name: "run",
        command: "run scene.toml -q --seed 1 --out new --checkpoint-every 0.001",
        touches: &[],
        kept: |_, _, _| {},
        go_on: |place, folder, what| {
            let begin = "run scene.toml -q --seed 1 --out new --checkpoint-every 0.001";
            let resume = "run -q --resume new";
            let is_begun = folder.join("new/checkpoint").exists();
            succeed(place, folder, if is_begun { resume } else { begin }, what);
        },
        check: |files, what| same_run(files, "one", "new", what),
    },
    Scenario {
        name: "resume",
        command: "run -q --resume cut --checkpoint-every 0.001",
        touches: &["cut/"],
        kept: |_, _, _| {},
        go_on: |place, folder, what| succeed(place, folder, "run -q --resume cut", what),
        check: |files, what| same_run(files, "whole", "cut", what),
    },
    Scenario {
        name: "extend",
        command: "run -q --resume one --until-time 3.0 --checkpoint-every 0.001",
        touches: &["one/"],
        kept: |_, _, _| {},
        go_on: |place, folder, what| succeed(place, folder, "run -q --resume one --until-time 3.0", what),
        check: |files, what| same_run(files, "long", "one", what),
    },
    Scenario {
        name: "replace",
        command: "run scene.toml -q --seed 2 --out one --force --checkpoint-every 0.001",
        touches: &["one/"],
        kept: |before, after, what| {
            // The old run stays complete until the new run is complete. A note then marks the replacement.
            let is_noted = String::from_utf8_lossy(&after["one/.carom"]).contains("replacement complete");
            if !is_noted && !is_new(after, "one", "two") {
                for (name, bytes) in of(before, "one").filter(|(name, _)| *name != ".carom") {
                    assert!(after.get(&format!("one/{name}")) == Some(bytes), "{what}: one/{name} is lost");
                }
            }
        },
        go_on: |place, folder, what| {
            let again = "run scene.toml -q --seed 2 --out one --force";
            let is_begun = folder.join("one/replacement/checkpoint").exists();
            succeed(place, folder, if is_begun { "run -q --resume one" } else { again }, what);
        },
        check: |files, what| {
            same_run(files, "two", "one", what);
            assert!(!files.keys().any(|name| name.contains("replacement")), "{what}: {:?}", files.keys());
        },
    },
    Scenario {
        name: "convert to a folder",
        command: "convert one --to vtk --out old-vtk --force",
        touches: &["old-vtk"],
        kept: |before, after, what| {
            let old = of(before, "old-vtk").all(|(name, bytes)| after.get(&format!("old-vtk/{name}")) == Some(bytes));
            let has_all = of(before, "old-vtk").all(|(name, _)| after.contains_key(&format!("old-vtk/{name}")));
            let is_new = !old && has_all;
            assert!(old || is_new, "{what}: old and new are lost");
        },
        go_on: |place, folder, what| succeed(place, folder, "convert one --to vtk --out old-vtk --force", what),
        check: |files, what| assert!(!files.keys().any(|name| name.starts_with("old-vtk.")), "{what}"),
    },
    Scenario {
        name: "convert to arrays",
        command: "convert one --to npy --out old-npy --force",
        touches: &["old-npy"],
        kept: |before, after, what| {
            let is =
                |run: &str| of(before, run).all(|(name, bytes)| after.get(&format!("old-npy/{name}")) == Some(bytes));
            assert!(is("old-npy") || is("one/trajectory-npy"), "{what}: old and new are lost");
        },
        go_on: |place, folder, what| succeed(place, folder, "convert one --to npy --out old-npy --force", what),
        check: |files, what| {
            let is_new = of(files, "one/trajectory-npy")
                .all(|(name, bytes)| files.get(&format!("old-npy/{name}")) == Some(bytes));
            assert!(is_new, "{what}");
        },
    },
    Scenario {
        name: "convert to a file",
        command: "convert one --to csv --out old.csv --force",
        touches: &["old.csv"],
        kept: |before, after, what| whole(before, after, "old.csv", b"frame,time", what),
        go_on: |place, folder, what| succeed(place, folder, "convert one --to csv --out old.csv --force", what),
        check: |_, _| {},
    },
    Scenario {
        name: "report",
        command: "report one --out old.html --force",
        touches: &["old.html"],
        kept: |before, after, what| {
            whole(before, after, "old.html", b"<!", what);
            let end = String::from_utf8_lossy(&after["old.html"]).trim_end().ends_with("</html>");
            assert!(end, "{what}: half a page");
        },
        go_on: |place, folder, what| succeed(place, folder, "report one --out old.html --force", what),
        check: |_, _| {},
    },
    Scenario {
        name: "render",
        command: "render one --size 64x48 --out old.png --force",
        touches: &["old.png"],
        kept: |before, after, what| {
            whole(before, after, "old.png", b"\x89PNG", what);
            assert!(after["old.png"].ends_with(b"IEND\xaeB`\x82"), "{what}: half a picture");
        },
        go_on: |place, folder, what| succeed(place, folder, "render one --size 64x48 --out old.png --force", what),
        check: |_, _| {},
    },
    Scenario {
        name: "exchange",
        command: "exchange pair.toml -q --jobs 1 --out new --checkpoint-every 0.001",
        touches: &[],
        kept: |_, _, _| {},
        go_on: |place, folder, what| succeed(place, folder, "exchange pair.toml -q --jobs 1 --out new", what),
        check: |files, what| same_exchange(files, "pair", "new", what),
    },
    Scenario {
        name: "extend an exchange",
        command: "exchange pair -q --jobs 1 --until-time 40 --checkpoint-every 0.001",
        touches: &["pair/"],
        kept: |_, _, _| {},
        go_on: |place, folder, what| succeed(place, folder, "exchange pair -q --jobs 1 --until-time 40", what),
        check: |files, what| same_exchange(files, "later", "pair", what),
    },
    Scenario {
        name: "sweep",
        command: "sweep scene.toml -q --jobs 1 --vary seed=1,2 --set output.formats=[] --out new --checkpoint-every 0.001",
        touches: &[],
        kept: |_, _, _| {},
        go_on: |place, folder, what| {
            succeed(
                place,
                folder,
                "sweep scene.toml -q --jobs 1 --vary seed=1,2 --set output.formats=[] --out new",
                what,
            );
        },
        check: |files, what| {
            for point in ["seed-1", "seed-2"] {
                same_run(files, &format!("sweep/{point}"), &format!("new/{point}"), what);
            }
            let names = |folder| of(files, folder).map(|(name, _)| name).filter(|name| !name.contains("checkpoint"));
            assert!(names("sweep").eq(names("new")), "{what}: {:?}", names("new").collect::<Vec<_>>());
            assert!(files["sweep/sweep-mean.csv"] == files["new/sweep-mean.csv"], "{what}");
        },
    },
];

fn succeed(place: &Place, folder: &Path, command: &str, what: &str) {
    let output = place.try_to(folder, command);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{what}: then {command}: {message}");
}

fn of<'a>(files: &'a Files, folder: &'a str) -> impl Iterator<Item = (&'a str, &'a Vec<u8>)> {
    let inside = move |name: &'a String| name.strip_prefix(folder).and_then(|rest| rest.strip_prefix('/'));
    files.iter().filter_map(move |(name, bytes)| inside(name).map(|name| (name, bytes)))
}

fn whole(before: &Files, after: &Files, name: &str, start: &[u8], what: &str) {
    let now = after.get(name).unwrap_or_else(|| panic!("{what}: {name} is lost"));
    assert!(now == &before[name] || now.starts_with(start), "{what}: {name} is neither the old one nor the new one");
}

fn is_new(files: &Files, folder: &str, other: &str) -> bool {
    files.get(&format!("{folder}/thermo.csv")) == files.get(&format!("{other}/thermo.csv"))
}

fn same_run(files: &Files, expected: &str, found: &str, what: &str) {
    let is_result = |name: &str| {
        !["checkpoint", ".carom", "report.txt", "notes.txt", "run.html"].iter().any(|other| name.starts_with(other))
    };
    for (name, bytes) in of(files, expected).filter(|(name, _)| is_result(name)) {
        let other =
            files.get(&format!("{found}/{name}")).unwrap_or_else(|| panic!("{what}: {found}/{name} is missing"));
        if name == "summary.json" {
            assert_eq!(without_speed(bytes), without_speed(other), "{what}: {name}");
        } else {
            assert!(bytes == other, "{what}: {name} differs");
        }
    }
    for (name, _) in of(files, found).filter(|(name, _)| is_result(name)) {
        assert!(files.contains_key(&format!("{expected}/{name}")), "{what}: {found}/{name} is left");
    }
}

/// Compares all files of an exchange except the checkpoint, which contains the initial scene.
fn same_exchange(files: &Files, expected: &str, found: &str, what: &str) {
    let all = |folder| of(files, folder).filter(|(name, _)| *name != "exchange.checkpoint").collect::<Vec<_>>();
    let names = |folder| all(folder).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    assert_eq!(names(expected), names(found), "{what}");
    for ((name, one), (_, other)) in all(expected).into_iter().zip(all(found)) {
        assert!(one == other, "{what}: {name} differs");
    }
}

fn without_speed(summary: &[u8]) -> serde_json::Value {
    let mut summary: serde_json::Value = serde_json::from_slice(summary).unwrap();
    summary.as_object_mut().unwrap().remove("speed");
    summary
}
