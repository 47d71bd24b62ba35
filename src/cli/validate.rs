use std::fmt::Write;

use crate::base::text::digits;
use crate::check::validate::{self, Comparison, Effort, Source, StatePoint, StatePointError, Verdict};
use clap::Args;

use super::failure::Failure;
use super::signals;

/// Measures known state points and compares the results
#[derive(Debug, Args)]
#[command(after_help = "\
A quantity passes if its deviation is at most four standard errors plus an allowance. The table's notes give the reason: the
effect of a finite number of particles, an approximation of the theory, or round-off. The default takes about a minute.

Examples:
  carom validate --list
  carom validate hard_spheres
  carom validate --long --seed 2")]
pub struct Validate {
    /// Selects the points whose names contain this text
    filter: Option<String>,
    /// Lists the points without measuring them
    #[arg(long)]
    list: bool,
    /// More particles, events and points; takes a quarter of an hour
    #[arg(long, conflicts_with = "brief")]
    long: bool,
    /// Fewer events at fewer points; takes seconds
    #[arg(long)]
    brief: bool,
    /// Seed of the random numbers that draw velocities
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
        value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
}

impl Validate {
    pub fn execute(&self) -> Result<(), Failure> {
        let points = self.points()?;
        if self.list {
            return super::print(&list(&points));
        }
        signals::watch_without_traces();
        super::print(&head())?;
        let (mut count, mut bad) = (0, 0);
        let mut notes = Notes::default();
        for point in &points {
            match point.measure(self.seed, &mut signals::flow) {
                Ok(compared) => {
                    count += compared.len();
                    bad += compared.iter().filter(|comparison| !comparison.verdict().is_pass()).count();
                    let rows: String = compared.iter().map(|comparison| row(point, comparison, &mut notes)).collect();
                    super::print(&rows)?;
                }
                Err(StatePointError::Interrupted) => return Err(Failure::failed("interrupted", None)),
                Err(fault) => {
                    count += point.quantities.len();
                    bad += point.quantities.len();
                    super::print(&format!("{:<23} {:<32} FAIL: {fault}\n", point.quantities.join(", "), point.state))?;
                }
            }
        }
        super::print(&notes.text())?;
        verdict(count, bad)
    }

    fn points(&self) -> Result<Vec<StatePoint>, Failure> {
        let effort = match (self.brief, self.long) {
            (true, _) => Effort::Brief,
            (_, true) => Effort::Long,
            _ => Effort::Usual,
        };
        let mut points = validate::points(effort);
        if let Some(filter) = &self.filter {
            points.retain(|point| point.name.contains(filter.as_str()));
        }
        if points.is_empty() {
            let message =
                format!("no state point has a name that contains {:?}", self.filter.as_deref().unwrap_or_default());
            return Err(Failure::bad_input(message, Some("carom validate --list shows all names")));
        }
        Ok(points)
    }
}

fn list(points: &[StatePoint]) -> String {
    let line = |point: &StatePoint| format!("{:<24}{:<36}{}\n", point.name, point.state, point.quantities.join(", "));
    points.iter().map(line).collect()
}

fn head() -> String {
    format!(
        "{:<23} {:<32} {:>12} {:>9} {:>12} {:>9} {:>8}  {:<10} source\n",
        "quantity", "state point", "measured", "error", "published", "allowance", "off by", "verdict"
    )
}

fn row(point: &StatePoint, comparison: &Comparison, notes: &mut Notes) -> String {
    let known = |value: Option<f64>, text: fn(f64) -> String| value.map_or_else(|| "unknown".to_owned(), text);
    let error = match comparison.standard_error {
        Some(0.0) => "-".to_owned(),
        error => known(error, |error| format!("{error:.1e}")),
    };
    let allowance = comparison.allowance.amount;
    let off = match (comparison.deviation(), comparison.difference()) {
        (Some(errors), _) => format!("{errors:+.1} se"),
        (None, Some(difference)) => format!("{difference:+.0e}"),
        (None, None) => "unknown".to_owned(),
    };
    let verdict = match comparison.verdict() {
        Verdict::Pass => "pass",
        Verdict::Fail => "FAIL",
        Verdict::Unresolved => "UNRESOLVED",
    };
    format!(
        "{:<23} {:<32} {:>12} {:>9} {:>12} {:>9} {:>8}  {:<10} {}\n",
        comparison.quantity,
        point.state,
        known(comparison.measured, digits),
        error,
        digits(comparison.published),
        if allowance > 0.0 { format!("{allowance:.1e}") } else { "-".to_owned() },
        off,
        verdict,
        notes.refer(comparison),
    )
}

/// Notes below the table, in order of their first use.
#[derive(Default)]
struct Notes {
    sources: Vec<Source>,
    reasons: Vec<&'static str>,
}

impl Notes {
    /// Returns the short name of a comparison's source, and the number of the note about its allowance.
    fn refer(&mut self, comparison: &Comparison) -> String {
        if !self.sources.contains(&comparison.source) {
            self.sources.push(comparison.source);
        }
        let reason = comparison.allowance.reason;
        if reason.is_empty() {
            return comparison.source.short.to_owned();
        }
        let known = self.reasons.iter().position(|known| *known == reason);
        let index = known.unwrap_or_else(|| {
            self.reasons.push(reason);
            self.reasons.len() - 1
        });
        format!("{} [{}]", comparison.source.short, index + 1)
    }

    fn text(&self) -> String {
        let mut text = String::new();
        if !self.sources.is_empty() {
            let _ = writeln!(text, "\nsources");
        }
        for source in &self.sources {
            let _ = writeln!(text, "  {:<18} {}", source.short, source.full);
        }
        if !self.reasons.is_empty() {
            let _ = writeln!(text, "allowances, added to four standard errors (se)");
        }
        for (index, reason) in self.reasons.iter().enumerate() {
            let _ = writeln!(text, "  [{}] {reason}", index + 1);
        }
        text
    }
}

fn verdict(count: usize, bad: usize) -> Result<(), Failure> {
    if bad > 0 {
        let message = format!("{bad} of {count} comparisons do not agree");
        let help = "run it again with another --seed: one comparison in 16,000 fails by chance";
        return Err(Failure::failed(message, Some(help)));
    }
    super::print(&format!("\nPASSED: {count} of {count}\n"))
}
