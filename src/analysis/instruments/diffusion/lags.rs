//! Ticks, and the time lags at which displacements are sampled.

use serde::{Deserialize, Serialize};

use crate::analysis::instruments::block_times::{feasible, incommensurate};
use crate::analysis::instruments::free_time::{flow_decay_time, mean_free_time};
use crate::analysis::instruments::instrument::Setup;
use crate::analysis::instruments::logarithmic::Ticks;
use crate::base::numbers::{trunc_to_u64, trunc_to_usize};
use crate::model::measurement_plan::Diffusion as Plan;
use crate::model::measurement_plan::MOST_DIFFUSION_STEPS as MOST_STEPS;

pub(super) const TICKS_PER_STEP: u64 = 32;

const STEPS_PER_FREE_TIME: f64 = 5.0;

/// Shortest and longest default span, in mean free times.
const FREE_TIMES: [f64; 2] = [100.0, 1000.0];

/// Default span, in decay times of the slowest flow in the box.
const FLOW_DECAYS: f64 = 10.0;

const FEWEST_STEPS: f64 = 50.0;
/// Largest number of linear steps if the plan gives an interval but no span.
const MOST_OF_INTERVAL: f64 = 500.0;
/// Number of new time origins per span. Long runs have fewer.
const OVERLAPPING: u64 = 4;

/// Largest expected number of origins in a run.
const ORIGINS: f64 = 256.0;

/// The grid of all lags and origins, counted in ticks since the start.
///
/// The linear lags are multiples of the interval, up to the span. The logarithmic lags are 1, 2, 3, 4, 6, 8, 12, ...
/// ticks. Origins are multiples of the interval, at least a quarter of the span apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Lags {
    pub ticks: Ticks,
    /// Index of the last linear lag.
    pub steps: usize,
    /// Number of linear steps between two time origins.
    pub stride: u64,
}

impl Lags {
    /// `interval = span / steps`. The default span is ten decay times of the slowest flow in the box. It is limited to
    /// 100 to 1000 mean free times, and to a quarter of the duration. Without a mean free time, the span is a quarter
    /// of the duration and has 100 steps.
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let free_time = mean_free_time(setup.system, &setup.sample);
        let quarter = 0.25 * setup.duration;
        let (interval, steps) = match (plan.interval, plan.span) {
            (Some(interval), Some(span)) => (interval, (span / interval).round()),
            (Some(interval), None) => (interval, (quarter / interval).floor().min(MOST_OF_INTERVAL)),
            (None, span) => {
                let decays = flow_decay_time(setup.system, &setup.sample).map_or(0.0, |time| FLOW_DECAYS * time);
                let longest = free_time.map_or(quarter, |time| {
                    let [least, most] = FREE_TIMES.map(|times| times * time);
                    quarter.min(decays.clamp(least, most))
                });
                let span = span.unwrap_or(longest);
                let fitting = free_time.map_or(100.0, |time| (span / time * STEPS_PER_FREE_TIME).round());
                // `incommensurate` may shorten the interval by up to 28 %. The span has at most `MOST_STEPS` intervals.
                let most = MOST_STEPS as f64 * if setup.system.scaling_interval.is_some() { 0.7 } else { 1.0 };
                let interval = incommensurate(span / fitting.clamp(FEWEST_STEPS, most), setup.system.scaling_interval);
                (interval, (span / interval).round())
            }
        };
        let shortest = Ticks::shortest(setup.sample.time, setup.duration);
        let interval = feasible(interval, setup.duration).max(shortest * TICKS_PER_STEP as f64);
        let steps = trunc_to_usize(steps.clamp(1.0, MOST_STEPS as f64));
        // The limit prevents an overflow of the tick counter.
        let apart = trunc_to_u64((setup.duration / interval / ORIGINS).ceil().clamp(1.0, 1e9));
        Self {
            ticks: Ticks { start: setup.sample.time, tick: interval / TICKS_PER_STEP as f64 },
            steps,
            stride: (steps as u64).div_ceil(OVERLAPPING).max(apart),
        }
    }

    /// Spacing of the linear lags `[time]`.
    pub fn interval(&self) -> f64 {
        self.ticks.duration(TICKS_PER_STEP)
    }

    pub fn origin_ticks(&self) -> u64 {
        self.stride.saturating_mul(TICKS_PER_STEP)
    }

    /// Index of the linear lag with this number of ticks, if any.
    pub fn linear(&self, ticks: u64) -> Option<usize> {
        let step = ticks / TICKS_PER_STEP;
        (ticks.is_multiple_of(TICKS_PER_STEP) && step <= self.steps as u64).then_some(step as usize)
    }

    pub fn next_linear(&self, ticks: u64) -> Option<u64> {
        let step = ticks / TICKS_PER_STEP + 1;
        (step <= self.steps as u64).then_some(step * TICKS_PER_STEP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::instruments::system::Sample;
    use crate::analysis::instruments::system::SystemDescription;
    use crate::analysis::instruments::test_system::{hard_spheres, instrument};

    #[test]
    fn lags_fit_mean_free_time_and_run_length() {
        let (system, simulation) = hard_spheres(108, 0.3);
        let lags = |plan: Plan, duration| instrument(&simulation, &system, duration, |setup| Lags::new(&plan, setup));
        let long = lags(Plan::default(), 1000.0);
        assert_eq!(long.steps, 500);
        assert!((long.interval() / 0.0199 - 1.0).abs() < 0.01, "{}", long.interval());
        assert_eq!(long.stride, trunc_to_u64((1000.0 / long.interval() / 256.0).ceil()));
        // In a larger box, the slowest flow decays in a time of about 3.9. The span is ten times as long.
        let (large, of_large) = hard_spheres(2048, 0.3);
        let decay = flow_decay_time(&large, &Sample::of(&of_large.snapshot())).unwrap();
        let in_large = instrument(&of_large, &large, 1000.0, |setup| Lags::new(&Plan::default(), setup));
        assert!(decay > 3.0 && decay < 5.0, "{decay}");
        assert_eq!(in_large.steps, 2000);
        assert!((in_large.interval() * 2000.0 / (10.0 * decay) - 1.0).abs() < 1e-9, "{}", in_large.interval());
        let scaled = SystemDescription { scaling_interval: Some(0.024), ..system.clone() };
        let plan = Plan { interval: None, span: Some(40.0) };
        let beside = instrument(&simulation, &scaled, 1000.0, |setup| Lags::new(&plan, setup));
        assert!((beside.interval() * beside.steps as f64 - 40.0).abs() < beside.interval(), "{beside:?}");
        let short = lags(Plan::default(), 4.0);
        assert_eq!((short.steps, short.stride), (50, 13));
        assert_eq!(short.interval(), 0.02);
        let given = lags(Plan { interval: Some(0.1), span: Some(3.0) }, 1000.0);
        assert_eq!((given.steps, given.stride), (30, 40));
        assert_eq!(given.ticks.passed(given.ticks.time(77).next_down(), 0), 77);
        assert_eq!([0, 32, 33, 960, 992].map(|t| given.linear(t)), [Some(0), Some(1), None, Some(30), None]);
        assert_eq!(
            [0, 31, 32, 959, 960].map(|t| given.next_linear(t)),
            [Some(32), Some(32), Some(64), Some(960), None]
        );
    }
}
