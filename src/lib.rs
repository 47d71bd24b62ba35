//! Event-driven particle dynamics: hard spheres, square wells, bonds and stepped potentials, with gravity, walls, static
//! meshes and dissipation.
//!
//! Between events every particle flies freely, so there is no time step. Carom computes the time of the next event,
//! executes the event, and predicts new events for the particles involved. The algorithms come from M. N. Bannerman and
//! S. Strobl, *Stable Event-Driven Particle Dynamics: Spherically Symmetric Potentials*. They stay stable when
//! round-off puts particles on the wrong side of a discontinuity.
//!
//! ```
//! use carom::scene::{Fill, InteractionDraft, Lattice, Model, SpeciesDraft};
//! use carom::{SceneBuilder, Simulation, Until};
//!
//! // 500 hard spheres at a packing fraction of 0.3, in a periodic cube.
//! let scene = SceneBuilder::new("fluid")
//!     .seed(7)
//!     .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
//!     .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
//!     .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(500).packing_fraction(0.3))
//!     .temperature(1.0)
//!     .build()?;
//!
//! let mut simulation = Simulation::new(scene)?;
//! let before = simulation.energy().kinetic;
//! simulation.advance(Until::events(20_000))?;
//!
//! assert_eq!(simulation.event_counts().core, 20_000);
//! // Each event rounds the velocities of two particles once or twice. The energy drifts no further.
//! assert!((simulation.energy().kinetic / before - 1.0).abs() < 20_000.0 * f64::EPSILON);
//! assert!(simulation.event_counts().deepest_overlap < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where to start
//!
//! | to | use | example |
//! |---|---|---|
//! | simulate and see every event | [`engine::Simulation`] | `event_statistics` |
//! | stop at an event, change velocities or positions | [`engine::Simulation`] | `stop_on_condition` |
//! | run independent replicas in threads | [`engine::Simulation`] is `Send` | `replicas_in_threads` |
//! | equilibrate, measure with standard errors | [`run::Run`] | `fluid` |
//! | write the files of a run and its page | [`io::Folder`], `view::report::page` | `own_instrument` |
//! | measure something new, or end a run on a condition | [`analysis::instruments::Instrument`] | `own_instrument` |
//! | simulate another potential | [`model::Potential::new`] | `own_potential` |
//!
//! The programs are in the folder `examples`. For example, `cargo run --release --example fluid` runs `fluid`.
//!
//! # An instrument of one's own
//!
//! A type that implements [`Instrument`](analysis::instruments::Instrument) returns the time of its next sample, takes
//! the sample, and reports numbers and curves. A [`Run`](run::Run) calls the instrument and stores it in checkpoints.
//! If a [`Folder`](io::Folder) records the run, the report of the instrument is in the files of the run and on the page
//! made by `view::report::page`. Your program needs `serde = { version = "1", features = ["derive"] }`.
//!
//! ```
//! use carom::analysis::instruments::{Instrument, Measured, Number, Sample, SystemDescription};
//! use carom::analysis::{SamplingTimes, statistics::BlockAverage};
//! use carom::model::{RunPlan, Until};
//! use carom::run::Run;
//! use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
//! use serde::{Deserialize, Serialize};
//!
//! /// The mean of `|v|^4 / (15 T^2)`, which is 1 in Maxwell's distribution.
//! #[derive(Clone, Serialize, Deserialize)]
//! struct Kurtosis {
//!     times: SamplingTimes,
//!     mean: BlockAverage,
//! }
//!
//! impl Instrument for Kurtosis {
//!     fn next_sample(&self) -> f64 {
//!         self.times.next()
//!     }
//!
//!     fn sample(&mut self, sample: &Sample<'_>, _system: &SystemDescription) {
//!         let count = sample.velocities.len() as f64;
//!         let mean = |power: i32| sample.velocities.iter().map(|v| v.norm().powi(power)).sum::<f64>() / count;
//!         self.mean.add(mean(4) / mean(2).powi(2) * 9.0 / 15.0, 1.0);
//!         self.times.pass(sample.time);
//!     }
//!
//!     fn report(&self, _system: &SystemDescription, measured: &mut Measured) {
//!         let method = "<|v|^4> / (15 T^2), with the temperature T = <|v|^2> / 3 of each sample";
//!         let estimate = self.mean.estimate();
//!         measured.numbers.push(Number::estimated("kurtosis", "Kurtosis", "1", estimate, method));
//!     }
//! }
//!
//! let scene = SceneBuilder::new("fluid")
//!     .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
//!     .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
//!     .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(256).packing_fraction(0.3))
//!     .temperature(1.0)
//!     .run(RunPlan { equilibration: Until::time(2.0), limit: Until::time(20.0), ..RunPlan::default() })
//!     .build()?;
//! let finished = Run::new(scene)
//!     .instrument("kurtosis", |setup| Kurtosis {
//!         times: SamplingTimes::given(setup.sample.time, 0.1),
//!         mean: BlockAverage::new(1.0),
//!     })
//!     .finish()?;
//! let kurtosis = finished.measured.number("kurtosis").and_then(|number| number.mean).unwrap_or_default();
//! // At constant energy the exact value is N / (N + 2/3).
//! assert!((kurtosis - 1.0).abs() < 0.03);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is where
//!
//! A scene becomes a simulation, whose loop is *pop, stream, execute, repredict*:
//!
//! | question | module | paper |
//! |---|---|---|
//! | How does a particle move between events? | [`physics::motion`] | equations 1, 2 |
//! | When is a state invalid? | [`physics::overlap`] | equations 5 to 9 |
//! | When is the next event of a pair? | [`physics::detection`] | Algorithms 2 to 6 |
//! | What happens at the event? | [`physics::response`], [`engine::event`] | section 1 |
//! | What is simulated, as data? | [`model`] | figure 1 |
//! | The event loop | [`engine`] | |
//! | What is measured, and with what error? | [`analysis::instruments`], [`analysis::observables`], [`analysis::statistics`] | |
//! | Published results of theory and other simulations | [`analysis::published`] | |
//! | Frames and their file | [`trajectory`] | |
//! | Initial states: lattices, packings, chains, surfaces, velocities | `prepare`, behind [`scene`] | |
//! | How is a scene built, from a file or in code? | [`scene`] | |
//! | A whole run, its audit, its checkpoint | [`run`], [`run::audit`], [`run::checkpoint`] | |
//! | The folder of a run, and formats of other programs | [`io`] | |
//! | Replicas of one scene at several temperatures, with swaps | [`exchange`] | |
//! | Many runs of one scene: their folder, their tables | [`sweep`] | |
//! | The algorithm of the paper, word for word, for checks | [`mod@check::reference`] | Algorithm 1 |
//! | Is a run correct, event by event? | [`mod@check::verify`] | Algorithm 1 |
//! | Do measurements agree with published results? | [`check::validate`] | |
#![cfg_attr(feature = "view", doc = "| Pictures, movies, pages, a scene in words | [`view`] | figure 6 |")]
#![cfg_attr(feature = "cli", doc = "| The commands of the program, and their output | [`cli`] | |")]
//!
//! A module uses only modules in the rows above it, see `docs/architecture.md`.
//!
//! # Notation and units
//!
//! `r_ij = r_i - r_j` and `v_ij = v_i - v_j`, as in the paper. Units are reduced: the scene defines lengths, masses and
//! energies, and Boltzmann's constant is 1. Comments give dimensions as `[length]`, `[mass]`, `[energy]` and `[time]`.
//!
//! # Reproducible results
//!
//! A scene and its seed give the same bits every time and on every processor. Pauses and observers change nothing.

// The functions in `clippy.toml` give different last bits on different processors. Unit tests may use them.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// No input may end a program that uses this library, so code that may panic is forbidden.
#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented
    )
)]
// Without the feature `view`, some code for writing files is not used.
#![cfg_attr(not(feature = "view"), allow(dead_code, unused_imports))]

pub mod analysis;
/// Tools that the packages of this repository share. Their interface may change at any time.
#[doc(hidden)]
pub mod base;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod engine;
pub mod exchange;
pub mod io;
pub mod mesh;
pub mod model;
pub mod physics;
pub(crate) mod prepare;
pub mod run;
pub mod scene;
pub mod sweep;
pub mod trajectory;
#[cfg(feature = "view")]
pub mod view;

pub use engine::Simulation;
pub use engine::event::Event;
pub use model::{Potential, Scene, Until};
pub use run::Run;
pub use scene::SceneBuilder;

/// The crate that defines [`Vector`], re-exported so that programs use the same version.
pub use nalgebra;

/// A vector in space. Its components along flat axes are exactly zero.
pub type Vector = nalgebra::Vector3<f64>;
