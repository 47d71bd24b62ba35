use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::analysis::statistics::Estimate;
use crate::base::text::digits;
use crate::exchange::{Exchange, ExchangeFolder, ExchangeSummary, MeanForcePoint, Opened};
use crate::io::{Existing, read_scene, refuse_input, refuse_link};
use crate::model::{ExchangeEnsemble, Scene};
use crate::view::{describe, report};
use clap::Args;

use super::again::{Again, CHECKPOINT_EVERY};
use super::failure::Failure;
use super::progress::bar;
use super::terminal::columns;
use super::{Changes, borrowed, cores, signals};

/// Runs replicas of a scene at several temperatures, or in windows of a distance, with swaps between neighbours
#[derive(Debug, Args)]
#[command(after_help = "\
The scene has a table [exchange]:
  temperatures = [0.4, 0.6, 1.0]   ascending or descending
  interval = 2.0                   simulated time between swap attempts
  rate = 1.0                       rate at which each particle gets a velocity from the heat bath
  ensemble = \"multicanonical\"      optional: every replica visits the energies of all temperatures
  ensemble = \"umbrella\"            optional: replicas at one temperature, each in a window of a distance,
  umbrella = { between = [[0], [19]], windows = [[1.0, 2.5], [2.0, 4.0]] }
The table [run] has until_time and, optionally, equilibration_time. The results are the same bits for any --jobs and after interruptions.
The same command resumes an interrupted exchange from its last checkpoint. With a later end, a complete exchange continues, as if that end
had been given from the beginning.

Examples:
  carom exchange chain.toml
  carom exchange chain.toml --set 'exchange.temperatures=[0.3, 0.4, 0.55, 0.8]' --seed 2 --out runs/second
  carom exchange runs/chain-exchange         continues the exchange in this folder
  carom exchange runs/chain-exchange --until-time 40000      continues to another end, even if it was complete
  carom exchange runs/chain-exchange --temperatures-for 0.3  temperatures at which 30 % of all swaps are accepted, for --set")]
pub struct ExchangeCommand {
    /// A scene with [exchange], or the folder of an exchange
    path: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Number of replicas to run at the same time; by default the number of processors
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Measures for this simulated time instead of the time in the scene; an existing exchange continues to this time,
    /// even if it was complete
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = super::run::duration)]
    until_time: Option<f64>,
    /// Prints temperatures at which all swaps are accepted with at least this probability; needs a complete exchange
    #[arg(long, value_name = "ACCEPTANCE", value_parser = probability, conflicts_with_all = ["until_time", "out"])]
    temperatures_for: Option<f64>,
    /// The folder of the results; by default runs/NAME-exchange, where NAME is the name of the scene
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Wall time between two checkpoints, in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = super::run::seconds, default_value = CHECKPOINT_EVERY)]
    checkpoint_every: Duration,
    /// Allows output of more than 10 GB or a tenth of the free disk space
    #[arg(long)]
    force: bool,
    /// No progress, only the final table
    #[arg(long, short)]
    quiet: bool,
}

impl ExchangeCommand {
    pub fn execute(&self) -> Result<(), Failure> {
        if let Some(acceptance) = self.temperatures_for {
            return self.choose_temperatures(acceptance);
        }
        let opened = if self.path.is_dir() { self.kept() } else { self.given() };
        let (scene, record, path) = match opened {
            // The results of a complete exchange are shown even if files of its scene have been deleted.
            Err(_) if self.only_shows() => return end(&ExchangeFolder::read(&self.path)?, &self.path, true),
            opened => opened?,
        };
        self.refuse_large(&scene, &path)?;
        match ExchangeFolder::open(&path, scene, &record)? {
            Opened::UnderWay(begun) => {
                let (folder, exchange) = *begun;
                self.run(folder.checkpoint_every(self.checkpoint_every), exchange, &path)
            }
            _ => end(&ExchangeFolder::read(&path)?, &path, true),
        }
    }

