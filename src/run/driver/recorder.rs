//! Hides the type of the caller's recorder, so that the driver is compiled only once.

use crate::analysis::instruments::Scalar;
use crate::analysis::observables::Row;
use crate::engine::event::Event;
use crate::engine::{Simulation, Snapshot};
use crate::run::{Recorder, RunState, Stage};

/// The recorder failed. The error is in [`KeepsError`].
#[derive(Debug)]
pub(super) struct Failed;

pub(super) struct KeepsError<'r, R: Recorder> {
    pub recorder: &'r mut R,
    pub error: Option<R::Error>,
}

impl<R: Recorder> KeepsError<'_, R> {
    fn ask(&mut self, deed: impl FnOnce(&mut R) -> Result<(), R::Error>) -> Result<(), Failed> {
        deed(self.recorder).map_err(|error| {
            self.error = Some(error);
            Failed
        })
    }

    #[cfg_attr(
        not(test),
        expect(clippy::unreachable, reason = "a recorder that returns `Failed` has stored its error")
    )]
    pub fn into_error(self) -> R::Error {
        match self.error {
            Some(error) => error,
            None => unreachable!("a driver fails only if its recorder does"),
        }
    }
}

impl<R: Recorder> Recorder for KeepsError<'_, R> {
    type Error = Failed;

    fn row(&mut self, stage: Stage, row: &Row) -> Result<(), Failed> {
        self.ask(|recorder| recorder.row(stage, row))
    }

    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), Failed> {
        self.ask(|recorder| recorder.frame(snapshot, scalars))
    }

    fn frame_of(&mut self, simulation: &Simulation) -> Result<(), Failed> {
        self.ask(|recorder| recorder.frame_of(simulation))
    }

    fn has_events(&self) -> bool {
        self.recorder.has_events()
    }

    fn event(&mut self, event: &Event) -> Result<(), Failed> {
        self.ask(|recorder| recorder.event(event))
    }

    fn is_full(&self) -> bool {
        self.recorder.is_full()
    }

    fn is_checkpoint_due(&self) -> bool {
        self.recorder.is_checkpoint_due()
    }

    fn checkpoint(&mut self, simulation: &Simulation, state: &RunState) -> Result<(), Failed> {
        self.ask(|recorder| recorder.checkpoint(simulation, state))
    }
}
