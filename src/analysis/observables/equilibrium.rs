use std::fmt;

use serde::{Deserialize, Serialize};

use super::OBSERVABLES;
use crate::analysis::statistics::Stationarity;
use crate::base::text::digits;
use crate::model::Units;

/// Verdict on equilibrium: whether the observables were stationary during the measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// All observables are stationary, as far as the data show.
    Yes,
    /// At least one observable drifts.
    No,
    /// No verdict, for example because the run is too short.
    #[default]
    Unknown,
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Yes => "yes",
            Self::No => "no",
            Self::Unknown => "unknown",
        })
    }
}

/// Minimum number of events per particle for the verdict `yes`. A particle forgets its velocity within two collisions.
/// The slowest collective motion of a few hundred particles takes a few more collisions to decay.
const FEWEST_EVENTS: f64 = 10.0;

/// Mean number of events per particle below which no drift is reported.
const FEWEST_TO_DRIFT: f64 = 1.0;

#[derive(Debug, Clone, Copy)]
pub(super) struct Conditions {
    pub dimensions: usize,
    pub has_steady_state: bool,
    pub only_exchanges_velocities: bool,
    /// Mean number of events in which each moving particle took part.
    pub events_per_particle: f64,
}

/// Verdict on the equilibrium of a run, with reasons.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Equilibrium {
    /// The answer.
    pub verdict: Answer,
    /// Reasons against equilibrium, in words.
    pub reasons: Vec<String>,
}

impl Equilibrium {
    pub(crate) const COOLS: &str = "energy is lost in contacts and nothing supplies it, so there is no steady state";

    const EXCHANGES: &str = "equal particles on a line only exchange velocities, so means depend on the start: \
         take the scatter of several seeds as the error";

