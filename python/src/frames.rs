//! Frames of a trajectory, which are read one at a time.

use std::path::PathBuf;

use carom::trajectory::Frame;
use carom::trajectory::extended_xyz::{FramePlace, frame_at, frame_places};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::array;
use crate::error;
use crate::scene::names;

/// A trajectory file in extended XYZ, and the place of each frame in the file.
#[pyclass(frozen, module = "carom._carom")]
pub struct Trajectory {
    path: PathBuf,
    places: Vec<FramePlace>,
}

#[pymethods]
impl Trajectory {
    /// Scans the file, and ignores an incomplete frame at the end.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let places = py.detach(|| frame_places(&path)).map_err(|failure| error::unreadable(&path, &failure))?;
        Ok(Self { path, places })
    }

    fn __len__(&self) -> usize {
        self.places.len()
    }

    /// Returns the data of a frame, with the particles in the order of their ids.
    fn frame<'py>(&self, py: Python<'py>, at: usize) -> PyResult<Bound<'py, PyDict>> {
        let Some(place) = self.places.get(at) else {
            return Err(PyIndexError::new_err(format!("frame {at} of {}", self.places.len())));
        };
        let frame =
            py.detach(|| frame_at(&self.path, *place)).map_err(|failure| error::unreadable(&self.path, &failure))?;
        let mut order: Vec<usize> = (0..frame.particles.len()).collect();
        order.sort_by_key(|at| frame.particles[*at].id);
        dictionary_of(py, &frame, &order)
    }
}

pub fn dictionary_of<'py>(py: Python<'py>, frame: &Frame, order: &[usize]) -> PyResult<Bound<'py, PyDict>> {
    let particles = || order.iter().map(|at| &frame.particles[*at]);
    let all = PyDict::new(py);
    all.set_item("time", frame.time)?;
    all.set_item("lower", <[f64; 3]>::from(frame.lower))?;
    all.set_item("size", <[f64; 3]>::from(frame.size))?;
    all.set_item("periodic", frame.periodic)?;
    all.set_item("displacement", frame.displacement)?;
    all.set_item("species_names", names(py, frame.species.iter().map(|species| species.name.clone()))?)?;
    let masses = frame.species.iter().map(|it| if it.is_static { f64::INFINITY } else { it.mass.unwrap_or(f64::NAN) });
    all.set_item("species_masses", array(py, masses.collect::<Vec<f64>>(), None)?)?;
    all.set_item("ids", array(py, particles().map(|it| it.id.0.into()).collect::<Vec<i64>>(), None)?)?;
    all.set_item("species", array(py, particles().map(|it| it.species.0.into()).collect::<Vec<i64>>(), None)?)?;
    all.set_item("positions", array(py, flat(particles().map(|it| it.position)), Some(3))?)?;
    all.set_item("velocities", array(py, flat(particles().map(|it| it.velocity)), Some(3))?)?;
    all.set_item("radii", array(py, particles().map(|it| it.radius).collect::<Vec<f64>>(), None)?)?;
    let has_images = frame.images.len() == frame.particles.len();
    let images: Option<Vec<i32>> = has_images.then(|| order.iter().flat_map(|at| frame.images[*at]).collect());
    all.set_item("images", images.map(|images| array(py, images, Some(3))).transpose()?)?;
    let ends: Vec<i64> = frame.bonds.iter().flat_map(|pair| pair.map(|id| id.0.into())).collect();
    all.set_item("bonds", array(py, ends, Some(2))?)?;
    all.set_item("bond_names", names(py, frame.bond_names.iter().cloned())?)?;
    let kinds: Vec<i64> = frame.bond_kinds.iter().map(|kind| (*kind).into()).collect();
    all.set_item("bond_kinds", array(py, kinds, None)?)?;
    let scalars = PyDict::new(py);
    for scalar in &frame.scalars {
        let values: Vec<f64> = order.iter().map(|at| scalar.values[*at]).collect();
        scalars.set_item(&scalar.name, array(py, values, None)?)?;
    }
    all.set_item("scalars", scalars)?;
    Ok(all)
}

fn flat(vectors: impl Iterator<Item = carom::Vector>) -> Vec<f64> {
    vectors.flat_map(<[f64; 3]>::from).collect()
}
