//! Writes the surfaces of a trajectory as triangles in VTK PolyData files.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::poly_data::PolyData;
use crate::io::convert::{Draft, FrameError, finish};
use crate::io::number::Cell;
use crate::io::surfaces::{listed_surfaces, surface_files};
use crate::mesh::read_mesh;
use crate::model::TriangleMesh;
use crate::model::surface_motion::Timeline;
use crate::trajectory::Frame;

#[derive(Debug)]
struct Placed {
    /// Name of the VTK files without frame number and extension.
    name: String,
    mesh: TriangleMesh,
    number: Option<usize>,
    timeline: Option<Timeline>,
    is_written: bool,
}

#[derive(Debug, Default)]
pub(in crate::io) struct Surfaces {
    all: Vec<Placed>,
    list: Option<Draft>,
}

impl Surfaces {
    /// Reads the surfaces beside a trajectory. An error has the path of a file and the problem.
    pub fn beside(trajectory: &Path) -> Result<Self, (PathBuf, String)> {
        let folder = trajectory.parent().unwrap_or(Path::new(""));
        let list = listed_surfaces(folder).map_err(|(path, error)| (path, error.to_string()))?;
        let placed = |(index, file): (usize, PathBuf)| {
            let content = fs::read(&file).map_err(|error| (file.clone(), error.to_string()))?;
            let mesh = read_mesh("", "stl", &content).map_err(|error| (file.clone(), error.problem.to_string()))?;
            let name = file.file_name().unwrap_or_default().display().to_string();
            let number = list.iter().position(|listed| listed.file == name);
            let motions = number.and_then(|number| list.get(number)).map_or(&[][..], |listed| &listed.motions);
            let timeline = (!motions.is_empty()).then(|| Timeline::of(motions));
            let stem: String = file.file_stem().unwrap_or_default().to_string_lossy().chars().map(plain).collect();
            Ok(Placed { name: format!("surface_{index}_{stem}"), mesh, number, timeline, is_written: false })
        };
        let all = surface_files(folder).into_iter().enumerate().map(placed).collect::<Result<_, _>>()?;
        Ok(Self { all, list: None })
    }

    /// A surface at rest has one file for all frames.
    pub fn write(&mut self, folder: &Path, index: u64, frame: &Frame) -> Result<(), FrameError> {
        if self.all.is_empty() {
            return Ok(());
        }
        let mut list = match self.list.take() {
            Some(list) => list,
            None => super::list(&folder.join("surfaces.pvd"))?,
        };
        let time = Cell(Some(frame.time));
        for (part, surface) in self.all.iter_mut().enumerate() {
            let is_there = surface.number.and_then(|number| frame.surfaces.get(number)).copied().unwrap_or(true);
            if !is_there {
                continue;
            }
            let moved = surface.timeline.as_ref().map(|timeline| timeline.at(frame.time).pose);
            let name = match moved {
                Some(_) => format!("{}_{index:06}.vtp", surface.name),
                None => format!("{}.vtp", surface.name),
            };
            if moved.is_some() || !surface.is_written {
                let places: Vec<_> = surface
                    .mesh
                    .vertices
                    .iter()
                    .map(|vertex| moved.map_or(*vertex, |pose| pose.place(vertex)))
                    .collect();
                let mut data = PolyData::default();
                data.points(places.iter());
                data.triangles(&surface.mesh.triangles);
                data.write(&folder.join(&name))?;
                surface.is_written = true;
            }
            writeln!(list, "<DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" file=\"{name}\"/>")?;
        }
        self.list = Some(list);
        Ok(())
    }

    pub fn finish(self) -> Result<(), FrameError> {
        match self.list {
            Some(mut list) => {
                list.write_all(super::END_OF_LIST)?;
                Ok(finish(list)?)
            }
            None => Ok(()),
        }
    }
}

/// Replaces a character that some file systems or the PVD format do not permit by `_`.
fn plain(letter: char) -> char {
    if letter.is_ascii_alphanumeric() || "_-+.".contains(letter) { letter } else { '_' }
}