    #[must_use]
    pub(super) fn of(observables: &[(&'static str, Stationarity)], conditions: &Conditions, units: &Units) -> Self {
        let &Conditions { dimensions, has_steady_state, only_exchanges_velocities, events_per_particle } = conditions;
        let words = |name: &str| name.replace('_', " ");
        let drifting = observables.iter().filter_map(|(name, stationarity)| match stationarity {
            Stationarity::Drifting(by) => {
                Some(format!("{} drifts by {}{}", words(name), digits(rounded(*by)), unit_of(name, units, dimensions)))
            }
            _ => None,
        });
        // With less than one event per particle, an apparent drift may be chance.
        let is_short = events_per_particle < FEWEST_TO_DRIFT;
        let mut drifting: Vec<String> = if is_short { Vec::new() } else { drifting.collect() };
        let is_unknown = |(_, stationarity): &&(&str, Stationarity)| *stationarity == Stationarity::Unknown;
        let unknown: Vec<String> = observables.iter().filter(is_unknown).map(|(name, _)| words(name)).collect();
        let fluctuates = observables.iter().any(|(_, stationarity)| match stationarity {
            Stationarity::Drifting(_) => is_short,
            stationarity => *stationarity == Stationarity::Stationary,
        });
        let (verdict, reasons) = if !has_steady_state {
            let verdict = if drifting.is_empty() { Answer::Unknown } else { Answer::No };
            drifting.push(Self::COOLS.to_owned());
            (verdict, drifting)
        } else if !drifting.is_empty() {
            (Answer::No, drifting)
        } else if only_exchanges_velocities {
            (Answer::Unknown, vec![Self::EXCHANGES.to_owned()])
        } else if !unknown.is_empty() {
            (Answer::Unknown, vec![format!("too short to tell for {}", unknown.join(", "))])
        } else if !fluctuates {
            (Answer::Unknown, vec!["no fluctuating quantity was measured".to_owned()])
        } else if events_per_particle < FEWEST_EVENTS {
            let few = digits(rounded(events_per_particle));
            let reason = format!("too short to tell: {few} events per particle, and {FEWEST_EVENTS} are needed");
            (Answer::Unknown, vec![reason])
        } else {
            (Answer::Yes, Vec::new())
        };
        Self { verdict, reasons }
    }
}

/// Whether all observables are stationary or constant.
pub(crate) fn is_settled(observables: &[(&'static str, Stationarity)]) -> bool {
    let is_settled = |stationarity| matches!(stationarity, Stationarity::Stationary | Stationarity::Constant);
    observables.iter().all(|(_, stationarity)| is_settled(*stationarity))
}

impl fmt::Display for Equilibrium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.verdict)?;
        if self.reasons.is_empty() { Ok(()) } else { write!(f, " ({})", self.reasons.join(", ")) }
    }
}

fn unit_of(name: &str, units: &Units, dimensions: usize) -> String {
    let unit = OBSERVABLES.iter().find(|(known, _)| *known == name).map_or("1", |(_, unit)| unit);
    if unit == "1" { String::new() } else { format!(" [{}]", units.of(unit, dimensions)) }
}

fn rounded(drift: f64) -> f64 {
    format!("{drift:.1e}").parse().unwrap_or(drift)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEADY: Conditions = Conditions {
        dimensions: 3,
        has_steady_state: true,
        only_exchanges_velocities: false,
        events_per_particle: 1e4,
    };

    #[test]
    fn less_than_an_event_of_each_particle_tells_nothing() {
        let text = |events_per_particle: f64| {
            let conditions = Conditions { events_per_particle, ..STEADY };
            Equilibrium::of(&[("pressure", Stationarity::Drifting(0.5))], &conditions, &Units::default()).to_string()
        };
        assert_eq!(text(0.5), "unknown (too short to tell: 0.5 events per particle, and 10 are needed)");
        assert_eq!(text(1.0), "no (pressure drifts by 0.5 [energy / length^3])");
    }

    #[test]
    fn drift_outranks_unknown_stationarity() {
        let (stationary, unknown, constant) = (Stationarity::Stationary, Stationarity::Unknown, Stationarity::Constant);
        let drifting = Stationarity::Drifting(1.1234);
        let conditions = Conditions { events_per_particle: 10.0, ..STEADY };
        let text =
            |all: &[(&'static str, Stationarity)]| Equilibrium::of(all, &conditions, &Units::default()).to_string();
        assert_eq!(text(&[("temperature", constant), ("pressure", stationary)]), "yes");
        assert_eq!(
            text(&[("temperature", unknown), ("pressure", drifting)]),
            "no (pressure drifts by 1.1 [energy / length^3])"
        );
        assert_eq!(text(&[("collision_rate", drifting)]), "no (collision rate drifts by 1.1 [1 / time])");
        assert_eq!(text(&[("compressibility_factor", drifting)]), "no (compressibility factor drifts by 1.1)");
        let flat =
            Equilibrium::of(&[("pressure", drifting)], &Conditions { dimensions: 2, ..conditions }, &Units::default())
                .to_string();
        assert_eq!(flat, "no (pressure drifts by 1.1 [energy / length^2])");
        let expected = "unknown (too short to tell for collision rate)";
        assert_eq!(text(&[("temperature", stationary), ("collision_rate", unknown)]), expected);
        let expected = "unknown (too short to tell for temperature, pressure)";
        assert_eq!(text(&[("temperature", unknown), ("pressure", unknown)]), expected);
        assert_eq!(text(&[("temperature", constant)]), "unknown (no fluctuating quantity was measured)");
        assert_eq!(Equilibrium::of(&[], &conditions, &Units::default()).verdict, Answer::Unknown);
    }

    #[test]
    fn cooling_or_very_short_runs_are_never_in_equilibrium() {
        let begun = Conditions { events_per_particle: 0.25, ..STEADY };
        let cooling = Conditions { has_steady_state: false, ..STEADY };
        let all = [("temperature", Stationarity::Stationary)];
        let short = Equilibrium::of(&all, &begun, &Units::default()).to_string();
        assert_eq!(short, "unknown (too short to tell: 0.25 events per particle, and 10 are needed)");
        let still = Equilibrium::of(&all, &cooling, &Units::default());
        assert_eq!((still.verdict, &still.reasons[..]), (Answer::Unknown, &[Equilibrium::COOLS.to_owned()][..]));
        let falling = Equilibrium::of(&[("temperature", Stationarity::Drifting(-1.0))], &cooling, &Units::default());
        assert_eq!((falling.verdict, falling.reasons.len()), (Answer::No, 2));
        assert_eq!(falling.reasons[1], Equilibrium::COOLS);
    }

    #[test]
    fn constant_series_are_settled_and_unknown_ones_are_not() {
        let of = |all: &[Stationarity]| is_settled(&all.iter().map(|it| ("temperature", *it)).collect::<Vec<_>>());
        let (stationary, constant) = (Stationarity::Stationary, Stationarity::Constant);
        assert!(of(&[]) && of(&[constant]) && of(&[constant, stationary]));
        assert!(!of(&[constant, Stationarity::Unknown]) && !of(&[stationary, Stationarity::Drifting(1.0)]));
    }
}
