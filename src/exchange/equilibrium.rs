//! Warnings about an exchange that may not be in equilibrium.

use super::results::{ExchangeResults, TemperatureResult};
use crate::base::text::{digits, plural};
use crate::model::ExchangeEnsemble;

/// Minimum total number of round trips. With fewer round trips, errors are unreliable.
const FEWEST_TRIPS: u64 = 10;

pub(super) const TORN: &str = "there are no curves: some temperatures share no energies with the other temperatures; add temperatures between them";

pub(super) const TORN_WINDOWS: &str = "there is no potential of mean force: some windows share no distances with the other windows; let the windows overlap more";

impl ExchangeResults {
    /// Returns reasons why the exchange may not be in equilibrium, in words.
    ///
    /// A round trip goes from the highest temperature to the lowest and back, or from the last window to the first and
    /// back. A replica forgets its configuration at the highest temperature or in the last window. Each round trip is
    /// therefore an independent visit to the other end (H. G. Katzgraber, S. Trebst, D. A. Huse and M. Troyer, J. Stat.
    /// Mech. P03018 (2006), [doi:10.1088/1742-5468/2006/03/P03018](https://doi.org/10.1088/1742-5468/2006/03/P03018)).
    ///
    /// There are warnings about
    /// - temperatures or windows that never swapped replicas with a neighbour;
    /// - temperatures at which the potential energy never changed, although it changed at other temperatures:
    ///   only one state exists, or the replicas are frozen;
    /// - an exchange with fewer than ten round trips, or with fewer round trips than replicas.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let alone: Vec<&TemperatureResult> =
            self.temperatures.iter().enumerate().filter(|(place, _)| self.is_alone(*place)).map(|(_, at)| at).collect();
        if !alone.is_empty() {
            let (all, cure) = match self.ensemble {
                ExchangeEnsemble::Umbrella => (windows(&alone), "let neighbouring windows overlap more"),
                _ => (temperatures(&alone), "add temperatures nearby"),
            };
            warnings.push(format!("frozen {all}: no replica there was ever swapped; {cure}"));
        }
        let changes = self.temperatures.iter().any(|at| at.populations.len() > 1);
        let same: Vec<&TemperatureResult> =
            self.temperatures.iter().filter(|at| changes && constant(at).is_some()).collect();
        if !same.is_empty() {
            let what = "the potential energy never changed, so its error is unknown";
            warnings.push(format!("{}: {what}", temperatures(&same)));
        }
        let trips: u64 = self.round_trips.iter().sum();
        if trips < FEWEST_TRIPS.max(self.round_trips.len() as u64) {
            let trips = if trips == 0 {
                "no replica made a round trip".to_owned()
            } else {
                format!("the replicas made only {}", plural(trips, "round trip"))
            };
            warnings.push(format!(
                "equilibrium is not shown: {trips} between the {}; run it for longer",
                match self.ensemble {
                    ExchangeEnsemble::Canonical => "lowest and the highest temperature",
                    ExchangeEnsemble::Umbrella => "first and the last window",
                    ExchangeEnsemble::Multicanonical => "mean energies at the lowest and the highest temperature",
                }
            ));
        }
        warnings
    }

    /// Whether swaps with the neighbours of a temperature or window were attempted, and all of them were rejected.
    fn is_alone(&self, place: usize) -> bool {
        let pairs = self.neighbours.iter().enumerate().filter(|(pair, _)| *pair == place || pair + 1 == place);
        let mut tried = pairs.filter(|(_, it)| it.attempts > 0).peekable();
        tried.peek().is_some() && tried.all(|(_, it)| it.accepted == 0)
    }
}

/// Returns the potential energy at a temperature if it is the same in all samples.
fn constant(at: &TemperatureResult) -> Option<f64> {
    let all = at.populations.iter().find(|it| it.population.mean >= 1.0)?;
    (all.width == 0.0).then_some(all.energy)
}

fn temperatures(all: &[&TemperatureResult]) -> String {
    let all: Vec<String> = all.iter().map(|at| digits(at.temperature)).collect();
    format!("at T = {}", all.join(", "))
}

fn windows(all: &[&TemperatureResult]) -> String {
    let all: Vec<String> = all.iter().map(|at| at.place()).collect();
    format!("in {}", all.join(", "))
}
