//! A trajectory in the format GSD 2.0 with the schema `hoomd` 1.4, for HOOMD-blue, OVITO and MDAnalysis.
//!
//! | chunk | content |
//! |---|---|
//! | `configuration/step` | index of the frame in the trajectory, from 0 |
//! | `configuration/dimensions`, `configuration/box` | edges and tilt factors of the box. The tilt factor is `xy = d / Ly` if the next image along y is displaced by `d`. A box with z as its only flat axis has 2 dimensions and no extent along z. The edge along other flat axes is the largest diameter. |
//! | `particles/N`, `types`, `typeid`, `diameter`, `position`, `velocity` | particles in the order of ids; velocities only if the source has velocities |
//! | `particles/mass` | only if the source has the masses of all species; 0 for static particles, whose mass is infinite |
//! | `particles/image` | periods travelled, `i32`, only if the source has images |
//! | `bonds/N`, `types`, `typeid`, `group` | a type is the name of an interaction, or `bond` if there are no names; a group is the indices of two particles |
//! | `log/carom/time` | simulated time, `f64` |
//! | `log/particles/q6` and others | scalars of the particles, `f64` |
//! | `log/carom/centre`, `log/carom/periodic` | centre of the box, `f64`, and whether each axis is periodic |
//! | `log/carom/units` | names of the units of length, mass and time, like `particles/types`, only if the scene gives names |
//!
//! Numbers are `f32` unless noted otherwise. Positions are relative to the centre of the box, because HOOMD's box is
//! centred at the origin. In a tilted box, periods along x are added to move each particle inside. HOOMD's box is
//! always periodic, so particles may be outside the box along axes that are not periodic in the run. A chunk that
//! is equal in the first frame is not repeated.
//!
//! Sources: GSD file layer, version 2, and schema `hoomd`, version 1.4, as documented at <https://gsd.readthedocs.io>.

mod chunks;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use super::convert::{Draft, FrameError, Moment, Writer, bond_ends};
use crate::Vector;
use crate::base::numbers::{single, trunc_to_i32};
use crate::trajectory::Frame;
use chunks::{Chunks, Kind};

#[derive(Debug)]
pub(super) struct Trajectory {
    chunks: Chunks,
    /// Chunks of the first frame. Later frames contain only different chunks.
    first: Vec<(&'static str, Vec<u8>)>,
    /// True after a frame with velocities. Later frames need velocities, or they would inherit the first ones.
    has_velocities: bool,
    /// True after a frame with images. Later frames then need images.
    has_images: bool,
}

impl Trajectory {
    pub fn new(file: Draft) -> Self {
        Self { chunks: Chunks::new(file), first: Vec::new(), has_velocities: false, has_images: false }
    }

    fn lasting(&mut self, name: &'static str, kind: Kind, columns: u32, bytes: Vec<u8>) -> Result<(), FrameError> {
        let first = self.first.iter().find(|(known, _)| *known == name);
        if first.is_some_and(|(_, first)| *first == bytes) {
            return Ok(());
        }
        self.chunks.write(name, kind, columns, &bytes)?;
        if self.chunks.frame() == 0 {
            self.first.push((name, bytes));
        }
        Ok(())
    }

    fn configuration(&mut self, index: u64, frame: &Frame, centre: &Vector) -> Result<(), FrameError> {
        let is_plane = frame.is_flat(2) && !frame.is_flat(0) && !frame.is_flat(1);
        let (lower, upper) = frame.thickened();
        let mut edges = upper - lower;
        if is_plane {
            edges.z = 0.0;
        }
        let tilts = [if frame.displacement == 0.0 { 0.0 } else { frame.displacement / frame.size.y }, 0.0, 0.0];
        let lengths_and_tilts = edges.iter().chain(&tilts);
        self.chunks.write("configuration/step", Kind::Uint64, 1, &index.to_le_bytes())?;
        self.lasting("configuration/dimensions", Kind::Uint8, 1, vec![if is_plane { 2 } else { 3 }])?;
        self.lasting("configuration/box", Kind::Float, 1, singles(lengths_and_tilts)?)?;
        self.chunks.write("log/carom/time", Kind::Double, 1, &frame.time.to_le_bytes())?;
        let centre = centre.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.lasting("log/carom/centre", Kind::Double, 1, centre)?;
        if let Some(names) = frame.units.names() {
            let (names, width) = padded_words(&names)?;
            self.lasting("log/carom/units", Kind::Int8, width, names)?;
        }
        self.lasting("log/carom/periodic", Kind::Uint8, 1, frame.periodic.map(u8::from).to_vec())
    }

