//! Reads scenes from files.

use std::path::Path;

use super::checkpoints;
use super::folder::{SUMMARY, SUMMARY_BEFORE};
use super::owned::is_run;
use crate::base::text::with_causes;
use crate::model::{InputFile, Scene};
use crate::run::checkpoint::{Checkpoint, CheckpointError};
use crate::scene::{GivenParticles, LastRun, SceneError, SceneErrorKind, read_text};

/// Reads a scene from a file, like [`Scene::from_file_with`]. In addition, the scene may start from the end of a run.
///
/// ```
/// use carom::io::{Existing, Folder, read_scene};
/// use carom::model::Scene;
/// use carom::run::Run;
/// use std::ops::ControlFlow;
///
/// # let directory = tempfile::tempdir()?;
/// # let (first, next) = (directory.path().join("first"), directory.path().join("next.toml"));
/// # let shorter = [("run.until_events", "2000"), ("run.equilibration_events", "1000")];
/// # let scene = Scene::from_file_with("configs/hard_sphere_fluid.toml", &shorter)?;
/// // `first` is the folder of a run, `next` the path of a scene.
/// let mut folder = Folder::create(&first, &scene, Existing::Keep)?;
/// let finished = Run::new(scene).execute(&mut folder, &mut |_| ControlFlow::Continue(()))?;
/// folder.complete(&finished, "")?;
/// std::fs::write(&next, "start.from = \"first\"\nrun.until_events = 1000")?;
/// let scene = read_scene(&next, &[])?;
/// assert_eq!(scene.start_time(), finished.simulation.time());
/// assert_eq!(scene.particles().len(), finished.simulation.snapshot().positions.len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The errors of [`Scene::from_file_with`], [`SceneErrorKind::NoStart`] and [`SceneErrorKind::RunChanged`].
pub fn read_scene(path: impl AsRef<Path>, overrides: &[(&str, &str)]) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    Scene::from_toml_and_run(read_text(path)?, path, overrides, None, &open)
}

/// Like [`read_scene`], but takes the text of the scene. `name` replaces the path in messages and for relative paths.
///
/// # Errors
/// The errors of [`read_scene`], except errors of reading the file.
pub fn read_scene_text(
    text: impl Into<String>,
    name: impl AsRef<Path>,
    overrides: &[(&str, &str)],
) -> Result<Scene, SceneError> {
    Scene::from_toml_and_run(text.into(), name.as_ref(), overrides, None, &open)
}

/// Like [`read_scene_text`], but takes the particles from memory instead of a file.
///
/// ```
/// use carom::io::{read_scene_text, read_scene_with};
/// use carom::scene::GivenParticles;
/// use carom::trajectory::Frame;
///
/// # let text = std::fs::read_to_string("configs/hard_sphere_fluid.toml")?;
/// // `text` is the text of a scene with a `[[fill]]`.
/// let scene = read_scene_text(text.as_str(), "fluid.toml", &[])?;
/// let mut given = GivenParticles::new("start", Frame::start_of(&scene));
/// given.has_box = true;
/// let again = read_scene_with(text, "fluid.toml", &[("fill", "[]")], &given)?;
/// assert_eq!(again.particles(), scene.particles());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The errors of [`read_scene_text`]. An error in the particles is reported with their name and row.
pub fn read_scene_with(
    text: impl Into<String>,
    name: impl AsRef<Path>,
    overrides: &[(&str, &str)],
    particles: &GivenParticles,
) -> Result<Scene, SceneError> {
    Scene::from_toml_and_run(text.into(), name.as_ref(), overrides, Some(particles), &open)
}

fn open(folder: &Path) -> Result<LastRun, SceneErrorKind> {
    let refused =
        |problem: String, cure: String| Err(SceneErrorKind::NoStart { path: folder.to_owned(), problem, cure });
    if !is_run(folder) {
        let problem = if folder.is_dir() { "it is not the folder of a run" } else { "there is no such folder" };
        return refused(problem.to_owned(), "name the folder of a finished run, such as runs/fluid".to_owned());
    }
    let resume = || format!("carom run --resume {} continues it", folder.display());
    if !folder.join(SUMMARY).exists() {
        let problem = if folder.join(SUMMARY_BEFORE).exists() {
            "the run is still in progress"
        } else {
            "the run is not finished"
        };
        return refused(problem.to_owned(), resume());
    }
    let failed = |error: CheckpointError| SceneErrorKind::NoStart {
        path: folder.to_owned(),
        cure: cure(&error),
        problem: with_causes(&error),
    };
    let path = checkpoints::last(folder);
    let mut checkpoint = Checkpoint::read(&path).map_err(failed)?;
    let checksum = Checkpoint::stated_checksum(&path).map_err(failed)?;
    if !checkpoint.has_ended() {
        let problem = "the run was interrupted before its end, or could not continue";
        return refused(
            problem.to_owned(),
            format!("{}; for another end, add --until-time or --until-events", resume()),
        );
    }
    if let Err(error) = checkpoint.go_to_end() {
        return refused(error.to_string(), "start from a finished run".to_owned());
    }
    let simulation = checkpoint.simulation;
    if let Some(broken) = simulation.broken() {
        return refused(broken.to_string(), "start from a finished run".to_owned());
    }
    if simulation.is_growing() {
        let problem = "the run ended while its spheres were growing".to_owned();
        return refused(problem, "start from a run whose growth has ended".to_owned());
    }
    Ok(LastRun { simulation, checkpoint: InputFile::of_checkpoint(&path, checksum) })
}

fn cure(error: &CheckpointError) -> String {
    match error {
        CheckpointError::OtherVersion { .. } => {
            "repeat that run with this version, or start from its last frame, but not bit for bit: [[file]] with the \
             path of its trajectory.xyz and frame = -1"
        }
        CheckpointError::Missing(_) | CheckpointError::Damaged { .. } => "repeat that run",
        error => error.cure(),
    }
    .to_owned()
}
