//! A trajectory as a folder of NumPy arrays.
//!
//! | file | shape | content |
//! |---|---|---|
//! | `times.npy` | frames | simulated time |
//! | `positions.npy`, `velocities.npy` | frames x N x 3 | no velocities if the source has none |
//! | `images.npy` | frames x N x 3 | periods travelled, `i32`; no file if the source has none |
//! | `box.npy` | frames x 2 x 3 | lower corner and edges; an edge is 0 along flat axes |
//! | `displacements.npy` | frames | displacement along x of the next image along y |
//! | `periodic.npy` | 3 | whether each axis is periodic |
//! | `ids.npy`, `radius.npy` | N | ids and radii of the particles |
//! | `species.npy` | N | index of the species in the arrays of species |
//! | `species_names.npy`, `species_static.npy` | species | name, and whether the species never moves |
//! | `species_mass.npy` | species | infinite for static species; no file if a mass is unknown |
//! | `units.npy` | 3 | names of the units of length, mass and time; no file if the scene gives no names |
//! | `q6.npy` and others | frames x N | scalars of the particles |
//! | `bonds.npy` | bonds x 2 | ids of the bonded particles; no file without bonds |
//! | `bond_names.npy`, `bond_kinds.npy` | interactions, bonds | names of the interactions of bonds, and the index of a name for each bond |
//!
//! The unwrapped position is the position plus the image times the edges of the box. In a sheared box, add the image
//! along y times the displacement to x. Numbers are `f64`, ids and indices are `u32`, all little-endian. All frames
//! must have the same particles in the same order.

pub(super) mod array;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use super::convert::{FrameError, Moment, Writer};
use crate::analysis::instruments::Scalar;
use crate::trajectory::Frame;
use array::Array;

#[derive(Debug)]
pub(super) struct Arrays {
    folder: PathBuf,
    growing: Option<Growing>,
}

#[derive(Debug)]
struct Growing {
    first: Frame,
    times: Array,
    boxes: Array,
    displacements: Array,
    positions: Array,
    velocities: Option<Array>,
    images: Option<Array>,
    scalars: Vec<Array>,
}

impl Arrays {
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), growing: None }
    }

    /// Creates the arrays, and writes the data common to all frames.
    fn start(&self, frame: &Frame, has_velocities: bool) -> Result<Growing, FrameError> {
        let file = |name: &str| self.folder.join(name);
        let all = &frame.particles;
        Array::whole(&file("ids.npy"), "<u4", all.len(), &[], all.iter().flat_map(|p| p.id.0.to_le_bytes()))?;
        let species = all.iter().flat_map(|p| p.species.0.to_le_bytes());
        Array::whole(&file("species.npy"), "<u4", all.len(), &[], species)?;
        Array::whole(&file("radius.npy"), "<f8", all.len(), &[], all.iter().flat_map(|p| p.radius.to_le_bytes()))?;
        Array::whole(&file("periodic.npy"), "|b1", 3, &[], frame.periodic.map(u8::from))?;
        let is_static = frame.species.iter().map(|species| u8::from(species.is_static));
        Array::whole(&file("species_static.npy"), "|b1", frame.species.len(), &[], is_static)?;
        let names: Vec<&str> = frame.species.iter().map(|species| species.name.as_str()).collect();
        Array::words(&file("species_names.npy"), &names)?;
        if let Some(names) = frame.units.names() {
            Array::words(&file("units.npy"), &names)?;
        }
        let masses: Option<Vec<f64>> = frame.species.iter().map(|species| species.mass).collect();
        if let Some(masses) = masses {
            let bytes = masses.iter().flat_map(|mass| mass.to_le_bytes());
            Array::whole(&file("species_mass.npy"), "<f8", masses.len(), &[], bytes)?;
        }
        if !frame.bonds.is_empty() {
            let ends = frame.bonds.iter().flatten().flat_map(|id| id.0.to_le_bytes());
            Array::whole(&file("bonds.npy"), "<u4", frame.bonds.len(), &[2], ends)?;
        }
        if !frame.bond_kinds.is_empty() {
            let names: Vec<&str> = frame.bond_names.iter().map(String::as_str).collect();
            Array::words(&file("bond_names.npy"), &names)?;
            let kinds = frame.bond_kinds.iter().flat_map(|kind| kind.to_le_bytes());
            Array::whole(&file("bond_kinds.npy"), "<u4", frame.bond_kinds.len(), &[], kinds)?;
        }
        let scalars = |scalar: &Scalar| Array::create(&file(&format!("{}.npy", scalar.name)), "<f8", &[all.len()]);
        let vectors = |name: &str| Array::create(&file(name), "<f8", &[all.len(), 3]);
        let has_images = !frame.images.is_empty();
        Ok(Growing {
            times: Array::create(&file("times.npy"), "<f8", &[])?,
            boxes: Array::create(&file("box.npy"), "<f8", &[2, 3])?,
            displacements: Array::create(&file("displacements.npy"), "<f8", &[])?,
            positions: vectors("positions.npy")?,
            velocities: has_velocities.then(|| vectors("velocities.npy")).transpose()?,
            images: has_images.then(|| Array::create(&file("images.npy"), "<i4", &[all.len(), 3])).transpose()?,
            scalars: frame.scalars.iter().map(scalars).collect::<Result<_, _>>()?,
            first: frame.clone(),
        })
    }
}

