//! A parameter sweep: one scene with varying values, a run for each combination of values, and tables of all runs.
//!
//! An [`Axis`] is a key of the scene with its values, or several keys that change together. A [`Sweep`] is a scene with
//! its axes. Each combination of values is a [`Point`]. Its run has an ordinary run folder within the folder of the
//! sweep. Finished runs are not repeated, so a sweep can be resumed, on one machine or on several machines that share
//! the folder. [`Results`] has a row for each run and, averaged over the seeds, a row for each state point.
//!
//! ```
//! use carom::sweep::{Axis, Sweep};
//!
//! let axes = ["fill.0.packing_fraction=0.1..0.3/3".parse::<Axis>()?, "seed=1,2".parse()?];
//! let sweep = Sweep::new("configs/equation_of_state.toml", &[], axes.into())?;
//! let folders: Vec<&str> = sweep.points().iter().map(|point| point.folder()).collect();
//! assert_eq!(folders[..3], ["packing_fraction-0.1_seed-1", "packing_fraction-0.1_seed-2", "packing_fraction-0.2_seed-1"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agreement;
mod axis;
mod entries;
mod error;
mod execute;
mod folder;
mod inputs;
mod names;
mod plan;
mod results;
mod table;
mod value;

pub use agreement::Agreement;
pub use axis::{Axis, AxisError};
pub use entries::Entry;
pub use error::SweepError;
pub use execute::{Fate, News, Orders, Share};
pub use folder::SweepFolder;
pub use plan::{Point, Sweep};
pub use results::{Group, MeasuredQuantity, PointResult, Pooled, Results, StageMeans, StageResult, Standing};
