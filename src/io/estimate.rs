//! Estimates of a run's output and memory.
//!
//! ```
//! use carom::io::estimate::SizeEstimate;
//! use carom::model::{RunPlan, Until};
//! use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
//!
//! let scene = SceneBuilder::new("fluid")
//!     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
//!     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
//!     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(4_000).packing_fraction(0.3))
//!     .run(RunPlan { limit: Until::events(1_000_000), ..RunPlan::default() })
//!     .build()?;
//! let estimate = SizeEstimate::of(&scene, None);
//! assert!(estimate.is_complete && estimate.bytes < 1e9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::path::Path;

use thiserror::Error;

use super::event_log::bytes_of_event;
use crate::base::text::size;
use crate::model::{Format, Scene, SceneSurface, SurfaceShape, Until};
use crate::run::{FrameLimit, Settings, Stage};
use crate::trajectory::extended_xyz;

/// Largest number of rows of `thermo.csv` in a stage if the run chooses the interval.
const ROWS: f64 = 400.0;

/// Length of a number as text with all digits `[bytes]`.
const DIGITS: f64 = 19.0;

/// Size of the checkpoints per particle `[bytes]`. Up to three checkpoints exist at the same time.
const CHECKPOINT: f64 = 3.0 * 300.0;

/// Size of an event in the table of contacts `[bytes]`.
const CONTACT: f64 = 100.0;

/// Memory of the program without particles, and memory per particle in a dense system `[bytes]`.
const PROGRAM: f64 = 12e6;
const PARTICLE: f64 = 250.0;

/// Memory per triangle of a curved mesh, with the search tree `[bytes]`. A million triangles took 0.97 GB.
const TRIANGLE: f64 = 1_000.0;

/// Memory per particle of a second simulation, which runs ahead if instruments need the duration of the run `[bytes]`.
const COPY: f64 = 250.0;

/// Largest size of a run that is written without `--force` `[bytes]`.
const MOST: f64 = 1e10;

/// Estimated output and memory of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeEstimate {
    /// Number of rows of `thermo.csv`, if known.
    pub rows: Option<f64>,
    /// Number of frames of `trajectory.xyz`, if known.
    pub frames: Option<f64>,
    /// Why the size on disk limits the number of frames. `None` if the number is not limited.
    pub frames_limit: Option<&'static str>,
    /// Number of events of all stages, if known.
    pub events: Option<f64>,
    /// Total size of all files `[bytes]`, within a factor of two.
    pub bytes: f64,
    /// Whether `bytes` includes all files. Otherwise `bytes` is a lower bound.
    pub is_complete: bool,
    /// Memory of the program `[bytes]`, within a factor of two.
    pub memory: f64,
}

