//! Replica exchange (parallel tempering): replicas of a scene at several temperatures, with swaps between neighbouring
//! temperatures at regular intervals.
//!
//! At a low temperature a system may stay in one state for a long time. At a high temperature it moves freely between
//! states, and swaps bring these states to the low temperatures.
//!
//! An [`Exchange`] runs the replicas of a scene with the table `[exchange]`, in several threads. [`ExchangeResults`]
//! has the averages at each temperature with standard errors, and [`ThermalCurves`] the averages between the
//! temperatures. An [`ExchangeFolder`] keeps rows, trajectories and checkpoints. A resumed exchange continues from its
//! checkpoint and gives bitwise the same results.
//!
//! ```
//! use carom::Vector;
//! use carom::exchange::Exchange;
//! use carom::model::{ExchangeEnsemble, ExchangePlan, Potential, RunPlan, Space, Until};
//! use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};
//!
//! let scene = SceneBuilder::new("pair")
//!     .space(Space::periodic_cube(4.0))
//!     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
//!     .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0)?).between("A", "A"))
//!     .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
//!     .particle("A", Vector::new(3.0, 3.0, 3.0), Vector::zeros())
//!     .exchange(ExchangePlan { temperatures: vec![0.4, 0.6, 1.0], interval: 2.0, rate: 1.0, ensemble: ExchangeEnsemble::Canonical, umbrella: None })
//!     .run(RunPlan { equilibration: Until::time(20.0), limit: Until::time(4000.0), ..RunPlan::default() })
//!     .build()?;
//! let results = Exchange::new(scene)?.finish()?.results();
//! // The lowest energy level is the bound pair. Its exact population at T = 0.4 is 0.709.
//! let bound = results.temperatures[0].populations[0];
//! assert_eq!(bound.energy, -1.0);
//! assert!((bound.population.mean - 0.709).abs() < 4.0 * bound.population.standard_error.unwrap());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod attempt;
mod averages;
mod curves;
mod equilibrium;
mod error;
mod execute;
mod folder;
mod instruments;
mod levels;
mod mean_force;
mod multicanonical;
mod populations;
mod replica;
mod replicas;
mod results;
mod summary;
mod tables;
mod walk;
mod windows;

pub use curves::{HeatCapacityPeak, PotentialEnergies, ThermalCurves, ThermalPoint};
pub use error::{ExchangeError, ExchangeFolderError, StartError};
pub use execute::ExchangeRecorder;
pub use folder::{ExchangeFolder, Opened};
pub use levels::LevelDensity;
pub use mean_force::{Distances, MeanForce, MeanForcePoint};
pub use replicas::{DISTANCE, Exchange, ExchangeRow};
pub use results::{ExchangeResults, NeighbouringTemperatures, Population, TemperatureResult};
pub use summary::ExchangeSummary;

#[cfg(test)]
mod tests;
