mod display;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::analysis::statistics::Estimate;
use crate::base::text::{digits, with_causes};
use crate::io::estimate::{allowance, free_disk};
use crate::io::{Existing, FolderState, refuse_link};
use crate::sweep::{
    Agreement, Axis, Fate, News, Orders, Pooled, Results, Share, Standing, Sweep, SweepError, SweepFolder,
};
use crate::view::report;
use crate::view::{describe, final_table};
use clap::Args;

use super::again::{Again, CHECKPOINT_EVERY};
use super::failure::Failure;
use super::signals;
use super::terminal::columns;
use super::{Changes, borrowed, cores};
use display::Display;

/// Runs a scene for all combinations of values
#[derive(Debug, Args)]
#[command(after_help = "\
Each combination is a run in its own folder, with all files of a run. sweep.csv has a row for each run. sweep-mean.csv has a row for
each state point, with means over its seeds. In both tables, measured stages have their own rows. sweep.html plots every quantity
against the varied value, and links to a page of each run, run.html. Existing runs are not repeated: the same command resumes an
interrupted sweep, with identical bits, and accepts further values and seeds.

VALUES are a list, 0.1,0.2; integers, 1..5; a range with a number of values, 0.05..0.49/12; or a logarithmic range, 0.01..10/7/log.
Keys that change together are in one --vary, separated by `;`. The last --vary changes fastest. Means are taken over `seed`.

Examples:
  carom sweep fluid.toml --vary fill.0.packing_fraction=0.05..0.49/12 --vary seed=1..3
  carom sweep fluid.toml --vary 'fill.0.packing_fraction=0.1,0.4; run.until_events=1e5,4e5' --set run.equilibration_events=20000
  carom sweep study.toml                     scene = \"fluid.toml\", vary = [\"seed=1..3\"] and, optionally, set = [\"run.until_time=10\"]
  carom sweep runs/fluid-sweep               continues the sweep in this folder
  carom sweep study.toml --array $SLURM_ARRAY_TASK_ID/12     one task of a job array")]
pub struct SweepCommand {
    /// A scene with --vary, a sweep file, or the folder of a sweep
    path: PathBuf,
    /// A key of the scene and its values; may be repeated to run all combinations
    #[arg(long = "vary", value_name = "KEY=VALUES")]
    axes: Vec<Axis>,
    #[command(flatten)]
    changes: Changes,
    /// Number of runs at the same time; by default the number of processors
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// The folder of the sweep; by default runs/NAME-sweep, where NAME is the name of the file
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Runs only the K-th of every N points
    #[arg(long = "array", value_name = "K/N", value_parser = share)]
    share: Option<Share>,
    /// Wall time between two checkpoints of a run, in seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = super::run::seconds, default_value = CHECKPOINT_EVERY)]
    checkpoint_every: Duration,
    /// Allows output of more than 10 GB or a tenth of the free disk space
    #[arg(long)]
    force: bool,
    /// No progress, only the final table
    #[arg(long, short)]
    quiet: bool,
}

fn share(text: &str) -> Result<Share, String> {
    let share = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
    match share {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Share { number, of }),
        _ => Err("expected K/N with K from 1 to N, such as 3/12".to_owned()),
    }
}

