//! Reads the files of a run. Only `summary.json` is required. Missing or damaged files are noted and left out.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::Path;

use super::recording::{self, MOST_TRIANGLES, Recording};
use super::table::{self, Trace};
use crate::analysis::instruments::{Curve, Measured};
use crate::analysis::observables::Equilibrium;
use crate::analysis::published::PublishedValue;
use crate::base::text;
use crate::io::rates::Rate;
use crate::io::summary::{Column, Observable};
use crate::io::{Folder, Measurements, Summary, read_scene_text, surface_files};
use crate::model::Scene;
use crate::model::run_plan::MEASUREMENT;
use crate::view::ViewError;
use crate::view::surfaces::{self, Surfaces};

#[derive(Debug)]
pub(super) struct Inputs {
    pub summary: Summary,
    pub scene_text: Option<String>,
    pub scene: Option<Scene>,
    pub thermo: Vec<Trace>,
    pub measured: Measured,
    pub stages: Vec<StageInputs>,
    pub recording: Option<Recording>,
    pub notes: Vec<String>,
}

/// Results of a measured stage in files other than `summary.json`.
#[derive(Debug)]
pub(super) struct StageInputs {
    pub thermo: Vec<Trace>,
    pub measured: Measured,
}

/// Results of a measured stage, or of the last measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Results<'a> {
    /// Name of the stage; `None` for the last measurement.
    pub stage: Option<&'a str>,
    pub events: u64,
    pub equilibrated: &'a Equilibrium,
    pub observables: &'a BTreeMap<String, Observable>,
    pub published: &'a [PublishedValue],
    pub rates: &'a [Rate],
    pub measured: &'a Measured,
    pub thermo: &'a [Trace],
    pub scene: Option<&'a Scene>,
}

impl Results<'_> {
    /// Returns a unit with the names of the scene.
    pub fn unit_of(&self, unit: &str) -> String {
        self.scene.map_or_else(|| unit.to_owned(), |scene| scene.unit_of(unit))
    }
}

impl Inputs {
    pub fn last(&self) -> Results<'_> {
        let summary = &self.summary;
        Results {
            stage: None,
            events: summary.events.total,
            equilibrated: &summary.equilibrated,
            observables: &summary.observables,
            published: &summary.published,
            rates: &summary.rates,
            measured: &self.measured,
            thermo: &self.thermo,
            scene: self.scene.as_ref(),
        }
    }

    pub fn of_stages(&self) -> impl Iterator<Item = Results<'_>> {
        self.summary.stages.iter().zip(&self.stages).map(|(summary, stage)| Results {
            stage: Some(&summary.name),
            events: summary.events.total,
            equilibrated: &summary.equilibrated,
            observables: &summary.observables,
            published: &summary.published,
            rates: &summary.rates,
            measured: &stage.measured,
            thermo: &stage.thermo,
            ..self.last()
        })
    }
}

