//! The command line: what was typed, and what comes of it.

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
use crate::engine::Transport;
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
  carom new fluid > fluid.toml              a scene to start from, with comments
  carom check fluid.toml                    what will be simulated, and what is wrong with it
  carom run fluid.toml                      simulates it; the results are in runs/fluid
  carom run fluid.toml --until-events 1e5   shorter
  carom run fluid.toml --set fill.0.packing_fraction=0.3 --out runs/thin
  carom sweep fluid.toml --vary fill.0.packing_fraction=0.1..0.4/4 --vary seed=1..3     in runs/fluid-sweep
  carom exchange chain.toml                 replicas at several temperatures, in runs/chain-exchange
  carom run next.toml --from runs/fluid     starts from the end of that run
  carom verify runs/fluid                   proves the first events of that run
  carom validate                            measures what is known from theory and other simulations, in a minute
  carom render runs/fluid                  the last frame, in runs/fluid/picture.png
  carom movie runs/fluid --out fluid.mp4    all frames, as a movie; also .gif and .apng
  carom schema > scene.schema.json          what a scene can contain, for editors
  carom convert runs/fluid --to gsd         the trajectory for other programs, in runs/fluid/trajectory.gsd
  carom report runs/fluid                   all of that run as a page, in runs/fluid/report.html
  carom live fluid.toml                     the scene itself as a page, on which it runs, in live.html
  carom completions bash                    completion of commands and options, for a shell; carom man: the manual

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
    /// Runs a scene for all combinations of values, with tables and a page over all runs
    Sweep(sweep::SweepCommand),
    /// Runs replicas at several temperatures, which are swapped now and then, with averages at each
    Exchange(exchange::ExchangeCommand),
    /// Says in words what will be simulated, and finds what is wrong
    Check(check::Check),
    /// Proves that no event of a run, or of a range of it, is missing, spurious or out of order
    Verify(verify::Verify),
    /// Measures pressures, rates and motions that are known, and compares
    Validate(validate::Validate),
    /// Draws a frame of a run as a PNG
    #[command(alias = "picture")]
    Render(render::Render),
    /// Draws all frames of a run as a movie: MP4, GIF or APNG
    Movie(movie::Movie),
    /// Writes a trajectory in the format of another program: LAMMPS, GSD, VTK, NumPy, CSV
    Convert(convert::Convert),
    /// Writes a page about a run, for a browser: results, audit, plots and the moving particles
    Report(report::Report),
    /// Writes a page on which a scene runs, for a browser: with plots, sliders and an editor
    Live(live::Live),
    /// Prints a commented scene to start from
    New(new::New),
    /// Prints the JSON Schema of scene files, for completion and checks in editors
    Schema(schema::Schema),
    /// Prints what a shell needs to complete commands and options
    Completions(completions::Completions),
    /// Prints the manual page of the program, or of one of its commands
    Man(completions::Manual),
}

/// A scene file, and what replaces its values.
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

/// Overrides of a scene.
#[derive(Debug, Args)]
struct Changes {
    /// Seed of the random numbers that place particles and draw velocities
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Replaces a value of the scene: dots lead through tables, entries of lists go by number (from 0) or by name
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_and_value)]
    overrides: Vec<(String, String)>,
    /// Starts from the end of the run in this folder: its particles, bonds, box and time, exactly; those of the scene are left out
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

    /// The text of a scene that was loaded, with what was replaced in it.
    fn record(&self, scene: &Scene, path: &Path) -> Result<String, SceneError> {
        scene.record(path, &borrowed(&self.all()))
    }

    fn all(&self) -> Vec<(String, String)> {
        let mut all = self.overrides.clone();
        all.extend(self.seed.map(|seed| ("seed".to_owned(), seed.to_string())));
        all.extend(self.from.as_ref().map(|folder| {
            // From here, not from the folder of the scene.
            let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.clone());
            ("start.from".to_owned(), toml::Value::String(folder.to_string_lossy().into_owned()).to_string())
        }));
        all
    }
}

