use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use crate::base::text::{self, digits, short, tiny, with_causes};
use crate::check::compare::{self, CompareError, Comparison};
use crate::check::verify::{
    self, Certificate, Contact, Counts, End, EventRange, Fault, RunEnd, VerifyProgress, Violation,
};
use crate::engine::InvariantBroken;
use crate::exchange::ExchangeFolder;
use crate::io::{Folder, Summary, read_scene};
use crate::model::Scene;
use crate::run::Progress;
use crate::view::describe;
use crate::view::final_table::{self, Lines, kinds};
use clap::Args;

use super::Changes;
use super::failure::Failure;
use super::progress::Display;
use super::run::count;
use super::signals;

/// Proves a range of events of a run, and compares its files with the files of a replay
#[derive(Debug, Args)]
#[command(after_help = "\
Replays the events and checks each against the paper's Algorithm 1, over all pairs, walls and features of surfaces,
without the engine's cells, predictions or memory. The cost of an event grows with the number of particles.
For the folder of a run, also repeats the whole run in a temporary folder, and compares the files byte by byte.

Examples:
  carom verify configs/hopper.toml
  carom verify runs/fluid --from-events 1e6 --events 1e5
  carom verify configs/polymer.toml --seed 7 --set run.until_time=5")]
pub struct Verify {
    /// The folder of a run, or a scene
    #[arg(value_name = "RUN_OR_SCENE")]
    run: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Proves this number of physical events, or all events up to the end of a shorter run
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count, default_value = "1e5")]
    events: u64,
    /// First replays this number of events without proof; the pair states then come from the engine
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = count)]
    from_events: Option<u64>,
    /// Skips the comparison of the files, which takes as long as the run itself
    #[arg(long)]
    no_files: bool,
    /// No progress, only the final table
    #[arg(long, short)]
    quiet: bool,
}

impl Verify {
    pub fn execute(&self) -> Result<(), Failure> {
        let (scene, recorded) = self.load()?;
        signals::watch_without_traces();
        let mut display = Display::new(&scene, self.quiet);
        let mut watch = |step: &VerifyStep| {
            display.show(step);
            signals::flow()
        };
        let folder = recorded.is_some().then_some(self.run.as_path()).filter(|_| !self.no_files);
        let proof = prove(scene, recorded.as_ref(), (self.from_events, self.events), folder, &mut watch);
        display.clear();
        let proof = proof?;
        super::print_report(&proof.table)?;
        proof.verdict
    }

    fn load(&self) -> Result<(Scene, Option<Recorded>), Failure> {
        if !self.run.is_dir() {
            return Ok((self.changes.load(&self.run)?, None));
        }
        let file = Folder::scene_of(&self.run);
        if file.exists() && !self.changes.are_none() {
            let help = format!("prove a changed scene from its file: carom verify {}", file.display());
            let message = "a run is proven as it was simulated: --seed and --set need a scene file";
            return Err(Failure::bad_input(message, Some(&help)));
        }
        let (scene, recorded) = load_run(&self.run)?;
        Ok((scene, Some(recorded)))
    }
}

fn load_run(run: &Path) -> Result<(Scene, Recorded), Failure> {
    let file = Folder::scene_of(run);
    if !file.exists() {
        let message = format!("{} has no scene.toml", run.display());
        let help = "carom run writes the scene of a run into its folder when the run is complete";
        return Err(Failure::bad_input(message, Some(help)));
    }
    let recorded = Recorded::read(run)?;
    let scene = read_scene(&file, &[])?;
    recorded.refuse_other(&scene)?;
    Ok((scene, recorded))
}