impl SweepCommand {
    pub fn execute(&self) -> Result<(), Failure> {
        let (sweep, path) = self.sweep()?;
        self.check(&sweep, &path)?;
        let folder = SweepFolder::open(&path, &sweep)?;
        signals::watch();
        let display = Display::new(&sweep, self.share.unwrap_or(Share::ALL), self.quiet);
        let orders = Orders {
            jobs: self.jobs.map_or_else(cores, usize::from),
            share: self.share.unwrap_or(Share::ALL),
            checkpoint_every: self.checkpoint_every,
            most_bytes: if self.force { f64::INFINITY } else { allowance(free_disk(&path)) },
            report: &final_table::text,
            instruments: &|run| run,
            instrument_names: &[],
        };
        let watch = |place: usize, news: News<'_>| {
            display.show(&sweep, place, &news);
            signals::flow()
        };
        let fates = folder.execute(&sweep, &orders, &watch);
        display.clear();
        self.end(&sweep, &folder, &fates?)
    }

    fn sweep(&self) -> Result<(Sweep, PathBuf), Failure> {
        let changes = self.changes.all();
        if !self.axes.is_empty() {
            let sweep = Sweep::new(&self.path, &borrowed(&changes), self.axes.clone())?;
            let path = self.out.clone().unwrap_or_else(|| beside(&self.path));
            return Ok((sweep, path));
        }
        if !changes.is_empty() {
            let help = "add the axes with --vary, or write the changes into the sweep file, as set = [\"KEY=VALUE\"]";
            return Err(Failure::bad_input("--set, --seed and --from need --vary", Some(help)));
        }
        if self.path.is_dir() {
            let file = SweepFolder::file_in(&self.path);
            if !file.exists() {
                let message = format!("{} is not the folder of a sweep: it has no sweep.toml", self.path.display());
                return Err(Failure::bad_input(message, Some("start a sweep with a scene and --vary")));
            }
            let path = self.out.clone().unwrap_or_else(|| self.path.clone());
            return Ok((Sweep::from_file(file)?, path));
        }
        let sweep = Sweep::from_file(&self.path).map_err(|error| match error {
            SweepError::File { .. } => {
                let help = "if it is a scene, give the keys that vary, such as --vary seed=1..3; the file of a sweep has the keys \
                     scene = \"fluid.toml\", vary = [\"seed=1..3\"] and, if wanted, set = [\"run.until_time=10\"]";
                Failure::bad_input(with_causes(&error), Some(help))
            }
            error => error.into(),
        })?;
        // The command continues a sweep if the folder of `sweep.toml` has runs of the sweep.
        let own = self.path.parent().filter(|folder| SweepFolder::file_in(folder) == self.path);
        let path = self.out.clone().or_else(|| own.filter(|folder| holds_runs(folder, &sweep)).map(Path::to_owned));
        Ok((sweep, path.unwrap_or_else(|| beside(&self.path))))
    }

    /// Finds mistakes before any file is created.
    fn check(&self, sweep: &Sweep, path: &Path) -> Result<(), Failure> {
        let scene = sweep.check()?;
        super::refuse_exchange(
            &scene,
            "a sweep varies runs; for exchanges, loop over `carom exchange` with --set and --seed",
        )?;
        if self.force {
            return Ok(());
        }
        super::refuse_large("sweep", sweep.expected_bytes(&scene), path, "longer intervals in [output]").map(drop)
    }

    fn end(&self, sweep: &Sweep, folder: &SweepFolder, fates: &[(usize, Fate)]) -> Result<(), Failure> {
        let results = Results::read(folder, sweep);
        folder.write_tables(sweep, &results)?;
        let page = report::sweep_page_in(folder.path());
        refuse_link(&page)?;
        let hindered = report::write_run_pages(folder, sweep, &results);
        if let Some(first) = hindered.first() {
            super::warn(&format!("{} runs have no page: {}", hindered.len(), with_causes(first)));
        }
        report::write(&report::sweep_page(folder, sweep, &results), &page, Existing::Replace)?;
        super::print_report(&format!(
            "{}\nThe files are in {}: sweep.csv, sweep-mean.csv, sweep.html\n",
            text(sweep, &results, fates.iter().filter(|(_, fate)| *fate == Fate::Kept).count()),
            folder.path().display()
        ))?;
        let failed: Vec<String> = fates
            .iter()
            .filter_map(|(place, fate)| match fate {
                Fate::Failed(why) => Some(format!("{}: {why}", sweep.points()[*place].folder())),
                _ => None,
            })
            .collect();
        let elsewhere = fates.iter().filter(|(_, fate)| *fate == Fate::Elsewhere).count();
        if elsewhere > 0 {
            super::warn(&format!(
                "{elsewhere} runs are under way in other processes; the same command shows them when they are done"
            ));
        }
        if results.repeats() > 0 {
            super::warn(&format!(
                "{} runs are bit-for-bit equal to others, because nothing in them depends on the seed: the means count equal runs once",
                results.repeats()
            ));
        }
        let is_interrupted =
            signals::flow() == ControlFlow::Break(()) || fates.iter().any(|(_, fate)| *fate == Fate::Interrupted);
        if !failed.is_empty() {
            let message = format!("{} of {} runs failed:\n{}", failed.len(), fates.len(), failed.join("\n"));
            let help = "the other runs are complete; if a failed run has a folder, see its report.txt";
            return Err(Failure::failed(message, Some(help)));
        }
        if is_interrupted {
            let help = format!("repeat the same command, or: {}", self.again(folder.path()));
            return Err(Failure::failed("interrupted; complete runs are kept", Some(&help)));
        }
        Ok(())
    }

    fn again(&self, folder: &Path) -> Again {
        let share = self.share.map(|Share { number, of }| format!("{number}/{of}"));
        Again::new("sweep", folder)
            .option("jobs", self.jobs)
            .option("array", share)
            .checkpoint_every(self.checkpoint_every)
            .flags([("force", self.force), ("quiet", self.quiet)])
    }
}