    fn particles(&mut self, frame: &Frame, centre: &Vector, has_velocities: bool) -> Result<(), FrameError> {
        let particles = &frame.particles;
        self.lasting("particles/N", Kind::Uint32, 1, count(particles.len())?.to_le_bytes().to_vec())?;
        let names: Vec<&str> = frame.species.iter().map(|species| species.name.as_str()).collect();
        let (types, width) = padded_words(&names)?;
        self.lasting("particles/types", Kind::Int8, width, types)?;
        let species = particles.iter().flat_map(|particle| particle.species.0.to_le_bytes()).collect();
        self.lasting("particles/typeid", Kind::Uint32, 1, species)?;
        let diameters: Vec<f64> = particles.iter().map(|particle| 2.0 * particle.radius).collect();
        self.lasting("particles/diameter", Kind::Float, 1, singles(&diameters)?)?;
        if let Some(masses) = frame.masses() {
            self.lasting("particles/mass", Kind::Float, 1, singles(&masses)?)?;
        }
        let (shifted, periods): (Vec<Vector>, Vec<f64>) =
            particles.iter().map(|particle| tilted(frame, particle.position - centre)).unzip();
        let numbers = shifted.iter().flat_map(|position| position.iter());
        self.chunks.write("particles/position", Kind::Float, 3, &singles(numbers)?)?;
        self.has_images |= !frame.images.is_empty();
        if self.has_images {
            let none = [0; 3];
            let images = (0..particles.len()).map(|place| *frame.images.get(place).unwrap_or(&none));
            let mut bytes = Vec::with_capacity(12 * particles.len());
            for ([x, y, z], periods) in images.zip(periods) {
                let image = [travelled(x, periods)?, y, z];
                bytes.extend(image.into_iter().flat_map(i32::to_le_bytes));
            }
            self.chunks.write("particles/image", Kind::Int32, 3, &bytes)?;
        }
        self.has_velocities |= has_velocities;
        if self.has_velocities {
            let velocities = singles(particles.iter().flat_map(|particle| particle.velocity.iter()))?;
            self.chunks.write("particles/velocity", Kind::Float, 3, &velocities)?;
        }
        for scalar in &frame.scalars {
            let bytes: Vec<u8> = scalar.values.iter().flat_map(|value| value.to_le_bytes()).collect();
            self.chunks.write(format!("log/particles/{}", scalar.name), Kind::Double, 1, &bytes)?;
        }
        Ok(())
    }

    fn bonds(&mut self, frame: &Frame) -> Result<(), FrameError> {
        let ends = bond_ends(frame)?;
        let has_had_bonds = self.first.iter().any(|(name, _)| *name == "bonds/N");
        if ends.is_empty() && !has_had_bonds {
            return Ok(());
        }
        self.lasting("bonds/N", Kind::Uint32, 1, count(ends.len())?.to_le_bytes().to_vec())?;
        let names: Vec<&str> = frame.bond_names.iter().map(String::as_str).collect();
        let (types, width) = padded_words(if frame.bond_kinds.is_empty() { &["bond"] } else { &names })?;
        self.lasting("bonds/types", Kind::Int8, width, types)?;
        if !frame.bond_kinds.is_empty() {
            let kinds = frame.bond_kinds.iter().flat_map(|kind| kind.to_le_bytes()).collect();
            self.lasting("bonds/typeid", Kind::Uint32, 1, kinds)?;
        }
        let group = ends.iter().flatten().flat_map(|end| end.to_le_bytes()).collect();
        self.lasting("bonds/group", Kind::Uint32, 2, group)
    }
}

impl Writer for Trajectory {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError> {
        let frame = in_order_of_ids(moment.frame);
        let centre = frame.lower + 0.5 * frame.size;
        self.configuration(moment.index, &frame, &centre)?;
        self.particles(&frame, &centre, moment.has_velocities)?;
        self.bonds(&frame)?;
        self.chunks.end_frame();
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FrameError> {
        Ok(self.chunks.finish()?)
    }
}

/// Moves a position relative to the centre into HOOMD's tilted box. Also returns the periods subtracted along x.
fn tilted(frame: &Frame, position: Vector) -> (Vector, f64) {
    if frame.displacement == 0.0 {
        return (position, 0.0);
    }
    let middle = frame.displacement * (position.y / frame.size.y);
    let periods = ((position.x - middle) / frame.size.x).round();
    (Vector::new(position.x - periods * frame.size.x, position.y, position.z), periods)
}

/// Returns the image number along x after `periods` have been subtracted from the position.
fn travelled(image: i32, periods: f64) -> Result<i32, FrameError> {
    let sum = f64::from(image) + periods;
    if !(f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&sum) {
        return Err(FrameError::BeyondPeriods(sum));
    }
    Ok(trunc_to_i32(sum))
}

/// GSD identifies a particle by its index.
fn in_order_of_ids(frame: &Frame) -> Cow<'_, Frame> {
    if frame.particles.is_sorted_by_key(|particle| particle.id) {
        return Cow::Borrowed(frame);
    }
    let mut sorted = frame.clone();
    let mut order: Vec<usize> = (0..frame.particles.len()).collect();
    order.sort_by_key(|&place| frame.particles[place].id);
    sorted.particles = order.iter().map(|&place| frame.particles[place]).collect();
    if !frame.images.is_empty() {
        sorted.images = order.iter().map(|&place| frame.images[place]).collect();
    }
    for (scalar, source) in sorted.scalars.iter_mut().zip(&frame.scalars) {
        scalar.values = order.iter().map(|&place| source.values[place]).collect();
    }
    Cow::Owned(sorted)
}

fn count(number: usize) -> Result<u32, FrameError> {
    u32::try_from(number).map_err(|_| FrameError::TooMany(number))
}

fn singles<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Result<Vec<u8>, FrameError> {
    let mut bytes = Vec::new();
    for &number in numbers {
        let single = single(number);
        if !single.is_finite() {
            return Err(FrameError::BeyondSingle(number));
        }
        bytes.extend_from_slice(&single.to_le_bytes());
    }
    Ok(bytes)
}

/// Returns the names of types with equal width, padded with zeros. Each name ends with at least one zero.
fn padded_words(names: &[&str]) -> Result<(Vec<u8>, u32), FrameError> {
    let width = names.iter().map(|name| name.len()).max().unwrap_or(0) + 1;
    let mut bytes = Vec::new();
    for name in names {
        bytes.extend_from_slice(name.as_bytes());
        bytes.resize(bytes.len() + width - name.len(), 0);
    }
    Ok((bytes, count(width)?))
}