/// Progress of `carom verify`.
#[derive(Debug)]
pub enum VerifyStep<'a> {
    /// Progress of the proof.
    Proof(&'a VerifyProgress),
    /// Progress of the replay of the run.
    Files(&'a Progress),
}

/// Result of a proof.
#[derive(Debug)]
pub struct Proof {
    /// The proven range, the event counts and the margins.
    pub certificate: Certificate,
    /// Comparison of the run's files with the replay; `None` if not requested.
    pub files: Option<Comparison>,
    /// The printed table.
    pub table: String,
    /// The failure, if the proof or the comparison failed.
    pub verdict: Result<(), Failure>,
}

/// Proves `events` physical events of the run in a folder, after the first `from` events. With `has_files`, also
/// repeats the run and compares its files.
///
/// # Errors
/// [`Failure`] if nothing can be proven, or the files cannot be compared.
pub fn prove_run(
    run: &Path,
    (from, events): (Option<u64>, u64),
    has_files: bool,
    watch: &mut dyn FnMut(&VerifyStep) -> ControlFlow<()>,
) -> Result<Proof, Failure> {
    let (scene, recorded) = load_run(run)?;
    prove(scene, Some(&recorded), (from, events), has_files.then_some(run), watch)
}

fn prove(
    scene: Scene,
    recorded: Option<&Recorded>,
    (from, events): (Option<u64>, u64),
    folder: Option<&Path>,
    watch: &mut dyn FnMut(&VerifyStep) -> ControlFlow<()>,
) -> Result<Proof, Failure> {
    super::refuse_exchange(&scene, "replace [exchange] with an Andersen thermostat at one temperature in [run]")?;
    let range = EventRange { from: from.unwrap_or(0), events };
    let refuse_nothing = |events: u64| match from {
        None => Ok(()),
        Some(_) => {
            let message = format!("the run has only {}", text::plural(events, "event"));
            Err(Failure::bad_input(message, Some("choose a smaller --from-events")))
        }
    };
    if let Some(events) = recorded.and_then(|it| it.end.events).filter(|events| range.from >= *events) {
        refuse_nothing(events)?;
    }
    let header = header(&scene);
    let surfaces: Vec<String> = scene.surfaces().iter().map(|surface| surface.name.clone()).collect();
    let starts_from_run = scene.predecessor().is_some();
    let of_proof = &mut |progress: &VerifyProgress| watch(&VerifyStep::Proof(progress));
    let certificate = match recorded {
        Some(recorded) => verify::verify_run(scene, recorded.end, range, of_proof),
        None => verify::verify(scene, range, of_proof),
    };
    // The range must start before the end of the run.
    let has_ended = matches!(certificate.end, End::RunEnded | End::Idle);
    if has_ended && certificate.first_event <= range.from {
        refuse_nothing(certificate.first_event - 1)?;
    }
    let folder = folder.filter(|_| certificate.end != End::Interrupted);
    let files = folder
        .map(|run| compare::compare(run, &final_table::text, &mut |progress| watch(&VerifyStep::Files(progress))))
        .transpose()?;
    let files_table = files.as_ref().map_or_else(String::new, files_table);
    let table = format!("{header}{}{files_table}", table(&certificate, recorded.is_some(), starts_from_run));
    let verdict = verdict(&certificate, recorded, &surfaces)
        .and_then(|()| files.as_ref().map_or(Ok(()), |files| verdict_of_files(files, recorded)));
    Ok(Proof { certificate, files, table, verdict })
}

impl From<CompareError> for Failure {
    fn from(error: CompareError) -> Self {
        match error {
            CompareError::Scene(error) => error.into(),
            CompareError::Output(_) | CompareError::NoRoom { .. } => {
                Self::failed(with_causes(&error), Some(CompareError::CURE))
            }
            error => Self::bad_input(with_causes(&error), None),
        }
    }
}

const MOST_NAMES: usize = 5;

fn files_table(files: &Comparison) -> String {
    let mut lines = Lines::default();
    lines.title("files compared with a replay");
    if files.is_interrupted {
        lines.line("INTERRUPTED: not compared");
        return lines.text();
    }
    lines.pair("equal", &several(&files.equal, files.equal.len()));
    let shown = files.differences.iter().take(MOST_NAMES);
    for (name, difference) in shown {
        lines.pair("DIFFERENT", &format!("{name}: {difference}"));
    }
    if files.differences.len() > MOST_NAMES {
        lines.pair("", &format!("and {} more", files.differences.len() - MOST_NAMES));
    }
    let mut reasons: Vec<&str> = files.not_compared.iter().map(|(_, why)| *why).collect();
    reasons.sort_unstable();
    reasons.dedup();
    for (at, why) in reasons.into_iter().enumerate() {
        let names: Vec<String> =
            files.not_compared.iter().filter(|(_, other)| *other == why).map(|(name, _)| name.clone()).collect();
        let title = if at == 0 { "not compared" } else { "" };
        lines.pair(title, &format!("{}: {why}", several(&names, names.len())));
    }
    lines.text()
}

/// Lists the first few names, and the number of the remaining names.
fn several(names: &[String], count: usize) -> String {
    let shown = names.iter().take(MOST_NAMES).map(String::as_str).collect::<Vec<_>>().join(", ");
    match count {
        0 => "none".to_owned(),
        count if count > MOST_NAMES => format!("{shown} and {} more", count - MOST_NAMES),
        _ => shown,
    }
}

fn verdict_of_files(files: &Comparison, recorded: Option<&Recorded>) -> Result<(), Failure> {
    if files.is_interrupted {
        return Err(Failure::failed("interrupted; the events above are proven, the files were not compared", None));
    }
    let Some((name, difference)) = files.differences.first() else { return Ok(()) };
    let others = match files.differences.len() {
        1 => String::new(),
        count => format!(", and {} differ", text::plural(count - 1, "other file")),
    };
    let version = recorded.map_or("", |recorded| recorded.summary.version.as_str());
    let help = match version {
        env!("CARGO_PKG_VERSION") => {
            "the file was changed after the run, or another build or machine wrote it: run the scene again".to_owned()
        }
        _ => format!(
            "the run was made by Carom {version}, whose files may differ: verify it with that version, or run the scene again"
        ),
    };
    Err(Failure::failed(format!("{name} differs from the file of the replay: {difference}{others}"), Some(&help)))
}

struct Recorded {
    path: PathBuf,
    summary: Summary,
    end: RunEnd,
}

impl Recorded {
    fn read(run: &Path) -> Result<Self, Failure> {
        if ExchangeFolder::is_one(run) {
            let help = "its replicas have heat baths, so no event can be proven; verify a run of a single replica";
            let message = format!("{} is the folder of a replica exchange", run.display());
            return Err(Failure::bad_input(message, Some(help)));
        }
        let path = Folder::summary_of(run);
        let text = std::fs::read(&path).map_err(|source| {
            let help = "a run writes it at its end; a killed run has none, and carom run --resume continues it";
            Failure::bad_input(format!("cannot read {}: {source}", path.display()), Some(help))
        })?;
        let summary: Summary = serde_json::from_slice(&text).map_err(|source| {
            let message = format!("{} is not the summary of a run: {source}", path.display());
            Failure::bad_input(message, Some("run the scene again, or restore the file"))
        })?;
        let events = summary.events.before.map(|before| before.saturating_add(summary.events.total));
        let end = RunEnd { events, time: summary.time };
        Ok(Self { path, summary, end })
    }

    fn refuse_other(&self, scene: &Scene) -> Result<(), Failure> {
        let numbers = [
            ("seed", scene.seed(), self.summary.seed),
            ("number of particles", scene.particles().len() as u64, self.summary.particles as u64),
        ];
        // The number of particles may have changed during the run.
        let mut numbers = numbers.into_iter().take(if scene.has_flow() { 1 } else { 2 });
        let Some((what, of_scene, of_run)) = numbers.find(|(_, of_scene, of_run)| of_scene != of_run) else {
            return Ok(());
        };
        let message =
            format!("scene.toml is not the scene of this run: its {what} is {of_scene}, but {of_run} in summary.json");
        let help = format!("restore {}, or run the scene again", self.path.with_file_name("scene.toml").display());
        Err(Failure::bad_input(message, Some(&help)))
    }
}

fn header(scene: &Scene) -> String {
    let mut lines = Lines::default();
    lines.pair("scene", &format!("{}, seed {}", scene.name(), scene.seed()));
    lines.pair("particles", &describe::population(scene));
    let moving = scene.particles().iter().filter(|p| !scene.species()[p.species.0 as usize].is_static()).count() as f64;
    let all = scene.particles().len() as f64;
    let pairs = moving * (all - moving) + 0.5 * moving * (moving - 1.0);
    let others =
        if scene.surfaces().is_empty() { " and all walls" } else { ", all walls and all features of surfaces" };
    lines.pair("rule", &format!("Algorithm 1 over all {pairs} pairs{others}"));
    lines.text()
}

fn table(certificate: &Certificate, is_of_run: bool, starts_from_run: bool) -> String {
    let Certificate { first_event, start, duration, counts, margins, .. } = certificate;
    let mut lines = Lines::default();
    lines.pair("range", &format!("event {first_event} to {}", first_event + counts.events().max(1) - 1));
    lines.pair("", &format!("from t = {} on, a time of {}", digits(*start), digits(*duration)));
    let pairs = match (*first_event, starts_from_run) {
        (2.., _) => "from the engine at the start of the range",
        (_, true) => "from the end of the run in [start]",
        (_, false) => "from the distances at the start",
    };
    lines.pair("pair states", &format!("{pairs}, then from the events"));
    lines.title("proven");
    let Counts { core, capture, release, bounce, wall, surface, .. } = *counts;
    let kinds = kinds([core, capture, release, bounce, wall], |count| count.to_string());
    let surfaces = if surface > 0 { format!("{surface} surface") } else { String::new() };
    let kinds: Vec<String> = [kinds, surfaces].into_iter().filter(|words| !words.is_empty()).collect();
    let kinds = if kinds.is_empty() { String::new() } else { format!(" ({})", kinds.join(", ")) };
    lines.pair("events", &format!("{}{kinds}", counts.events()));
    lines.pair("ties within round-off", &counts.ties.to_string());
    lines.pair("at turning points", &counts.turning_points.to_string());
    lines.pair("in invalid states", &counts.in_invalid_state.to_string());
    lines.pair("due times asked for", &short(counts.asked as f64));
    lines.title("how exactly");
    lines
        .pair("largest gap at an event", &format!("{} of the discontinuity's distance", tiny(certificate.largest_gap)));
    lines.pair("deepest overlap at an event", &format!("{} of it", tiny(certificate.deepest_overlap)));
    for (name, margin) in [
        ("gaps and overlaps", margins.distance.max(margins.overlap)),
        ("velocities and energies", margins.outcome),
        ("flights", margins.flight),
    ] {
        lines.pair(name, &format!("at most {:.1} % of the round-off bound", 100.0 * margin));
    }
    lines.title("verdict");
    lines.line(&words(certificate));
    if is_of_run {
        match certificate.end {
            End::RunEnded | End::Idle => lines.line("number of events and final time agree with summary.json"),
            End::Asked => lines.line("of the scene in the folder; its seed and particles agree with summary.json"),
            _ => {}
        }
    }
    lines.text()
}

fn words(certificate: &Certificate) -> String {
    let proven = "PROVEN: no event is missing, spurious or out of order, and the outcome of each is correct";
    match certificate.end {
        End::Asked => proven.to_owned(),
        End::RunEnded => format!("{proven},\nup to the end of the run"),
        End::Idle => format!("{proven};\nnothing will happen any more"),
        End::Driven => {
            "NOTHING PROVEN: the run has a thermostat, a barostat, swap moves, growth, shear, a thermal wall, a thermal surface, an inlet \
             or an outlet"
                .to_owned()
        }
        End::OpenStages => {
            "NOTHING PROVEN: surfaces appear or vanish, or gravity changes, at a time that the scene does not define"
                .to_owned()
        }
        End::Departed { .. } => "NOT PROVEN: the events above belong to another run".to_owned(),
        End::Interrupted => "INTERRUPTED: the events above are proven".to_owned(),
        End::Violated(Violation { fault: Fault::EndedEarly { .. } | Fault::EndNotShown { .. }, .. }) => {
            "VIOLATED: the events above are proven, but another event may follow".to_owned()
        }
        End::Violated(Violation { fault: Fault::TooFast { .. } | Fault::WithoutDigits { .. }, .. }) => {
            "NOT PROVEN: the events above are proven; the numbers have too few digits for what follows".to_owned()
        }
        End::Violated(_) => "VIOLATED: the events above are proven, but the next event is wrong".to_owned(),
        End::Arrested(_) => "ARRESTED: the events above are proven, and the run cannot continue".to_owned(),
        End::Broken(_) => "BROKEN: the events above are proven, and the engine cannot continue".to_owned(),
    }
}

fn verdict(certificate: &Certificate, recorded: Option<&Recorded>, surfaces: &[String]) -> Result<(), Failure> {
    match certificate.end {
        End::Departed { recorded: run, events, time } => {
            let of_run = run.events.map_or_else(String::new, |events| format!("{events} events and "));
            let message = format!(
                "scene.toml does not reproduce the end of this run: it gives {events} events and a time of {time}, but summary.json has {of_run}{}",
                run.time
            );
            let version = recorded.map_or("", |recorded| recorded.summary.version.as_str());
            let help = match version {
                env!("CARGO_PKG_VERSION") => "restore scene.toml, or run the scene again".to_owned(),
                _ => format!(
                    "the run was made by Carom {version}, whose events may differ: prove it with that version, or run the scene again"
                ),
            };
            Err(Failure::failed(message, Some(&help)))
        }
        End::Violated(violation @ Violation { fault: Fault::TooFast { .. } | Fault::WithoutDigits { .. }, .. }) => {
            let help = "use a smaller box, shallower wells or slower particles, so that round-off is smaller";
            Err(Failure::failed(message(&violation, surfaces), Some(help)))
        }
        End::Violated(violation) => {
            let help = "this is a bug in Carom: please report the scene and the command";
            Err(Failure::failed(message(&violation, surfaces), Some(help)))
        }
        End::Arrested(arrest) => Err(Failure::failed(arrest.to_string(), Some(arrest.cure()))),
        End::Broken(broken) => Err(Failure::failed(broken.to_string(), Some(InvariantBroken::CURE))),
        End::Driven => {
            let help = "remove these features from the scene; moving surfaces and changing gravity can stay";
            Err(Failure::bad_input(
                "only runs without thermostat, barostat, swap moves, growth, shear, thermal walls or surfaces, inlets and outlets can be proven",
                Some(help),
            ))
        }
        End::OpenStages => {
            let help =
                "end the stage with until_time or until_events, or use the same surfaces and gravity in all stages";
            let what = "surfaces appear or vanish, or gravity changes, after a stage whose end depends on measurements";
            Err(Failure::bad_input(what, Some(help)))
        }
        End::Interrupted => Err(Failure::failed("interrupted; the events above are proven", None)),
        _ => Ok(()),
    }
}

fn message(violation: &Violation, surfaces: &[String]) -> String {
    let surface = match violation.fault.contact() {
        Some(Contact::Surface { surface, .. }) => surfaces.get(surface as usize),
        _ => None,
    };
    surface.map_or_else(|| violation.to_string(), |name| format!("{violation} (the surface is `{name}`)"))
}
