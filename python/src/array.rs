//! NumPy arrays that use memory of this library without a copy.
//!
//! An object with the [array interface](https://numpy.org/doc/stable/reference/arrays.interface.html) owns the memory.
//! `numpy.asarray` makes an array that keeps the object alive. The array is read-only, because changes to a copy of a
//! state would be lost.

use std::any::Any;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

pub trait Number: Copy + Send + Sync + 'static {
    /// Name of the type in the array interface, with the byte order of the machine.
    const KIND: &'static str;
}

macro_rules! number {
    ($type:ty, $kind:literal) => {
        impl Number for $type {
            const KIND: &'static str =
                if cfg!(target_endian = "little") { concat!("<", $kind) } else { concat!(">", $kind) };
        }
    };
}

number!(f64, "f8");
number!(i32, "i4");
number!(i64, "i8");

/// Owner of the memory of an array. The memory never changes.
#[pyclass(frozen, module = "carom._carom")]
struct Memory {
    _numbers: Box<dyn Any + Send + Sync>,
    address: usize,
    kind: &'static str,
    shape: Vec<usize>,
}

#[pymethods]
impl Memory {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        all.set_item("version", 3)?;
        all.set_item("typestr", self.kind)?;
        all.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        // `true` marks the memory as read-only.
        all.set_item("data", (self.address, true))?;
        Ok(all)
    }
}

/// An array with one axis, or with rows of `columns` numbers.
pub fn array<T: Number>(py: Python<'_>, numbers: Vec<T>, columns: Option<usize>) -> PyResult<Bound<'_, PyAny>> {
    let shape = match columns {
        Some(columns) => vec![numbers.len() / columns, columns],
        None => vec![numbers.len()],
    };
    // Moving a `Vec` does not move its elements, so the address stays valid.
    let address = numbers.as_ptr() as usize;
    let memory = Memory { _numbers: Box::new(numbers), address, kind: T::KIND, shape };
    py.import("numpy")?.call_method1("asarray", (memory,))
}
