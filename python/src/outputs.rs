//! Outputs made from the files of a run.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use carom::Vector;
use carom::cli::{VerifyStep, prove_run};
use carom::io::convert::{ConvertError, Options, convert_watched};
use carom::io::{Existing, Folder, refuse_input, refuse_link};
use carom::model::ParticleId;
use carom::view::movie::{self as movies, Follow, Movie};
use carom::view::render::{self as images, ColourBy, Style};
use carom::view::{ViewError, report};
use pyo3::prelude::*;

use crate::error;
use crate::run::Watch;
use crate::writer::format_of;

type Frames = (u64, Option<u64>);

/// Direction of view, azimuth and elevation in degrees, magnification, and whether to draw the box and the ground.
type Seen = (Option<[f64; 3]>, Option<[f64; 2]>, f64, bool, bool);

fn existing(force: bool) -> Existing {
    if force { Existing::Replace } else { Existing::Keep }
}

/// Returns the path of a run's trajectory. Rejects an output that would replace a file of the run, and a symbolic link
/// that the user has not named.
fn trajectory(run: &Path, out: &Path, is_named: bool) -> PyResult<PathBuf> {
    if !is_named {
        refuse_link(out).map_err(|failed| error::output(&failed))?;
    }
    refuse_input(out, Folder::files_of(run)).map_err(|failed| error::output(&failed))?;
    Ok(run.join("trajectory.xyz"))
}

/// Converts the trajectory of a run. Returns the path of the new file.
#[pyfunction]
pub fn convert(
    py: Python<'_>,
    run: PathBuf,
    to: &str,
    out: Option<PathBuf>,
    frames: Frames,
    force: bool,
) -> PyResult<PathBuf> {
    let (first, last) = frames;
    let format = format_of(&run, Some(to))?;
    let target = out.clone().unwrap_or_else(|| format.target_beside(&run.join("trajectory.xyz")));
    let source = trajectory(&run, &target, true)?;
    let mut watch = Watch::new(None);
    let options = Options { first, last, replace: force };
    let done = py.detach(|| {
        convert_watched((&source, format, &target), &options, &mut || watch.tell("converting", 0.0, 0.0, 0))
    });
    match (done, watch.raised.take()) {
        (Err(ConvertError::Interrupted), Some(raised)) => Err(raised),
        (Err(failed), _) => Err(error::convert(&failed)),
        (Ok(_), _) => Ok(target),
    }
}

fn style(colour: &str, size: Option<(u32, u32)>, seen: Seen) -> Style {
    let (from, angles, zoom, has_box, has_ground) = seen;
    let colour_by = match colour {
        "speed" => ColourBy::Speed,
        "pressure" => ColourBy::Pressure,
        _ => ColourBy::Species,
    };
    let mut style = Style { colour_by, zoom, has_box, has_ground, ..Style::default() };
    if let Some((width, height)) = size {
        style = Style { width, height, is_cut: false, ..style };
    }
    if let Some(side) = from {
        style = Style { from: Some(Vector::from(side)), azimuth: 0.0, ..style };
    }
    if let Some([azimuth, elevation]) = angles {
        style = Style { azimuth, elevation, ..style };
    }
    style
}

