//! Scenes from text and from dictionaries.

use std::path::{Path, PathBuf};

use carom::io::{read_scene_text, read_scene_with};
use carom::model::{ParticleId, Scene as Model, Species};
use carom::scene::KeptParticles;
use carom::trajectory::Frame;
use carom::view::description;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{
    PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyFrozenSet, PyInt, PyList, PyMapping, PySet, PyString,
};
use toml::{Table, Value};

use crate::array::array;
use crate::error;
use crate::given::Given;

/// A validated scene with its text.
#[pyclass(frozen, module = "carom._carom")]
pub struct Scene {
    pub model: Model,
    pub text: String,
    /// Path of the scene file, or a name that is used in its place.
    pub name: PathBuf,
    pub set: Vec<(String, String)>,
    pub given: Option<Given>,
}

pub fn borrowed(pairs: &[(String, String)]) -> Vec<(&str, &str)> {
    pairs.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect()
}

#[pymethods]
impl Scene {
    /// Reads a scene from its text. `name` is used as the path of its file.
    #[new]
    fn new(
        py: Python<'_>,
        text: String,
        name: PathBuf,
        set: Vec<(String, String)>,
        given: Option<Given>,
    ) -> PyResult<Self> {
        let made = py.detach(|| match &given {
            Some(Given(particles)) => read_scene_with(text.as_str(), &name, &borrowed(&set), particles),
            None => read_scene_text(text.as_str(), &name, &borrowed(&set)),
        });
        Ok(Self { model: made.map_err(|error| error::scene(&error))?, text, name, set, given })
    }

    #[staticmethod]
    fn toml_of(dictionary: &Bound<'_, PyAny>) -> PyResult<String> {
        match value_of(dictionary, "the scene")? {
            Value::Table(table) => toml::to_string(&table)
                .map_err(|error| PyValueError::new_err(format!("the scene cannot be written as TOML: {error}"))),
            _ => Err(PyTypeError::new_err("expected a dictionary with the keys of a scene file")),
        }
    }

    #[staticmethod]
    fn species_named_in(text: &str, name: PathBuf, set: Vec<(String, String)>) -> PyResult<Vec<String>> {
        Model::species_named_in(text, &name, &borrowed(&set)).map_err(|error| error::scene(&error))
    }

    #[staticmethod]
    fn value_of(value: &Bound<'_, PyAny>, place: &str) -> PyResult<String> {
        Ok(value_of(value, place)?.to_string())
    }

    /// TOML from which the scene can be recreated anywhere.
    fn record(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.complete_record())
    }

    fn given(&self) -> Option<Given> {
        self.given.clone()
    }

    fn description(&self) -> String {
        description::text(&self.model)
    }

    fn warnings(&self) -> Vec<String> {
        description::warnings(&self.model)
    }

    /// The text of the scene, the path of the scene file, and the overrides.
    fn source(&self) -> (String, PathBuf, Vec<(String, String)>) {
        (self.text.clone(), self.name.clone(), self.set.clone())
    }

    #[getter]
    fn name(&self) -> &str {
        self.model.name()
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.model.seed()
    }

    #[getter]
    fn count(&self) -> usize {
        self.model.particles().len()
    }

    #[getter]
    fn dimensions(&self) -> usize {
        self.model.space().dimensions()
    }

    #[getter]
    fn packing_fraction(&self) -> Option<f64> {
        self.model.space().is_closed().then(|| self.model.packing_fraction())
    }

    /// Lower corner, edges, which axes are periodic, and which axes are flat.
    fn space(&self) -> ([f64; 3], [f64; 3], [bool; 3], [bool; 3]) {
        use carom::model::space::Boundary;
        let space = self.model.space();
        let is = |kind: Boundary| space.boundary.map(|boundary| boundary == kind);
        (space.lower.into(), space.size.into(), is(Boundary::Periodic), is(Boundary::Flat))
    }

    /// Name, mass (infinite if static) and diameter of each species.
    fn species_table(&self) -> Vec<(String, f64, f64)> {
        self.model.species().iter().map(|it| (it.name.clone(), it.mass, it.diameter)).collect()
    }

    /// Mass of each species in frames: NaN if its particles have different masses.
    fn frame_masses(&self) -> Vec<f64> {
        let mass = |species: &Species| if species.has_different_masses() { f64::NAN } else { species.mass };
        self.model.species().iter().map(mass).collect()
    }

    fn has_exchange(&self) -> bool {
        self.model.exchange().is_some()
    }

    fn species<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let species: Vec<i64> = self.model.particles().iter().map(|particle| particle.species.0.into()).collect();
        array(py, species, None)
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all: Vec<f64> = self.model.particles().iter().flat_map(|it| <[f64; 3]>::from(it.position)).collect();
        array(py, all, Some(3))
    }

    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all: Vec<f64> = self.model.particles().iter().flat_map(|it| <[f64; 3]>::from(it.velocity)).collect();
        array(py, all, Some(3))
    }

    /// Names of the bond interactions, and for each bond the index of its interaction.
    fn bond_kinds<'py>(&self, py: Python<'py>) -> PyResult<(Vec<String>, Bound<'py, PyAny>)> {
        let (names, kinds) = Frame::kinds_of_bonds(&self.model);
        Ok((names, array(py, kinds.into_iter().map(i64::from).collect(), None)?))
    }

    fn bonds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ends: Vec<i64> =
            self.model.bonds().iter().flat_map(|bond| bond.pair.map(|ParticleId(id)| id.into())).collect();
        array(py, ends, Some(2))
    }
}

