//! A trajectory as a folder of VTK XML PolyData files, for ParaView and PyVista:
//!
//! - `trajectory.pvd` lists the frames with their times. Open this file.
//! - `frame_000000.vtp` and so on are the frames, numbered as in the trajectory.
//! - `surface_0_NAME.vtp` and so on are surfaces as triangles. A moving surface has a file for each frame.
//! - `surfaces.pvd` lists the surfaces that are present in each frame.
//! - `box.vtp` contains the edges of the first frame's box as lines.
//!
//! A frame has a vertex per particle and a line per bond. A bond through a periodic side is not drawn, because its line
//! would cross the whole box. The arrays of the particles are `radius`, `species` (an index), `id`, `static` (1 for
//! static particles) and the scalars. `velocity` and `image` are added if the source has them. `image` is the number of
//! periods travelled along each axis. The unwrapped position is the position plus the image times the edges of the box.
//! In a sheared box, the image along y times the displacement is added along x.
//!
//! The fields are `TimeValue`, `box` (lower and upper corner), `displacement`, `periodic` and `species_names`.
//!
//! Numbers are `f64`, little-endian, appended raw. Source: *VTK file formats*, XML, <https://docs.vtk.org>.

mod poly_data;
mod surfaces;
#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::{Path, PathBuf};

use super::convert::{Draft, FrameError, Moment, Writer, bond_ends, draft, finish};
use super::number::Cell;
use crate::trajectory::Frame;
use poly_data::PolyData;
pub(super) use surfaces::Surfaces;

#[derive(Debug)]
pub(super) struct Series {
    folder: PathBuf,
    list: Option<Draft>,
    surfaces: Surfaces,
}

const END_OF_LIST: &[u8] = b"</Collection>\n</VTKFile>\n";

/// Begins a PVD file, which lists files with their times.
fn list(path: &Path) -> std::io::Result<Draft> {
    let mut list = draft(path)?;
    list.write_all(
        b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    )?;
    Ok(list)
}

impl Series {
    pub fn new(folder: &Path, surfaces: Surfaces) -> Self {
        Self { folder: folder.to_owned(), list: None, surfaces }
    }

    fn start(&self, frame: &Frame) -> Result<Draft, FrameError> {
        outline(frame).write(&self.folder.join("box.vtp"))?;
        Ok(list(&self.folder.join("trajectory.pvd"))?)
    }
}

impl Writer for Series {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError> {
        let mut list = match self.list.take() {
            Some(list) => list,
            None => self.start(moment.frame)?,
        };
        let name = format!("frame_{:06}.vtp", moment.index);
        particles(moment)?.write(&self.folder.join(&name))?;
        let time = Cell(Some(moment.frame.time));
        writeln!(list, "<DataSet timestep=\"{time}\" group=\"\" part=\"0\" file=\"{name}\"/>")?;
        self.list = Some(list);
        self.surfaces.write(&self.folder, moment.index, moment.frame)
    }

    fn finish(self: Box<Self>) -> Result<(), FrameError> {
        if let Some(mut list) = self.list {
            list.write_all(END_OF_LIST)?;
            finish(list)?;
        }
        self.surfaces.finish()
    }
}

fn particles(moment: &Moment) -> Result<PolyData, FrameError> {
    let Moment { frame, has_velocities, .. } = *moment;
    let mut data = PolyData::default();
    data.field("TimeValue", 1, [frame.time]);
    let upper = frame.lower + frame.size;
    data.field("box", 3, frame.lower.iter().chain(&upper).copied());
    data.field("displacement", 1, [frame.displacement]);
    data.byte_field("periodic", frame.periodic.map(u8::from));
    data.words("species_names", frame.species.iter().map(|species| species.name.as_str()));
    if let Some(names) = frame.units.names() {
        data.words("units", names.into_iter());
    }
    let all = &frame.particles;
    data.points(all.iter().map(|particle| &particle.position));
    data.vertices();
    data.point_array("radius", "Float64", 1, all.iter().flat_map(|particle| particle.radius.to_le_bytes()));
    if has_velocities {
        let velocities = all.iter().flat_map(|particle| particle.velocity.iter());
        data.point_array("velocity", "Float64", 3, velocities.flat_map(|v| v.to_le_bytes()));
    }
    if !frame.images.is_empty() {
        data.point_array("image", "Int32", 3, frame.images.iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    data.point_array("species", "UInt32", 1, all.iter().flat_map(|particle| particle.species.0.to_le_bytes()));
    data.point_array("id", "UInt32", 1, all.iter().flat_map(|particle| particle.id.0.to_le_bytes()));
    data.point_array("static", "UInt8", 1, all.iter().map(|particle| u8::from(frame.is_static(particle))));
    for scalar in &frame.scalars {
        data.point_array(&scalar.name, "Float64", 1, scalar.values.iter().flat_map(|value| value.to_le_bytes()));
    }
    let mut ends = bond_ends(frame)?;
    ends.retain(|&ends| !leaves_through_a_side(frame, ends));
    data.lines(&ends);
    Ok(data)
}

fn leaves_through_a_side(frame: &Frame, ends: [u32; 2]) -> bool {
    let [Some(a), Some(b)] = ends.map(|end| frame.particles.get(end as usize)) else { return true };
    let separation = a.position - b.position;
    (0..3).any(|axis| frame.periodic[axis] && 2.0 * separation[axis].abs() > frame.size[axis])
}

fn outline(frame: &Frame) -> PolyData {
    let corners: Vec<_> = (0..8_u32)
        .map(|corner| {
            let is_upper = |axis: usize| if corner >> axis & 1 == 1 { frame.size[axis] } else { 0.0 };
            frame.lower + crate::Vector::new(is_upper(0), is_upper(1), is_upper(2))
        })
        .collect();
    // An edge of the box joins two corners that differ in one coordinate.
    let edges: Vec<[u32; 2]> =
        (0..8_u32).flat_map(|corner| [1, 2, 4].map(|axis| [corner, corner | axis])).filter(|[a, b]| a != b).collect();
    let mut data = PolyData::default();
    data.points(corners.iter());
    data.lines(&edges);
    data
}
