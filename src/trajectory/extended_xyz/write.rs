use std::fmt::Display;
use std::io::{self, Write};

use super::WriteError;
use super::comment::is_mass;
use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::shortest::Shortest;
use crate::model::space::displacement_within_period;
use crate::model::{SpeciesId, Units};
use crate::trajectory::Frame;
use crate::trajectory::frame::FrameParticle;

/// The text is written in pieces of about this size `[bytes]`.
const PIECE: usize = 1 << 16;

/// Appends a frame to a trajectory. The output need not be buffered, and is not flushed.
///
/// # Errors
/// [`WriteError::Io`] if the output fails, or another [`WriteError`] if the frame could not be read back. If the box,
/// the species, the bonds or the scalars are rejected, nothing is written.
pub fn write_frame<W: Write>(output: W, frame: &Frame) -> Result<(), WriteError> {
    if !frame.images.is_empty() && frame.images.len() != frame.particles.len() {
        return Err(WriteError::Images);
    }
    let heading = Heading {
        count: frame.particles.len(),
        has_images: !frame.images.is_empty(),
        has_masses: frame.particles.iter().all(|particle| mass(frame, particle.species).is_some()),
        thickness: frame.thickness(),
    };
    let mut writer = FrameWriter::begin(output, frame, &heading)?;
    for (index, particle) in frame.particles.iter().enumerate() {
        writer.particle(particle, frame.images.get(index))?;
    }
    writer.end()
}

pub(crate) struct Heading {
    pub count: usize,
    pub has_images: bool,
    pub has_masses: bool,
    /// Extent of flat axes in the file.
    pub thickness: f64,
}

/// Writes a frame one particle at a time, which saves memory. The text is the same as from [`write_frame`].
pub(crate) struct FrameWriter<'a, W> {
    output: W,
    /// Source of all data except the particles.
    frame: &'a Frame,
    has_masses: bool,
    index: usize,
    text: Vec<u8>,
}

impl<'a, W: Write> FrameWriter<'a, W> {
    /// Starts a frame. The particles in `frame` are ignored. Returns the errors of [`write_frame`], except errors of
    /// particles.
    pub fn begin(output: W, frame: &'a Frame, heading: &Heading) -> Result<Self, WriteError> {
        refuse_species(frame)?;
        refuse_scalars(frame, heading.count)?;
        refuse_bonds(frame)?;
        let is_box_finite = frame.time.is_finite() && is_finite(&frame.lower) && is_finite(&frame.size);
        let is_displaced = frame.displacement != 0.0;
        let can_be_displaced = (0..2).all(|axis| frame.periodic[axis] && frame.size[axis] > 0.0)
            && displacement_within_period(frame.displacement, frame.size.x) == frame.displacement;
        if !frame.units.names().is_none_or(|names| names.into_iter().all(Units::is_name)) {
            return Err(WriteError::Units);
        }
        if !is_box_finite || frame.size.iter().any(|&edge| edge < 0.0) || (is_displaced && !can_be_displaced) {
            return Err(WriteError::Frame);
        }
        let mut text = Vec::with_capacity(PIECE + 1024);
        write_comment(&mut text, frame, heading)?;
        Ok(Self { output, frame, has_masses: heading.has_masses, index: 0, text })
    }

    /// Writes the next particle. Returns the errors of [`write_frame`] for a particle.
    pub fn particle(&mut self, particle: &FrameParticle, image: Option<&[i32; 3]>) -> Result<(), WriteError> {
        let (frame, text) = (self.frame, &mut self.text);
        let species = frame.species.get(particle.species.0 as usize).ok_or(WriteError::NoSpecies(particle.id))?;
        let is_radius = particle.radius.is_finite() && particle.radius >= 0.0;
        if !(is_radius && is_finite(&particle.position) && is_finite(&particle.velocity)) {
            return Err(WriteError::Particle(particle.id));
        }
        text.extend_from_slice(species.name.as_bytes());
        let mut put = |number: f64| {
            text.push(b' ');
            Shortest(number).push(text);
        };
        particle.position.iter().chain(particle.velocity.iter()).chain([&particle.radius]).for_each(|x| put(*x));
        put(particle.id.0.into());
        image.into_iter().flatten().for_each(|periods| put((*periods).into()));
        mass(frame, particle.species).filter(|_| self.has_masses).into_iter().for_each(&mut put);
        frame.scalars.iter().for_each(|scalar| put(scalar.values[self.index]));
        text.push(b'\n');
        self.index += 1;
        if text.len() > PIECE {
            self.output.write_all(text)?;
            text.clear();
        }
        Ok(())
    }

    pub fn end(mut self) -> Result<(), WriteError> {
        self.output.write_all(&self.text)?;
        Ok(())
    }
}

/// Mass of the particles of a species, if known. It is 0 for static species, so that sums stay finite.
fn mass(frame: &Frame, species: SpeciesId) -> Option<f64> {
    let mass = frame.species.get(species.0 as usize)?.mass?;
    Some(if mass.is_finite() { mass } else { 0.0 })
}

