//! Event-driven particle dynamics: hard spheres, square wells, bonds and stepped potentials, with gravity, walls, static
//! meshes and dissipation.
//!
//! Between events every particle flies freely, so nothing is integrated: the time of the next event is solved for, the
//! event is executed, and what it changed is predicted anew. The algorithms are those of M. N. Bannerman and S. Strobl,
//! *Stable Event-Driven Particle Dynamics: Spherically Symmetric Potentials*, which stay stable where rounding puts particles
//! on the wrong side of a discontinuity.
//!
//! ```
//! use carom::model::potential::Potential;
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
//! | What is simulated? | [`scene`], [`space`], [`potential`] | figure 1 |
//! | How does a particle fly? | [`motion`] | equations 1, 2 |
//! | When is a state invalid? | [`overlap`] | equations 5 to 9 |
//! | When is the next event of a pair? | [`detection`] | Algorithms 2 to 6 |
//! | What happens then? | [`response`], [`event`] | section 1 |
//! | Who could meet whom, and in which pair state? | [`neighbours`], [`interaction`] | |
//! | Which event is next? | [`queue`] | |
//! | The loop itself | [`simulation`] | |
//! | The paper, word for word, for checking | [`mod@reference`] | Algorithm 1 |
//! | What is measured, and how well did it go? | [`observe`], [`statistics`], [`audit`] | |
//! | What is known from theory and other simulations? | [`published`] | |
//! | Does what is measured agree with it? | [`validate`] | |
//! | Is a run right, event by event? | [`mod@verify`] | Algorithm 1 |
//! | What does a scene ask to be measured? | [`measure`] | |
//! | A whole run, its files, its picture, its page | [`run`], [`output`], [`picture`], [`report`] | figure 6 |
//! | Stopping and going on | [`checkpoint`] | |
//! | All of that in words | [`describe`] | |
//!
//! # Notation and units
//!
//! `r_ij = r_i - r_j` and `v_ij = v_i - v_j`, the paper's sign. Reduced units: lengths, masses and energies are what the scene makes
//! them, and Boltzmann's constant is 1. `[length]`, `[mass]`, `[energy]` and `[time]` name the dimension of a quantity.
//!
//! # Results repeat
//!
//! A run is a function of its scene and seed: the same bits every time, on every processor, however it is cut into stretches, and
//! whoever looks on.

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
pub mod view;

/// A vector in space; the components along flat axes are exactly zero.
pub type Vector = nalgebra::Vector3<f64>;
