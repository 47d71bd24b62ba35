//! Triangle meshes that are drawn with the particles.

mod skin;

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

pub(super) use skin::Skin;

use super::ViewError;
use crate::Vector;
use crate::io::{listed_surfaces, surface_files};
use crate::mesh::read_mesh;
use crate::model::TriangleMesh;
use crate::model::surface_motion::{Pose, Timeline};
use crate::trajectory::Frame;

/// Surfaces that extend farther than this beyond the displayed region do not enlarge the region, so that particles stay
/// large. The distance is relative to the longest edge of the region.
const REACH: f64 = 0.5;

/// Surfaces to draw.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surfaces {
    pub(super) skins: Vec<Skin>,
}

impl Surfaces {
    /// Creates a surface from each mesh. Meshes without area are left out.
    #[must_use]
    pub fn of<'m>(meshes: impl IntoIterator<Item = &'m TriangleMesh>) -> Self {
        Self { skins: meshes.into_iter().map(Skin::of).filter(|skin| !skin.triangles.is_empty()).collect() }
    }

    /// Reads the surfaces in the folder of a trajectory. Returns no surfaces if there are no files.
    pub fn beside(trajectory: &Path) -> Result<Self, ViewError> {
        let folder = trajectory.parent().unwrap_or(Path::new(""));
        let files = surface_files(folder);
        let meshes = files.into_iter().map(|file| read(&file).map(|mesh| (file, mesh)));
        Self::of_run(folder, meshes.collect::<Result<Vec<_>, _>>()?)
    }

    /// Creates surfaces from the meshes of a run. Reads the index and the motions of each surface from the folder.
    pub(super) fn of_run(folder: &Path, meshes: Vec<(PathBuf, TriangleMesh)>) -> Result<Self, ViewError> {
        let list = listed_surfaces(folder).map_err(|(path, source)| ViewError::SurfaceFile { path, source })?;
        let skin = |(file, mesh): (PathBuf, TriangleMesh)| {
            let name = file.file_name().unwrap_or_default().display().to_string();
            let number = list.iter().position(|listed| listed.file == name);
            let motions = number.and_then(|number| list.get(number)).map_or(&[][..], |listed| &listed.motions);
            Skin { number, timeline: (!motions.is_empty()).then(|| Timeline::of(motions)), ..Skin::of(&mesh) }
        };
        Ok(Self { skins: meshes.into_iter().map(skin).filter(|skin| !skin.triangles.is_empty()).collect() })
    }

    pub(super) fn at(&self, frame: &Frame) -> Cow<'_, Self> {
        let is_there = |skin: &&Skin| skin.is_among(&frame.surfaces);
        if self.skins.iter().all(|skin| skin.timeline.is_none() && is_there(&skin)) {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Self { skins: self.skins.iter().filter(is_there).map(|skin| skin.at(frame.time)).collect() })
    }

    /// Returns the pose `R x + d` of each surface: the columns of the rotation `R`, then the displacement `d`. An
    /// absent surface has no pose. The list is empty if all surfaces are present and at rest.
    pub(super) fn poses(&self, time: f64, present: &[bool]) -> Vec<Option<[f64; 12]>> {
        if self.skins.iter().all(|skin| skin.timeline.is_none() && skin.is_among(present)) {
            return Vec::new();
        }
        let pose = |skin: &Skin| {
            let Pose { rotation, displacement, .. } =
                skin.timeline.as_ref().map_or_else(Pose::default, |timeline| timeline.at(time).pose);
            let mut numbers = rotation.iter().chain(displacement.iter()).copied();
            skin.is_among(present).then(|| std::array::from_fn(|_| numbers.next().unwrap_or_default()))
        };
        self.skins.iter().map(pose).collect()
    }

    /// Extends the bounding box of each moving surface to contain the surface at all given times.
    pub(super) fn around(mut self, times: impl Iterator<Item = f64> + Clone) -> Self {
        for skin in self.skins.iter_mut().filter(|skin| skin.timeline.is_some()) {
            let boxes = times.clone().map(|time| skin.bounds_at(time));
            skin.bounds = boxes.reduce(|[a, b], [c, d]| [a.inf(&c), b.sup(&d)]).unwrap_or(skin.bounds);
        }
        self
    }

    /// Whether there are no surfaces to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.skins.is_empty()
    }

    /// Returns the corners of the bounding boxes of all surfaces that must be completely visible. The arguments are the
    /// corners of the displayed region without surfaces.
    pub(super) fn framed(&self, [lower, upper]: [Vector; 2]) -> Vec<Vector> {
        let room = REACH * (upper - lower).max();
        let is_near =
            |[low, high]: &[Vector; 2]| (0..3).all(|k| low[k] >= lower[k] - room && high[k] <= upper[k] + room);
        let near = self.skins.iter().map(|skin| skin.bounds).filter(is_near);
        near.flat_map(|[low, high]| super::render::corners(&low, &(high - low))).collect()
    }

    /// Memory for drawing the surfaces, without the pixels `[bytes]`.
    pub(super) fn image_bytes(&self) -> u64 {
        self.skins.iter().map(|skin| 24 * skin.vertices.len() as u64 + 28 * skin.triangles.len() as u64).sum()
    }
}

pub(super) fn read(file: &Path) -> Result<TriangleMesh, ViewError> {
    let content = fs::read(file).map_err(|source| ViewError::SurfaceFile { path: file.to_owned(), source })?;
    let extension = file.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let name = file.display().to_string();
    read_mesh(&name, extension, &content).map_err(|source| ViewError::Surface(Box::new(source)))
}
