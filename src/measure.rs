//! What a scene asks to be measured while it runs: structure, motion, transport, profiles.
//!
//! A [`Plan`] says what is wanted; each entry becomes an [`Instrument`] that is shown the particles at times of its own choosing, and
//! the events where it asks for them. Instruments only read: a run has the same trajectory, bit for bit, whatever is measured.
//! Their memory is bounded, and their state is part of a checkpoint. What came out is [`Measured`].

pub mod plan;
pub mod quantity;
pub mod subject;

mod instrument;

pub use instrument::Instruments;
#[allow(unused_imports)]
pub(crate) use instrument::{Instrument, Setup};
pub use plan::Plan;
pub use quantity::{Curve, Measured, Number, Published, Series, Variable};
pub use subject::{Sample, Subject};
