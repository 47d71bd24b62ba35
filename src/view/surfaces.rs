//! Surfaces that are drawn with the particles: meshes of triangles with the normals of the round shapes that they stand for.

mod skin;

use std::borrow::Cow;
use std::fs;
use std::path::Path;

pub(super) use skin::Skin;

use super::ViewError;
use crate::Vector;
use crate::io::{surface_files, surface_motions};
use crate::mesh::read_mesh;
use crate::model::TriangleMesh;
use crate::model::surface_motion::Timeline;

/// How far a surface may reach beyond the particles and the box and still be framed as a whole, relative to the longest edge of what holds these. Larger ones
/// run out of the picture, so that particles stay large in it.
const REACH: f64 = 0.5;

/// Surfaces to draw.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surfaces {
    pub(super) skins: Vec<Skin>,
}

impl Surfaces {
    /// Some meshes.
    #[must_use]
    pub fn of<'m>(meshes: impl IntoIterator<Item = &'m TriangleMesh>) -> Self {
        Self { skins: meshes.into_iter().map(Skin::of).filter(|skin| !skin.triangles.is_empty()).collect() }
    }

    /// The surfaces that a run wrote beside its trajectory; none where there are no such files.
    ///
    /// # Errors
    /// [`ViewError::SurfaceFile`] or [`ViewError::Surface`] if one of them cannot be read.
    pub fn beside(trajectory: &Path) -> Result<Self, ViewError> {
        let folder = trajectory.parent().unwrap_or(Path::new(""));
        let motions = surface_motions(folder).map_err(|(path, source)| ViewError::SurfaceFile { path, source })?;
        let mut surfaces = Self::default();
        for file in surface_files(folder) {
            let mut skin = Skin::of(&read(&file)?);
            let name = file.file_name().unwrap_or_default().display().to_string();
            skin.timeline = motions.get(&name).map(|motions| Timeline::of(motions));
            if !skin.triangles.is_empty() {
                surfaces.skins.push(skin);
            }
        }
        Ok(surfaces)
    }

    /// The surfaces where they are at a time.
    pub(super) fn at(&self, time: f64) -> Cow<'_, Self> {
        if self.skins.iter().all(|skin| skin.timeline.is_none()) {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Self { skins: self.skins.iter().map(|skin| skin.at(time)).collect() })
    }

    /// Whether there is nothing to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.skins.is_empty()
    }

    /// Corners of the boxes around those that are framed as a whole, given the lower and upper corner of what else is framed.
    pub(super) fn framed(&self, [lower, upper]: [Vector; 2]) -> Vec<Vector> {
        let room = REACH * (upper - lower).max();
        let is_near =
            |[low, high]: &[Vector; 2]| (0..3).all(|k| low[k] >= lower[k] - room && high[k] <= upper[k] + room);
        let near = self.skins.iter().map(|skin| skin.bounds).filter(is_near);
        near.flat_map(|[low, high]| super::render::corners(&low, &(high - low))).collect()
    }

    /// Memory of an image for them, besides that of its pixels `[bytes]`.
    pub(super) fn image_bytes(&self) -> u64 {
        self.skins.iter().map(|skin| 24 * skin.vertices.len() as u64 + 28 * skin.triangles.len() as u64).sum()
    }
}

/// Reads a mesh.
pub(super) fn read(file: &Path) -> Result<TriangleMesh, ViewError> {
    let content = fs::read(file).map_err(|source| ViewError::SurfaceFile { path: file.to_owned(), source })?;
    let extension = file.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let name = file.display().to_string();
    read_mesh(&name, extension, &content).map_err(|source| ViewError::Surface(Box::new(source)))
}