impl SizeEstimate {
    /// Estimates the output and memory of a run. `rate` is the number of events per simulated time `[1/time]`.
    #[must_use]
    pub fn of(scene: &Scene, rate: Option<f64>) -> Self {
        let (duration, measured) = lengths(&scene.run.limit, rate);
        let output = &scene.output;
        let count = |interval: Option<f64>, chosen: f64| match interval {
            Some(interval) => duration.map(|time| (time / interval).ceil() + 2.0),
            None => Some(chosen.min(measured.unwrap_or(f64::INFINITY).max(1.0) * 2.0 + 2.0)),
        };
        let limit = FrameLimit::of(scene);
        let measured_rows = count(output.thermo_interval, ROWS);
        let frames = count(output.frame_interval, limit.most(Stage::Measurement))
            .zip(earlier_frames(scene, rate, limit))
            .map(|(last, more)| last + more);
        let earlier_rows = earlier_rows(scene, rate);
        let rows = measured_rows.zip(earlier_rows).map(|(measured, earlier)| measured + earlier);
        let row = (12.0 + output.regions.len() as f64) * DIGITS;
        let events_of = |(_, settings): (Stage, Settings)| match settings.limit == Until::default() {
            true => (!settings.is_endless()).then_some(0.0),
            false => lengths(&settings.limit, rate).1,
        };
        let before: Option<f64> = earlier(scene).map(events_of).sum();
        let logged = earlier(scene).filter(|(stage, _)| stage.is_measured()).map(events_of).sum::<Option<f64>>();
        let particles = scene.particles.len() as f64 + scene.entering();
        let per_event =
            if output.has_event_log { bytes_of_event() } else { 0.0 } + if output.has_contacts { CONTACT } else { 0.0 };
        let has_copy = !scene.measure.is_empty() && scene.run.limit.events.is_some();
        let parts = [
            measured_rows.map(|rows| rows * row),
            earlier_rows.map(|rows| rows * row),
            frames.map(|frames| frames * frame_bytes(scene)),
            if per_event > 0.0 { measured.zip(logged).map(|(a, b)| (a + b) * per_event) } else { Some(0.0) },
            Some(particles * CHECKPOINT),
        ];
        Self {
            rows,
            frames,
            frames_limit: limit.reason(),
            events: if rests(scene) {
                Some(0.0)
            } else {
                measured.zip(before).map(|(measured, before)| measured + before)
            },
            bytes: parts.iter().flatten().sum(),
            is_complete: parts.iter().all(Option::is_some),
            memory: PROGRAM
                + particles * if has_copy { PARTICLE + COPY } else { PARTICLE }
                + triangles(scene) * if has_copy { 2.0 * TRIANGLE } else { TRIANGLE },
        }
    }
}

fn triangles(scene: &Scene) -> f64 {
    let of = |surface: &SceneSurface| match &surface.shape {
        SurfaceShape::Mesh(mesh) => mesh.triangles.len(),
        _ => 0,
    };
    scene.surfaces.iter().map(of).sum::<usize>() as f64
}

/// Whether no event can happen: all particles rest without overlaps, and nothing accelerates them.
fn rests(scene: &Scene) -> bool {
    let plan = &scene.run;
    let is_pushed = scene.accelerations().any(|acceleration| acceleration.norm() > 0.0) || scene.shear_rate.is_some();
    let is_driven = Stage::all(plan).map(|stage| stage.settings(plan)).any(|it| {
        it.thermostat.is_some()
            || it.barostat.is_some()
            || it.swap.is_some()
            || it.growth.is_some()
            || it.gravity.is_some()
    });
    let is_at_rest = scene.particles.iter().all(|particle| particle.velocity.norm() == 0.0);
    is_at_rest
        && !is_pushed
        && !is_driven
        && !scene.allow_invalid_start
        && !scene.has_moving_surfaces()
        && scene.inlets.is_empty()
}

fn earlier(scene: &Scene) -> impl Iterator<Item = (Stage, Settings)> + '_ {
    let all = Stage::all(&scene.run).filter(|stage| *stage != Stage::Measurement);
    all.map(|stage| (stage, stage.settings(&scene.run)))
}

fn earlier_rows(scene: &Scene, rate: Option<f64>) -> Option<f64> {
    let simulated = earlier(scene).filter(|(_, settings)| settings.has_end());
    simulated.map(|(_, settings)| at_times(&settings, rate, scene.output.thermo_interval, ROWS)).sum()
}

fn earlier_frames(scene: &Scene, rate: Option<f64>, limit: FrameLimit) -> Option<f64> {
    let measured = earlier(scene).filter(|(stage, _)| stage.is_measured());
    let frames = |(stage, settings): (Stage, Settings)| {
        at_times(&settings, rate, scene.output.frame_interval, limit.most(stage))
    };
    measured.map(frames).sum()
}

/// Number of rows or frames in a stage before the final measurement, if known; at most `most` without an interval.
fn at_times(settings: &Settings, rate: Option<f64>, interval: Option<f64>, most: f64) -> Option<f64> {
    if settings.is_endless() {
        return None;
    }
    let (time, events) = lengths(&settings.limit, rate);
    match interval {
        Some(interval) => time.map(|time| (time / interval).ceil() + 1.0),
        None => Some(most.min(events.unwrap_or(f64::INFINITY).max(1.0) * 2.0 + 2.0)),
    }
}

