//! Surfaces of a scene as files beside its trajectory, to be looked at with it: binary STL in the folder `surfaces`, one file for each.
//!
//! The name of a file is that of its surface, where blanks and letters beyond ASCII are `_`; where two would be the same, also on a disk that does not tell
//! capitals from small letters, the later one has a number. A surface of which nothing is in sight has no file, nor has one with coordinates beyond `f32`.
//! The files are those before the first motion; `motions.json` has the motions of those that move.

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::partial::PartialFile;
use crate::mesh::{WriteStlError, shown, write_stl};
use crate::model::{Scene, SurfaceMotion};

/// The folder, in that of a run.
const FOLDER: &str = "surfaces";

/// The file of their motions, by the names of their files.
const MOTIONS: &str = "motions.json";

/// Extension of the files.
const EXTENSION: &str = "stl";

/// The longest name without its extension, in bytes.
const LONGEST: usize = 80;

/// Names that stand for devices on Windows, whatever their extension.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// The files of the surfaces of a scene, in the folder of a run.
pub(super) fn names(scene: &Scene) -> Vec<String> {
    let motions = scene.has_moving_surfaces().then(|| MOTIONS.to_owned());
    meshes(scene).into_iter().chain(motions).map(|name| format!("{FOLDER}/{name}")).collect()
}

/// The files of their triangles, in the folder of surfaces.
fn meshes(scene: &Scene) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let surfaces = scene.surfaces().iter().map(|surface| surface.name.as_str());
    surfaces.map(|name| format!("{}.{EXTENSION}", file_name(name, &mut taken))).collect()
}

/// Motions of surfaces, by the names of their files.
pub type Motions = BTreeMap<String, Vec<SurfaceMotion>>;

/// The motions of the surfaces in the folder of a trajectory; none where there is no file of them.
///
/// # Errors
/// The file, and [`io::Error`], if there is one that cannot be read.
pub fn surface_motions(folder: &Path) -> Result<Motions, (PathBuf, io::Error)> {
    let path = folder.join(FOLDER).join(MOTIONS);
    let read = match fs::read(&path) {
        Ok(content) => serde_json::from_slice(&content).map_err(io::Error::from),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Motions::new()),
        Err(error) => Err(error),
    };
    read.map_err(|error| (path, error))
}

/// Writes those of these files that are wanted, each with its name at once: they are complete from the start of a run.
///
/// # Errors
/// [`OutputError::Folder`] or [`OutputError::Write`].
pub(super) fn write(run: &Path, scene: &Scene, is_wanted: impl Fn(&Path) -> bool) -> Result<(), OutputError> {
    let folder = run.join(FOLDER);
    let make = || fs::create_dir_all(&folder).map_err(|source| OutputError::Folder { path: folder.clone(), source });
    let meshes = meshes(scene);
    for (name, (_, mesh)) in meshes.iter().zip(shown(scene)) {
        let path = folder.join(name);
        if mesh.triangles.is_empty() || !is_wanted(&path) {
            continue;
        }
        make()?;
        let mut file = PartialFile::create(path.clone())?;
        match write_stl(&mesh, file.writer()) {
            Ok(()) => file.complete().map(drop)?,
            Err(WriteStlError::Io(source)) => return Err(OutputError::write(&path)(source)),
            // Beyond what the format holds; nothing was written.
            Err(_) => file.discard()?,
        }
    }
    let path = folder.join(MOTIONS);
    if !scene.has_moving_surfaces() || !is_wanted(&path) {
        return Ok(());
    }
    let moving = meshes.into_iter().zip(scene.surfaces()).filter(|(_, surface)| surface.moves());
    let motions: Motions = moving.map(|(name, surface)| (name, surface.motions.clone())).collect();
    make()?;
    let mut file = PartialFile::create(path.clone())?;
    serde_json::to_writer_pretty(file.writer(), &motions).map_err(|error| OutputError::write(&path)(error.into()))?;
    file.complete().map(drop)
}

/// The files of surfaces in the folder of a trajectory, in the order of their names; none without such a folder.
#[must_use]
pub fn surface_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join(FOLDER)).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_surface = |path: &PathBuf| {
        path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION)) && path.is_file()
    };
    let mut files: Vec<PathBuf> = entries.filter(is_surface).collect();
    files.sort();
    files
}

/// A name that every disk can have, and that no other surface has.
fn file_name(name: &str, taken: &mut BTreeSet<String>) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-+.()".contains(c);
    let plain: String = name.chars().take(LONGEST).map(|c| if is_plain(c) { c } else { '_' }).collect();
    let first = plain.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let is_port = first.len() == 4 && (first.starts_with("com") || first.starts_with("lpt"));
    let plain = if is_port || DEVICES.contains(&first.as_str()) { format!("_{plain}") } else { plain };
    let numbered = (2_u32..).map(|number| format!("{plain}-{number}"));
    let free = [plain.clone()].into_iter().chain(numbered).find(|name| taken.insert(name.to_ascii_lowercase()));
    free.unwrap_or(plain)
}
