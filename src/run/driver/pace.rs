//! How often a run writes, where the scene leaves it open.

use super::Driver;
use crate::run::ticks::{self, Ticks};
use crate::run::{Ending, Recorder};
use crate::scene::Limit;

impl<R: Recorder> Driver<'_, R> {
    /// The times of rows and frames; or the ending, if the run ends while they are chosen.
    ///
    /// Where only the number of events is known, the rate in the first of them tells how long the run will last.
    pub(super) fn pace(&mut self) -> Result<Result<(Ticks, Ticks), Ending>, R::Error> {
        let start = self.stage.time;
        let plan = &self.simulation.scene().output;
        let (thermo, frame) = (plan.thermo_interval, plan.frame_interval);
        let is_given = thermo.is_some() && frame.is_some();
        let duration = match self.stage.limit {
            Limit { time: Some(time), events: None } => time,
            _ if is_given => f64::INFINITY,
            Limit { time, events } => {
                let events = events.unwrap_or(u64::MAX);
                let (end_time, end_events) = self.stage.end();
                let mut pilot = events.div_ceil(1000);
                loop {
                    let target = self.stage.events.saturating_add(pilot).min(end_events);
                    match self.advance(end_time, target)? {
                        None => return Ok(Err(Ending::Time)),
                        Some(Ending::Events) if target < end_events => {}
                        Some(ending) => return Ok(Err(ending)),
                    }
                    // Simultaneous events tell no rate.
                    if self.simulation.time() > start {
                        break;
                    }
                    pilot = pilot.saturating_mul(2);
                }
                let done = (self.simulation.tally().physical() - self.stage.events) as f64;
                let expected = (self.simulation.time() - start) * (events as f64 / done);
                ticks::rounded(expected).min(time.unwrap_or(f64::INFINITY))
            }
        };
        let ticks = |given: Option<f64>, aim| match given {
            Some(interval) => Ticks::given(start, interval),
            None => Ticks::expecting(start, duration, aim),
        };
        let mut pace = (ticks(thermo, ticks::ROWS), ticks(frame, ticks::FRAMES));
        if self.simulation.time() > start {
            // The pilot is a thousandth of the events, and seldom reaches the first tick.
            if pace.0.next() <= self.simulation.time() {
                pace.0.pass(self.simulation.time());
            }
            if pace.1.next() <= self.simulation.time() {
                pace.1.pass(self.simulation.time());
            }
        }
        Ok(Ok(pace))
    }
}