    /// Prints temperatures for the given acceptance, in the format of `--set`.
    fn choose_temperatures(&self, acceptance: f64) -> Result<(), Failure> {
        let summary = ExchangeFolder::read(&self.path)?;
        let Some(temperatures) = summary.temperatures_for(acceptance) else {
            let folder = self.path.display();
            let (message, help) = if summary.umbrella.is_some() {
                (
                    format!("{folder} has the same temperature in all windows"),
                    "choose an exchange with several temperatures",
                )
            } else if summary.density_of_states.is_empty() {
                (format!("{folder} has no density of states to derive temperatures from"), NO_DENSITY)
            } else {
                let acceptance = digits(acceptance);
                (
                    format!("an acceptance of {acceptance} needs more than a thousand temperatures"),
                    "ask for a lower acceptance",
                )
            };
            return Err(Failure::bad_input(message, Some(help)));
        };
        let all: Vec<String> = temperatures.iter().map(|temperature| digits(*temperature)).collect();
        super::print(&format!("exchange.temperatures=[{}]\n", all.join(", ")))
    }

    fn only_shows(&self) -> bool {
        let changes_nothing = self.until_time.is_none() && self.changes.are_none() && self.out.is_none();
        changes_nothing && ExchangeFolder::is_one(&self.path) && ExchangeFolder::read(&self.path).is_ok()
    }

    fn given(&self) -> Result<(Scene, String, PathBuf), Failure> {
        let scene = read_scene(&self.path, &borrowed(&self.replaced()))?;
        if scene.exchange().is_none() {
            let message = format!("{} has no [exchange]", self.path.display());
            let help = "add [exchange] with temperatures, interval and rate; `carom run` runs a scene without it";
            return Err(Failure::bad_input(message, Some(help)));
        }
        let beside = || PathBuf::from("runs").join(format!("{}-exchange", scene.name()));
        let path = self.out.clone().unwrap_or_else(beside);
        if !ExchangeFolder::is_one(&path) {
            let inputs = scene.inputs().iter().map(|input| Path::new(&input.path));
            refuse_input(&path, inputs.chain([self.path.as_path()]))?;
        }
        let record = scene.record(&self.path, &borrowed(&self.replaced()))?;
        Ok((scene, record, path))
    }

    fn replaced(&self) -> Vec<(String, String)> {
        let mut all = self.changes.all();
        all.extend(self.until_time.map(|time| ("run.until_time".to_owned(), format!("{time:?}"))));
        all
    }

    fn kept(&self) -> Result<(Scene, String, PathBuf), Failure> {
        let file = ExchangeFolder::scene_of(&self.path);
        if !ExchangeFolder::is_one(&self.path) || !file.exists() {
            let message = format!("{} is not the folder of a replica exchange", self.path.display());
            return Err(Failure::bad_input(message, Some("start an exchange with a scene that has [exchange]")));
        }
        if !self.changes.are_none() || self.out.is_some() {
            let help = format!("to run another exchange with its scene: carom exchange {} with --out", file.display());
            let message = "an exchange continues unchanged: --seed, --set, --from and --out are for new exchanges";
            return Err(Failure::bad_input(message, Some(&help)));
        }
        let unreadable =
            |error: std::io::Error| Failure::bad_input(format!("cannot read {}: {error}", file.display()), None);
        let kept = fs::read_to_string(&file).map_err(unreadable)?;
        let replaced = self.replaced();
        let scene = read_scene(&file, &borrowed(&replaced))?;
        let record = if replaced.is_empty() { kept } else { scene.record(&file, &borrowed(&replaced))? };
        Ok((scene, record, self.path.clone()))
    }

    fn refuse_large(&self, scene: &Scene, path: &Path) -> Result<(), Failure> {
        if self.force {
            return Ok(());
        }
        // The existing files of a resumed exchange need no further space.
        let size = |file: fs::DirEntry| file.metadata().map_or(0, |metadata| metadata.len());
        let there: u64 = fs::read_dir(path).map_or(0, |files| files.flatten().map(size).sum());
        let bytes = (ExchangeFolder::expected_bytes(scene) - there as f64).max(0.0);
        super::refuse_large("exchange", bytes, path, "a longer output.frame_interval or exchange.interval").map(drop)
    }

    fn run(&self, mut folder: ExchangeFolder, exchange: Exchange, path: &Path) -> Result<(), Failure> {
        signals::watch();
        let [before, total] = exchange.attempts();
        let template = "{pos} of {len} attempts {wide_bar:.cyan/blue} {percent:>3} %, {eta} left";
        let bar = bar(total, template, self.quiet).with_position(before);
        let jobs = self.jobs.map_or_else(cores, usize::from);
        let ran = exchange.execute(jobs, &mut folder, &mut |[attempts, _]| {
            bar.set_position(attempts);
            signals::flow()
        });
        bar.finish_and_clear();
        let exchange = ran?;
        if !exchange.is_over() {
            let again = Again::new("exchange", path).option("jobs", self.jobs).checkpoint_every(self.checkpoint_every);
            let again = again.flags([("force", self.force), ("quiet", self.quiet)]);
            let help = format!("repeat the same command, or: {again}");
            return Err(Failure::failed("interrupted; the simulated part is kept", Some(&help)));
        }
        end(&folder.complete(&exchange)?, path, false)
    }
}

