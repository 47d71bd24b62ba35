//! Instruments: what each has in common, and all of a run together.

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use super::quantity::Measured;
use super::subject::{Sample, Subject};
use crate::event::Event;

/// What an instrument starts with.
#[derive(Debug, Clone, Copy)]
#[allow(dead_code)]
pub(crate) struct Setup<'a> {
    /// The constants of the scene.
    pub subject: &'a Subject,
    /// The particles at the start of the measurement.
    pub sample: Sample<'a>,
    /// How long the measurement will last, as far as is known; positive and finite `[time]`.
    pub duration: f64,
}

/// Measures one kind of quantity.
pub(crate) trait Instrument {
    /// Simulated time of the next sample that it wants, later than the last one; infinite for none.
    fn next_sample(&self) -> f64;

    /// Shows it the particles, at the time that it asked for or, at the end of the run, earlier.
    fn sample(&mut self, sample: &Sample<'_>, subject: &Subject);

    /// Whether it wants to see events.
    fn has_events(&self) -> bool {
        false
    }

    /// Shows it an event.
    fn event(&mut self, _event: &Event, _subject: &Subject) {}

    /// Adds what it has measured so far.
    fn report(&self, subject: &Subject, measured: &mut Measured);
}

/// Declares the kinds of instruments and how they are told apart.
macro_rules! instruments {
    ($($kind:ident($type:ty)),* $(,)?) => {
        /// One instrument of any kind.
        #[derive(Debug, Clone, Serialize, Deserialize)]
        enum Kind { $($kind($type),)* }

        impl Kind {
            fn get(&self) -> &dyn Instrument {
                match *self { $(Self::$kind(ref instrument) => instrument,)* }
            }

            fn get_mut(&mut self) -> &mut dyn Instrument {
                match *self { $(Self::$kind(ref mut instrument) => instrument,)* }
            }
        }
    };
}

instruments! {}

/// All instruments of a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Instruments {
    kinds: Vec<Kind>,
}

impl Instruments {
    /// Instruments for what is planned, at the start of the measurement.
    pub(crate) fn new(plan: &Plan, _setup: &Setup<'_>) -> Self {
        let kinds = Vec::new();
        let _ = plan;
        Self { kinds }
    }

    /// Simulated time of the next sample that any of them wants; infinite for none.
    pub(crate) fn next_sample(&self) -> f64 {
        self.kinds.iter().map(|kind| kind.get().next_sample()).fold(f64::INFINITY, f64::min)
    }

    /// Shows the particles to those that have waited for this time.
    pub(crate) fn sample(&mut self, sample: &Sample<'_>, subject: &Subject) {
        for kind in &mut self.kinds {
            if kind.get().next_sample() <= sample.time {
                kind.get_mut().sample(sample, subject);
            }
        }
    }

    /// Whether any wants to see events.
    pub(crate) fn has_events(&self) -> bool {
        self.kinds.iter().any(|kind| kind.get().has_events())
    }

    /// Shows an event to those that want to see it.
    pub(crate) fn event(&mut self, event: &Event, subject: &Subject) {
        for kind in &mut self.kinds {
            if kind.get().has_events() {
                kind.get_mut().event(event, subject);
            }
        }
    }

    /// What was measured so far.
    #[must_use]
    pub fn report(&self, subject: &Subject) -> Measured {
        let mut measured = Measured::default();
        self.kinds.iter().for_each(|kind| kind.get().report(subject, &mut measured));
        measured
    }
}