fn holds_runs(folder: &Path, sweep: &Sweep) -> bool {
    let is_there =
        |name: &str| crate::io::Folder::state_of(&folder.join(name)).is_ok_and(|it| it != FolderState::Nothing);
    sweep.points().iter().any(|point| is_there(point.folder()))
}

fn beside(file: &Path) -> PathBuf {
    let name = file.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    PathBuf::from("runs").join(format!("{name}-sweep"))
}

const MOST_COLUMNS: usize = 4;
const MOST_ROWS: usize = 40;

/// Returns a report with the numbers of runs, a table of mean values, and comparisons with published values.
fn text(sweep: &Sweep, results: &Results, kept: usize) -> String {
    let [done, failed] = results.counts();
    let begun = results.points.iter().filter(|point| matches!(point.standing, Standing::Begun)).count();
    let missing = results.points.len() - done - failed - begun;
    let mut words = vec![format!("{done} of {} runs done", results.points.len())];
    for (count, what) in [(kept, "were there already"), (failed, "failed"), (begun, "begun"), (missing, "not begun")] {
        words.extend((count > 0).then(|| format!("{count} {what}")));
    }
    let mut lines = vec![words.join(", ")];
    let shown: Vec<usize> = (0..results.quantities.len()).take(MOST_COLUMNS).collect();
    if shown.is_empty() {
        return lines.concat() + "\n";
    }
    let names = shown.iter().map(|at| results.quantities[*at].name.replace('_', " "));
    let stage = results.has_stages().then(|| "stage".to_owned());
    let heads = sweep.state_point_names().into_iter().chain(stage).chain(["runs".to_owned()]).chain(names);
    let mut rows: Vec<Vec<String>> = vec![heads.collect()];
    let keys = rows[0].len() - shown.len();
    for (group, means) in results.means().take(MOST_ROWS) {
        let settings = sweep.points()[group.places[0]].state_point().map(|(_, value)| value.clone());
        let stage = results.has_stages().then(|| means.stage.clone());
        let values = shown.iter().map(|at| match means.values[*at] {
            None => String::new(),
            // A quantity that is constant in each run has no standard error, but may differ between runs.
            Some(Pooled { estimate: Estimate { mean, standard_error }, scatter, .. }) => {
                match standard_error.filter(|error| *error > 0.0).or(scatter) {
                    Some(error) if error > 0.0 => describe::estimate(&Estimate { mean, standard_error: Some(error) }),
                    _ => digits(mean),
                }
            }
        });
        rows.push(settings.chain(stage).chain([means.runs.to_string()]).chain(values).collect());
    }
    lines.extend(columns(&rows, keys));
    let more = results.means().count().saturating_sub(MOST_ROWS);
    if more > 0 {
        lines.push(format!("  and {more} more in sweep-mean.csv"));
    }
    lines.extend(shown.iter().flat_map(|at| agreements(results, *at)));
    lines.join("\n") + "\n"
}

fn agreements(results: &Results, at: usize) -> Vec<String> {
    let name = results.quantities[at].name.replace('_', " ");
    let line = |it: &Agreement| {
        let without = it.without_size.map(|sum| format!(" ({} without the finite-size correction)", digits(sum)));
        let (sum, without) = (digits(it.chi_square), without.unwrap_or_default());
        format!(
            "{name} compared with {}: chi^2 = {sum} for {} degrees of freedom{without}{}",
            it.label.trim_start_matches("from "),
            it.freedom,
            it.left_out()
        )
    };
    results.agreements(at).iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_partition_the_points() {
        assert_eq!(share("3/12"), Ok(Share { number: 3, of: 12 }));
        for bad in ["0/3", "4/3", "3", "a/b", "1/0", "-1/2"] {
            assert!(share(bad).is_err(), "{bad}");
        }
        let all: Vec<usize> =
            (1..=3).flat_map(|number| (0..10).filter(move |at| Share { number, of: 3 }.has(*at))).collect();
        assert_eq!(all, [0, 3, 6, 9, 1, 4, 7, 2, 5, 8]);
    }
}
