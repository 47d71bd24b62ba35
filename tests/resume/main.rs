//! Runs that are stopped in any way and resumed have the same bits as uninterrupted runs.

#[path = "../program/files.rs"]
mod files;
mod runs;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use files::files;
use runs::{SCENES, assert_same, carom, files_of, finish, resume, start, stop, unfinish, unwrapped};

const STOPS: usize = 8;

/// Largest number of tries for each stop.
const TRIES: usize = 200;

#[test]
fn random_stops_change_no_bit() {
    let halves = SCENES.chunks(SCENES.len().div_ceil(2));
    let stopped = |half: &[(&str, &str)]| half.iter().map(|(scene, events)| stop_at_random(scene, events)).collect();
    let ways: Vec<[usize; 3]> = std::thread::scope(|scope| {
        let threads: Vec<_> = halves.map(|half| scope.spawn(move || stopped(half))).collect();
        threads.into_iter().flat_map(|thread| -> Vec<[usize; 3]> { thread.join().unwrap() }).collect()
    });
    let ways = [0, 1, 2].map(|way| ways.iter().map(|ways| ways[way]).sum::<usize>());
    println!("stops: {} by SIGKILL, {} by SIGTERM, {} by SIGINT", ways[0], ways[1], ways[2]);
    assert!(ways.iter().all(|stops| *stops >= 4), "{ways:?}");
}

/// Stops a run and continues it several times. Returns how often it was stopped in each way.
fn stop_at_random(scene: &str, events: &str) -> [usize; 3] {
    let directory = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(scene.bytes().map(u64::from).sum());
    let whole = directory.path().join("whole");
    let begun = std::time::Instant::now();
    finish(start(scene, events, &whole));
    // Upper limit of the random time before a stop, in milliseconds.
    let mut latest = u64::try_from(begun.elapsed().as_millis()).unwrap() / 4 + 4;
    let (mut runs, mut stops, mut ways) = (0, 0, [0; 3]);
    let fresh = |runs: usize| {
        let parts = directory.path().join(runs.to_string());
        (start(scene, events, &parts), parts)
    };
    let (mut command, mut parts) = fresh(runs);
    for _ in 0..STOPS * TRIES {
        let mut child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1 + random.next_u64() % latest));
        let way = random.next_u32() % 3;
        if !stop(&mut child, way) {
            finish(resume(&parts));
            assert_same(&whole, &parts, scene);
            (latest, runs) = (latest - latest / 4, runs + 1);
            (command, parts) = fresh(runs);
            continue;
        }
        // A stop before the first checkpoint leaves nothing to continue.
        if !parts.join("checkpoint").exists() {
            latest += latest / 4 + 1;
            command = start(scene, events, &parts);
            continue;
        }
        ways[way as usize] += 1;
        stops += 1;
        command = resume(&parts);
        if stops == STOPS {
            break;
        }
    }
    assert_eq!(stops, STOPS, "{scene}: stops that a run could be gone on from");
    finish(command);
    assert_same(&whole, &parts, scene);
    let is_left = |file: &&PathBuf| file.to_string_lossy().ends_with(".partial");
    assert_eq!(files_of(&parts).iter().find(is_left), None, "{scene}");
    ways
}

#[test]
fn extending_a_finished_run_equals_one_longer_run() {
    let directory = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| directory.path().join(name));
    let scene = format!("{}/configs/square_well_fluid.toml", env!("CARGO_MANIFEST_DIR"));
    let run = |time: &str, folder: &Path| {
        let mut command = carom(&["run", &scene, "--quiet", "--until-time", time]);
        command.args(["--set", "run.equilibration_events=5000", "--set", "output.contacts=true"]);
        command.args(["--set", "output.events=true"]);
        // 0.1 is not a binary fraction, so the last tick is not exactly at the end.
        command.args(["--set", "output.thermo_interval=0.1", "--set", "output.frame_interval=0.3"]);
        command.arg("--out").arg(folder);
        command
    };
    finish(run("1.2", &whole));
    finish(run("0.6", &parts));
    let mut longer = resume(&parts);
    longer.args(["--until-time", "1.2"]);
    finish(longer);
    assert_same(&whole, &parts, "square wells");
}

#[test]
fn damaged_checkpoints_are_rejected_and_the_run_is_kept() {
    let directory = tempfile::tempdir().unwrap();
    let folder = directory.path().join("run");
    finish(start("pendulum", "20000", &folder));
    let checkpoint = folder.join("checkpoint");
    let good = fs::read(&checkpoint).unwrap();
    let refused = |expected: &str| {
        let output = resume(&folder).output().unwrap();
        let message = unwrapped(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(expected), "{message}");
        assert!(folder.join("summary.json").exists(), "{expected}");
    };
    let mut random = ChaCha8Rng::seed_from_u64(6);
    for _ in 0..20 {
        let mut bad = good.clone();
        let at = usize::try_from(random.next_u64() % bad.len() as u64).unwrap();
        bad[at] ^= 1 << (random.next_u32() % 8);
        fs::write(&checkpoint, &bad).unwrap();
        refused("damaged");
    }
    fs::write(&checkpoint, &good[..good.len() / 2]).unwrap();
    refused("its end is");
    fs::write(&checkpoint, "").unwrap();
    refused("damaged");
    let _ = fs::remove_file(folder.join("checkpoint.previous"));
    fs::remove_file(&checkpoint).unwrap();
    refused("no checkpoint");
    fs::write(&checkpoint, &good).unwrap();
    let thermo = fs::read(folder.join("thermo.csv")).unwrap();
    fs::write(folder.join("thermo.csv"), &thermo[..100]).unwrap();
    refused("has 100 bytes");
    fs::write(folder.join("thermo.csv"), &thermo).unwrap();
    finish(resume(&folder));
}