/// Simulated time and number of events at which a limit is reached, if known. If time and events are limited, the event
/// rate tells which limit is reached first.
fn lengths(limit: &Until, rate: Option<f64>) -> (Option<f64>, Option<f64>) {
    let rate = rate.filter(|rate| *rate > 0.0);
    match (limit.time, limit.events.map(|events| events as f64), rate) {
        (Some(time), Some(events), Some(rate)) => (Some(time.min(events / rate)), Some(events.min(time * rate))),
        (Some(time), None, rate) => (Some(time), rate.map(|rate| time * rate)),
        (None, Some(events), rate) => (rate.map(|rate| events / rate), Some(events)),
        (Some(_), Some(_), None) | (None, None, _) => (None, None),
    }
}

/// Size of a frame `[bytes]`, summed over all formats.
fn frame_bytes(scene: &Scene) -> f64 {
    let text = extended_xyz::frame_bytes(scene);
    // Sizes relative to extended XYZ. A binary number has 4 or 8 bytes, fewer than its digits.
    let share = |format: &Format| match format {
        Format::Gsd => 0.3,
        Format::Npy => 0.5,
        _ => 1.1,
    };
    text * (1.0 + scene.output.formats.iter().map(share).sum::<f64>())
}

/// The expected output is larger than permitted without `--force`.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("would write about {}, more than the {} allowed without --force", size(*.bytes), size(*.most))]
pub struct TooLarge {
    /// Expected size `[bytes]`.
    pub bytes: f64,
    /// Largest permitted size `[bytes]`.
    pub most: f64,
}

/// Checks the expected size of an output. Returns the largest size in a folder without `--force` `[bytes]`.
///
/// # Errors
/// [`TooLarge`] if `bytes` exceeds this size.
pub fn allowed(bytes: f64, folder: &Path) -> Result<f64, TooLarge> {
    let most = allowance(free_disk(folder));
    if bytes <= most { Ok(most) } else { Err(TooLarge { bytes, most }) }
}

/// Returns the largest size of a run without `--force` `[bytes]`. It is 10 GB, or a tenth of the free disk space if
/// this is less. The argument `free` is the free disk space, if known.
#[must_use]
pub fn allowance(free: Option<f64>) -> f64 {
    free.map_or(MOST, |free| (0.1 * free).min(MOST))
}

/// Free disk space `[bytes]` for a folder that may not exist yet. `None` if unknown.
#[cfg(target_os = "linux")]
#[must_use]
pub fn free_disk(folder: &Path) -> Option<f64> {
    use std::ffi::CString;
    use std::os::unix::ffi::OsStrExt;

    let folder = std::path::absolute(folder).ok()?;
    let there = folder.ancestors().find(|folder| folder.exists())?;
    let path = CString::new(there.as_os_str().as_bytes()).ok()?;
    let mut status = std::mem::MaybeUninit::<libc::statvfs>::zeroed();
    // SAFETY: the path is null-terminated, and `status` can hold everything that the call writes.
    let result = unsafe { libc::statvfs(path.as_ptr(), status.as_mut_ptr()) };
    // SAFETY: the value was initialized with zeros, which are valid for this type.
    let status = unsafe { status.assume_init() };
    (result == 0).then_some(status.f_bavail as f64 * status.f_frsize as f64)
}

