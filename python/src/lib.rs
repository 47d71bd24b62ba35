//! The compiled part of the Python package `carom`.
//!
//! This part is private. The classes and functions for users are in `lib/carom`.

mod array;
mod error;
mod event;
mod exchange;
mod frames;
mod given;
mod observe;
mod outputs;
mod run;
mod saved;
mod scene;
mod signals;
mod simulation;
mod statistics;
mod sweep;
mod writer;

use std::collections::HashMap;
use std::ffi::OsString;

use pyo3::prelude::*;

/// See `carom/_carom.pyi`.
#[pymodule]
mod _carom {
    use super::*;

    #[pymodule_export]
    use super::exchange::{exchange, exchange_temperatures};
    #[pymodule_export]
    use super::frames::Trajectory;
    #[pymodule_export]
    use super::given::Given;
    #[pymodule_export]
    use super::outputs::{convert, movie, render, verify, write_page};
    #[pymodule_export]
    use super::run::{observable_units, page, resume, run};
    #[pymodule_export]
    use super::scene::{Scene, parse_toml};
    #[pymodule_export]
    use super::simulation::Simulation;
    #[pymodule_export]
    use super::statistics::mean_and_error;
    #[pymodule_export]
    use super::sweep::Sweep;
    #[pymodule_export]
    use super::writer::Writer;

    /// Runs the command-line program. Returns the exit code.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| carom::cli::main(&arguments, || None))
    }

    /// Returns the kinds of example scenes, each with its text.
    #[pyfunction]
    fn examples() -> HashMap<&'static str, &'static str> {
        carom::cli::scenes().collect()
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
