use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crate::base::text::with_causes;
use crate::engine::{Communicator, InvariantBroken};
use crate::exchange::ExchangeFolder;
use crate::io::estimate::{SizeEstimate, allowance, free_disk};
use crate::io::{Completed, Folder, OutputError, refuse_input};
use crate::model::{Scene, Threads, Until};
use crate::run::checkpoint::CheckpointError;
use crate::run::{self, Blocked, Ending, Finished, Jam};
use crate::sweep::SweepFolder;
use crate::view::{description, final_table};
use clap::Args;

use super::again::{Again, CHECKPOINT_EVERY};
use super::failure::Failure;
use super::progress::Display;
use super::{Changes, Join};
use super::{processes, signals};

/// Simulates a scene
#[derive(Debug, Args)]
#[command(after_help = "\
Ctrl-C or SIGTERM ends the run early, with files complete up to that time. A second signal ends it at once. In both cases, and
after a crash or a power cut, --resume continues the run from its last checkpoint, with identical bits. A folder that contains
a run is refused without --force. With --force, the old run stays unchanged until the new run is complete. A new run that is
interrupted or fails stays in the subfolder replacement, and --resume continues it.

Examples:
  carom run configs/hopper.toml
  carom run configs/hard_sphere_fluid.toml --seed 7 --until-events 1e6 --out runs/seven
  carom run configs/bouncing_ball.toml --set space.z.restitution=0.9 --set output.contacts=true
  carom run next.toml --from runs/fluid                 starts from the end of the run in runs/fluid
  carom run --resume runs/hopper                        continues to the planned end
  carom run --resume runs/hopper --until-time 160       continues to another end, even if the run was complete")]
pub struct Run {
    /// The scene, a TOML file
    #[arg(required_unless_present = "resume", conflicts_with = "resume")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
    /// Continues the run in this folder from its last checkpoint
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "seed", "overrides", "from"])]
    resume: Option<PathBuf>,
    /// The folder of the results; by default runs/NAME, where NAME is the name of the scene
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Measures for this simulated time instead of the time in the scene
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = duration)]
    until_time: Option<f64>,
    /// Measures for this number of physical events instead of the number in the scene; with --until-time, the limit
    /// that is reached first ends the run
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    until_events: Option<u64>,
    /// Wall time between two checkpoints, in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = seconds, default_value = CHECKPOINT_EVERY)]
    checkpoint_every: Duration,
    /// Number of threads, instead of the number in the scene. Any number yields the same results. auto uses one thread
    /// per core, but at most one per 50000 particles
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    threads: Option<Threads>,
    /// Replaces the run in the folder once the new run is complete; also allows output of more than 10 GB or a tenth of
    /// the free disk space
    #[arg(long)]
    force: bool,
    /// No progress, only the final table
    #[arg(long, short)]
    quiet: bool,
}

pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds| (1e-3..=1e9).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| "expected a time from 0.001 to 1e9 seconds".to_owned())
}

pub fn duration(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(time) if (1e-50..=1e50).contains(&time) => Ok(time),
        Ok(time) if time > 0.0 && time.is_finite() => Err("expected a time from 1e-50 to 1e50".to_owned()),
        _ => Err("expected a positive finite time".to_owned()),
    }
}

/// Parses a positive integer, such as `20000`, `1e6` or `1_000_000`.
pub fn count(text: &str) -> Result<u64, String> {
    let plain = text.replace('_', "");
    let whole = |x: &f64| x.fract() == 0.0 && (1.0..=9.007_199_254_740_992e15).contains(x);
    match (plain.parse::<u64>(), plain.parse::<f64>()) {
        (Ok(number), _) if number > 0 => Ok(number),
        (Err(_), Ok(number)) if whole(&number) => {
            #[expect(clippy::cast_possible_truncation, reason = "a whole number up to 2^53")]
            let number = number as u64;
            Ok(number)
        }
        _ => Err("expected a whole number of at least 1, such as 20000 or 1e6".to_owned()),
    }
}

impl Run {
    pub fn execute(&self, arguments: &[OsString], join: Join) -> Result<(), Failure> {
        let again = |folder: &Path| self.again(folder);
        let Some(communicator) = join() else { return self.ready()?.execute(None, &again) };
        let are_same = processes::refuse_others(arguments, &*communicator);
        if communicator.rank() > 0 {
            return processes::take_part(&communicator);
        }
        match are_same.and_then(|()| self.ready()) {
            Ok(ready) => ready.execute(Some(&communicator), &again),
            Err(failure) => {
                run::Run::shared(None, &communicator);
                Err(failure)
            }
        }
    }

