//! Computes a fingerprint of all code that affects results or checkpoints. A program rejects a checkpoint with another
//! fingerprint.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Source files that only report on runs and do not affect them.
const OUTSIDE: [&str; 7] = ["cli", "cli.rs", "main.rs", "view", "view.rs", "check", "check.rs"];

fn main() -> io::Result<()> {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rerun-if-changed=Cargo.lock");
    // The engine for browsers, built by `web/build`, if the program includes it.
    println!("cargo::rustc-check-cfg=cfg(carries_module)");
    println!("cargo::rerun-if-env-changed=CAROM_MODULE");
    if let Some(module) = std::env::var_os("CAROM_MODULE") {
        let module = fs::canonicalize(module)?;
        println!("cargo::rerun-if-changed={}", module.display());
        println!("cargo::rustc-env=CAROM_MODULE={}", module.display());
        println!("cargo::rustc-cfg=carries_module");
    }
    println!("cargo::rustc-env=CAROM_FINGERPRINT={:016x}", fingerprint(&root)?);
    Ok(())
}

/// Hashes all source files that can affect a run, and the versions of all dependencies.
pub fn fingerprint(root: &Path) -> io::Result<u64> {
    let mut files = Vec::new();
    collect(&root.join("src"), true, &mut files)?;
    // `Cargo.lock` does not exist if Carom is a dependency of another program.
    files.extend(Some(root.join("Cargo.lock")).filter(|lock| lock.exists()));
    files.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for file in files {
        let name = file.strip_prefix(root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        // The lengths are hashed, so text that moves to another file changes the fingerprint.
        let text = fs::read_to_string(&file)?.replace("\r\n", "\n");
        for part in [name.as_bytes(), text.as_bytes()] {
            add(&mut hash, &(part.len() as u64).to_le_bytes());
            add(&mut hash, part);
        }
    }
    Ok(hash)
}

fn collect(folder: &Path, is_top: bool, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let is_outside = is_top && path.file_name().is_some_and(|name| OUTSIDE.iter().any(|known| name == *known));
        if path.is_dir() && !is_outside {
            collect(&path, false, files)?;
        } else if path.extension().is_some_and(|ending| ending == "rs") && !is_outside {
            files.push(path);
        }
    }
    Ok(())
}

/// FNV-1a.
fn add(hash: &mut u64, bytes: &[u8]) {
    for byte in bytes {
        *hash = (*hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
}
