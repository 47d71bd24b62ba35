//! The command line: parses the arguments and executes the commands.

mod again;
mod camera;
mod check;
mod completions;
mod convert;
mod exchange;
pub mod exhaustion;
mod failure;
mod live;
mod movie;
mod new;
mod processes;
mod progress;
mod render;
mod report;
mod run;
mod schema;
mod signals;
mod sweep;
mod terminal;
mod validate;
mod verify;

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use crate::base::text::printable;
use crate::engine::Communicator;
use crate::exchange::ExchangeFolder;
use crate::io::estimate::allowed;
use crate::io::{Existing, Folder, read_scene_text};
use crate::model::Scene;
use crate::scene::{SceneError, Source, read_text};
use crate::sweep::SweepFolder;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Args, Parser, Subcommand};

pub use failure::Failure;
pub use new::scenes;
pub use verify::{Proof, VerifyStep, prove_run};

const EXAMPLES: &str = "\
Examples:
  carom new fluid > fluid.toml              prints a commented scene to start from
  carom check fluid.toml                    describes the simulation and reports mistakes in the scene
  carom run fluid.toml                      simulates the scene; the results are in runs/fluid
  carom run fluid.toml --until-events 1e5   a shorter run
  carom run fluid.toml --set fill.0.packing_fraction=0.3 --out runs/thin
  carom sweep fluid.toml --vary fill.0.packing_fraction=0.1..0.4/4 --vary seed=1..3     in runs/fluid-sweep
  carom exchange chain.toml                 replicas at several temperatures, in runs/chain-exchange
  carom run next.toml --from runs/fluid     starts from the end of the run in runs/fluid
  carom verify runs/fluid                   proves the first events of the run
  carom validate                            compares measurements with theory and other simulations, in a minute
  carom render runs/fluid                  the last frame, in runs/fluid/picture.png
  carom movie runs/fluid --out fluid.mp4    all frames, as a movie; also .gif and .apng
  carom schema > scene.schema.json          prints the JSON Schema of scenes, for editors
  carom convert runs/fluid --to gsd         the trajectory for other programs, in runs/fluid/trajectory.gsd
  carom report runs/fluid                   a page about the run, in runs/fluid/report.html
  carom live fluid.toml                     a page that runs the scene, in live.html
  carom completions bash                    completes commands and options in a shell; carom man prints the manual

Exit codes:
  0  done
  1  the simulation, audit, proof or comparison failed; memory ran out; or the run was interrupted
  2  bad input";

/// Event-driven dynamics of particles: hard spheres, square wells, bonds, stepped potentials, gravity and meshes.
#[derive(Debug, Parser)]
#[command(version, after_help = EXAMPLES, subcommand_required = true, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulates a scene and writes thermo.csv, trajectory.xyz, summary.json and more
    Run(run::Run),
    /// Runs a scene for all combinations of values, and writes tables and a page about all runs
    Sweep(sweep::SweepCommand),
    /// Runs replicas at several temperatures with swaps between them, and averages at each temperature
    Exchange(exchange::ExchangeCommand),
    /// Describes the simulation in words and reports mistakes in the scene
    Check(check::Check),
    /// Proves that no event in a run, or in a part of it, is missing, spurious or out of order
    Verify(verify::Verify),
    /// Measures pressures, rates and motions with known values, and compares the results
    Validate(validate::Validate),
    /// Draws a frame of a run as a PNG
    #[command(alias = "picture")]
    Render(render::Render),
    /// Draws all frames of a run as a movie: MP4, GIF or APNG
    Movie(movie::Movie),
    /// Writes a trajectory in the format of another program: LAMMPS, GSD, VTK, NumPy, CSV
    Convert(convert::Convert),
    /// Writes a page about a run for a browser: results, audit, plots and the moving particles
    Report(report::Report),
    /// Writes a page that runs a scene in a browser: with plots, sliders and an editor
    Live(live::Live),
    /// Prints a commented scene to start from
    New(new::New),
    /// Prints the JSON Schema of scene files, for completion and checks in editors
    Schema(schema::Schema),
    /// Prints a shell script that completes commands and options
    Completions(completions::Completions),
    /// Prints the manual page of the program, or of one of its commands
    Man(completions::Manual),
}