    fn ready(&self) -> Result<Ready, Failure> {
        match (&self.resume, &self.scene) {
            (Some(path), _) => self.go_on(path),
            (None, Some(scene)) => self.begin(scene),
            // The command-line parser requires a scene or `--resume`.
            (None, None) => Err(Failure::bad_input("expected a scene, or --resume with a folder", None)),
        }
    }

    fn begin(&self, file: &Path) -> Result<Ready, Failure> {
        let mut scene = self.changes.load(file)?;
        super::refuse_exchange(
            &scene,
            "run it with `carom exchange`, or replace [exchange] with an Andersen thermostat in [run]",
        )?;
        if let Some(limit) = self.limit() {
            scene = scene.with_limit(limit)?;
        }
        let path = self.out.clone().unwrap_or_else(|| PathBuf::from("runs").join(scene.name()));
        let inputs = scene.inputs().iter().map(|input| Path::new(&input.path));
        refuse_input(&path, inputs.chain([file]))?;
        let record = self.changes.record(&scene, file)?;
        let most = self.most_bytes(&scene, &path)?;
        let mut folder = Folder::create(&path, &scene, super::existing(self.force))?
            .checkpoint_every(self.checkpoint_every)
            .at_most(most);
        folder.keep_scene(&record)?;
        let warnings = [
            description::unused_input(&scene),
            description::unmeasurable(&scene),
            description::unreached(&scene),
            description::burdens(&scene),
            description::at_rest(&scene),
        ];
        for warning in warnings.concat() {
            super::warn(&format!("warning: {warning}"));
        }
        let display = Display::new(&scene, self.quiet);
        Ok(Ready { run: self.on_threads(run::Run::without_start(scene)), folder, display })
    }

    fn go_on(&self, path: &Path) -> Result<Ready, Failure> {
        let (folder, checkpoint) =
            Folder::resume_with(path, self.limit(), &[]).map_err(|error| not_a_run(path, error))?;
        let most = if self.force { f64::INFINITY } else { allowance(free_disk(path)) };
        let folder = folder.checkpoint_every(self.checkpoint_every).at_most(most);
        let display = Display::new(checkpoint.simulation.scene(), self.quiet);
        Ok(Ready { run: self.on_threads(run::Run::resume(checkpoint)), folder, display })
    }

    fn again(&self, folder: &Path) -> Again {
        Again::new("run --resume", folder)
            .option("threads", self.threads)
            .checkpoint_every(self.checkpoint_every)
            .flags([("force", self.force), ("quiet", self.quiet)])
    }

    fn on_threads(&self, run: run::Run) -> run::Run {
        match self.threads {
            Some(threads) => run.threads(threads),
            None => run,
        }
    }

    fn most_bytes(&self, scene: &Scene, path: &Path) -> Result<f64, Failure> {
        if self.force {
            return Ok(f64::INFINITY);
        }
        let bytes = SizeEstimate::of(scene, run::foreseen_rate(scene).ok()).bytes;
        super::refuse_large("run", bytes, path, "longer intervals in [output]")
    }

    fn limit(&self) -> Option<Until> {
        let is_given = self.until_time.is_some() || self.until_events.is_some();
        is_given.then_some(Until { time: self.until_time, events: self.until_events })
    }
}

fn not_a_run(path: &Path, error: OutputError) -> Failure {
    let folder = path.display();
    let (what, cure) = match &error {
        OutputError::Checkpoint(CheckpointError::Missing(_)) if ExchangeFolder::is_one(path) => {
            ("a replica exchange", format!("continue it: carom exchange {folder}"))
        }
        OutputError::Checkpoint(CheckpointError::Missing(_)) if SweepFolder::existing(path).is_ok() => (
            "a sweep",
            format!(
                "continue all of its runs: carom sweep {folder}; with one of them: carom run --resume {folder}/RUN"
            ),
        ),
        _ => return error.into(),
    };
    Failure::bad_input(format!("{folder} is the folder of {what}, not of a run"), Some(&cure))
}

struct Ready {
    run: run::Run,
    folder: Folder,
    display: Display,
}

