//! Event-driven particle dynamics: hard spheres, square wells, bonds and stepped potentials, with gravity, walls, static
//! meshes and dissipation.
//!
//! Between events every particle flies freely, so nothing is integrated: the time of the next event is solved for, the
//! event is executed, and what it changed is predicted anew. The algorithms are those of M. N. Bannerman and S. Strobl,
//! *Stable Event-Driven Particle Dynamics: Spherically Symmetric Potentials*, which stay stable where rounding puts particles
//! on the wrong side of a discontinuity.
//!
//! ```
//! use carom::model::Potential;
//! use carom::scene::{Amount, Lattice, SceneBuilder};
//! use carom::engine::{Simulation, Until};
//!
//! // 500 hard spheres at a packing fraction of 0.3, in a periodic cube.
//! let scene = SceneBuilder::new("fluid")
//!     .seed(7)
//!     .species("sphere", 1.0, 1.0)
//!     .interaction("sphere", "sphere", Potential::hard_sphere(1.0)?, 1.0)
//!     .fill(Lattice::FaceCentredCubic, "sphere", 500, Amount::PackingFraction(0.3))
//!     .temperature(1.0)
//!     .build()?;
//!
//! let mut simulation = Simulation::new(scene);
//! let before = simulation.energy().kinetic;
//! simulation.advance(Until::events(20_000))?;
//!
//! assert_eq!(simulation.tally().core, 20_000);
//! // Every event rounds the velocities of two particles once or twice; the energy drifts no further.
//! assert!((simulation.energy().kinetic / before - 1.0).abs() < 20_000.0 * f64::EPSILON);
//! assert!(simulation.tally().deepest_overlap < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is where
//!
//! A scene becomes a simulation, whose loop is *pop, stream, execute, repredict*:
//!
//! | question | module | paper |
//! |---|---|---|
//! | How does a particle fly? | [`physics::motion`] | equations 1, 2 |
//! | When is a state invalid? | [`physics::overlap`] | equations 5 to 9 |
//! | When is the next event of a pair? | [`physics::detection`] | Algorithms 2 to 6 |
//! | What happens then? | [`physics::response`], [`engine::event`] | section 1 |
//! | What is simulated, as data? | [`model`] | figure 1 |
//! | The event loop | [`engine`] | |
//! | Which particles are close, and in which pair state? | [`engine::neighbours`], [`engine::pairs`] | |
//! | Which event is next? | [`engine::schedule`] | |
//! | What is measured, and how well is it known? | [`analysis::instruments`], [`analysis::observables`], [`analysis::statistics`] | |
//! | What is known from theory and other simulations? | [`analysis::published`] | |
//! | Frames and their file | [`trajectory`] | |
//! | How is a scene made, from a file or in code? | [`scene`] | |
//! | A whole run, its audit, its checkpoint | [`run`], [`run::audit`], [`run::checkpoint`] | |
//! | The folder of a run, and formats of other programs | [`io`] | |
//! | The paper, word for word, for checking | [`mod@check::reference`] | Algorithm 1 |
//! | Is a run right, event by event? | [`mod@check::verify`] | Algorithm 1 |
//! | Does what is measured agree with published results? | [`check::validate`] | |
#![cfg_attr(feature = "view", doc = "| Pictures, pages, a scene in words | [`view`] | figure 6 |")]
//!
//! Each of these modules is a layer or part of one, and uses only those above it in this table: `docs/architecture.md`.
//!
//! # Notation and units
//!
//! `r_ij = r_i - r_j` and `v_ij = v_i - v_j`, the paper's sign. Reduced units: lengths, masses and energies are what the scene makes
//! them, and Boltzmann's constant is 1. `[length]`, `[mass]`, `[energy]` and `[time]` name the dimension of a quantity.
//!
//! # Results repeat
//!
//! A run is a function of its scene and seed: the same bits every time, on every processor, however often it is paused, and
//! whatever observes it.

// The same bits on every processor; unit tests may be careless.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Some of what writes files safely serves pictures and pages only.
#![cfg_attr(not(feature = "view"), allow(dead_code, unused_imports))]

pub mod analysis;
pub mod base;
pub mod check;
pub mod engine;
pub mod io;
pub mod model;
pub mod physics;
pub mod run;
pub mod scene;
pub mod trajectory;
#[cfg(feature = "view")]
pub mod view;

/// A vector in space; the components along flat axes are exactly zero.
pub type Vector = nalgebra::Vector3<f64>;
