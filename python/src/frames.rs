//! Frames of a trajectory, each read when it is asked for.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::PathBuf;

use carom::trajectory::Frame;
use carom::trajectory::extended_xyz::{FrameReader, ReadError};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::array;
use crate::error;
use crate::scene::names;

/// Bytes that are read at once.
const BUFFER: usize = 1 << 18;

/// A trajectory in extended XYZ, with the places of its frames in the file.
#[pyclass(frozen, module = "carom._carom")]
pub struct Trajectory {
    path: PathBuf,
    /// Where each frame begins.
    starts: Vec<u64>,
}

#[pymethods]
impl Trajectory {
    /// Passes once over the file. A frame that is cut off at its end, as by a kill, is left out.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let starts = py.detach(|| starts_of(&path)).map_err(|failure| error::unreadable(&path, &failure))?;
        Ok(Self { path, starts })
    }

    fn __len__(&self) -> usize {
        self.starts.len()
    }

    /// All of a frame, the particles in the order of their ids.
    fn frame<'py>(&self, py: Python<'py>, at: usize) -> PyResult<Bound<'py, PyDict>> {
        let Some(start) = self.starts.get(at) else {
            return Err(PyIndexError::new_err(format!("frame {at} of {}", self.starts.len())));
        };
        let frame =
            py.detach(|| read(&self.path, *start)).map_err(|failure| error::unreadable(&self.path, &failure))?;
        dictionary_of(py, &frame)
    }
}

fn opened(path: &PathBuf) -> Result<BufReader<File>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::Open { path: path.clone(), source })?;
    Ok(BufReader::with_capacity(BUFFER, file))
}

fn starts_of(path: &PathBuf) -> Result<Vec<u64>, ReadError> {
    let unreadable = |source| ReadError::Open { path: path.clone(), source };
    let mut input = opened(path)?;
    let length = input.get_ref().metadata().map_err(unreadable)?.len();
    let mut starts = Vec::new();
    let mut at = 0;
    while at < length {
        // Of a frame that begins here: the lines of the particles, and those of their number and of the comment.
        let mut line = Vec::new();
        let read = input.read_until(b'\n', &mut line).map_err(unreadable)? as u64;
        let text = String::from_utf8_lossy(&line);
        if text.trim().is_empty() {
            at += read;
            continue;
        }
        let Ok(count) = text.trim().parse::<u64>() else {
            // Let the reader say what is wrong.
            input.seek(SeekFrom::Start(at)).map_err(unreadable)?;
            return match FrameReader::new(input).next() {
                Some(Err(error)) => Err(error),
                _ => Ok(starts),
            };
        };
        let mut end = at + read;
        let mut is_whole = true;
        for _ in 0..=count {
            let skipped = skip_line(&mut input).map_err(unreadable)?;
            is_whole &= skipped > 0;
            end += skipped;
            if skipped == 0 {
                break;
            }
        }
        if is_whole {
            starts.push(at);
        }
        at = end;
    }
    Ok(starts)
}

/// Passes over a line, and says how many bytes it has.
fn skip_line(input: &mut impl BufRead) -> std::io::Result<u64> {
    let mut passed = 0;
    loop {
        let bytes = input.fill_buf()?;
        if bytes.is_empty() {
            return Ok(passed as u64);
        }
        if let Some(end) = bytes.iter().position(|byte| *byte == b'\n') {
            input.consume(end + 1);
            return Ok((passed + end + 1) as u64);
        }
        let length = bytes.len();
        passed += length;
        input.consume(length);
    }
}

fn read(path: &PathBuf, start: u64) -> Result<Frame, ReadError> {
    let mut input = opened(path)?;
    input.seek(SeekFrom::Start(start)).map_err(|source| ReadError::Open { path: path.clone(), source })?;
    FrameReader::new(input).next().unwrap_or(Err(ReadError::NoFrame))
}

/// A frame as arrays.
fn dictionary_of<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Bound<'py, PyDict>> {
    let mut order: Vec<usize> = (0..frame.particles.len()).collect();
    order.sort_by_key(|at| frame.particles[*at].id);
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
    all.set_item("ids", array(py, particles().map(|it| it.id.0).collect::<Vec<u32>>(), None)?)?;
    all.set_item("species", array(py, particles().map(|it| it.species.0).collect::<Vec<u32>>(), None)?)?;
    all.set_item("positions", array(py, flat(particles().map(|it| it.position)), Some(3))?)?;
    all.set_item("velocities", array(py, flat(particles().map(|it| it.velocity)), Some(3))?)?;
    all.set_item("radii", array(py, particles().map(|it| it.radius).collect::<Vec<f64>>(), None)?)?;
    let has_images = frame.images.len() == frame.particles.len();
    let images: Option<Vec<i32>> = has_images.then(|| order.iter().flat_map(|at| frame.images[*at]).collect());
    all.set_item("images", images.map(|images| array(py, images, Some(3))).transpose()?)?;
    let ends: Vec<u32> = frame.bonds.iter().flat_map(|pair| pair.map(|id| id.0)).collect();
    all.set_item("bonds", array(py, ends, Some(2))?)?;
    let scalars = PyDict::new(py);
    for scalar in &frame.scalars {
        let values: Vec<f64> = order.iter().map(|at| scalar.values[*at]).collect();
        scalars.set_item(&scalar.name, array(py, values, None)?)?;
    }
    all.set_item("scalars", scalars)?;
    Ok(all)
}

/// Components one after the other.
fn flat(vectors: impl Iterator<Item = carom::Vector>) -> Vec<f64> {
    vectors.flat_map(<[f64; 3]>::from).collect()
}
