//! Tests `carom convert`. `tests/readers` tests how other programs read the converted files.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const FRAME: &str = "2\nLattice=\"9 0 0 0 9 0 0 0 9\" Properties=species:S:1:pos:R:3:velo:R:3 Time=0.5\n\
    A 1 2 3 0 0 1\nB 4 5 6 0 0 -1\n";

fn carom(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.args(arguments).current_dir(folder).env("NO_COLOR", "1").output().unwrap()
}

fn said(output: &Output) -> (i32, String) {
    let text = [&output.stdout[..], &output.stderr[..]].concat();
    (output.status.code().unwrap(), String::from_utf8_lossy(&text).into_owned())
}

fn with(trajectory: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("runs/a")).unwrap();
    fs::write(folder.path().join("runs/a/trajectory.xyz"), trajectory).unwrap();
    folder
}

#[test]
fn convert_writes_beside_the_trajectory_and_needs_force_to_replace() {
    let folder = with(&FRAME.repeat(3));
    for (format, name) in [
        ("lammps", "trajectory.lammpstrj"),
        ("gsd", "trajectory.gsd"),
        ("vtk", "trajectory-vtk"),
        ("npy", "trajectory-npy"),
        ("csv", "trajectory.csv"),
        ("xyz", "trajectory-piece.xyz"),
    ] {
        let expected = format!("runs/a/{name}: 3 frames\n");
        assert_eq!(said(&carom(folder.path(), &["convert", "runs/a", "--to", format])), (0, expected.clone()));
        assert!(folder.path().join("runs/a").join(name).exists());
        let (code, text) = said(&carom(folder.path(), &["convert", "runs/a", "--to", format]));
        assert!(code == 2 && text.contains(&format!("{name} exists")) && text.contains("--force"), "{text}");
        let again = said(&carom(folder.path(), &["convert", "runs/a/trajectory.xyz", "--to", format, "--force"]));
        assert_eq!(again, (0, expected));
    }
}

#[test]
fn frames_option_selects_a_range_of_frames() {
    let folder = with(&FRAME.repeat(5));
    for (frames, count) in [("1..3", "3 frames"), ("..1", "2 frames"), ("4..", "1 frame"), ("2", "1 frame")] {
        let arguments = ["convert", "runs/a", "--to", "csv", "--out", "a.csv", "--force", "--frames", frames];
        assert_eq!(said(&carom(folder.path(), &arguments)), (0, format!("a.csv: {count}\n")));
    }
    let table = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert_eq!(table.lines().nth(2), Some("2,0.5,1,B,4,5,6,0,0,-1,0.5"));
}

#[test]
fn convert_errors_say_what_is_wrong_and_where() {
    let folder = with(&format!("{FRAME}{}", FRAME.replace("B 4 5", "B 4 x")));
    fs::write(folder.path().join("empty.xyz"), "").unwrap();
    fs::create_dir(folder.path().join("empty")).unwrap();
    let to = |more: &[&'static str]| [&["convert"], more, &["--to", "gsd"]].concat();
    for (arguments, expected) in [
        (to(&["runs/a"]), "line 8: position is `x`"),
        (to(&["runs/a"]), "trajectory.xyz"),
        (to(&["empty.xyz"]), "empty.xyz: the file holds no frame"),
        (to(&["missing.xyz"]), "missing.xyz"),
        (to(&["empty"]), "no trajectory.xyz"),
        (to(&["empty.xyz", "--frames", "3..1"]), "FIRST..LAST"),
        (vec!["convert", "runs/a", "--to", "pdb"], "lammps"),
        (vec!["convert", "runs/a"], "--to"),
    ] {
        let (code, text) = said(&carom(folder.path(), &arguments));
        assert_eq!(code, 2, "{arguments:?}: {text}");
        let text: String = text.replace("│ ", "").split_whitespace().collect();
        let expected: String = expected.split_whitespace().collect();
        assert!(text.contains(&expected), "{arguments:?}: {text}");
    }
    let left = fs::read_dir(folder.path().join("runs/a")).unwrap().count();
    assert_eq!(left, 1, "nothing is left of what failed");
}

#[test]
fn convert_writes_the_complete_frames_of_a_killed_run() {
    let text = FRAME.repeat(2);
    let folder = with(&text[..text.len() - 4]);
    let (code, text) = said(&carom(folder.path(), &["convert", "runs/a", "--to", "csv"]));
    assert!(code == 0 && text.contains("1 frame; the trajectory ends within the next one"), "{text}");
}

#[test]
fn compressed_trajectories_are_written_and_read_wherever_plain_ones_are() {
    let folder = with(&FRAME.repeat(4));
    let convert = |arguments: &[&str]| said(&carom(folder.path(), &[&["convert"], arguments].concat()));
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(convert(&["runs/a", "--to", "csv", "--out", "plain.csv"]).0, 0);
    assert_eq!(convert(&["runs/a", "--to", "xyz", "--out", "plain.xyz"]).0, 0);
    for (name, start) in [("t.xyz.gz", &[0x1f, 0x8b][..]), ("t.xyz.zst", &[0x28, 0xb5, 0x2f, 0xfd])] {
        assert_eq!(convert(&["runs/a", "--to", "xyz", "--out", name]), (0, format!("{name}: 4 frames\n")));
        assert!(read(name).starts_with(start), "{name} is compressed");
        assert_eq!(convert(&[name, "--to", "csv", "--out", "again.csv", "--force"]).0, 0);
        assert_eq!(read("again.csv"), read("plain.csv"), "{name}");
        assert_eq!(convert(&[name, "--to", "xyz", "--out", "again.xyz", "--force"]).0, 0);
        assert_eq!(read("again.xyz"), read("plain.xyz"), "{name}");
        let (code, text) = said(&carom(folder.path(), &["render", name, "--out", "p.png", "--force"]));
        assert_eq!(code, 0, "{text}");
        let (code, text) = said(&carom(folder.path(), &["movie", name, "--out", "m.gif"]));
        assert!(code == 2 && text.contains("is compressed"), "{text}");
        let scene = format!(
            "[[species]]\nname = 'A'\nmass = 1.0\ndiameter = 1.0\n[[species]]\nname = 'B'\nmass = 1.0\ndiameter = 1.0\n\
             [[interaction]]\nspecies = ['A', 'B']\npotential = 'hard-sphere'\n[[interaction]]\nspecies = ['A', 'A']\npotential = 'hard-sphere'\n\
             [[interaction]]\nspecies = ['B', 'B']\npotential = 'hard-sphere'\n[[file]]\npath = '{name}'\nframe = -1\n[run]\nuntil_time = 1.0\n"
        );
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let (code, text) = said(&carom(folder.path(), &["check", "scene.toml"]));
        assert!(code == 0 && text.contains("1 A") && text.contains("9"), "{text}");
    }
    let (code, text) = convert(&["runs/a", "--to", "csv", "--out", "t.csv.gz"]);
    assert!(code == 2 && text.contains("but only extended XYZ can"), "{text}");
    let packed = read("t.xyz.gz");
    fs::write(folder.path().join("cut.xyz.gz"), &packed[..packed.len() / 2]).unwrap();
    let (code, text) = convert(&["cut.xyz.gz", "--to", "csv", "--out", "cut.csv"]);
    assert!(code == 2 && !text.contains("panicked"), "{text}");
}