/// Draws the frame of a run at the time nearest to `time`, or the last frame.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "all are keywords of one method of Python")]
pub fn render(
    py: Python<'_>,
    run: PathBuf,
    out: Option<PathBuf>,
    time: Option<f64>,
    colour: &str,
    size: Option<(u32, u32)>,
    seen: Seen,
    force: bool,
) -> PyResult<PathBuf> {
    let target = out.clone().unwrap_or_else(|| run.join("picture.png"));
    let source = trajectory(&run, &target, out.is_some())?;
    let style = style(colour, size, seen);
    py.detach(|| {
        let image = images::of_trajectory(&source, time, &style)?;
        image.write_png(&target, existing(force))
    })
    .map_err(|failed| error::report(&failed))?;
    Ok(target)
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "all are keywords of one method of Python")]
pub fn movie(
    py: Python<'_>,
    run: PathBuf,
    out: PathBuf,
    frames: Frames,
    pace: (u64, u32, f64),
    colour: &str,
    size: (u32, u32),
    seen: Seen,
    follow: Option<i64>,
    force: bool,
    callback: Option<Py<PyAny>>,
) -> PyResult<PathBuf> {
    let ((first, last), (every, fps, turn)) = (frames, pace);
    let source = trajectory(&run, &out, true)?;
    // `is_cut` has no effect on movies.
    let style = Style { is_cut: Style::default().is_cut, ..style(colour, Some(size), seen) };
    let follow = follow.map(|id| u32::try_from(id).map_or(Follow::CentreOfMass, |id| Follow::Particle(ParticleId(id))));
    let movie = Movie { style, frames_per_second: fps, first, last, every, turn, follow };
    let mut watch = Watch::new(callback);
    let done = py.detach(|| {
        movies::write(&source, &out, &movie, existing(force), &mut |progress| {
            let stage = if progress.is_drawing { "drawing" } else { "reading" };
            watch.tell(stage, progress.fraction, progress.time, progress.frames)
        })
    });
    match (done, watch.raised.take()) {
        (Err(ViewError::Interrupted), Some(raised)) => Err(raised),
        (Err(failed), _) => Err(error::report(&failed)),
        (Ok(_), _) => Ok(out),
    }
}

#[pyfunction]
pub fn write_page(py: Python<'_>, run: PathBuf, out: Option<PathBuf>, force: bool) -> PyResult<PathBuf> {
    let target = out.clone().unwrap_or_else(|| run.join("report.html"));
    trajectory(&run, &target, out.is_some())?;
    py.detach(|| report::write(&report::page(&run)?, &target, existing(force)))
        .map_err(|failed| error::report(&failed))?;
    Ok(target)
}

/// Equal files, different files with the difference, and files that were not compared with the reason.
type Files = (Vec<String>, Vec<(String, String)>, Vec<(String, String)>);

/// Verifies events of a run. Returns the printed text, four values of the certificate, the comparison of the files and
/// the error, if any. The four values are whether the events are proven, the first event, the number of events, and the
/// largest gap.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "a tuple of Python")]
pub fn verify(
    py: Python<'_>,
    run: PathBuf,
    events: u64,
    from_events: Option<u64>,
    files: bool,
    callback: Option<Py<PyAny>>,
) -> PyResult<(String, (bool, u64, u64, f64), Option<Files>, Option<(String, Option<String>)>)> {
    let mut watch = Watch::new(callback);
    let proof = py.detach(|| {
        prove_run(&run, (from_events, events), files, &mut |step| -> ControlFlow<()> {
            match step {
                VerifyStep::Proof(progress) => {
                    let stage = if progress.is_proving { "proving" } else { "replaying" };
                    watch.tell(stage, progress.fraction(), 0.0, progress.events)
                }
                VerifyStep::Files(progress) => {
                    watch.tell("comparing files", progress.fraction(), progress.time, progress.events)
                }
            }
        })
    });
    if let Some(raised) = watch.raised.take() {
        return Err(raised);
    }
    let proof = proof.map_err(|failed| error::cured("FolderError", &failed.message(), failed.cure().as_deref()))?;
    let failure = proof.verdict.err().map(|failed| (failed.message(), failed.cure()));
    let certificate = &proof.certificate;
    let numbers =
        (certificate.is_proven(), certificate.first_event, certificate.counts.events(), certificate.largest_gap);
    let files = proof.files.map(|files| {
        let changed = files.differences.into_iter().map(|(name, difference)| (name, difference.to_string())).collect();
        let left_out = files.not_compared.into_iter().map(|(name, why)| (name, why.to_owned())).collect();
        (files.equal, changed, left_out)
    });
    Ok((proof.table, numbers, files, failure))
}
