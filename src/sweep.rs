//! A parameter sweep: one scene with values that vary, a run for each combination, and the tables of all.
//!
//! An [`Axis`] is a key of the scene, or several that change together, with its values. A [`Sweep`] is a scene with its axes; each combination
//! of values is a [`Point`], which has a folder of its own within that of the sweep: the folder of a run like any other. What is there is not
//! run again, so that a sweep goes on where it stopped, on one machine or on several that share the folder. [`Results`] are the numbers of all
//! runs, as a row for each and, over the seeds, as a row for each state point.
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
pub use results::{Group, MeasuredQuantity, PointResult, Pooled, Results, StageMeans, StageResult, Standing, Value};
