use carom::analysis::statistics::{BlockAverage, Stationarity};
use pyo3::prelude::*;

/// Returns the mean of a series at evenly spaced times, the standard error, and the verdict on stationarity. The
/// numbers are of the type `f8`.
#[pyfunction]
pub fn mean_and_error(py: Python<'_>, values: &[u8]) -> (f64, Option<f64>, &'static str) {
    py.detach(|| {
        let mut average = BlockAverage::new(1.0);
        for bytes in values.as_chunks::<8>().0 {
            average.add(f64::from_ne_bytes(*bytes), 1.0);
        }
        let estimate = average.estimate();
        let error = estimate.and_then(|estimate| estimate.standard_error);
        (estimate.map_or(f64::NAN, |estimate| estimate.mean), error, word(average.stationarity()))
    })
}

fn word(verdict: Stationarity) -> &'static str {
    match verdict {
        Stationarity::Stationary => "stationary",
        Stationarity::Constant => "constant",
        Stationarity::Drifting(_) => "drifting",
        Stationarity::Unknown => "unknown",
    }
}
