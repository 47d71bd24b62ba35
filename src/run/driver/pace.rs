//! Chooses the intervals of rows and frames that a scene does not specify.

use super::{Driver, Failed, Monitor, NEVER};
use crate::analysis::sampling_times::SamplingTimes;
use crate::model::Until;
use crate::run::Ending;
use crate::run::state::Pilot;

/// Target number of rows in a stage. There may be up to twice as many rows.
const ROWS: u32 = 200;

/// Assumed relative growth of the diameters up to a target pressure. It determines the interval of rows.
const SOME_GROWTH: f64 = 0.05;

/// Maximum number of events in a pilot run, and maximum total of events, cell transitions and Andersen collisions.
const LONGEST: u64 = 1_000_000;
const MOST_WORK: u64 = 20_000_000;

/// A stage continues from its pilot run only if the pilot run has at most `1 / MOST_OF_STAGE` of the events. Such a
/// pilot run normally ends before the first row.
const MOST_OF_STAGE: u64 = 400;

/// A pilot run stops at this fraction of an interval, so that it ends before the first row despite rounding.
const EARLIER: f64 = 1.0 - 1e-6;

/// A pilot run has no work limit if less work than this is expected.
const LITTLE_WORK: u64 = MOST_WORK / 4;

/// Sampling times and expected duration of a measurement `[time]`.
pub(super) struct Pace {
    pub rows: SamplingTimes,
    pub frames: SamplingTimes,
    pub duration: f64,
    /// How the measurement ended, if it ended during the pilot run.
    pub ending: Option<Ending>,
}

pub(super) struct Found {
    /// Expected duration of the stage `[time]`.
    duration: f64,
    ending: Option<Ending>,
}

