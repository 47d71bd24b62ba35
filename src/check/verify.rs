//! A proof that a range of events of a run is right.
//!
//! The events of an engine are replayed and each is held against the rule of the paper, asked over all pairs, all walls and all features
//! of surfaces by [Algorithm 1](crate::check::reference::next_event): no event is missing, spurious or out of order, each came out as the
//! energies demand, and no overlap function decreased while it was negative. The engine's cells, predictions and memory of
//! pairs are not used. States are taken from the engine after every event, so that the two cannot drift apart; what is
//! compared are distances, within what the rounding of numbers explains, and never times.
//!
//! ```
//! use std::ops::ControlFlow;
//! use carom::model::potential::Potential;
//! use carom::scene::{Amount, Lattice, SceneBuilder};
//! use carom::check::verify::{EventRange, verify};
//!
//! let scene = SceneBuilder::new("well")
//!     .species("A", 1.0, 1.0)
//!     .interaction("A", "A", Potential::square_well(1.0, 1.5, 1.0)?, 1.0)
//!     .fill(Lattice::FaceCentredCubic, "A", 108, Amount::PackingFraction(0.2))
//!     .temperature(2.0)
//!     .build()?;
//! let certificate = verify(scene, EventRange { from: 0, events: 500 }, &mut |_| ControlFlow::Continue(()));
//! assert!(certificate.is_proven());
//! assert_eq!(certificate.counts.events(), 500);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod approach;
mod barrier;
mod bounds;
mod certificate;
mod clear;
mod contact;
mod ending;
mod facet;
mod flights;
mod foot;
mod meeting;
mod moving;
mod outcome;
mod pace;
mod pairs;
mod replay;
mod rules;
mod schedule;
mod swing;
mod verifier;
mod violation;
mod window;
mod world;

pub use certificate::{Certificate, Counts, End, Margins};
pub use contact::Contact;
pub use replay::{EventRange, RunEnd, VerifyProgress, verify, verify_run};
pub use verifier::Verifier;
pub use violation::{Fault, Quantity, Violation};
