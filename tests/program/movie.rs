//! Movies of a run.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Stdio};

use super::place::{FLUID, Place, code, contents, errors, line, send_signal, wait_until, words};

fn place(frames: usize) -> Place {
    let scene = FLUID.replace("equilibration_events = 500\n", "");
    let place = Place::with(&format!("{scene}[output]\nframe_interval = 0.02\n"));
    let until = format!("{}", 0.02 * (frames as f64 - 0.5));
    place.done(&["run", "scene.toml", "-q", "--until-time", &until]);
    place
}

fn frames_of(place: &Place) -> usize {
    place.read("runs/scene/trajectory.xyz").matches("Lattice=").count()
}

/// Returns the size of a GIF. For each image, returns the changed pixels and the duration in hundredths of a second.
fn gif_frames(path: &Path) -> (u16, u16, Vec<(Vec<u8>, u16)>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(File::open(path).unwrap()).unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        frames.push((frame.buffer.to_vec(), frame.delay));
    }
    (decoder.width(), decoder.height(), frames)
}

fn has_ffmpeg() -> bool {
    Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

#[test]
fn a_movie_has_all_frames_of_a_run() {
    let place = place(6);
    let count = frames_of(&place);
    assert!(count > 5);
    let before = contents(place.path());
    for name in ["film.gif", "film.apng"] {
        let output = place.carom(&["movie", "runs/scene", "--out", name, "--size", "120x90", "--fps", "20", "-q"]);
        assert_eq!((code(&output), errors(&output).as_str()), (0, ""));
        let said = format!("{name}: {count} frames in {:.1} s, ", count as f64 / 20.0);
        assert!(words(&output).starts_with(&said), "{}", words(&output));
    }
    let (width, height, frames) = gif_frames(&place.path().join("film.gif"));
    assert_eq!((width, height, frames.len()), (120, 90, count));
    assert!(frames.iter().all(|(_, delay)| *delay == 5));
    assert_eq!(frames[0].0.len(), 4 * 120 * 90);
    assert!(
        frames[count - 1].0.chunks(4).filter(|pixel| pixel[3] > 0).count() > 100,
        "the last one shows something else"
    );
    let file = BufReader::new(File::open(place.path().join("film.apng")).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    let info = reader.info();
    assert_eq!((info.width, info.height), (120, 90));
    assert_eq!(info.animation_control().unwrap().num_frames as usize, count);
    let control = info.frame_control().unwrap();
    assert_eq!((control.delay_num, control.delay_den), (1, 20));
    for name in ["film.gif", "film.apng"] {
        fs::remove_file(place.path().join(name)).unwrap();
    }
    assert!(contents(place.path()) == before, "nothing else has changed");
}

#[test]
fn frames_speed_turn_and_colours_are_chosen() {
    let place = place(9);
    let chosen =
        ["movie", "runs/scene/trajectory.xyz", "--size", "80x60", "-q", "--turn", "-45.5", "--colour", "speed"];
    let chosen = [&chosen[..], &["--frames", "2..7", "--every", "2", "--fps", "30", "--out", "film.GIF"]].concat();
    place.done(&chosen);
    let (_, _, frames) = gif_frames(&place.path().join("film.GIF"));
    assert_eq!(frames.iter().map(|(_, delay)| *delay).collect::<Vec<_>>(), [3, 4, 3]);
    let film = fs::read(place.path().join("film.GIF")).unwrap();
    for (other, is_other) in
        [("--turn=-45.5", false), ("--turn=0", true), ("--colour=species", true), ("--frames=2..6", false)]
    {
        let key = other.split('=').next().unwrap();
        let at = chosen.iter().position(|word| *word == key).unwrap();
        let mut changed = chosen.clone();
        changed.splice(at..at + 2, [other]);
        let output = place.carom(&[&changed[..], &["--force"]].concat());
        assert_eq!(code(&output), 0, "{other}: {}", errors(&output));
        assert_eq!(fs::read(place.path().join("film.GIF")).unwrap() != film, is_other, "{other}");
    }
}

#[test]
fn no_movie_replaces_anything_unasked_or_a_file_of_the_run() {
    let place = place(2);
    fs::write(place.path().join("mine.gif"), "years of work").unwrap();
    let before = contents(place.path());
    let small = ["--size", "32x32"];
    for (arguments, exit, expected) in [
        (&["movie", "runs/scene", "--out", "mine.gif"][..], 2, "--force"),
        (&["movie", "runs/scene", "--out", "film.avi"], 2, "expected .mp4, .gif or .apng"),
        (&["movie", "runs/scene", "--out", "film"], 2, "expected .mp4, .gif or .apng"),
        (&["movie", "runs/scene", "--out", "runs/scene/trajectory.xyz", "--force"], 2, "which is read"),
        (&["movie", "runs/scene", "--out", "film.gif", "--fps", "51"], 2, "50 with --fps"),
        (&["movie", "runs/scene", "--out", "film.gif", "--fps", "0"], 2, "--fps"),
        (&["movie", "runs/scene", "--out", "film.gif", "--every", "0"], 2, "at least 1"),
        (&["movie", "runs/scene", "--out", "film.gif", "--turn", "nan"], 2, "degrees"),
        (&["movie", "runs/scene", "--out", "film.gif", "--frames", "9.."], 2, "frame 9 of"),
        (&["movie", "runs/scene", "--out", "film.gif", "--frames", "4..3"], 2, "FIRST..LAST"),
        (&["movie", "runs", "--out", "film.gif"], 2, "no trajectory.xyz"),
        (&["movie", "scene.toml", "--out", "film.gif"], 2, "cannot read the trajectory scene.toml"),
        (&["movie", "runs/scene", "--out", "nowhere/film.gif"], 2, "cannot write nowhere/film.gif"),
        (&["movie", "runs/scene"], 2, "--out"),
    ] {
        let output = place.carom(&[arguments, &small].concat());
        assert_eq!(code(&output), exit, "{arguments:?}: {}", errors(&output));
        assert!(line(&output).contains(expected), "{arguments:?}: {}", errors(&output));
        assert!(contents(place.path()) == before, "{arguments:?} changed something");
    }
    place.done(&["movie", "runs/scene", "--out", "mine.gif", "--force", "--size", "32x32", "-q"]);
    assert_eq!(gif_frames(&place.path().join("mine.gif")).2.len(), frames_of(&place));
}

#[test]
fn an_mp4_has_all_frames_where_ffmpeg_is() {
    if !has_ffmpeg() {
        return;
    }
    let place = place(5);
    place.done(&["movie", "runs/scene", "--out", "film.mp4", "--size", "96x64", "-q"]);
    let decoded = Command::new("ffmpeg")
        .args(["-v", "error", "-i", "film.mp4", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"])
        .current_dir(place.path())
        .output()
        .unwrap();
    let images: Vec<&[u8]> = decoded.stdout.chunks(96 * 64 * 3).collect();
    assert_eq!((images.len(), decoded.stdout.len() % (96 * 64 * 3)), (frames_of(&place), 0), "{}", errors(&decoded));
    assert!(images[0] != images[images.len() - 1]);
    // A corner shows the light background. Lossy compression may change it a little.
    let corner = &images[0][..3];
    assert!(
        corner.iter().zip([247, 248, 250]).all(|(found, exact): (&u8, u8)| found.abs_diff(exact) <= 4),
        "{corner:?}"
    );
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 3);
}

#[test]
fn without_ffmpeg_an_mp4_is_refused_before_anything_is_drawn() {
    let place = place(2);
    let before = contents(place.path());
    let output = place.command(&["movie", "runs/scene", "--out", "film.mp4"]).env("PATH", "").output().unwrap();
    assert_eq!(code(&output), 2, "{}", errors(&output));
    for expected in ["ffmpeg", "install", ".gif or .apng"] {
        assert!(line(&output).contains(expected), "{}", errors(&output));
    }
    assert!(!errors(&output).contains("drawing") && contents(place.path()) == before);
    let output = place.command(&["movie", "runs/scene", "--out", "film.mp4", "--size", "31x32"]).output().unwrap();
    assert!(code(&output) == 2 && line(&output).contains("even numbers with --size"), "{}", errors(&output));
}

#[cfg(unix)]
#[test]
fn an_ffmpeg_that_fails_says_why_and_leaves_nothing() {
    use std::os::unix::fs::PermissionsExt;

    let place = place(3);
    let tools = tempfile::tempdir().unwrap();
    let path = tools.path().join("ffmpeg");
    let with = |script: &str| {
        fs::write(
            &path,
            format!("#!/bin/sh\ncase \"$*\" in *-encoders*) echo ' V..... libx264 x'; exit;; esac\n{script}\n"),
        )
        .unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        let arguments = ["movie", "runs/scene", "--out", "film.mp4", "--size", "64x48", "-q"];
        place.command(&arguments).env("PATH", tools.path()).output().unwrap()
    };
    let before = contents(place.path());
    for (script, expected) in [
        ("echo the disk is full >&2; exit 1", "ffmpeg failed: the disk is full"),
        ("/bin/cat > /dev/null; exit 3", "ffmpeg failed: it ended with exit status: 3"),
        ("exit 0", "ffmpeg failed"),
    ] {
        let output = with(script);
        assert_eq!(code(&output), 1, "{script}: {}", errors(&output));
        assert!(line(&output).contains(expected), "{script}: {}", errors(&output));
        assert!(contents(place.path()) == before, "{script}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_of_a_movie() {
    let place = place(40);
    let before = contents(place.path());
    let names = if has_ffmpeg() { &["film.gif", "film.apng", "film.mp4"][..] } else { &["film.gif", "film.apng"] };
    for name in names {
        let arguments = ["movie", "runs/scene", "--out", name, "--size", "1600x1200"];
        let child = place.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        assert!(wait_until(|| fs::read_dir(place.path()).unwrap().count() > 2), "{name}");
        send_signal(&child, "-INT");
        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), 1, "{name}: {}", errors(&output));
        assert!(line(&output).contains("interrupted"), "{}", errors(&output));
        assert!(contents(place.path()) == before, "{name}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_movie_whose_ffmpeg_hangs() {
    use std::os::unix::fs::PermissionsExt;

    let place = place(3);
    let tools = tempfile::tempdir().unwrap();
    let (path, begun) = (tools.path().join("ffmpeg"), tools.path().join("begun"));
    let script = "#!/bin/sh\ncase \"$*\" in *-encoders*) echo ' V..... libx264 x'; exit;; esac\n";
    // A fake `ffmpeg` reads one byte and hangs, so that Carom waits for it.
    let read = "/bin/dd bs=1 count=1 of=/dev/null 2> /dev/null";
    let hang = format!("{read}\necho > '{}'\nexec /bin/sleep 1000\n", begun.display());
    fs::write(&path, [script, &hang].concat()).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    let before = contents(place.path());
    // An image is larger than the buffer of a pipe.
    let arguments = ["movie", "runs/scene", "--out", "film.mp4", "--size", "640x480", "-q"];
    let mut command = place.command(&arguments);
    let mut child = command.env("PATH", tools.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    assert!(wait_until(|| begun.exists()));
    send_signal(&child, "-INT");
    let has_ended = wait_until(|| child.try_wait().unwrap().is_some());
    let _ = child.kill();
    let output = child.wait_with_output().unwrap();
    assert!(has_ended && line(&output).contains("interrupted"), "{}", errors(&output));
    assert_eq!(code(&output), 1);
    assert!(contents(place.path()) == before);
}