/// Refuses a scene that asks for replica exchange, where another command would leave that out.
fn refuse_exchange(scene: &Scene, help: &str) -> Result<(), Failure> {
    if scene.exchange().is_none() {
        return Ok(());
    }
    let message = format!("the scene {} has [exchange], several replicas", scene.name());
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

/// Joins the processes that this one was started together with, if there are any.
pub type Join = fn() -> Option<Arc<dyn Transport>>;

/// The program: does what was typed when it was started. To be called first, before there is a second thread.
#[must_use]
pub fn program(join: Join) -> ExitCode {
    exhaustion::take_stack();
    exhaustion::give_back_large_arrays();
    exhaustion::report_full_files();
    let arguments: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(main(&arguments, join))
}

/// Does what was typed: `arguments` begin with the name of the program. All messages go to the standard output and error, and interrupts pause what runs.
///
/// Returns the exit code: 0 for success, 1 for a failure or an interruption, 2 for bad input.
#[must_use]
pub fn main(arguments: &[OsString], join: Join) -> u8 {
    let has_controls = arguments.iter().any(|word| word.to_string_lossy().contains(char::is_control));
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version come here, too. Neither they nor a closed pipe are errors.
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

/// The trajectory of a run: `run` is its folder, or the trajectory itself.
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
            format!("name the frames of one temperature or window, such as {folder}/trajectory-1.xyz")
        }
        Some(Several::Sweep) => format!("name one of its runs: {folder}/RUN"),
        None => {
            "carom run writes the trajectory; the folder of an unfinished run has a trajectory.xyz.partial".to_owned()
        }
    };
    Err(Failure::bad_input(format!("{folder} has no trajectory.xyz"), Some(&help)))
}

/// Folders of several runs.
enum Several {
    Exchange,
    Sweep,
}

/// Whether a folder is that of several runs.
fn of_several(folder: &Path) -> Option<Several> {
    if ExchangeFolder::is_one(folder) {
        return Some(Several::Exchange);
    }
    SweepFolder::existing(folder).is_ok().then_some(Several::Sweep)
}

/// Policy for files and folders that exist already.
fn existing(force: bool) -> Existing {
    if force { Existing::Replace } else { Existing::Keep }
}

/// A trajectory, and the files of the run that it may belong to: what is made from it must replace none of them.
fn files_beside(trajectory: &Path) -> Vec<PathBuf> {
    let mut files = trajectory.parent().map(Folder::files_of).unwrap_or_default();
    files.push(trajectory.to_owned());
    files
}

/// Refuses to write more bytes than are written unasked; how many those are.
fn refuse_large(what: &str, bytes: f64, path: &Path, instead: &str) -> Result<f64, Failure> {
    allowed(bytes, path).map_err(|too_large| {
        let help = format!("choose {instead}, or another disk with --out, or --force");
        Failure::bad_input(format!("the {what} {too_large}"), Some(&help))
    })
}

/// A word that can be typed, what is said of it in the help, and what it stands for.
type Choice<T> = (&'static str, Option<&'static str>, T);

/// Takes one of some words.
fn one_of<T: Copy + Send + Sync>(choices: &'static [Choice<T>]) -> ValueParser {
    let words = choices.iter().map(|(word, help, _)| PossibleValue::new(*word).help(*help));
    let meaning = |typed: String| choices.iter().find(|(word, ..)| *word == typed).map(|(.., meaning)| *meaning);
    PossibleValuesParser::new(words).try_map(move |typed| meaning(typed).ok_or("expected one of the words")).into()
}

/// Number of processors that this program may use.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Writes to standard output. A pipe that is closed early, as by `head`, is no error.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(printable(text).as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::failed(format!("cannot write to the standard output: {error}"), None))
        }
        _ => Ok(()),
    }
}

/// Writes a report to standard output, as wide as the terminal.
fn print_report(text: &str) -> Result<(), Failure> {
    print(&terminal::fitted(text))
}

/// Writes a warning to standard error. Where that is closed, the results are still complete.
fn warn(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(text));
}