fn probability(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| 0.0 < *number && *number < 1.0);
    number.ok_or_else(|| "expected a number between 0 and 1".to_owned())
}

/// Writes the page of a complete exchange, and prints the results. Returns a failure if the audit found faults.
fn end(summary: &ExchangeSummary, path: &Path, was_there: bool) -> Result<(), Failure> {
    refuse_link(&report::exchange_page_in(path))?;
    let page = report::exchange_page(path)?;
    report::write(&page, &report::exchange_page_in(path), Existing::Replace)?;
    let tables = summary.tables.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let complete = if was_there { "It was complete already. " } else { "" };
    super::print_report(&format!(
        "{}\n{complete}The files are in {}: summary.json, {tables}, exchange.html\n",
        text(summary),
        path.display()
    ))?;
    let faults = &summary.results.faults;
    if faults.is_empty() {
        return Ok(());
    }
    Err(Failure::of_audit(faults))
}

const NO_DENSITY: &str = "let the exchange run for longer, or choose temperatures whose energies overlap; hard bodies \
    have no density of states";

const SHOWN: [(&str, &str); 6] = [
    ("distance", "distance"),
    ("temperature", "kinetic T"),
    ("potential_energy_per_particle", "potential energy"),
    ("heat_capacity_per_particle", "heat capacity"),
    ("compressibility_factor", "Z"),
    ("pressure", "pressure"),
];

fn text(summary: &ExchangeSummary) -> String {
    let results = &summary.results;
    let has = |name: &str| results.temperatures.iter().any(|at| at.observables.contains_key(name));
    let shown: Vec<(&str, &str)> = SHOWN.into_iter().filter(|(name, _)| has(name)).take(4).collect();
    let is_swapped = summary.results.ensemble != ExchangeEnsemble::Multicanonical;
    let place = if summary.umbrella.is_some() { "window" } else { "temperature" };
    let heads = std::iter::once(place).chain(is_swapped.then_some("swaps"));
    let heads = heads.chain(shown.iter().map(|(_, head)| *head)).map(str::to_owned);
    let mut rows: Vec<Vec<String>> = vec![heads.collect()];
    for (place, at) in results.temperatures.iter().enumerate() {
        let acceptance = results.neighbours.get(place).and_then(|it| it.acceptance);
        let cells = shown.iter().map(|(name, _)| cell(at.observables.get(*name).copied()));
        let swaps = is_swapped.then(|| cell(acceptance));
        rows.push(std::iter::once(at.place()).chain(swaps).chain(cells).collect());
    }
    let what = if is_swapped { "attempts to swap" } else { "samples of each replica in a multicanonical ensemble" };
    let mut lines = vec![format!("{}, {} {what}", summary.scene, results.attempts)];
    lines.extend(columns(&rows, 1));
    let trips: Vec<String> = results.round_trips.iter().map(u64::to_string).collect();
    lines.push(format!("  round trips of the replicas: {}", trips.join(", ")));
    lines.extend(summary.heat_capacity_peak.map(|peak| {
        let [height, at] = [peak.heat_capacity_per_particle, peak.temperature].map(|it| cell(Some(it)));
        format!("  the heat capacity is highest at T = {at}: {height}")
    }));
    lines.extend(lowest(summary));
    lines.extend(summary.warnings.iter().map(|warning| format!("  warning: {warning}")));
    lines.join("\n") + "\n"
}

fn lowest(summary: &ExchangeSummary) -> Option<String> {
    let at = |of| MeanForcePoint::lowest(&summary.potential_of_mean_force, of).map(|point| digits(point.distance));
    let (free_energy, potential) = (at(|it| it.free_energy)?, at(|it| it.potential_of_mean_force)?);
    Some(format!(
        "  the free energy is lowest at the distance {free_energy}, the potential of mean force at {potential}"
    ))
}

fn cell(measured: Option<Estimate>) -> String {
    measured.map_or_else(String::new, |Estimate { mean, standard_error }| match standard_error {
        Some(_) => describe::estimate(&Estimate { mean, standard_error }),
        None => digits(mean),
    })
}
