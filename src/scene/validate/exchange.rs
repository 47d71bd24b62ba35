mod umbrella;

use crate::base::text::shortest;
use crate::model::exchange_plan::{MOST_ATTEMPTS, MOST_TEMPERATURES};
use crate::model::measurement_plan::InstrumentKind;
use crate::model::{ExchangeEnsemble, ExchangePlan, Scene, SceneParts};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::limits::{affordable, positive};

impl SceneParts {
    pub(super) fn check_exchange(&self) -> Result<(), SceneError> {
        let Some(plan) = &self.exchange else { return Ok(()) };
        match plan.ensemble {
            ExchangeEnsemble::Umbrella => umbrella::check_windows(plan)?,
            _ => check_temperatures(plan)?,
        }
        let at = ConfigPath::root().key("exchange");
        positive(plan.interval, at.key("interval"))?;
        positive(plan.rate, at.key("rate"))?;
        self.check_times(plan)?;
        self.check_learning(plan)?;
        match self.refused_instrument() {
            Some((key, expected)) => refuse(ConfigPath::root().key("measure").key(key), "given", expected),
            None => Ok(()),
        }
    }

    /// Checks that times of the run and its output are multiples of the exchange interval.
    fn check_times(&self, plan: &ExchangePlan) -> Result<(), SceneError> {
        let (run, output) = (ConfigPath::root().key("run"), ConfigPath::root().key("output"));
        if self.run.limit.time.is_none() {
            return Err(missing(
                &run,
                "until_time",
                "replicas are swapped at regular intervals, and an [exchange] must end with a swap",
            ));
        }
        let events = [(self.run.limit.events, "until_events"), (self.run.equilibration.events, "equilibration_events")];
        for (count, key) in events {
            if let Some(count) = count {
                let expected = "to be absent with [exchange], whose replicas are swapped at regular intervals: give until_time and equilibration_time";
                return refuse(run.key(key), count, expected);
            }
        }
        if self.run.until_stationary {
            let expected = "to be absent with [exchange]: give equilibration_time";
            return refuse(run.key("equilibration"), "\"auto\"", expected);
        }
        for (time, at) in [
            (self.run.limit.time, run.key("until_time")),
            (self.run.equilibration.time, run.key("equilibration_time")),
            (self.output.frame_interval, output.key("frame_interval")),
        ] {
            let Some(time) = time else { continue };
            if plan.attempts(time).is_none_or(|attempts| attempts == 0) {
                let expected = format!(
                    "a multiple of {} (exchange.interval), at most {MOST_ATTEMPTS:e} times as long",
                    shortest(plan.interval)
                );
                return refuse(at, shortest(time), expected);
            }
        }
        Ok(())
    }

    /// Checks that the equilibration is long enough to find weights, or to bring replicas into their windows.
    fn check_learning(&self, plan: &ExchangePlan) -> Result<(), SceneError> {
        let why = match plan.ensemble {
            ExchangeEnsemble::Canonical => return Ok(()),
            ExchangeEnsemble::Multicanonical => {
                "\"multicanonical\", whose weights follow from the energies of its equilibration"
            }
            ExchangeEnsemble::Umbrella => {
                "\"umbrella\", because the replicas move into their windows during the equilibration"
            }
        };
        let at = ConfigPath::root().key("run");
        let expected = format!("at least {LEAST_LEARNING} times exchange.interval with the ensemble {why}");
        match self.run.equilibration.time {
            None => Err(missing(&at, "equilibration_time", &expected)),
            Some(time) if plan.attempts(time).is_none_or(|attempts| attempts < LEAST_LEARNING) => {
                refuse(at.key("equilibration_time"), shortest(time), expected)
            }
            Some(_) => Ok(()),
        }
    }

    /// Returns the key of the first instrument that an exchange does not support, and what is expected instead.
    fn refused_instrument(&self) -> Option<(&'static str, String)> {
        let mut all = self.measure.requested().map(|it| it.kind);
        if self.exchange.as_ref().is_some_and(|plan| plan.ensemble != ExchangeEnsemble::Canonical) {
            let expected =
                "to be absent with an ensemble other than \"canonical\": measure it in the canonical ensemble";
            return all.next().map(|kind| (kind.key, expected.to_owned()));
        }
        let kind = all.find(|kind| !kind.at_one_time)?;
        let expected = format!(
            "to be absent with [exchange]: replicas change their temperatures, so an exchange allows only {}; for \
             other measurements, use `carom run` at one temperature, with an Andersen thermostat in [run]",
            InstrumentKind::listed(|kind| kind.at_one_time)
        );
        Some((kind.key, expected))
    }
}

impl SceneBuilder {
    pub(in crate::scene) fn check_equilibrium(&self, scene: &Scene) -> Result<(), SceneError> {
        let Some(plan) = &scene.exchange else { return Ok(()) };
        let at = ConfigPath::root().key("exchange").key("temperatures");
        if scene.moving().next().is_none() {
            return refuse(at, "given for a scene in which nothing moves", "particles that move");
        }
        umbrella::check_groups(scene, plan)?;
        affordable((scene.particles.len() as u64).saturating_mul(plan.replicas() as u64), &at)
    }
}

/// Minimum number of swap attempts during the equilibration. A multicanonical exchange computes its first weights after
/// a quarter of them, from at least five attempts.
const LEAST_LEARNING: u64 = 20;

fn check_temperatures(plan: &ExchangePlan) -> Result<(), SceneError> {
    let temperatures = &plan.temperatures;
    if plan.umbrella.is_some() {
        let at = ConfigPath::root().key("exchange").key("umbrella");
        return refuse(at, "given", "none, except with exchange.ensemble = \"umbrella\"");
    }
    let at = ConfigPath::root().key("exchange").key("temperatures");
    let count = temperatures.len();
    if !(2..=MOST_TEMPERATURES).contains(&count) {
        let expected = format!(
            "2 to {MOST_TEMPERATURES} temperatures, ascending or descending: replicas at neighbouring temperatures are swapped"
        );
        return refuse(at, format!("a list of {count}"), expected);
    }
    for (index, temperature) in temperatures.iter().enumerate() {
        positive(*temperature, at.index(index))?;
    }
    let is_ascending = temperatures[1] > temperatures[0];
    let is_wrong = |pair: &[f64]| pair[0] == pair[1] || (pair[1] > pair[0]) != is_ascending;
    if let Some(index) = temperatures.windows(2).position(is_wrong) {
        let (before, here) = (temperatures[index], temperatures[index + 1]);
        let order = if is_ascending { "above" } else { "below" };
        let expected = if before == here {
            "a temperature that differs from the previous one".to_owned()
        } else {
            format!("a temperature {order} the previous one, {}: temperatures must ascend or descend", shortest(before))
        };
        return refuse(at.index(index + 1), shortest(here), expected);
    }
    Ok(())
}