/// Reads the files of a run. A trajectory larger than `most_bytes` is left out.
pub(super) fn read(run: &Path, most_bytes: u64) -> Result<Inputs, ViewError> {
    if !run.is_dir() {
        return Err(ViewError::NotFolder(run.to_owned()));
    }
    let path = run.join("summary.json");
    let text = match fs::read(&path) {
        Ok(text) => text,
        Err(source) => return Err(ViewError::Unreadable { path, source }),
    };
    let summary: Summary =
        serde_json::from_slice(&text).map_err(|error| ViewError::Summary { path, source: error.into() })?;
    let mut notes = Vec::new();
    let (scene_text, scene) = scene(run, &mut notes);
    let mut measurements = measurements(run, &mut notes);
    let units = summary.columns.get("thermo.csv").map_or(&[][..], Vec::as_slice);
    let thermo = thermo(run, MEASUREMENT, units, &mut notes);
    let stages = summary.stages.iter().map(|stage| {
        let measured = measurements.stages.iter_mut().find(|measured| measured.name == stage.name);
        StageInputs {
            // Errors of this table are already in `notes`.
            thermo: thermo
                .as_ref()
                .and_then(|_| self::thermo(run, &stage.name, units, &mut Vec::new()))
                .unwrap_or_default(),
            measured: measured.map(|measured| std::mem::take(&mut measured.measured)).unwrap_or_default(),
        }
    });
    let stages = stages.collect();
    let measured = measurements.last;
    let mut recording = noted("trajectory.xyz", &mut notes, || {
        let path = run.join("trajectory.xyz");
        let size = fs::metadata(&path).map_or(0, |file| file.len());
        if size > most_bytes {
            return Err(format!(
                "a size of {} is too large for a small page; carom report makes a page with the player",
                text::size(size as f64)
            ));
        }
        recording::read(open(&path)?, scene.as_ref())
    });
    if let Some(recording) = &mut recording {
        recording.add_surfaces(&surfaces(run, &mut notes));
        if let Some(scene) = &scene {
            recording.begin_with(scene.live());
        }
        notes.extend(recording.notes.iter().cloned());
    }
    Ok(Inputs { summary, scene_text, scene, thermo: thermo.unwrap_or_default(), measured, stages, recording, notes })
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
        noted("scene.toml", notes, || read_scene_text(text.clone(), &path, &[]).map_err(|error| error.to_string()))
    });
    (text, scene)
}

fn surfaces(run: &Path, notes: &mut Vec<String>) -> Surfaces {
    let mut room = MOST_TRIANGLES;
    let mut meshes = Vec::new();
    for file in surface_files(run) {
        let name = format!("surfaces/{}", file.file_name().unwrap_or_default().display());
        let mesh = noted(&name, notes, || match surfaces::read(&file) {
            Ok(mesh) if mesh.triangles.len() > room => Err(format!(
                "the player does not show it: it has {} triangles, and only {room} more fit",
                mesh.triangles.len()
            )),
            Ok(mesh) => Ok(mesh),
            Err(ViewError::Surface(error)) => Err(error.problem.to_string()),
            Err(ViewError::SurfaceFile { source, .. }) => Err(cannot_read(&source)),
            Err(error) => Err(error.to_string()),
        });
        room -= mesh.as_ref().map_or(0, |mesh| mesh.triangles.len());
        meshes.extend(mesh.map(|mesh| (file, mesh)));
    }
    let surfaces = Surfaces::of_run(run, meshes);
    noted("surfaces", notes, || surfaces.map_err(|error| error.to_string())).unwrap_or_default()
}

fn thermo(run: &Path, stage: &str, units: &[Column], notes: &mut Vec<String>) -> Option<Vec<Trace>> {
    noted("thermo.csv", notes, || {
        let file = open(&run.join("thermo.csv"))?;
        table::read(file, stage, units)
    })
}

fn measurements(run: &Path, notes: &mut Vec<String>) -> Measurements {
    let read = noted("measurements.json", notes, || Measurements::read(run).map_err(|error| error.to_string()));
    let mut measurements = read.flatten().unwrap_or_default();
    let stages = measurements.stages.iter_mut().map(|stage| &mut stage.measured);
    for measured in [&mut measurements.last].into_iter().chain(stages) {
        measured.curves.retain(|curve| {
            let is_sound = is_even(curve);
            if !is_sound {
                notes.push(format!("measurements.json: the columns of {} do not have the same length", curve.name));
            }
            is_sound
        });
    }
    measurements
}

fn is_even(curve: &Curve) -> bool {
    let Some(length) = curve.variables.first().map(|variable| variable.values.len()) else { return false };
    curve.variables.iter().all(|variable| variable.values.len() == length)
        && curve.series.iter().all(|series| series.values.len() == length && series.standard_errors.len() == length)
        && curve.published.iter().all(|published| published.x.len() == published.y.len())
}
