//! Replica exchange in a folder, as in `carom exchange`.

use std::path::PathBuf;

use carom::exchange::{ExchangeFolder, Opened};
use carom::io::{Existing, refuse_input};
use carom::view::report;
use pyo3::prelude::*;

use crate::error;
use crate::run::{Watch, interval_of, most_bytes};
use crate::scene::Scene;

/// Runs or continues a replica exchange in a folder. Returns the faults that the audits found.
#[pyfunction]
pub fn exchange(
    py: Python<'_>,
    scene: &Scene,
    out: PathBuf,
    jobs: usize,
    orders: (bool, f64),
    callback: Option<Py<PyAny>>,
) -> PyResult<Vec<String>> {
    let (force, checkpoint_every) = orders;
    let interval = interval_of(checkpoint_every)?;
    let mut watch = Watch::new(callback);
    py.detach(|| {
        if !ExchangeFolder::is_one(&out) {
            refuse_input(&out, scene.inputs()).map_err(|error| error::output(&error))?;
            most_bytes("the exchange", ExchangeFolder::expected_bytes(&scene.model), &out, force)?;
        }
        let record = scene.complete_record()?;
        let opened = ExchangeFolder::open(&out, scene.model.clone(), &record);
        if let Opened::UnderWay(begun) = opened.map_err(|error| error::exchange_folder(&error))? {
            let (folder, exchange) = *begun;
            let mut folder = folder.checkpoint_every(interval);
            let ran = exchange.execute(jobs, &mut folder, &mut |[attempts, total]| {
                watch.tell("exchanging", attempts as f64 / total.max(1) as f64, 0.0, attempts)
            });
            let exchange = ran.map_err(|error| error::exchange(&error))?;
            if let Some(raised) = watch.raised.take() {
                return Err(raised);
            }
            folder.complete(&exchange).map_err(|error| error::exchange_folder(&error))?;
        }
        let summary = ExchangeFolder::read(&out).map_err(|error| error::exchange_folder(&error))?;
        let page = report::exchange_page(&out).map_err(|error| error::exchange_folder(&error))?;
        let written = report::write(&page, &report::exchange_page_in(&out), Existing::Replace);
        written.map_err(|error| error::report(&error))?;
        Ok(summary.results.faults)
    })
}

/// Suggests temperatures for an exchange, as few as possible. All swaps are predicted to have the same acceptance, at
/// least `acceptance`. The prediction uses the density of states of a finished exchange. `None` if there are no such
/// temperatures.
#[pyfunction]
pub fn exchange_temperatures(py: Python<'_>, folder: PathBuf, acceptance: f64) -> PyResult<Option<Vec<f64>>> {
    let summary = py.detach(|| ExchangeFolder::read(&folder)).map_err(|error| error::exchange_folder(&error))?;
    Ok(summary.temperatures_for(acceptance))
}
