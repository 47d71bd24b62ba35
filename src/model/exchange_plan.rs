//! Plan of replica exchange: the table `[exchange]`.

use super::UmbrellaPlan;
use serde::{Deserialize, Serialize};

/// Replica exchange plan of a scene (parallel tempering): a replica for each temperature, or for each window of a distance, and when neighbours are swapped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExchangePlan {
    /// Temperatures, ascending or descending; those next to each other are neighbours. Of umbrella windows the one that all have `[energy]`.
    pub temperatures: Vec<f64>,
    /// Between two attempts to swap `[time]`.
    pub interval: f64,
    /// Mean rate of collisions of each particle with the heat bath of its replica `[1 / time]`.
    pub rate: f64,
    /// How replicas sample the energies between those of the temperatures.
    pub ensemble: ExchangeEnsemble,
    /// Windows of a distance, of the ensemble [`ExchangeEnsemble::Umbrella`].
    pub umbrella: Option<UmbrellaPlan>,
}

/// Ensemble in which replicas are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ExchangeEnsemble {
    /// At each temperature a canonical ensemble, whose replicas are swapped.
    #[default]
    Canonical,
    /// All replicas in one multicanonical ensemble, which visits all energies between those of the temperatures equally often.
    Multicanonical,
    /// In each window of a distance a canonical ensemble with the distance in that window, at one temperature, whose replicas are swapped: umbrella sampling.
    Umbrella,
}

impl ExchangePlan {
    /// Number of replicas: one for each temperature, or for each window.
    #[must_use]
    pub fn replicas(&self) -> usize {
        self.umbrella.as_ref().map_or(self.temperatures.len(), |umbrella| umbrella.windows.len())
    }

    /// Temperature of each replica, in the order of the places `[energy]`.
    pub(crate) fn temperatures_of_places(&self) -> Vec<f64> {
        match (&self.umbrella, self.temperatures.first()) {
            (Some(umbrella), Some(temperature)) => vec![*temperature; umbrella.windows.len()],
            _ => self.temperatures.clone(),
        }
    }

    /// Number of intervals in a duration `[time]`, if it is a whole number within round-off.
    #[must_use]
    pub fn attempts(&self, duration: f64) -> Option<u64> {
        let (count, whole) = (duration / self.interval, (duration / self.interval).round());
        let is_whole = (count - whole).abs() <= ROUNDING * whole && whole <= MOST_ATTEMPTS;
        is_whole.then(|| crate::base::numbers::trunc_to_u64(whole))
    }
}

/// The lowest and the highest of temperatures that ascend or descend `[energy]`; of none, zeros.
pub(crate) fn ends(temperatures: &[f64]) -> [f64; 2] {
    let [first, last] = [temperatures.first(), temperatures.last()].map(|it| it.copied().unwrap_or(0.0));
    [first.min(last), first.max(last)]
}

/// Relative round-off of a number of intervals, because of decimal fractions.
const ROUNDING: f64 = 1e-9;

/// More than any computer does, and few enough that each has a stream of random numbers for each of its replicas.
pub(crate) const MOST_ATTEMPTS: f64 = 1e12;

/// Most temperatures.
pub(crate) const MOST_TEMPERATURES: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_whole_numbers_of_intervals() {
        let plan = ExchangePlan {
            temperatures: vec![1.0, 2.0],
            interval: 0.1,
            rate: 1.0,
            ensemble: ExchangeEnsemble::Canonical,
            umbrella: None,
        };
        assert_eq!(plan.attempts(0.3), Some(3));
        assert_eq!(plan.attempts(1e6), Some(10_000_000));
        assert_eq!([plan.attempts(0.35), plan.attempts(0.04), plan.attempts(1e50)], [None; 3]);
    }
}
