//! Carom's web site: a static folder for any host, which also opens from disk.
//!
//! `cargo run -p carom-site` writes `web/site/out`: a home page, the documents of `docs` with all linked files, and a
//! page for each scene in `configs`. `carom-site ROOT OUT` reads the repository ROOT and writes to OUT.

mod document;
mod gallery;
mod layout;
mod links;
mod live;
mod markdown;
mod scene;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};

use crate::document::Library;
use crate::scene::ScenePage;

struct Site {
    root: PathBuf,
    out: PathBuf,
    /// The engine for browsers, built by `web/build`. Without the engine, no page runs a scene.
    module: Option<Vec<u8>>,
}

impl Site {
    fn read(&self, path: &str) -> io::Result<String> {
        fs::read_to_string(self.root.join(path)).map_err(|error| named(path, &error))
    }

    fn write(&self, path: &str, bytes: &[u8]) -> io::Result<()> {
        let place = self.out.join(path);
        fs::create_dir_all(place.parent().unwrap_or(&self.out))?;
        fs::write(&place, bytes).map_err(|error| named(path, &error))
    }

    fn copy(&self, from: &str, to: &str) -> io::Result<()> {
        let bytes = fs::read(self.root.join(from)).map_err(|error| named(from, &error))?;
        self.write(to, &bytes)
    }

    fn names(&self, folder: &str, ending: &str) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(self.root.join(folder)).map_err(|error| named(folder, &error))? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == ending) {
                names.extend(path.file_name().map(|name| name.to_string_lossy().into_owned()));
            }
        }
        names.sort();
        Ok(names)
    }
}

fn named(path: &str, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{path}: {error}"))
}

fn build(site: &Site) -> io::Result<usize> {
    let scenes = ScenePage::all(site)?;
    let library = Library::of(site, &scenes)?;
    library.write(site)?;
    site.write("site.css", style().as_bytes())?;
    for scene in &scenes {
        scene.write(site, &scenes)?;
    }
    gallery::write(site, &scenes)?;
    live::write_editor(site, &scenes)?;
    Ok(library.len() + scenes.len() + 3)
}

fn style() -> String {
    format!("{}\n{}", include_str!("../../../src/view/report/page.css"), include_str!("site.css"))
}

fn main() -> ExitCode {
    let mut words = env::args_os().skip(1).map(PathBuf::from);
    let root = words.next().unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    let out = words.next().unwrap_or_else(|| root.join("web/site/out"));
    let module = fs::read(root.join("web/carom.module")).ok();
    if module.is_none() {
        eprintln!("no web/carom.module: the pages have no scenes that run; web/build makes it");
    }
    let site = Site { root, out, module };
    match build(&site) {
        Ok(pages) => {
            println!("{pages} pages in {}", site.out.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
