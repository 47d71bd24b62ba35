use std::path::{Path, PathBuf};

use crate::io::refuse_input;
use crate::view::{live, report};
use clap::Args;

use super::failure::Failure;
use super::{SceneArgs, borrowed};

/// The WebAssembly module of the engine, if it was built into the program.
#[cfg(carries_module)]
const CARRIED: Option<&[u8]> = Some(include_bytes!(env!("CAROM_MODULE")));
#[cfg(not(carries_module))]
const CARRIED: Option<&[u8]> = None;

/// Path of the module made by `web/build`, relative to the root of the sources.
const MODULE: &str = "web/carom.module";

/// Writes a page that runs a scene in a browser: with plots, sliders and an editor
#[derive(Debug, Args)]
#[command(after_help = "\
The page is a single file that needs no network. It contains the WebAssembly engine and computes the same bits as this program.
The script `web/build` in the source folder makes the module; a program built with CAROM_MODULE=web/carom.module contains it.

Example:
  carom live configs/maxwell.toml --out maxwell.html")]
pub struct Live {
    #[command(flatten)]
    scene: SceneArgs,
    /// The file to write
    #[arg(long, value_name = "FILE", default_value = "live.html")]
    out: PathBuf,
    /// The engine as a WebAssembly module, made by web/build; the default is the module in the program, or else a
    /// module near the program or in the current folder
    #[arg(long, value_name = "FILE")]
    module: Option<PathBuf>,
    /// Replaces an existing file
    #[arg(long)]
    force: bool,
}

impl Live {
    pub fn execute(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        if scene.predecessor().is_some() {
            let help = "read the last frame of that run's trajectory.xyz with [[file]] and frame = -1";
            let message = format!("the scene {} starts from a run, and a page cannot include that run", scene.name());
            return Err(Failure::bad_input(message, Some(help)));
        }
        super::refuse_exchange(&scene, "a page simulates one system: leave [exchange] out")?;
        if scene.run().has_barostat() {
            let message =
                format!("the scene {} has a barostat, but the box of a page has a constant size", scene.name());
            return Err(Failure::bad_input(message, Some("remove the barostat")));
        }
        if scene.run().has_swaps() {
            let message =
                format!("the scene {} has swap moves, but the particles of a page keep their sizes", scene.name());
            return Err(Failure::bad_input(message, Some("remove swap")));
        }
        if scene.has_individual_diameters() {
            let message = format!(
                "the scene {} has individual diameters, but all particles of a species look alike on a page",
                scene.name()
            );
            return Err(Failure::bad_input(
                message,
                Some("remove `diameters`, which divides the distribution into classes"),
            ));
        }
        if scene.has_flow() {
            let message = format!(
                "particles enter or leave in the scene {}, but a page shows the same particles at all times",
                scene.name()
            );
            return Err(Failure::bad_input(
                message,
                Some(
                    "remove the inlets and outlets, or look at the pictures of a run: `carom run`, then `carom render`",
                ),
            ));
        }
        let source = live::Source::of_file(&self.scene.scene, &borrowed(&self.scene.changes.all()))?;
        let module = self.module()?;
        let Some(engine) = live::Engine::of(&module) else {
            let message = "the module is not an engine for browsers, expected a file made by web/build";
            return Err(Failure::bad_input(message, None));
        };
        if !engine.is_of_these_sources() {
            super::warn("note: the module was built from other sources than this program; rebuild it with web/build");
        }
        let inputs = scene.inputs().iter().map(|input| PathBuf::from(&input.path));
        refuse_input(&self.out, inputs.chain([self.scene.scene.clone()]))?;
        let page = live::page(&scene, &source, engine);
        report::write(&page, &self.out, super::existing(self.force))?;
        super::print(&format!("{}\n", self.out.display()))
    }

    fn module(&self) -> Result<Vec<u8>, Failure> {
        match (&self.module, CARRIED) {
            (Some(path), _) => read(path),
            (None, Some(carried)) => Ok(carried.to_owned()),
            (None, None) => match places().into_iter().find(|path| path.is_file()) {
                Some(path) => read(&path),
                None => {
                    let help = "make it in the folder of Carom's sources, with `rustup target add wasm32-unknown-unknown` and `web/build`, or name it \
                                with --module";
                    let message = "the engine for browsers, web/carom.module, is missing";
                    Err(Failure::bad_input(message, Some(help)))
                }
            },
        }
    }
}

/// Returns where to look for [`MODULE`]: the folder of the program, three folders above, and the current folder.
fn places() -> Vec<PathBuf> {
    let program = std::env::current_exe().unwrap_or_default();
    program.ancestors().skip(1).take(4).chain([Path::new("")]).map(|folder| folder.join(MODULE)).collect()
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|error| {
        let message = format!("cannot read {}: {error}", path.display());
        Failure::bad_input(message, Some("build it with web/build"))
    })
}
