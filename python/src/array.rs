//! Arrays of NumPy, made by NumPy itself around memory that was written once.
//!
//! NumPy is not linked: a `bytearray` is filled here, and `numpy.frombuffer` makes it an array that can be written to.

use pyo3::prelude::*;
use pyo3::types::PyByteArray;

/// A number that arrays hold, in the byte order of the machine.
pub trait Number: Copy {
    /// Its type, as NumPy writes it.
    const KIND: &'static str;
    /// Bytes of one.
    const SIZE: usize;
    /// Writes it into as many bytes.
    fn write(self, bytes: &mut [u8]);
}

macro_rules! number {
    ($type:ty, $kind:literal) => {
        impl Number for $type {
            const KIND: &'static str = $kind;
            const SIZE: usize = size_of::<$type>();

            fn write(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_ne_bytes());
            }
        }
    };
}

number!(f64, "=f8");
number!(i32, "=i4");
number!(u32, "=u4");

/// An array of one axis, or of rows of `columns` numbers where that is given.
pub fn array<'py, T: Number>(py: Python<'py>, numbers: &[T], columns: Option<usize>) -> PyResult<Bound<'py, PyAny>> {
    filled::<T>(py, numbers.len(), columns, |bytes| {
        for (bytes, number) in bytes.chunks_exact_mut(T::SIZE).zip(numbers) {
            number.write(bytes);
        }
    })
}

/// The same of as many numbers that `fill` writes.
pub fn filled<'py, T: Number>(
    py: Python<'py>,
    count: usize,
    columns: Option<usize>,
    fill: impl FnOnce(&mut [u8]),
) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    let array = if count == 0 {
        // NumPy makes no array of no bytes.
        numpy.call_method1("zeros", (0, T::KIND))?
    } else {
        let bytes = PyByteArray::new_with(py, count * T::SIZE, |bytes| {
            fill(bytes);
            Ok(())
        })?;
        numpy.call_method1("frombuffer", (bytes, T::KIND))?
    };
    match columns {
        Some(columns) => array.call_method1("reshape", (count / columns, columns)),
        None => Ok(array),
    }
}