impl Driver<'_> {
    /// Chooses the sampling times of rows and frames. Returns `None` if the caller interrupts the run.
    ///
    /// If only the number of events is known, a pilot run over the first events estimates the duration.
    pub(super) fn pace(&mut self) -> Result<Option<Pace>, Failed> {
        let (start, limit) = (self.state.stage.time, self.state.planned());
        let scene = self.simulation.scene();
        let (thermo, frame) = (scene.output.thermo_interval, scene.output.frame_interval);
        let is_given = thermo.is_some() && frame.is_some() && scene.measure.is_empty() && self.registry.is_empty();
        let of_time = Found { duration: limit.time.unwrap_or(f64::INFINITY), ending: None };
        let found = if is_given { Some(of_time) } else { self.expected(limit)? };
        let Some(Found { duration, ending }) = found else { return Ok(None) };
        let ticks = |given: Option<f64>, aim| match given {
            Some(interval) => SamplingTimes::given(start, interval),
            None => SamplingTimes::expecting(start, duration, aim, 0.0),
        };
        let limit = self.state.frames;
        let frames = ticks(frame, limit.aim()).at_most(limit.between());
        Ok(Some(Pace { rows: ticks(thermo, ROWS), frames, duration, ending }))
    }

    /// Chooses the sampling times of the rows in a stage without measurement. Also returns the ending, if the stage
    /// ended during the pilot run. Returns `None` if the caller interrupts the run.
    pub(super) fn pace_of_rows(&mut self) -> Result<Option<(SamplingTimes, Option<Ending>)>, Failed> {
        let (start, limit) = (self.state.stage.time, self.state.stage.limit);
        if let Some(interval) = self.simulation.scene().output.thermo_interval {
            return Ok(Some((SamplingTimes::given(start, interval), None)));
        }
        let found = match (limit, self.growth()) {
            (Until { time: None, events: None }, Some(growth)) => {
                Some(Found { duration: SOME_GROWTH / growth.rate, ending: None })
            }
            // Rows are planned for the shortest possible equilibration.
            (Until { time: None, events: None }, None) => {
                let events = 1000 * self.state.monitor.as_ref().map_or(1, Monitor::shortest);
                let expected = self.excursion(None, events, self.first_pilot(events))?;
                expected.map(|expected| Found { duration: rounded(expected / 1000.0), ending: None })
            }
            _ => self.expected(limit)?,
        };
        let Some(Found { duration, ending }) = found else { return Ok(None) };
        let duration = if duration.is_finite() && duration > 0.0 { duration } else { f64::INFINITY };
        Ok(Some((SamplingTimes::expecting(start, duration, ROWS, 0.0), ending)))
    }

    /// Returns the expected duration of a stage with a limit; `None` if the caller interrupts the run.
    fn expected(&mut self, limit: Until) -> Result<Option<Found>, Failed> {
        match limit {
            Until { time: Some(duration), events: None } => Ok(Some(Found { duration, ending: None })),
            Until { time, events } => {
                let found = self.pilot_run(time, events.unwrap_or(u64::MAX))?;
                let longest = time.unwrap_or(f64::INFINITY);
                Ok(found.map(|found| Found { duration: rounded(found.duration).min(longest), ..found }))
            }
        }
    }

    /// Estimates the simulated time of a number of events, from a pilot run over a thousandth of the events or of the
    /// time limit. Returns `None` if the caller interrupts the run.
    ///
    /// A pilot run with too much work is abandoned, for example in a gas with hardly any events. The estimate is then
    /// the time limit, or the time in which a particle crosses the box.
    ///
    /// If no output is due during the pilot run, the stage continues from there. Otherwise, the pilot run uses a copy.
    fn pilot_run(&mut self, limit: Option<f64>, events: u64) -> Result<Option<Found>, Failed> {
        let first = self.first_pilot(events);
        let pilot = match self.state.pilot {
            // If the limit of the run was changed, the pilot run may have too many events.
            Some(begun) if begun.events > (events / MOST_OF_STAGE).max(first.events) => {
                Pilot { events: first.events, ..begun }
            }
            Some(begun) => Pilot { events: begun.events.max(first.events), ..begun },
            None => first,
        };
        if self.may_be_kept(events) {
            self.state.pilot = Some(pilot);
            match self.beginning(limit, events, pilot)? {
                Outcome::Found(found) => return Ok(Some(found)),
                Outcome::Interrupted => return Ok(None),
                Outcome::Undecided => {}
            }
        }
        let expected = self.excursion(limit, events, pilot)?;
        Ok(expected.map(|duration| Found { duration, ending: None }))
    }

    fn first_pilot(&self, events: u64) -> Pilot {
        Pilot { events: events.div_ceil(1000).min(LONGEST), patience: self.work().saturating_add(MOST_WORK) }
    }

    /// Whether a stage may continue from its pilot run. This is impossible if an instrument needs the duration at the
    /// start, or if the stage has too few events.
    fn may_be_kept(&self, events: u64) -> bool {
        let is_measured = self.state.stage.stage.is_measured();
        events >= MOST_OF_STAGE && !(is_measured && self.system.is_some())
    }

    /// Returns a time just before the first row or frame `[time]`. Infinite if the scene specifies no intervals.
    fn first_given(&self) -> f64 {
        let output = &self.simulation.scene().output;
        let is_measured = self.state.stage.stage.is_measured();
        let given = [output.thermo_interval, output.frame_interval.filter(|_| is_measured)];
        self.state.stage.time + EARLIER * given.into_iter().flatten().fold(f64::INFINITY, f64::min)
    }

    /// Simulates the pilot run as the first part of the stage, and stops before the first row. The trajectory is the
    /// same, bit for bit, as without a pilot run.
    fn beginning(&mut self, limit: Option<f64>, events: u64, mut pilot: Pilot) -> Result<Outcome, Failed> {
        let start = self.state.stage;
        let (end_time, end_events) = start.end();
        let soon = limit.map_or(f64::INFINITY, |limit| start.time + limit / 1000.0);
        let given = self.first_given();
        // A time just before the first row, if the pilot run is abandoned.
        let early = start.time + EARLIER * rounded(self.without_rate(limit)) / f64::from(ROWS);
        loop {
            let surely = soon.min(given);
            let until_time = if pilot.patience == u64::MAX { surely } else { surely.min(early) };
            let until_events = start.events.saturating_add(pilot.events);
            (self.pause, self.patience) = (Until::time(until_time).or_events(until_events), pilot.patience);
            let ending = self.advance(end_time, end_events)?;
            (self.pause, self.patience) = (NEVER, u64::MAX);
            let (time, done) = (self.simulation.time(), self.simulation.event_counts().physical());
            let is_there = time >= until_time || done >= until_events;
            if self.work() > pilot.patience {
                return Ok(Outcome::Found(Found { duration: self.without_rate(limit), ending: None }));
            }
            match ending {
                Some(Ending::Interrupted) if !is_there => return Ok(Outcome::Interrupted),
                Some(Ending::Interrupted) => {}
                ending => return Ok(Outcome::Found(Found { duration: self.estimate(limit, events), ending })),
            }
            if time >= soon || (done >= until_events && time > start.time) {
                return Ok(Outcome::Found(Found { duration: self.estimate(limit, events), ending: None }));
            }
            if time >= given {
                return Ok(Outcome::Undecided);
            }
            if done >= until_events {
                // If all events so far are simultaneous, their rate is undefined.
                pilot.events = pilot.events.saturating_mul(2);
                if pilot.events > events / MOST_OF_STAGE {
                    return Ok(Outcome::Undecided);
                }
            } else {
                let work = (MOST_WORK - (pilot.patience - self.work())) as f64;
                let by_now = (done - start.events) as f64;
                // The initial lattice may have fewer events than kinetic theory predicts for the fluid.
                let expected = self.state.rate.map_or(by_now, |rate| by_now.max(rate * (time - start.time)));
                if work * pilot.events as f64 >= LITTLE_WORK as f64 * expected {
                    return Ok(Outcome::Undecided);
                }
                pilot.patience = u64::MAX;
            }
            self.state.pilot = Some(pilot);
        }
    }

    /// Simulates the pilot run on a copy, which is then discarded.
    ///
    /// No checkpoint is written. If the run is killed, the pilot run is repeated later.
    fn excursion(&mut self, limit: Option<f64>, events: u64, pilot: Pilot) -> Result<Option<f64>, Failed> {
        let present = (self.simulation.clone(), self.state.clone());
        (self.is_pilot, self.patience) = (true, pilot.patience);
        let mut expected = self.pilot(limit, events, pilot);
        // After too much work, the pilot run stops at a time that depends on the machine. The estimate is not used.
        if self.work() > self.patience
            && let Ok(Some(expected)) = &mut expected
        {
            *expected = self.without_rate(limit);
        }
        (self.is_pilot, self.patience) = (false, u64::MAX);
        (self.simulation, self.state) = present;
        self.is_over = false;
        // Swap moves of the pilot run have changed the species of particles.
        self.scaling = None;
        self.describe();
        expected
    }

    fn pilot(&mut self, limit: Option<f64>, events: u64, pilot: Pilot) -> Result<Option<f64>, Failed> {
        let start = self.state.stage;
        let (_, end_events) = start.end();
        let soon = limit.map_or(f64::INFINITY, |limit| start.time + limit / 1000.0);
        let mut pilot = pilot.events;
        loop {
            let target = start.events.saturating_add(pilot).min(end_events);
            match self.advance(soon, target)? {
                Some(Ending::Interrupted) => return Ok(None),
                Some(Ending::Events) if target < end_events => {}
                _ => break,
            }
            // If all events so far are simultaneous, their rate is undefined.
            if self.simulation.time() > start.time {
                break;
            }
            pilot = pilot.saturating_mul(2);
        }
        Ok(Some(self.estimate(limit, events)))
    }

    /// Estimates the simulated time of a number of events, from the mean rate since the start of the stage.
    fn estimate(&self, limit: Option<f64>, events: u64) -> f64 {
        let start = self.state.stage;
        let done = (self.simulation.event_counts().physical() - start.events) as f64;
        if done == 0.0 {
            return limit.unwrap_or(f64::INFINITY);
        }
        (self.simulation.time() - start.time) * (events as f64 / done)
    }

    /// Assumed duration of a stage with an unknown event rate: the time limit or the crossing time of the box.
    pub(super) fn without_rate(&self, limit: Option<f64>) -> f64 {
        let crossing = self.state.crossing;
        limit.unwrap_or(if crossing.is_finite() { crossing } else { 1.0 })
    }
}

/// Outcome of a pilot run that was simulated as the beginning of its stage.
enum Outcome {
    Found(Found),
    Interrupted,
    /// The pilot run must continue on a copy, because a row may be due before the pilot run ends.
    Undecided,
}

/// Rounds a duration to two digits, so that output intervals are short numbers.
fn rounded(duration: f64) -> f64 {
    format!("{duration:.1e}").parse().unwrap_or(duration)
}

#[cfg(test)]
mod tests;
