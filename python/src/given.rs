//! Particles of a scene from arrays.

use std::sync::Arc;

use carom::Vector;
use carom::analysis::instruments::Scalar;
use carom::model::{ParticleId, SpeciesId};
use carom::scene::GivenParticles;
use carom::trajectory::Frame;
use carom::trajectory::frame::{FrameParticle, FrameSpecies};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::frames::dictionary_of;

/// Particles that replace the particles in a scene file.
#[pyclass(frozen, from_py_object, module = "carom._carom")]
#[derive(Clone)]
pub struct Given(pub Arc<GivenParticles>);

#[pymethods]
impl Given {
    /// Reads the parts of a `carom.Frame`. Arrays are bytes of the type `f8`, `i8` or, for images, `i4`.
    #[new]
    fn new(name: &str, parts: &Bound<'_, PyDict>, bond: Option<String>, known: [bool; 3]) -> PyResult<Self> {
        let mut given = GivenParticles::new(name, frame_of(parts)?);
        [given.has_box, given.has_radii, given.is_plane] = known;
        given.bond = bond;
        Ok(Self(Arc::new(given)))
    }

    /// Returns the name, the parts of a `carom.Frame`, the interaction of the bonds, and three flags: the box is known,
    /// the radii are known, z is unknown.
    #[allow(clippy::type_complexity, reason = "a tuple of Python")]
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<(&str, Bound<'py, PyDict>, Option<&str>, [bool; 3])> {
        let it = &*self.0;
        let order: Vec<usize> = (0..it.frame.particles.len()).collect();
        Ok((
            &it.name,
            dictionary_of(py, &it.frame, &order)?,
            it.bond.as_deref(),
            [it.has_box, it.has_radii, it.is_plane],
        ))
    }
}

fn part<'py, T: for<'a> FromPyObject<'a, 'py, Error: Into<PyErr>>>(
    parts: &Bound<'py, PyDict>,
    name: &str,
) -> PyResult<T> {
    let value = parts.get_item(name)?.ok_or_else(|| PyValueError::new_err(format!("a frame has `{name}`")))?;
    value.extract().map_err(Into::into)
}

fn numbers<T, const SIZE: usize>(
    parts: &Bound<'_, PyDict>,
    name: &str,
    number: impl Fn([u8; SIZE]) -> T,
) -> PyResult<Vec<T>> {
    let bytes: Bound<'_, PyBytes> = part::<Bound<'_, PyAny>>(parts, name)?.cast_into::<PyBytes>()?;
    Ok(bytes.as_bytes().as_chunks::<SIZE>().0.iter().map(|bytes| number(*bytes)).collect())
}

fn counts(parts: &Bound<'_, PyDict>, name: &str) -> PyResult<Vec<u32>> {
    let all = numbers(parts, name, i64::from_ne_bytes)?;
    let wrong =
        |number: i64| PyValueError::new_err(format!("{name}: expected whole numbers below 2^32, found {number}"));
    all.into_iter().map(|number| u32::try_from(number).map_err(|_| wrong(number))).collect()
}

fn vectors(parts: &Bound<'_, PyDict>, name: &str) -> PyResult<Vec<Vector>> {
    let all = numbers(parts, name, f64::from_ne_bytes)?;
    Ok(all.as_chunks::<3>().0.iter().map(|vector| Vector::from(*vector)).collect())
}

fn scalars_of(parts: &Bound<'_, PyDict>, count: usize) -> PyResult<Vec<Scalar>> {
    let all: Bound<'_, PyDict> = part::<Bound<'_, PyAny>>(parts, "scalars")?.cast_into::<PyDict>()?;
    let scalar = |(name, _): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let name: String = name.extract()?;
        let values = numbers(&all, &name, f64::from_ne_bytes)?;
        if values.len() != count {
            return Err(PyValueError::new_err(format!("scalar `{name}`: expected one number for each particle")));
        }
        Ok(Scalar::new(&name, values))
    };
    all.iter().map(scalar).collect()
}

fn frame_of(parts: &Bound<'_, PyDict>) -> PyResult<Frame> {
    let ids = counts(parts, "ids")?;
    let species = counts(parts, "species")?;
    let (positions, velocities) = (vectors(parts, "positions")?, vectors(parts, "velocities")?);
    let radii = numbers(parts, "radii", f64::from_ne_bytes)?;
    let count = positions.len();
    if [ids.len(), species.len(), velocities.len(), radii.len()].iter().any(|other| *other != count) {
        return Err(PyValueError::new_err("the arrays of a frame have one row for each particle"));
    }
    let particle = |at: usize| FrameParticle {
        id: ParticleId(ids[at]),
        species: SpeciesId(species[at]),
        position: positions[at],
        velocity: velocities[at],
        radius: radii[at],
    };
    let masses = numbers(parts, "species_masses", f64::from_ne_bytes)?;
    let named = |(name, mass): (String, &f64)| FrameSpecies {
        name,
        is_static: mass.is_infinite(),
        mass: (!mass.is_nan()).then_some(*mass),
    };
    let images = numbers(parts, "images", i32::from_ne_bytes)?;
    Ok(Frame {
        time: part(parts, "time")?,
        lower: Vector::from(part::<[f64; 3]>(parts, "lower")?),
        size: Vector::from(part::<[f64; 3]>(parts, "size")?),
        periodic: part(parts, "periodic")?,
        displacement: part(parts, "displacement")?,
        species: part::<Vec<String>>(parts, "species_names")?.into_iter().zip(&masses).map(named).collect(),
        particles: (0..count).map(particle).collect(),
        bonds: counts(parts, "bonds")?.as_chunks::<2>().0.iter().map(|ends| ends.map(ParticleId)).collect(),
        bond_names: part(parts, "bond_names")?,
        bond_kinds: counts(parts, "bond_kinds")?,
        images: images.as_chunks::<3>().0.to_vec(),
        scalars: scalars_of(parts, count)?,
        ..Frame::default()
    })
}
