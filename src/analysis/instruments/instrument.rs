//! The common interface of all instruments.

use super::quantity::Measured;
use super::system::{Sample, SystemDescription};
use crate::engine::event::Event;

/// The system and its state at the start of the measurement.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Setup<'a> {
    /// The particles, species and box of the simulation.
    pub system: &'a SystemDescription,
    /// The particles at the start of the measurement. They are not passed to [`Instrument::sample`].
    pub sample: Sample<'a>,
    /// Expected duration of the measurement, positive and finite `[time]`.
    pub duration: f64,
}

/// An instrument measures one kind of quantity during a run, like a *compute* in other programs.
///
/// An instrument samples the particles at times that it chooses, and can receive all events. It does not change the
/// trajectory. The results are written to `measurements.json`, to a table for each curve, and to the page of the run.
///
/// To write an instrument, implement this trait and register the type with
/// [`Run::instrument`](crate::run::Run::instrument). Checkpoints contain the state of the instrument, so derive
/// `serde::Serialize`, `serde::Deserialize` and `Clone`. Keep everything that later samples need in fields. Checkpoints
/// are written with `postcard`, which does not support serde's `flatten`, `untagged` and `skip_serializing_if`.
///
/// [The guide of the crate](crate#an-instrument-of-ones-own) and `examples/own_instrument.rs` have complete examples.
#[doc(alias = "compute")]
#[doc(alias = "fix")]
#[doc(alias = "observable")]
pub trait Instrument {
    /// Returns the time of the next sample, later than the previous sample. Infinity means no further sample.
    fn next_sample(&self) -> f64;

    /// Takes a sample of the particles at the requested time.
    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription);

    /// Called with the particles at the end of the measurement, even if the measurement was interrupted.
    ///
    /// The default method takes a sample if the requested time has been reached. Your own method must do the same. The
    /// checkpoint at the end is written before this call.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let due = self.next_sample();
        if is_now(due, sample.time) {
            self.sample(&Sample { time: due, ..*sample }, system);
        }
    }

    /// Whether the instrument receives events.
    fn has_events(&self) -> bool {
        false
    }

    /// Takes an event.
    fn event(&mut self, _event: &Event, _system: &SystemDescription) {}

    /// Receives the particles before and after a thermostat scales all velocities. The scaling is not an event.
    fn scaled(&mut self, _before: &Sample<'_>, _after: &Sample<'_>, _system: &SystemDescription) {}

    /// Whether the run should end now. Called after every sample and event.
    fn is_done(&self) -> bool {
        false
    }

    /// Adds the results so far. Can be called at any time during the measurement, and several times.
    fn report(&self, system: &SystemDescription, measured: &mut Measured);
}

fn is_now(due: f64, now: f64) -> bool {
    due <= now || due - now <= 16.0 * f64::EPSILON * now.abs()
}