/// A scene file with overrides of its values.
#[derive(Debug, Args)]
struct SceneArgs {
    /// The scene, a TOML file
    scene: PathBuf,
    #[command(flatten)]
    changes: Changes,
}

impl SceneArgs {
    fn load(&self) -> Result<Scene, SceneError> {
        self.changes.load(&self.scene)
    }
}

/// Options that override values of a scene.
#[derive(Debug, Args)]
struct Changes {
    /// Seed of the random numbers that place particles and draw velocities
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Replaces a value of the scene. Dots separate keys; an entry of a list is given by its number (from 0) or its
    /// name
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_and_value)]
    overrides: Vec<(String, String)>,
    /// Starts from the exact final state of the run in this folder. Particles, bonds, box and time are taken
    /// from the run instead of the scene
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
}

impl Changes {
    fn load(&self, path: &Path) -> Result<Scene, SceneError> {
        let (text, all) = (read_text(path)?, self.all());
        let source = Source::new(&path.to_string_lossy(), text.clone(), &borrowed(&all));
        let scene = read_scene_text(text, path, &borrowed(&all))?;
        let in_file = |key: &str| if key == "start_time" { key.to_owned() } else { format!("[[{key}]]") };
        let left_out: Vec<String> = source.left_out().into_iter().map(in_file).collect();
        if !left_out.is_empty() {
            warn(&format!("left out of the scene: {}; its start is the end of the run", left_out.join(", ")));
        }
        Ok(scene)
    }

    fn are_none(&self) -> bool {
        self.seed.is_none() && self.overrides.is_empty() && self.from.is_none()
    }

    fn record(&self, scene: &Scene, path: &Path) -> Result<String, SceneError> {
        scene.record(path, &borrowed(&self.all()))
    }

    fn all(&self) -> Vec<(String, String)> {
        let mut all = self.overrides.clone();
        all.extend(self.seed.map(|seed| ("seed".to_owned(), seed.to_string())));
        all.extend(self.from.as_ref().map(|folder| {
            // The path is relative to the current folder, not to the folder of the scene.
            let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.clone());
            ("start.from".to_owned(), toml::Value::String(folder.to_string_lossy().into_owned()).to_string())
        }));
        all
    }
}

/// Rejects a scene with `[exchange]` in a command that would ignore the exchange.
fn refuse_exchange(scene: &Scene, help: &str) -> Result<(), Failure> {
    if scene.exchange().is_none() {
        return Ok(());
    }
    let message = format!("the scene {} has [exchange], which describes several replicas", scene.name());
    Err(Failure::bad_input(message, Some(help)))
}

fn borrowed(pairs: &[(String, String)]) -> Vec<(&str, &str)> {
    pairs.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect()
}

fn key_and_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().to_owned(), value.trim().to_owned())),
        _ => Err("expected KEY=VALUE, such as dynamics.contact_time=0.01".to_owned()),
    }
}

/// Connects this process to the other processes of the same run. Returns `None` if this process is alone.
pub type Join = fn() -> Option<Arc<dyn Communicator>>;

/// Executes the command line of the program. Call this before any other thread starts.
#[must_use]
pub fn program(join: Join) -> ExitCode {
    exhaustion::take_stack();
    exhaustion::give_back_large_arrays();
    exhaustion::report_full_files();
    let arguments: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(main(&arguments, join))
}

