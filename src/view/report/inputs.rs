//! The files of a run, as far as they are there and sound.

use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::Path;

use super::ReportError;
use super::recording::{self, Recording};
use super::table::{self, Trace};
use crate::analysis::instruments::{Curve, Measured};
use crate::io::{Folder, Summary, scene_from_text};
use crate::model::Scene;

/// Everything that a page is made of.
#[derive(Debug)]
pub(super) struct Inputs {
    pub summary: Summary,
    pub scene_text: Option<String>,
    pub scene: Option<Scene>,
    pub thermo: Vec<Trace>,
    pub measured: Measured,
    pub recording: Option<Recording>,
    /// What is missing or damaged.
    pub notes: Vec<String>,
}

/// Reads the folder of a run.
pub(super) fn read(run: &Path) -> Result<Inputs, ReportError> {
    if !run.is_dir() {
        return Err(ReportError::NotFolder(run.to_owned()));
    }
    let path = run.join("summary.json");
    let text = match fs::read(&path) {
        Ok(text) => text,
        Err(source) => return Err(ReportError::Unreadable { path, source }),
    };
    let summary: Summary = serde_json::from_slice(&text).map_err(|source| ReportError::Summary { path, source })?;
    let mut notes = Vec::new();
    let (scene_text, scene) = scene(run, &mut notes);
    let measured = measured(run, &mut notes);
    let thermo = noted("thermo.csv", &mut notes, || {
        let file = open(&run.join("thermo.csv"))?;
        table::read(file).map_err(|error| error.to_string())
    });
    let recording = noted("trajectory.xyz", &mut notes, || {
        let file = open(&run.join("trajectory.xyz"))?;
        recording::read(file, scene.as_ref())
    });
    if let Some(recording) = &recording {
        notes.extend(recording.notes.iter().cloned());
    }
    Ok(Inputs { summary, scene_text, scene, thermo: thermo.unwrap_or_default(), measured, recording, notes })
}

fn noted<T>(file: &str, notes: &mut Vec<String>, read: impl FnOnce() -> Result<T, String>) -> Option<T> {
    read().map_err(|error| notes.push(format!("{file}: {error}"))).ok()
}

fn open(path: &Path) -> Result<BufReader<File>, String> {
    let file = File::open(path).map_err(|error| cannot_read(&error))?;
    Ok(BufReader::with_capacity(1 << 16, file))
}

fn cannot_read(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::NotFound {
        "there is no such file".to_owned()
    } else {
        format!("cannot read it: {error}")
    }
}

fn scene(run: &Path, notes: &mut Vec<String>) -> (Option<String>, Option<Scene>) {
    let path = Folder::scene_of(run);
    let text = noted("scene.toml", notes, || fs::read_to_string(&path).map_err(|error| cannot_read(&error)));
    let scene = text.as_ref().and_then(|text| {
        noted("scene.toml", notes, || scene_from_text(text.clone(), &path, &[]).map_err(|error| error.to_string()))
    });
    (text, scene)
}

/// What was measured beyond the rows. Runs that measure no more than those have no such file.
fn measured(run: &Path, notes: &mut Vec<String>) -> Measured {
    let text = match fs::read(run.join("measurements.json")) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Measured::default(),
        text => text,
    };
    let mut measured = noted("measurements.json", notes, || {
        let text = text.map_err(|error| cannot_read(&error))?;
        serde_json::from_slice::<Measured>(&text).map_err(|error| error.to_string())
    })
    .unwrap_or_default();
    measured.curves.retain(|curve| {
        let is_sound = is_even(curve);
        if !is_sound {
            notes.push(format!("measurements.json: the columns of {} do not have the same length", curve.name));
        }
        is_sound
    });
    measured
}

/// Whether all columns of a curve have the same length.
fn is_even(curve: &Curve) -> bool {
    let Some(length) = curve.variables.first().map(|variable| variable.values.len()) else { return false };
    curve.variables.iter().all(|variable| variable.values.len() == length)
        && curve.series.iter().all(|series| series.values.len() == length && series.standard_errors.len() == length)
        && curve.published.iter().all(|published| published.x.len() == published.y.len())
}
