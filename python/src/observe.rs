//! Functions of the user that observe a run. An instrument calls them with frames and records their values.

use std::cell::RefCell;

use carom::Vector;
use carom::analysis::SamplingTimes;
use carom::analysis::instruments::{Curve, Instrument, Measured, Number, Sample, SystemDescription};
use carom::analysis::statistics::{BlockAverage, Estimate};
use carom::model::space::Boundary;
use carom::run::Run;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};

use crate::array::array;

thread_local! {
    /// The user's functions. They are not stored in the instruments, because instruments are saved in checkpoints.
    static FUNCTIONS: RefCell<Option<Functions>> = const { RefCell::new(None) };
}

/// Functions by name. No function is called after an exception.
struct Functions {
    by_name: Vec<(String, Py<PyAny>)>,
    raised: Option<PyErr>,
}

pub struct Observation {
    by_name: Vec<(String, Py<PyAny>)>,
    every: f64,
}

impl Observation {
    /// `every` is the time between two calls. Each function receives a frame as a dictionary of arrays.
    pub fn new(by_name: Vec<(String, Py<PyAny>)>, every: f64) -> PyResult<Self> {
        if !(1e-50..=1e50).contains(&every) {
            return Err(PyValueError::new_err(format!("every: expected a time from 1e-50 to 1e50, found {every}")));
        }
        Ok(Self { by_name, every })
    }

    pub fn names(&self) -> Vec<String> {
        self.by_name.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Adds an instrument for each function to the run.
    pub fn of(&self, run: Run) -> Run {
        self.by_name.iter().fold(run, |run, (name, _)| {
            let (name, every) = (name.clone(), self.every);
            run.instrument(&name.clone(), move |setup| Observed {
                name,
                times: SamplingTimes::given(setup.sample.time, every),
                taken: Vec::new(),
            })
        })
    }

    /// Adds the instruments to the run. Until [`end`], this thread calls their functions.
    pub fn begin(&self, run: Run) -> Run {
        FUNCTIONS.set(Some(self.functions()));
        self.of(run)
    }

    fn functions(&self) -> Functions {
        let by_name = Python::attach(|py| {
            self.by_name.iter().map(|(name, function)| (name.clone(), function.clone_ref(py))).collect()
        });
        Functions { by_name, raised: None }
    }

    /// Runs a closure in which instruments can call the functions. Also returns the exception of a function, if any.
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> (T, Option<PyErr>) {
        // A function may start another run with other functions, so the previous functions are restored afterwards.
        let before = FUNCTIONS.replace(Some(self.functions()));
        let done = work();
        (done, FUNCTIONS.replace(before).and_then(|functions| functions.raised))
    }
}

/// Removes the functions of this thread. Returns the exception that a function raised, if any.
pub fn end() -> Option<PyErr> {
    FUNCTIONS.take().and_then(|functions| functions.raised)
}

/// An exception in a function of the user ends the run.
pub fn has_failed() -> bool {
    FUNCTIONS.with_borrow(|functions| functions.as_ref().is_some_and(|functions| functions.raised.is_some()))
}

/// Records the values of a user function during the measurement.
#[derive(Clone, Serialize, Deserialize)]
struct Observed {
    name: String,
    times: SamplingTimes,
    taken: Vec<[f64; 2]>,
}

impl Instrument for Observed {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !has_failed() {
            match Python::attach(|py| value_of(py, &self.name, sample, system)) {
                Ok(value) => self.taken.push([sample.time, value]),
                Err(raised) => FUNCTIONS.with_borrow_mut(|functions| {
                    if let Some(functions) = functions {
                        functions.raised = Some(raised);
                    }
                }),
            }
        }
        self.times.pass(sample.time);
    }

    fn report(&self, _system: &SystemDescription, measured: &mut Measured) {
        let mut average = BlockAverage::new(1.0);
        self.taken.iter().for_each(|[_, value]| average.add(*value, 1.0));
        let method = format!("mean of a user-defined function, evaluated every {}", self.times.interval());
        measured.numbers.push(Number::estimated(&self.name, &self.name, "1", average.estimate(), &method));
        let values: Vec<Option<Estimate>> =
            self.taken.iter().map(|[_, value]| Some(Estimate { mean: *value, standard_error: None })).collect();
        let curve = Curve::new(&self.name, &self.name, "values of a user-defined function during the measurement");
        let times = self.taken.iter().map(|[time, _]| *time).collect();
        measured.curves.push(curve.variable("time", "time", times).series(&self.name, "1", &values));
    }
}

fn value_of(py: Python<'_>, name: &str, sample: &Sample<'_>, system: &SystemDescription) -> PyResult<f64> {
    let function = FUNCTIONS.with_borrow(|functions| {
        let by_name = functions.iter().flat_map(|functions| &functions.by_name);
        by_name.filter(|(known, _)| known == name).map(|(_, function)| function.clone_ref(py)).next()
    });
    let Some(function) = function else {
        return Err(PyValueError::new_err(format!("observe: no function was given for {name}")));
    };
    function.bind(py).call1((frame_of(py, sample, system)?,))?.extract()
}

/// The particles as the keyword arguments of `carom.Frame`.
fn frame_of<'py>(py: Python<'py>, sample: &Sample<'_>, system: &SystemDescription) -> PyResult<Bound<'py, PyDict>> {
    let space = &system.space;
    let flat = |vectors: &[Vector]| array(py, vectors.iter().flat_map(|it| <[f64; 3]>::from(*it)).collect(), Some(3));
    let of_species = |k: usize| sample.species[k].0 as usize;
    // A species whose particles have different masses has no mass.
    let mut masses: Vec<f64> = system.species_masses.clone();
    for k in 0..system.own_diameters.len() {
        if system.masses[k] != system.species_masses[of_species(k)] {
            masses[of_species(k)] = f64::NAN;
        }
    }
    let diameter = |k: usize| system.own_diameters.get(k).copied().unwrap_or(system.diameters[of_species(k)]);
    let radii: Vec<f64> = (0..sample.species.len()).map(|k| 0.5 * diameter(k)).collect();
    let ids: Vec<i64> = sample.ids.iter().map(|id| i64::from(id.0)).collect();
    let all = PyDict::new(py);
    all.set_item("time", sample.time)?;
    all.set_item("lower", <[f64; 3]>::from(space.lower))?;
    all.set_item("size", <[f64; 3]>::from(space.size))?;
    all.set_item("periodic", space.boundary.map(|boundary| boundary == Boundary::Periodic))?;
    all.set_item("displacement", sample.displacement)?;
    all.set_item("species_names", &system.species_names)?;
    all.set_item("species_masses", array(py, masses, None)?)?;
    all.set_item("ids", array(py, ids, None)?)?;
    all.set_item("species", array(py, sample.species.iter().map(|it| i64::from(it.0)).collect(), None)?)?;
    all.set_item("positions", flat(sample.positions)?)?;
    all.set_item("velocities", flat(sample.velocities)?)?;
    all.set_item("radii", array(py, radii, None)?)?;
    all.set_item("images", array(py, sample.images.concat(), Some(3))?)?;
    let ends: Vec<i64> = system.bonds.iter().flatten().map(|id| i64::from(*id)).collect();
    all.set_item("bonds", array(py, ends, Some(2))?)?;
    Ok(all)
}
