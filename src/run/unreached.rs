//! Time settings of a scene that are never reached, because they exceed the duration of their stage.

use super::driver::FEWEST_MOVES;
use super::stage::{Settings, Stage};
use crate::model::{Barostat, Scene, Thermostat};
use crate::scene::measurement_times;

/// A setting that has no effect, because a stage is too short.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreached {
    /// An interval or a sampling time is longer than the stage or measurement.
    Time {
        /// Key of the time in the scene file.
        key: String,
        /// The time `[time]`.
        time: f64,
        /// Name of the stage that is too short; `None` if all measurements are too short.
        stage: Option<String>,
        /// Duration `[time]`.
        duration: f64,
    },
    /// There are too few volume moves to tune their amplitude.
    Amplitude {
        /// Number of volume moves that tune the amplitude.
        moves: f64,
        /// Minimum number of volume moves needed to tune the amplitude.
        fewest: f64,
    },
}

/// Returns the times in a scene that are never reached, because stages with a time limit are too short.
#[must_use]
pub fn unreached(scene: &Scene) -> Vec<Unreached> {
    let plan = &scene.run;
    let stages: Vec<(Stage, Settings)> = Stage::simulated(plan).map(|stage| (stage, stage.settings(plan))).collect();
    let mut all = Vec::new();
    let mut longest = 0.0_f64;
    for (stage, settings) in &stages {
        // The duration is unknown for an automatic equilibration and for a stage that is limited by events.
        let duration = settings.limit.time.filter(|_| !settings.until_stationary).unwrap_or(f64::INFINITY);
        if stage.is_measured() {
            longest = longest.max(duration);
        }
        let acting = [
            ("barostat.interval", settings.barostat.map(|it| it.interval)),
            ("thermostat.interval", settings.thermostat.and_then(scaling_interval)),
        ];
        for (key, time) in acting.into_iter().filter_map(|(key, time)| Some((key, time?))) {
            if time > duration {
                let stage = Some(stage.name(plan).into_owned());
                all.push(Unreached::Time { key: key.to_owned(), time, stage, duration });
            }
        }
    }
    all.extend(few_moves(&stages));
    let late = measurement_times(&scene.measure).into_iter().filter(|(_, time)| *time > longest);
    all.extend(late.map(|(key, time)| Unreached::Time { key, time, stage: None, duration: longest }));
    all
}

fn scaling_interval(thermostat: Thermostat) -> Option<f64> {
    match thermostat {
        Thermostat::Rescaling { interval, .. } => Some(interval),
        Thermostat::Andersen { .. } => None,
    }
}

fn few_moves(stages: &[(Stage, Settings)]) -> Option<Unreached> {
    let is_open = |settings: &Settings| settings.barostat.is_some_and(|barostat| barostat.amplitude.is_none());
    let first = stages.iter().position(|(stage, settings)| stage.is_measured() && is_open(settings))?;
    let moves = |(stage, settings): &(Stage, Settings)| {
        let Settings { barostat: Some(Barostat { interval, .. }), limit, until_stationary, .. } = settings else {
            return 0.0;
        };
        match limit.time {
            _ if stage.is_measured() || !is_open(settings) => 0.0,
            Some(time) if !until_stationary => (time / interval).floor(),
            _ => f64::INFINITY,
        }
    };
    let moves = stages[..first].iter().map(moves).sum();
    let fewest = f64::from(FEWEST_MOVES);
    (moves < fewest).then_some(Unreached::Amplitude { moves, fewest })
}
