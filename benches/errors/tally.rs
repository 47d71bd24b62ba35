use std::collections::BTreeMap;
use std::fmt::Write;

use carom::analysis::instruments::Measured;
use carom::analysis::statistics::Estimate;
use carom::exchange::{ExchangeResults, ThermalCurves};
use carom::run::Finished;

/// A claimed error is judged correct if scatter / claimed error is in this range.
const HONEST: std::ops::RangeInclusive<f64> = 0.8..=1.25;

#[derive(Debug, Default)]
pub struct Tally(BTreeMap<String, Vec<Claim>>);

#[derive(Debug, Clone, Copy)]
struct Claim {
    mean: Option<f64>,
    error: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Verdict {
    runs: usize,
    /// Number of runs with an error.
    claimed: usize,
    /// Scatter of the means divided by the rms claimed error. `None` if most runs have no error.
    ratio: Option<f64>,
    /// Largest deviation of a mean from the mean of all runs, in units of the claimed error.
    deviation: f64,
}

impl Tally {
    pub fn add(&mut self, finished: &Finished) {
        for (name, estimate) in &finished.observables {
            self.add_estimate(name.to_string(), estimate);
        }
        self.add_numbers(&finished.measured, "measured");
    }

    pub fn add_exchange(&mut self, results: &ExchangeResults, curves: &ThermalCurves) {
        for at in &results.temperatures {
            let place = format!("T = {}", at.place());
            at.observables.iter().for_each(|(name, estimate)| self.add_estimate(format!("{name}, {place}"), estimate));
            self.add_numbers(&at.measured, &place);
        }
        for pair in &results.neighbours {
            let name = format!("acceptance, T = {} and {}", pair.temperatures[0], pair.temperatures[1]);
            pair.acceptance.iter().for_each(|estimate| self.add_estimate(name.clone(), estimate));
        }
        if let Some(peak) = &curves.peak {
            self.add_estimate("heat_capacity_per_particle, maximum".to_owned(), &peak.heat_capacity_per_particle);
            self.add_estimate("temperature of the maximum of the heat capacity".to_owned(), &peak.temperature);
        }
    }

    fn add_numbers(&mut self, measured: &Measured, place: &str) {
        for number in &measured.numbers {
            self.note(format!("{}, {place}", number.name), number.mean, number.standard_error);
        }
    }

    fn add_estimate(&mut self, name: String, estimate: &Estimate) {
        self.note(name, Some(estimate.mean), estimate.standard_error);
    }

    fn note(&mut self, name: String, mean: Option<f64>, error: Option<f64>) {
        self.0.entry(name).or_default().push(Claim { mean, error });
    }

    fn verdicts(&self) -> impl Iterator<Item = (&str, Verdict)> {
        self.0.iter().filter_map(|(name, runs)| Some((name.as_str(), verdict(runs)?)))
    }

    /// Cells of a row. The first four count observables with correct, too large, too small and missing errors.
    pub fn line(&self) -> String {
        let (mut within, mut below, mut above, mut withheld) = (0, 0, 0, 0);
        let mut largest: f64 = 0.0;
        for (_, verdict) in self.verdicts() {
            match verdict.ratio {
                None => withheld += 1,
                Some(ratio) if ratio < *HONEST.start() => below += 1,
                Some(ratio) if ratio > *HONEST.end() => above += 1,
                Some(_) => within += 1,
            }
            largest = largest.max(verdict.deviation);
        }
        format!("{within} | {below} | {above} | {withheld} | {largest:.1}")
    }
}

/// Compares the scatter of the means with the claimed errors. `None` if the observable is constant, or if fewer than
/// two runs have a mean.
fn verdict(runs: &[Claim]) -> Option<Verdict> {
    let means: Vec<f64> = runs.iter().filter_map(|run| run.mean).collect();
    // Leaves out conserved quantities, whose errors are only round-off.
    let claimed: Vec<(f64, f64)> = runs
        .iter()
        .filter_map(|run| Some((run.mean?, run.error?)))
        .filter(|(mean, error)| *error > 1e-11 * mean.abs())
        .collect();
    let count = means.len() as f64;
    let all = means.iter().sum::<f64>() / count;
    let scatter = means.iter().map(|mean| (mean - all).powi(2)).sum::<f64>() / (count - 1.0);
    if means.len() < 2 || scatter.sqrt() <= 1e-11 * all.abs() {
        return None;
    }
    let square = claimed.iter().map(|(_, error)| error * error).sum::<f64>() / claimed.len() as f64;
    let of_these = claimed.iter().map(|(mean, _)| (mean - all).powi(2)).sum::<f64>() / (claimed.len() as f64 - 1.0);
    let deviation = claimed.iter().map(|(mean, error)| (mean - all).abs() / error).fold(0.0, f64::max);
    let ratio = (2 * claimed.len() >= runs.len() && claimed.len() > 1).then(|| (of_these / square).sqrt());
    Some(Verdict { runs: runs.len(), claimed: claimed.len(), ratio, deviation })
}

pub fn table(system: &str, tallies: &[Tally]) -> String {
    let mut text = format!("### {system}\n\n| observable |");
    for which in ["short", "five times longer"].iter().take(tallies.len()) {
        let _ = write!(text, " {which}: ratio | errors given | largest deviation |");
    }
    text.push_str("\n|---|");
    text.push_str(&"---|---|---|".repeat(tallies.len()));
    text.push('\n');
    let mut names: Vec<&str> = tallies.iter().flat_map(|tally| tally.verdicts().map(|(name, _)| name)).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let _ = write!(text, "| {name} |");
        for tally in tallies {
            match tally.0.get(name).and_then(|runs| verdict(runs)) {
                Some(Verdict { runs, claimed, ratio, deviation }) => {
                    let ratio = ratio.map_or("withheld".to_owned(), |ratio| format!("{ratio:.2}"));
                    let _ = write!(text, " {ratio} | {claimed} of {runs} | {deviation:.1} |");
                }
                None => text.push_str(" | | |"),
            }
        }
        text.push('\n');
    }
    text
}
