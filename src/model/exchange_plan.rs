//! The table `[exchange]`.

use super::UmbrellaPlan;
use serde::{Deserialize, Serialize};

/// Plan of replica exchange (parallel tempering). Each temperature or umbrella window has one replica.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExchangePlan {
    /// Temperatures in ascending or descending order `[energy]`. Umbrella windows have a single temperature.
    pub temperatures: Vec<f64>,
    /// Time between two swap attempts `[time]`.
    pub interval: f64,
    /// Mean rate of a particle's collisions with the heat bath `[1 / time]`.
    pub rate: f64,
    /// Sampled ensemble.
    pub ensemble: ExchangeEnsemble,
    /// Umbrella windows, for the ensemble [`ExchangeEnsemble::Umbrella`].
    pub umbrella: Option<UmbrellaPlan>,
}

/// Ensemble sampled by the replicas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ExchangeEnsemble {
    /// A canonical ensemble at each temperature. Replicas are swapped.
    #[default]
    Canonical,
    /// One multicanonical ensemble of all replicas. All energies between the mean energies at the lowest and the
    /// highest temperature are equally likely.
    Multicanonical,
    /// Umbrella sampling: a canonical ensemble in each window, at one temperature. Replicas are swapped.
    Umbrella,
}

impl ExchangePlan {
    /// Number of replicas.
    #[must_use]
    pub fn replicas(&self) -> usize {
        self.umbrella.as_ref().map_or(self.temperatures.len(), |umbrella| umbrella.windows.len())
    }

    pub(crate) fn temperatures_of_places(&self) -> Vec<f64> {
        match (&self.umbrella, self.temperatures.first()) {
            (Some(umbrella), Some(temperature)) => vec![*temperature; umbrella.windows.len()],
            _ => self.temperatures.clone(),
        }
    }

    /// Returns a duration `[time]` as a number of intervals, if this number is whole within round-off.
    #[must_use]
    pub fn attempts(&self, duration: f64) -> Option<u64> {
        let (count, whole) = (duration / self.interval, (duration / self.interval).round());
        let is_whole = (count - whole).abs() <= ROUNDING * whole && whole <= MOST_ATTEMPTS;
        is_whole.then(|| crate::base::numbers::trunc_to_u64(whole))
    }
}

/// Returns the lowest and the highest temperature of a sorted list `[energy]`; zeros for an empty list.
pub(crate) fn ends(temperatures: &[f64]) -> [f64; 2] {
    let [first, last] = [temperatures.first(), temperatures.last()].map(|it| it.copied().unwrap_or(0.0));
    [first.min(last), first.max(last)]
}

/// Relative round-off when a duration is divided by an interval.
const ROUNDING: f64 = 1e-9;

pub(crate) const MOST_ATTEMPTS: f64 = 1e12;

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