/// Executes a command line, which begins with the name of the program. An interrupt stops the command cleanly.
///
/// Returns the exit code: 0 for success, 1 for a failure or an interruption, 2 for bad input.
#[must_use]
pub fn main(arguments: &[OsString], join: Join) -> u8 {
    let has_controls = arguments.iter().any(|word| word.to_string_lossy().contains(char::is_control));
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version texts are printed here. They are not failures, even if the pipe is closed.
            if has_controls {
                warn(&error.render().to_string());
            } else {
                let _ = error.print();
            }
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    let result = match &cli.command {
        Command::Run(run) => run.execute(arguments, join),
        Command::Sweep(sweep) => sweep.execute(),
        Command::Exchange(exchange) => exchange.execute(),
        Command::Check(check) => check.execute(),
        Command::Verify(verify) => verify.execute(),
        Command::Validate(validate) => validate.execute(),
        Command::Render(render) => render.execute(),
        Command::Movie(movie) => movie.execute(),
        Command::Convert(convert) => convert.execute(),
        Command::Report(report) => report.execute(),
        Command::Live(live) => live.execute(),
        Command::New(new) => new.execute(),
        Command::Schema(schema) => schema.execute(),
        Command::Completions(completions) => completions.execute(),
        Command::Man(manual) => manual.execute(),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}

/// Returns the trajectory of a run. `run` is the folder of the run, or the trajectory itself.
fn trajectory_of(run: &Path) -> Result<PathBuf, Failure> {
    if !run.is_dir() {
        return Ok(run.to_owned());
    }
    let trajectory = run.join("trajectory.xyz");
    if trajectory.exists() {
        return Ok(trajectory);
    }
    let folder = run.display();
    let help = match of_several(run) {
        Some(Several::Exchange) => {
            format!("choose the frames of one temperature or window, such as {folder}/trajectory-1.xyz")
        }
        Some(Several::Sweep) => format!("choose one of its runs: {folder}/RUN"),
        None => {
            "carom run writes the trajectory; the folder of an unfinished run has a trajectory.xyz.partial".to_owned()
        }
    };
    Err(Failure::bad_input(format!("{folder} has no trajectory.xyz"), Some(&help)))
}

enum Several {
    Exchange,
    Sweep,
}

/// Returns the kind of a folder with several runs, or `None` for any other folder.
fn of_several(folder: &Path) -> Option<Several> {
    if ExchangeFolder::is_one(folder) {
        return Some(Several::Exchange);
    }
    SweepFolder::existing(folder).is_ok().then_some(Several::Sweep)
}

fn existing(force: bool) -> Existing {
    if force { Existing::Replace } else { Existing::Keep }
}

/// Returns the files that a picture, movie or conversion of a trajectory must not replace.
fn files_beside(trajectory: &Path) -> Vec<PathBuf> {
    let mut files = trajectory.parent().map(Folder::files_of).unwrap_or_default();
    files.push(trajectory.to_owned());
    files
}

/// Rejects output that exceeds the size permitted without `--force`. Returns this size `[bytes]`.
fn refuse_large(what: &str, bytes: f64, path: &Path, instead: &str) -> Result<f64, Failure> {
    allowed(bytes, path).map_err(|too_large| {
        let help = format!("choose {instead}, or another disk with --out, or write all files with --force");
        Failure::bad_input(format!("the {what} {too_large}"), Some(&help))
    })
}

/// A word that the command line accepts, its help text, and its value.
type Choice<T> = (&'static str, Option<&'static str>, T);

fn one_of<T: Copy + Send + Sync>(choices: &'static [Choice<T>]) -> ValueParser {
    let words = choices.iter().map(|(word, help, _)| PossibleValue::new(*word).help(*help));
    let meaning = |typed: String| choices.iter().find(|(word, ..)| *word == typed).map(|(.., meaning)| *meaning);
    PossibleValuesParser::new(words).try_map(move |typed| meaning(typed).ok_or("expected one of the words")).into()
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Writes to standard output. A pipe that the reader closes early, as `head` does, is not an error.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(printable(text).as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::failed(format!("cannot write to standard output: {error}"), None))
        }
        _ => Ok(()),
    }
}

fn print_report(text: &str) -> Result<(), Failure> {
    print(&terminal::fitted(text))
}

/// Prints a warning. A closed standard error is ignored, because the results are complete without the warning.
fn warn(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(text));
}
