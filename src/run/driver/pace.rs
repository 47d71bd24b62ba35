//! How often a run writes, where the scene leaves it open.

use super::{Driver, Monitor};
use crate::analysis::sampling_times::SamplingTimes;
use crate::model::Limit;
use crate::run::{Ending, Recorder};

/// A run that chooses its interval itself aims at this many rows, and at most twice as many.
const ROWS: u32 = 200;

/// As [`ROWS`], for frames.
const FRAMES: u32 = 20;

/// Growth to a pressure takes at least so much of the diameters, and there are more rows if it takes more.
const SOME_GROWTH: f64 = 0.05;

/// Events that are enough to estimate a rate, and the other work of a pilot run: less than some seconds.
const LONGEST: u64 = 1_000_000;
const MOST_WORK: u64 = 20_000_000;

/// When a measurement writes, and how long it will last, as far as is known `[time]`.
pub(super) struct Pace {
    pub rows: SamplingTimes,
    pub frames: SamplingTimes,
    pub duration: f64,
}

impl<R: Recorder> Driver<'_, R> {
    /// The times of rows and frames from the start of the measurement on, and how long it will last, as far as is known; or the ending, if the
    /// caller wants no more while they are chosen.
    ///
    /// Where only the number of events is known, a pilot run over the first of them estimates how long the run will last.
    pub(super) fn pace(&mut self) -> Result<Result<Pace, Ending>, R::Error> {
        let start = self.state.stage.time;
        let scene = self.simulation.scene();
        let (thermo, frame) = (scene.output.thermo_interval, scene.output.frame_interval);
        let is_given = thermo.is_some() && frame.is_some() && scene.measure.is_empty() && self.registry.is_empty();
        let duration = match self.state.stage.limit {
            Limit { time: Some(time), events: None } => time,
            _ if is_given => f64::INFINITY,
            Limit { time, events } => match self.pilot_run(time, events.unwrap_or(u64::MAX))? {
                Some(expected) => rounded(expected).min(time.unwrap_or(f64::INFINITY)),
                None => return Ok(Err(Ending::Interrupted)),
            },
        };
        let ticks = |given: Option<f64>, aim| match given {
            Some(interval) => SamplingTimes::given(start, interval),
            None => SamplingTimes::expecting(start, duration, aim, 0.0),
        };
        Ok(Ok(Pace { rows: ticks(thermo, ROWS), frames: ticks(frame, FRAMES), duration }))
    }

    /// The times of rows in a stage before the measurement; or the ending, if the caller wants no more while they are chosen.
    pub(super) fn pace_of_rows(&mut self) -> Result<Result<SamplingTimes, Ending>, R::Error> {
        let (start, limit) = (self.state.stage.time, self.state.stage.limit);
        if let Some(interval) = self.simulation.scene().output.thermo_interval {
            return Ok(Ok(SamplingTimes::given(start, interval)));
        }
        let duration = match limit {
            Limit { time: Some(time), events: None } => Some(time),
            Limit { time, events: Some(events) } => match self.pilot_run(time, events)? {
                Some(expected) => Some(rounded(expected).min(time.unwrap_or(f64::INFINITY))),
                None => return Ok(Err(Ending::Interrupted)),
            },
            Limit { time: None, events: None } => match self.growth() {
                Some(growth) => Some(SOME_GROWTH / growth.rate),
                // An equilibration that ends by itself: as long as that takes at least.
                None => match self.pilot_run(None, 1000 * self.state.monitor.as_ref().map_or(1, Monitor::shortest))? {
                    Some(expected) => Some(rounded(expected / 1000.0)),
                    None => return Ok(Err(Ending::Interrupted)),
                },
            },
        };
        let duration = duration.filter(|duration| duration.is_finite() && *duration > 0.0).unwrap_or(f64::INFINITY);
        Ok(Ok(SamplingTimes::expecting(start, duration, ROWS, 0.0)))
    }

    /// How long so many events will take, from the first thousandth of them, or of a limit in time; `None` if the caller wants no more.
    ///
    /// Where that takes too much work, as of a gas so thin that hardly anything happens, it is the time in which a particle crosses the box:
    /// intervals that are chosen from it grow with the run.
    ///
    /// A copy goes ahead and is dropped, so that the run itself has its rows, frames and samples from the start of the measurement on. A checkpoint
    /// from meanwhile is none: a run that is killed now makes its pilot run again, from the same state to the same bits.
    fn pilot_run(&mut self, limit: Option<f64>, events: u64) -> Result<Option<f64>, R::Error> {
        let present = (self.simulation.clone(), self.state.clone());
        (self.is_pilot, self.patience) = (true, self.work().saturating_add(MOST_WORK));
        let mut expected = self.pilot(limit, events);
        // By what was done, not by where it gave up, which depends on the clock.
        if self.work() > self.patience
            && let Ok(Some(expected)) = &mut expected
        {
            let crossing = self.state.crossing;
            *expected = limit.unwrap_or(if crossing.is_finite() { crossing } else { 1.0 });
        }
        (self.is_pilot, self.patience) = (false, u64::MAX);
        (self.simulation, self.state) = present;
        self.is_over = false;
        expected
    }

    fn pilot(&mut self, limit: Option<f64>, events: u64) -> Result<Option<f64>, R::Error> {
        let start = self.state.stage;
        let (_, end_events) = start.end();
        let soon = limit.map_or(f64::INFINITY, |limit| start.time + limit / 1000.0);
        let mut pilot = events.div_ceil(1000).min(LONGEST);
        loop {
            let target = start.events.saturating_add(pilot).min(end_events);
            match self.advance(soon, target)? {
                Some(Ending::Interrupted) => return Ok(None),
                Some(Ending::Events) if target < end_events => {}
                _ => break,
            }
            // Simultaneous events give no rate.
            if self.simulation.time() > start.time {
                break;
            }
            pilot = pilot.saturating_mul(2);
        }
        let done = (self.simulation.event_counts().physical() - start.events) as f64;
        if done == 0.0 {
            return Ok(Some(limit.unwrap_or(f64::INFINITY)));
        }
        Ok(Some((self.simulation.time() - start.time) * (events as f64 / done)))
    }
}

/// A duration rounded to two digits, for intervals that are shown.
fn rounded(duration: f64) -> f64 {
    format!("{duration:.1e}").parse().unwrap_or(duration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_rounded_to_two_digits() {
        assert_eq!(rounded(123.4), 120.0);
        assert_eq!(rounded(0.000_678_9), 0.000_68);
    }
}