impl Ready {
    fn execute(
        self,
        communicator: Option<&Arc<dyn Communicator>>,
        again: &dyn Fn(&Path) -> Again,
    ) -> Result<(), Failure> {
        let Self { run, mut folder, mut display } = self;
        let run = match communicator {
            Some(communicator) => run::Run::shared(Some(run), communicator),
            None => Some(run),
        };
        let Some(run) = run else { return Ok(()) };
        signals::watch();
        let result = run.execute(&mut folder, &mut |progress| {
            display.show(progress);
            signals::flow()
        });
        display.clear();
        match (result, communicator) {
            (Ok(finished), _) => end(&finished, folder, again),
            (Err(error), None) => Err(error.into()),
            (Err(error), Some(communicator)) => {
                // The failure of one process does not end the others.
                Failure::from(error).report();
                communicator.abort("the run ends here")
            }
        }
    }
}

fn end(finished: &Finished, folder: Folder, again: &dyn Fn(&Path) -> Again) -> Result<(), Failure> {
    let report = final_table::text(finished);
    let excess = folder.excess().filter(|_| finished.ending == Ending::Interrupted);
    let done = folder.complete(finished, &report)?;
    super::print_report(&format!(
        "{report}\nThe files are in {}\n{}",
        done.folder.display(),
        stay(finished, &done, again)
    ))?;
    let failures: Vec<String> = done.failures.iter().map(|failure| with_causes(failure)).collect();
    let unconverted = format!("the trajectory was not converted: {}", failures.join("; "));
    let again_here = again(done.kept.as_ref().unwrap_or(&done.folder));
    if let Err(failure) = excess.map_or_else(|| verdict(finished, &again_here), |excess| Err(excess.into())) {
        if !failures.is_empty() {
            super::warn(&unconverted);
        }
        return Err(failure);
    }
    let cure = match &done.kept {
        _ if failures.is_empty() => return Ok(()),
        None => "everything else is complete; remove the cause, then run `carom convert`".to_owned(),
        Some(_) => format!("remove the cause, then run `{again_here}`"),
    };
    Err(Failure::failed(unconverted, Some(&cure)))
}

fn stay(finished: &Finished, done: &Completed, again: &dyn Fn(&Path) -> Again) -> String {
    let Some(kept) = &done.kept else { return String::new() };
    let run = kept.display();
    let new = done.folder.display();
    let why = if done.failures.is_empty() { "was interrupted or failed" } else { "is not complete" };
    let next = if finished.can_go_on() {
        format!("`{}` finishes the new run, which then replaces the old one; ", again(kept))
    } else {
        format!("To keep the new run, move {new} elsewhere; ")
    };
    format!("The run in {run} is unchanged: the new run {why}\n{next}`--force` starts the run from the beginning\n")
}

fn verdict(finished: &Finished, again: &Again) -> Result<(), Failure> {
    let faults = finished.audit.faults();
    match &finished.ending {
        Ending::Blocked(blocked) => Err(Failure::failed(blocked.to_string(), Some(Blocked::CURE))),
        Ending::Jammed(jam) => Err(Failure::failed(jam.to_string(), Some(Jam::CURE))),
        Ending::Arrested(arrest) => Err(Failure::failed(arrest.told(finished.simulation.scene()), Some(arrest.cure()))),
        Ending::Broken(broken) => Err(Failure::failed(broken.to_string(), Some(InvariantBroken::CURE))),
        _ if !faults.is_empty() => {
            let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
            Err(Failure::of_audit(&faults))
        }
        Ending::GaveUp => Err(Failure::failed(
            format!(
                "gave up at time {}: no event happened during a million rows of output, or for a very long time",
                finished.simulation.time()
            ),
            Some("set run.until_time, or longer intervals in [output]"),
        )),
        Ending::Unsettled => Err(Failure::failed(
            format!(
                "gave up at time {}: the equilibration did not end, because after {} events per particle, an \
                 observable still drifts, or its drift is unknown",
                finished.simulation.time(),
                run::MOST_EVENTS_PER_PARTICLE
            ),
            Some("set run.equilibration_time or run.equilibration_events; a system that loses energy needs a supply"),
        )),
        Ending::Interrupted => Err(Failure::failed(
            "interrupted; the files are complete up to there",
            Some(&format!("{again} continues it")),
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn event_counts_accept_exponents_and_underscores() {
        assert_eq!(count("1e6"), Ok(1_000_000));
        assert_eq!(count("20_000"), Ok(20_000));
        assert_eq!(count("18446744073709551615"), Ok(u64::MAX));
        for bad in ["0", "-1", "1.5", "1e30", "nan", "inf", "", "many"] {
            assert!(count(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn times_are_positive_and_finite() {
        assert_eq!(duration("2.5"), Ok(2.5));
        for bad in ["0", "-1", "nan", "inf", "", "1e-300"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }
}