#[test]
fn resume_falls_back_to_the_previous_checkpoint() {
    let directory = tempfile::tempdir().unwrap();
    let folder = directory.path().join("run");
    finish(start("pendulum", "20000", &folder));
    let results = ["thermo.csv", "trajectory.xyz", "contacts.csv"].map(|name| folder.join(name));
    let before = results.clone().map(|path| fs::read(path).unwrap());
    fs::rename(folder.join("checkpoint"), folder.join("checkpoint.previous")).unwrap();
    finish(resume(&folder));
    assert!(before == results.map(|path| fs::read(path).unwrap()));
}

#[test]
fn checkpoint_resumes_only_with_the_files_of_its_run() {
    let directory = tempfile::tempdir().unwrap();
    let [whole, one, two] = ["whole", "one", "two"].map(|name| directory.path().join(name));
    for (folder, seed) in [(&whole, "seed=1"), (&one, "seed=1"), (&two, "seed=2")] {
        let mut command = start("granular_cooling", "20000", folder);
        command.args(["--set", seed]);
        finish(command);
    }
    unfinish(&one);
    let good = files(&one);
    let restore = || good.iter().for_each(|(name, bytes)| fs::write(one.join(name), bytes).unwrap());
    let refused = |expected: &str| {
        let before = files(&one);
        let output = resume(&one).output().unwrap();
        let message = unwrapped(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(expected), "{message}");
        assert!(files(&one) == before, "{expected}: something was changed");
        restore();
    };
    let flip = |name: &str, at: usize| {
        let mut bytes = good[name].clone();
        bytes[at] ^= 1;
        fs::write(one.join(name), bytes).unwrap();
    };
    fs::copy(two.join("checkpoint"), one.join("checkpoint")).unwrap();
    refused("scene.toml.partial is not the scene of the checkpoint");
    fs::copy(two.join("checkpoint"), one.join("checkpoint")).unwrap();
    fs::copy(two.join("scene.toml"), one.join("scene.toml.partial")).unwrap();
    refused("thermo.csv.partial");
    let scene = String::from_utf8(good["scene.toml.partial"].clone()).unwrap();
    fs::write(one.join("scene.toml.partial"), scene.replace("restitution = 0", "restitution = 1.0 # 0")).unwrap();
    refused("scene.toml.partial is not the scene");
    fs::remove_file(one.join("scene.toml.partial")).unwrap();
    refused("cannot read");
    for (name, at) in [("thermo.csv.partial", 0), ("thermo.csv.partial", 100), ("trajectory.xyz.partial", 5000)] {
        flip(name, at);
        refused(&format!("{name} differ from the checkpoint"));
    }
    flip("events/time.npy", 128);
    refused("time.npy differ from the checkpoint");
    // Damage in these places does no harm. The header is rewritten at the end, and later data are cut off.
    flip("events/time.npy", 100);
    let last = good["thermo.csv.partial"].len() - 1;
    flip("thermo.csv.partial", last);
    finish(resume(&one));
    assert_same(&whole, &one, "granular cooling");
}

/// A limit on the length of files acts like a full disk.
#[cfg(unix)]
#[test]
fn run_stopped_by_a_full_disk_can_be_resumed() {
    let directory = tempfile::tempdir().unwrap();
    for (scene, longest) in [("pendulum", "contacts.csv"), ("hard_sphere_fluid", "trajectory.xyz")] {
        let [whole, parts] = ["whole", "parts"].map(|name| directory.path().join(format!("{scene}_{name}")));
        let arguments = |folder: &Path| {
            let scene = format!("{}/configs/{scene}.toml", env!("CARGO_MANIFEST_DIR"));
            let mut command = carom(&["run", &scene, "--quiet", "--until-events", "20000", "--out"]);
            // The first checkpoint is written long before the output reaches its size limit.
            command.arg(folder).args(["--checkpoint-every", "0.001"]);
            command.args(["--set", "output.events=true", "--set", "output.contacts=true"]);
            command.args(["--set", "run.equilibration_events=1000"]);
            command
        };
        finish(arguments(&whole));
        let sizes = |folder: &Path, name: &str| fs::metadata(folder.join(name)).unwrap().len();
        let limit = sizes(&whole, longest) / 2;
        assert!(limit > 2 * sizes(&whole, "checkpoint"), "{limit}");
        let plain = arguments(&parts);
        let mut limited = Command::new("sh");
        limited.args(["-c", &format!("trap '' XFSZ; ulimit -f {}; exec \"$@\"", limit / 512), "sh"]);
        limited.arg(plain.get_program()).args(plain.get_args());
        let output = limited.output().unwrap();
        let message = unwrapped(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("cannot write") && message.contains(longest), "{message}");
        assert!(message.contains("File too large"), "{message}");
        assert!(message.contains("free some space") && message.contains("--resume"), "{message}");
        assert!(!parts.join("summary.json").exists() && parts.join("checkpoint").exists());
        finish(resume(&parts));
        assert_same(&whole, &parts, scene);
    }
}