impl Scene {
    /// TOML from which the scene can be recreated, with all particles.
    pub fn complete_record(&self) -> PyResult<String> {
        self.record_with(self.given.as_ref().map(|Given(particles)| KeptParticles::InTables(particles)))
    }

    /// TOML from which the scene can be recreated. Particles that were given as arrays are in a file or in tables.
    pub fn record_with(&self, given: Option<KeptParticles<'_>>) -> PyResult<String> {
        let record = self.model.record_with(self.text.clone(), &self.name, &borrowed(&self.set), given);
        record.map_err(|error| error::scene(&error))
    }

    /// The scene file and the files that it reads.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.model.inputs().iter().map(|input| Path::new(&input.path)).chain([self.name.as_path()])
    }
}

/// A Python value as a TOML value. `place` is the key in error messages.
fn value_of(value: &Bound<'_, PyAny>, place: &str) -> PyResult<Value> {
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        let number = value.extract::<i64>();
        return number
            .map(Value::Integer)
            .map_err(|_| PyOverflowError::new_err(format!("{place}: expected a whole number from -2^63 to 2^63 - 1")));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return table_of(mapping, place).map(Value::Table);
    }
    // The method `tolist` of NumPy arrays and scalars returns plain Python values.
    if value.hasattr("tolist")? {
        return value_of(&value.call_method0("tolist")?, place);
    }
    if value.hasattr("__fspath__")? {
        return Ok(Value::String(value.extract::<PathBuf>()?.to_string_lossy().into_owned()));
    }
    let is_bytes = value.is_instance_of::<PyBytes>() || value.is_instance_of::<PyByteArray>();
    // Sets have no order, so a list made from a set would not be reproducible.
    let is_set = value.is_instance_of::<PySet>() || value.is_instance_of::<PyFrozenSet>();
    if value.is_none() || is_bytes || is_set {
        let kind = value.get_type().name()?.to_string();
        let cure = if is_set {
            "use a list, because a set has no order"
        } else {
            "leave the key out, or use a number or a string"
        };
        let message = format!("{place}: a scene cannot contain a value of type {kind}; {cure}");
        return Err(PyTypeError::new_err(message));
    }
    let Ok(items) = value.try_iter() else {
        let kind = value.get_type().name()?.to_string();
        return Err(PyTypeError::new_err(format!(
            "{place}: expected a number, a string, a list or a dictionary, found {kind}"
        )));
    };
    let items = items.enumerate().map(|(at, item)| value_of(&item?, &format!("{place}.{at}")));
    Ok(Value::Array(items.collect::<PyResult<_>>()?))
}

fn table_of(mapping: &Bound<'_, PyMapping>, place: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for pair in mapping.items()?.iter() {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = pair.extract()?;
        let Ok(key) = key.extract::<String>() else {
            return Err(PyTypeError::new_err(format!(
                "{place}: expected keys that are strings, found {}",
                key.repr()?
            )));
        };
        let inner = if place == "the scene" { key.clone() } else { format!("{place}.{key}") };
        table.insert(key, value_of(&value, &inner)?);
    }
    Ok(table)
}

#[pyfunction]
pub fn parse_toml<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let table: Table = text.parse().map_err(|error| PyValueError::new_err(format!("no TOML: {error}")))?;
    object_of(py, Value::Table(table))
}

fn object_of(py: Python<'_>, value: Value) -> PyResult<Bound<'_, PyAny>> {
    match value {
        Value::String(text) => Ok(text.into_pyobject(py)?.into_any()),
        Value::Integer(number) => Ok(number.into_pyobject(py)?.into_any()),
        Value::Float(number) => Ok(number.into_pyobject(py)?.into_any()),
        Value::Boolean(is) => Ok(PyBool::new(py, is).to_owned().into_any()),
        Value::Datetime(time) => Ok(time.to_string().into_pyobject(py)?.into_any()),
        Value::Array(items) => {
            let items = items.into_iter().map(|item| object_of(py, item)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyList::new(py, items)?.into_any())
        }
        Value::Table(table) => {
            let all = PyDict::new(py);
            for (key, value) in table {
                all.set_item(key, object_of(py, value)?)?;
            }
            Ok(all.into_any())
        }
    }
}

pub fn dictionary<'py, V: IntoPyObject<'py>>(
    py: Python<'py>,
    items: impl IntoIterator<Item = (&'static str, V)>,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, value) in items {
        all.set_item(name, value)?;
    }
    Ok(all)
}

pub fn names<'py>(py: Python<'py>, names: impl IntoIterator<Item = String>) -> PyResult<Bound<'py, PyList>> {
    PyList::new(py, names.into_iter().collect::<Vec<_>>())
}