impl Growing {
    fn add(&mut self, frame: &Frame) -> Result<(), FrameError> {
        self.times.add(frame.time.to_le_bytes())?;
        self.boxes.add(frame.lower.iter().chain(&frame.size).flat_map(|x| x.to_le_bytes()))?;
        self.displacements.add(frame.displacement.to_le_bytes())?;
        self.positions.add(frame.particles.iter().flat_map(|p| p.position.iter()).flat_map(|x| x.to_le_bytes()))?;
        if let Some(velocities) = &mut self.velocities {
            velocities.add(frame.particles.iter().flat_map(|p| p.velocity.iter()).flat_map(|v| v.to_le_bytes()))?;
        }
        if let Some(images) = &mut self.images {
            images.add(frame.images.iter().flatten().flat_map(|image| image.to_le_bytes()))?;
        }
        for (array, scalar) in self.scalars.iter_mut().zip(&frame.scalars) {
            array.add(scalar.values.iter().flat_map(|value| value.to_le_bytes()))?;
        }
        Ok(())
    }

    fn refuse_others(&self, frame: &Frame, has_velocities: bool) -> Result<(), FrameError> {
        let first = &self.first;
        let is_same =
            |same: fn(&crate::trajectory::frame::FrameParticle, &crate::trajectory::frame::FrameParticle) -> bool| {
                first.particles.iter().zip(&frame.particles).all(|(a, b)| same(a, b))
            };
        let faults = [
            (first.particles.len() != frame.particles.len(), "particles"),
            (!is_same(|a, b| a.id == b.id), "ids"),
            (first.species != frame.species || !is_same(|a, b| a.species == b.species), "species"),
            (!is_same(|a, b| a.radius == b.radius), "radii"),
            (first.bonds != frame.bonds || first.bond_kinds != frame.bond_kinds, "bonds"),
            (first.periodic != frame.periodic, "periodic axes"),
            (!first.scalars.iter().map(|s| &s.name).eq(frame.scalars.iter().map(|s| &s.name)), "scalars"),
            (self.images.is_some() == frame.images.is_empty(), "columns (with or without images)"),
            (self.velocities.is_some() != has_velocities, "columns (with or without velocities)"),
        ];
        match faults.into_iter().find(|(is_fault, _)| *is_fault) {
            Some((_, what)) => Err(FrameError::OtherParticles(what)),
            None => Ok(()),
        }
    }
}

impl Writer for Arrays {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError> {
        let mut growing = match self.growing.take() {
            Some(growing) => {
                growing.refuse_others(moment.frame, moment.has_velocities)?;
                growing
            }
            None => self.start(moment.frame, moment.has_velocities)?,
        };
        growing.add(moment.frame)?;
        self.growing = Some(growing);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FrameError> {
        if let Some(growing) = self.growing {
            let Growing { times, boxes, displacements, positions, velocities, images, scalars, .. } = growing;
            let always = [times, boxes, displacements, positions];
            for array in always.into_iter().chain(velocities).chain(images).chain(scalars) {
                array.finish()?;
            }
        }
        Ok(())
    }
}