fn write_comment(text: &mut Vec<u8>, frame: &Frame, heading: &Heading) -> io::Result<()> {
    writeln!(text, "{}", heading.count)?;
    let lattice = (0..9).map(|entry| match (entry / 3, entry % 3) {
        (1, 0) => frame.displacement,
        (row, column) if row != column => 0.0,
        (row, _) if frame.is_flat(row) => heading.thickness,
        (row, _) => frame.size[row],
    });
    write_list(text, "Lattice", lattice.map(Shortest))?;
    write_list(text, " Origin", frame.lower.iter().copied().map(Shortest))?;
    text.extend_from_slice(b" Properties=type:S:1:pos:R:3:velo:R:3:radius:R:1:id:I:1");
    if heading.has_images {
        text.extend_from_slice(b":map_shift:I:3");
    }
    if heading.has_masses {
        text.extend_from_slice(b":masses:R:1");
    }
    for scalar in &frame.scalars {
        write!(text, ":{}:R:1", scalar.name)?;
    }
    write!(text, " Time={}", Shortest(frame.time))?;
    let word = |flag: bool| if flag { "T" } else { "F" };
    write_list(text, " pbc", frame.periodic.map(word))?;
    let flat = [0, 1, 2].map(|axis| frame.is_flat(axis));
    if flat.contains(&true) {
        write_list(text, " flat", flat.map(word))?;
    }
    if !frame.species.is_empty() {
        write_list(text, " species_table", frame.species.iter().map(|species| &species.name))?;
        write_list(text, " static", frame.species.iter().map(|species| word(species.is_static)))?;
        let masses: Option<Vec<_>> = frame.species.iter().map(|species| species.mass.map(Shortest)).collect();
        masses.map_or(Ok(()), |masses| write_list(text, " species_mass", masses))?;
    }
    for (index, [a, b]) in frame.bonds.iter().enumerate() {
        write!(text, "{}{}-{}", if index == 0 { " bonds=\"" } else { " " }, a.0, b.0)?;
    }
    if !frame.bonds.is_empty() {
        text.push(b'"');
    }
    if !frame.bond_kinds.is_empty() {
        write_list(text, " bond_table", &frame.bond_names)?;
    }
    // A single name needs no indices.
    if !frame.bond_kinds.is_empty() && frame.bond_names.len() > 1 {
        write_list(text, " bond_kind", &frame.bond_kinds)?;
    }
    if !frame.surfaces.is_empty() {
        write_list(text, " surfaces", frame.surfaces.iter().copied().map(word))?;
    }
    if let Some(names) = frame.units.names() {
        write_list(text, " units", names)?;
    }
    text.push(b'\n');
    Ok(())
}

fn write_list(text: &mut Vec<u8>, key: &str, values: impl IntoIterator<Item = impl Display>) -> io::Result<()> {
    write!(text, "{key}=\"")?;
    for (index, value) in values.into_iter().enumerate() {
        write!(text, "{}{value}", if index == 0 { "" } else { " " })?;
    }
    text.push(b'"');
    Ok(())
}

fn is_finite(vector: &Vector) -> bool {
    vector.iter().all(|x| x.is_finite())
}

fn refuse_scalars(frame: &Frame, count: usize) -> Result<(), WriteError> {
    for (index, Scalar { name, values }) in frame.scalars.iter().enumerate() {
        let is_new = frame.scalars[..index].iter().all(|other| other.name != *name);
        let is_whole = values.len() == count && values.iter().all(|value| value.is_finite());
        if !(Frame::is_name_of_scalar(name) && is_new && is_whole) {
            return Err(WriteError::Scalar(name.clone()));
        }
    }
    Ok(())
}

/// Whether a name can be stored in a list of names.
fn is_word(name: &str) -> bool {
    !name.is_empty() && !name.chars().any(|c| c.is_whitespace() || c.is_control() || matches!(c, '"' | '\\'))
}

fn refuse_bonds(frame: &Frame) -> Result<(), WriteError> {
    let (names, kinds) = (&frame.bond_names, &frame.bond_kinds);
    let is_known = kinds.len() == frame.bonds.len() && kinds.iter().all(|kind| (*kind as usize) < names.len());
    if !(kinds.is_empty() || is_known) || !names.iter().all(|name| is_word(name)) {
        return Err(WriteError::Bonds);
    }
    Ok(())
}

fn refuse_species(frame: &Frame) -> Result<(), WriteError> {
    let mut names: Vec<&str> = frame.species.iter().map(|species| species.name.as_str()).collect();
    if let Some(name) = names.iter().find(|name| !is_word(name)) {
        return Err(WriteError::SpeciesName((*name).to_owned()));
    }
    if let Some(species) = frame.species.iter().find(|species| species.mass.is_some_and(|mass| !is_mass(&mass))) {
        return Err(WriteError::Mass(species.name.clone()));
    }
    names.sort_unstable();
    match names.windows(2).find(|two| two[0] == two[1]) {
        Some(two) => Err(WriteError::SpeciesName(two[0].to_owned())),
        None => Ok(()),
    }
}
