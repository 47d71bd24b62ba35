//! Proves that the events of a run are right, for a range of events.
//!
//! The proof replays the events of the engine and checks each against the rule of the paper, evaluated for all pairs,
//! all walls and all features of surfaces by [Algorithm 1](crate::check::reference::next_event). It shows that no event
//! is missing, spurious or out of order, that each event has the outcome that the energies demand, and that no negative
//! overlap function decreased. It does not use the engine's cells, predictions or pair states. After every event it
//! takes the state from the engine, so the two states cannot drift apart. It compares distances, within round-off, and
//! never times.
//! ```
//! use std::ops::ControlFlow;
//! use carom::model::potential::Potential;
//! use carom::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};
//! use carom::check::verify::{EventRange, verify};
//!
//! let scene = SceneBuilder::new("well")
//!     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
//!     .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0)?).between("A", "A"))
//!     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2))
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
mod rest;
mod rub;
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
