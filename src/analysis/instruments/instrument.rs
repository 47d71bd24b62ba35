//! The common interface of all instruments.

use super::quantity::Measured;
use super::system::{Sample, SystemDescription};
use crate::engine::event::Event;

/// Initial conditions of an instrument: the system and its state at the start of the measurement.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Setup<'a> {
    /// The particles, species and box of the simulation.
    pub system: &'a SystemDescription,
    /// The particles at the start of the measurement. They are not passed to [`Instrument::sample`], so an
    /// instrument that needs them has to read them here.
    pub sample: Sample<'a>,
    /// Expected duration of the measurement, positive and finite `[time]`.
    pub duration: f64,
}

/// An instrument measures one kind of quantity during a run, like a *compute* in other programs.
///
/// An instrument sees the particles at times that it chooses, and all events if it asks for them. It only
/// reads: the trajectory of a run is the same, bit for bit, whatever is measured. Its report is written with
/// the other measurements of the run (`measurements.json`, and a table for each curve) and drawn on the page
/// of the run.
///
/// To add your own instrument, implement this trait and register the type with
/// [`Run::instrument`](crate::run::Run::instrument). Its state is part of every checkpoint through
/// `serde::Serialize` and `serde::Deserialize`. Derive both and `Clone`, and keep everything that later
/// samples depend on in its fields. Checkpoints are written with `postcard`, which stores no field names, so
/// `serde`'s attributes `flatten`, `untagged` and `skip_serializing_if` cannot be used.
///
/// [The guide of the crate](crate#an-instrument-of-ones-own) and `examples/own_instrument.rs` have complete
/// examples.
#[doc(alias = "compute")]
#[doc(alias = "fix")]
#[doc(alias = "observable")]
pub trait Instrument {
    /// Simulated time of the next sample, which must be later than the previous sample; infinite if there is
    /// none.
    fn next_sample(&self) -> f64;

    /// Takes a sample of the particles at the requested time.
    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription);

    /// Called with the particles at the end of the measurement, even if it was interrupted.
    ///
    /// By default, it takes a sample if the requested time has been reached; your own method must do the same. A
    /// checkpoint is written before this call, so an instrument restored from the checkpoint has not seen the call.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let due = self.next_sample();
        if is_now(due, sample.time) {
            self.sample(&Sample { time: due, ..*sample }, system);
        }
    }

    /// Whether the instrument needs to see events.
    fn has_events(&self) -> bool {
        false
    }

    /// Takes an event.
    fn event(&mut self, _event: &Event, _system: &SystemDescription) {}

    /// Called after a thermostat has scaled all velocities, with the particles just before and just after the scaling.
    /// A scaling is not reported as an event.
    fn scaled(&mut self, _before: &Sample<'_>, _after: &Sample<'_>, _system: &SystemDescription) {}

    /// Whether the run should end now. The run asks after every sample and event.
    fn is_done(&self) -> bool {
        false
    }

    /// Adds the results so far. May be called several times and at any time during the measurement.
    fn report(&self, system: &SystemDescription, measured: &mut Measured);
}

fn is_now(due: f64, now: f64) -> bool {
    due <= now || due - now <= 16.0 * f64::EPSILON * now.abs()
}
