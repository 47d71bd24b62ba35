//! Surfaces of a scene as binary STL files in the folder `surfaces`, beside the trajectory.
//!
//! A file is named after its surface, with `_` for special characters. A number is added to a name that exists. A
//! surface has no file if it lies outside the displayed region, or if its coordinates exceed the range of `f32`. The
//! files show the surfaces before their first motion. `surfaces.json` lists motions, if any.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::OutputError;
use super::partial::PartialFile;
use crate::mesh::{WriteStlError, shown, write_stl};
use crate::model::{Scene, SurfaceMotion};

const FOLDER: &str = "surfaces";

const LIST: &str = "surfaces.json";

const EXTENSION: &str = "stl";

/// Longest file name, without extension and number `[characters]`.
const LONGEST: usize = 80;

/// Names that Windows reserves for devices, with any extension.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

pub(crate) fn names(scene: &Scene) -> Vec<String> {
    let list = is_listed(scene).then(|| LIST.to_owned());
    meshes(scene).into_iter().chain(list).map(|name| format!("{FOLDER}/{name}")).collect()
}

fn meshes(scene: &Scene) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let surfaces = scene.surfaces().iter().map(|surface| surface.name.as_str());
    surfaces.map(|name| format!("{}.{EXTENSION}", file_name(name, &mut taken))).collect()
}

/// Entry of `surfaces.json`, which lists the surfaces in the order of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ListedSurface {
    /// Name of the STL file. The file is missing if the surface lies outside the displayed region.
    pub file: String,
    /// Motions of the surface.
    pub motions: Vec<SurfaceMotion>,
}

fn is_listed(scene: &Scene) -> bool {
    scene.surfaces().iter().any(|surface| surface.moves() || surface.comes_and_goes())
}

/// Reads `surfaces.json` in the folder of a trajectory. Returns an empty list if the file does not exist.
///
/// # Errors
/// The path of the file and an [`io::Error`], if the file exists and cannot be read.
pub fn listed_surfaces(folder: &Path) -> Result<Vec<ListedSurface>, (PathBuf, io::Error)> {
    let path = folder.join(FOLDER).join(LIST);
    let read = match fs::read(&path) {
        Ok(content) => serde_json::from_slice(&content).map_err(io::Error::from),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
    };
    read.map_err(|error| (path, error))
}

/// Writes the surface files that `is_wanted` selects.
pub(crate) fn write(run: &Path, scene: &Scene, is_wanted: impl Fn(&Path) -> bool) -> Result<(), OutputError> {
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
            // The coordinates exceed the range of the format.
            Err(_) => file.discard()?,
        }
    }
    let path = folder.join(LIST);
    if !is_listed(scene) || !is_wanted(&path) {
        return Ok(());
    }
    let surfaces = meshes.into_iter().zip(scene.surfaces());
    let list: Vec<ListedSurface> =
        surfaces.map(|(file, surface)| ListedSurface { file, motions: surface.motions.clone() }).collect();
    make()?;
    let mut file = PartialFile::create(path.clone())?;
    serde_json::to_writer_pretty(file.writer(), &list).map_err(|error| OutputError::write(&path)(error.into()))?;
    file.complete().map(drop)
}

/// Returns the paths of the surface files in the folder of a trajectory, sorted by name.
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

/// Returns a new file name that is valid on every file system.
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