/// Returns `None`, because this system does not report the free disk space.
#[cfg(not(target_os = "linux"))]
#[must_use]
pub fn free_disk(_folder: &Path) -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "
        [space]
        size = [20.0, 20.0, 20.0]
        [[species]]
        name = 'ball'
        mass = 1.3
        diameter = 1.0
        [[interaction]]
        species = ['ball', 'ball']
        potential = 'hard-sphere'
        [[fill]]
        species = 'ball'
        arrangement = 'sc'
        count = 1000
        temperature = 1.0
        ";

    fn estimate(more: &str, rate: Option<f64>) -> SizeEstimate {
        SizeEstimate::of(&Scene::from_toml(format!("{SCENE}{more}"), "scene.toml").unwrap(), rate)
    }

    #[test]
    fn undriven_scene_at_rest_has_no_expected_events() {
        let events = |temperature: &str, more: &str| {
            let text = SCENE.replace("temperature = 1.0", temperature) + more;
            SizeEstimate::of(&Scene::from_toml(text, "scene.toml").unwrap(), Some(3.0)).events
        };
        let run = "[run]\nuntil_events = 1000\n";
        let bath = "thermostat = { kind = 'andersen', temperature = 1.0, rate = 1.0 }\n";
        assert_eq!(events("", run), Some(0.0));
        assert_eq!(events("", &(run.to_owned() + bath)), Some(1000.0));
        assert_eq!(events("", &(run.to_owned() + "[dynamics]\ngravity = [0.0, 0.0, -1.0]\n")), Some(1000.0));
        assert_eq!(events("temperature = 1.0", run), Some(1000.0));
    }

    #[test]
    fn intervals_and_limits_give_rows_frames_and_bytes() {
        let it = estimate("[run]\nuntil_time = 1e9\n[output]\nthermo_interval = 1e-3\nframe_interval = 1e6", None);
        assert_eq!((it.rows, it.frames), (Some(1e12 + 2.0), Some(1002.0)));
        assert!(it.bytes > 1e13 && it.is_complete && it.events.is_none());
        let it =
            estimate("[run]\nuntil_events = 1000\nequilibration_events = 500\n[output]\nthermo_interval = 0.5", None);
        assert_eq!((it.rows, it.events, it.is_complete), (None, Some(1500.0), false));
        let it = estimate("[run]\nuntil_events = 1000\n[output]\nthermo_interval = 0.5", Some(10.0));
        assert_eq!((it.rows, it.is_complete), (Some(202.0), true));
        let before = "[run]\nuntil_events = 1000\nequilibration_events = 500\n[output]\nthermo_interval = 0.5";
        assert_eq!(estimate(before, Some(10.0)).rows, Some(202.0 + 101.0), "rows of all stages");
        let it = estimate("[run]\nuntil_time = 10.0\n[output]\nevents = true", Some(1e9));
        assert!((1.81e12..1.82e12).contains(&it.bytes) && it.is_complete, "{}", it.bytes);
        assert!(!estimate("[run]\nuntil_time = 10.0\n[output]\nevents = true", None).is_complete);
        let it =
            estimate("[run]\nuntil_time = 1e9\nequilibration_events = 500\n[output]\nthermo_interval = 1e-3", None);
        assert!(it.bytes > 1e13 && !it.is_complete && it.rows.is_none(), "the known parts alone are too large: {it:?}");
        let both = "[run]\nuntil_events = 1000\nuntil_time = 1e9\n[output]\nthermo_interval = 1e-3";
        assert_eq!((estimate(both, None).rows, estimate(both, Some(1e3)).rows), (None, Some(1002.0)));
        let automatic = estimate("[run]\nuntil_time = 10.0\nequilibration = \"auto\"", Some(10.0));
        assert_eq!((automatic.rows, automatic.events, automatic.is_complete), (None, None, false));
        let limited = "[run]\nuntil_events = 500\nequilibration = \"auto\"\nequilibration_events = 500";
        assert_eq!(estimate(limited, None).events, Some(1000.0), "at most");
        let plain = estimate("[run]\nuntil_time = 10.0", None);
        assert!(plain.bytes < 1e7 && plain.rows == Some(ROWS) && plain.memory < 2e7);
    }

    #[test]
    fn a_tenth_of_the_disk_and_ten_gigabytes_at_most() {
        assert_eq!(allowance(None), 1e10);
        assert_eq!(allowance(Some(1e9)), 1e8);
        assert_eq!(allowance(Some(1e13)), 1e10);
        if cfg!(target_os = "linux") {
            assert!(free_disk("not/made/yet".as_ref()).is_some_and(f64::is_finite));
        }
    }
}
