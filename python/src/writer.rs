//! Writes frames in the formats of other programs.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use carom::io::convert::FrameSeries;
use carom::model::Format;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error;
use crate::given::Given;

/// `series` is `None` when the output is complete or has failed.
#[pyclass(frozen, module = "carom._carom")]
pub struct Writer {
    series: Mutex<Option<FrameSeries>>,
    path: PathBuf,
}

/// Finds a format by its name or, without a name, by the extension of the path.
pub fn format_of(path: &Path, name: Option<&str>) -> PyResult<Format> {
    let names = || Format::ALL.map(Format::name).join(", ");
    if let Some(name) = name {
        let found = Format::ALL.into_iter().find(|format| format.name() == name);
        return found
            .ok_or_else(|| PyValueError::new_err(format!("there is no format {name:?}, expected one of {}", names())));
    }
    Format::of_name(path).ok_or_else(|| {
        let endings = Format::ENDINGS.map(|(_, ending)| ending).join(", ");
        let message = format!(
            "{}: the ending of the name is no format's, expected one of {endings}; or give format, one of {}",
            path.display(),
            names()
        );
        PyValueError::new_err(message)
    })
}

#[pymethods]
impl Writer {
    #[new]
    fn new(path: PathBuf, format: Option<&str>, force: bool) -> PyResult<Self> {
        let series =
            FrameSeries::create(&path, format_of(&path, format)?, force).map_err(|failed| error::convert(&failed))?;
        Ok(Self { series: Mutex::new(Some(series)), path })
    }

    fn write(&self, py: Python<'_>, frame: Given) -> PyResult<()> {
        py.detach(|| {
            let mut series = self.series.lock().unwrap_or_else(PoisonError::into_inner);
            let open = series.as_mut().ok_or_else(|| self.closed())?;
            open.write(&frame.0.frame).map_err(|failed| {
                // Closes the writer, because a partly written frame cannot be removed.
                *series = None;
                error::convert(&failed)
            })
        })
    }

    /// Number of frames so far; `None` if the writer is closed.
    fn frames(&self) -> Option<u64> {
        self.series.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(FrameSeries::frames)
    }

    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| {
            let series = self.series.lock().unwrap_or_else(PoisonError::into_inner).take();
            let series = series.ok_or_else(|| self.closed())?;
            series.finish().map_err(|failed| error::convert(&failed))
        })
    }

    /// Removes the incomplete file.
    fn abandon(&self) {
        *self.series.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Writer {
    fn closed(&self) -> PyErr {
        PyValueError::new_err(format!("the writer of {} is closed", self.path.display()))
    }
}
