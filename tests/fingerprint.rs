//! A program rejects checkpoints of programs that were built from other sources.

use std::fs;
use std::path::Path;
use std::process::Command;

#[allow(dead_code, reason = "main writes the fingerprint for the build")]
#[path = "../build.rs"]
mod build;

use build::fingerprint;

#[test]
fn every_source_that_a_run_depends_on_changes_the_fingerprint() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(fingerprint(here).unwrap(), fingerprint(here).unwrap());
    let place = tempfile::tempdir().unwrap();
    let root = place.path();
    let write = |name: &str, text: &str| {
        fs::create_dir_all(root.join(name).parent().unwrap()).unwrap();
        fs::write(root.join(name), text).unwrap();
    };
    let sources = ["src/lib.rs", "src/run/state.rs", "src/engine/body.rs", "Cargo.lock"];
    sources.iter().for_each(|name| write(name, "struct Body { position: f64, velocity: f64 }\n"));
    write("src/cli/run.rs", "words\n");
    let first = fingerprint(root).unwrap();
    for name in sources {
        // The exchange of two fields changes only the layout of the struct.
        write(name, "struct Body { velocity: f64, position: f64 }\n");
        assert_ne!(fingerprint(root).unwrap(), first, "{name}");
        write(name, "struct Body { position: f64, velocity: f64 }\r\n");
        assert_eq!(fingerprint(root).unwrap(), first, "{name}: line breaks of another system");
        write(name, "struct Body { position: f64, velocity: f64 }\n");
    }
    write("src/cli/run.rs", "other words\n");
    assert_eq!(fingerprint(root).unwrap(), first);
    fs::rename(root.join("src/lib.rs"), root.join("src/lob.rs")).unwrap();
    assert_ne!(fingerprint(root).unwrap(), first);
}

#[test]
fn a_checkpoint_of_other_sources_is_refused_and_left_as_it_is() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("run");
    let carom = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command.args(arguments).arg(&folder).env("NO_COLOR", "1").output().unwrap()
    };
    let scene = format!("{}/configs/pendulum.toml", env!("CARGO_MANIFEST_DIR"));
    let output = carom(&["run", &scene, "--quiet", "--until-events", "500", "--out"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let path = folder.join("checkpoint");
    let good = fs::read(&path).unwrap();
    // Bytes 28 to 35 are the fingerprint. The checksum is recomputed, so only the fingerprint is wrong.
    for at in 28..36 {
        let mut other = good.clone();
        other[at] ^= 1;
        let content = other.len() - 4;
        let checksum = crc32fast::hash(&other[..content]).to_le_bytes();
        other[content..].copy_from_slice(&checksum);
        fs::write(&path, &other).unwrap();
        let output = carom(&["run", "--quiet", "--resume"]);
        let message = String::from_utf8_lossy(&output.stderr).replace('│', " ");
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.contains("which may continue differently") && message.contains("version that wrote it"),
            "{message}"
        );
        assert!(folder.join("summary.json").exists() && fs::read(&path).unwrap() == other);
    }
    fs::write(&path, &good).unwrap();
    assert!(carom(&["run", "--quiet", "--resume"]).status.success());
}
