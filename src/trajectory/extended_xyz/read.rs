//! Text to frames.

use std::collections::HashMap;
use std::io::{BufRead, Read};

use super::comment::{Columns, Comment, finite};
use super::error::shorten;
use super::{LONGEST_LINE, ReadError};
use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::numbers::id;
use crate::model::{ParticleId, SpeciesId};
use crate::trajectory::Frame;
use crate::trajectory::frame::{FrameParticle, FrameSpecies};

/// Radius of particles in files that give none `[length]`: a diameter of 1 in reduced units.
const DEFAULT_RADIUS: f64 = 0.5;

/// The most particles that memory is set aside for before they have been seen.
const TRUSTED_COUNT: usize = 1 << 16;

/// Properties of a frame that stand before its particles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Preamble {
    /// Number of particles.
    pub count: usize,
    /// Simulated time `[time]`.
    pub time: f64,
    /// Lower corner and edges of the box, if it is given `[length]`.
    pub region: Option<(Vector, Vector)>,
}

/// Reader of extended XYZ: an iterator over the frames of a trajectory. Ends after the first error.
///
/// Where a file does not say: velocities are zero, radii 1/2, ids count from 0 in the order of the lines, the time is
/// 0, images are not known, and the box is the smallest that holds the spheres, not periodic. Columns of one real number that mean nothing here are kept
/// as scalars, if all their numbers are finite.
#[derive(Debug)]
pub struct FrameReader<R> {
    input: R,
    line: usize,
    text: Vec<u8>,
    /// Where the frame read last begins.
    frame_line: usize,
    has_velocities: bool,
    has_species: bool,
    has_radii: bool,
    has_box: bool,
    is_finished: bool,
    beside: Beside,
}

/// Columns of a file that are not part of a frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Beside {
    /// Momenta of the particles of a frame without velocities; else empty `[mass length / time]`.
    pub momenta: Vec<Vector>,
    /// The mass of each particle, if it has a column and no table of them; 0 for what never moves `[mass]`.
    pub masses: Vec<f64>,
    /// Names of columns that mean nothing here.
    pub unused: Vec<String>,
}

impl<R: BufRead> FrameReader<R> {
    /// Reads from the beginning of a frame.
    pub fn new(input: R) -> Self {
        Self::behind(input, 0)
    }

    /// Reads from the beginning of a frame behind so many lines.
    pub(crate) fn behind(input: R, lines: usize) -> Self {
        Self {
            input,
            line: lines,
            text: Vec::new(),
            frame_line: 0,
            has_velocities: false,
            has_species: false,
            has_radii: false,
            has_box: false,
            is_finished: false,
            beside: Beside::default(),
        }
    }

    /// Whether the frame read last came with velocities.
    #[must_use]
    pub fn has_velocities(&self) -> bool {
        self.has_velocities
    }

    /// Whether the frame read last came with the species of its particles.
    #[must_use]
    pub fn has_species(&self) -> bool {
        self.has_species
    }

    /// Whether the frame read last came with the radii of its particles.
    #[must_use]
    pub fn has_radii(&self) -> bool {
        self.has_radii
    }

    /// Whether the frame read last came with its box.
    #[must_use]
    pub fn has_box(&self) -> bool {
        self.has_box
    }

    /// Further columns of the frame read last.
    pub(crate) fn beside(&mut self) -> Beside {
        std::mem::take(&mut self.beside)
    }

    /// The line on which the frame read last begins, from 1; its comment is on the next one.
    #[must_use]
    pub fn frame_line(&self) -> usize {
        self.frame_line
    }

    /// Passes over the next frame without reading its numbers; false where nothing but blank lines is left.
    ///
    /// # Errors
    /// As for frames that are read, but for what their lines say.
    pub fn skip_frame(&mut self) -> Result<bool, ReadError> {
        let Some(count) = self.next_count()? else { return Ok(false) };
        let first = self.line;
        for found in 0..=count {
            if self.next_line()?.is_none() {
                return Err(ReadError::Truncated { line: first, expected: count, found: found.saturating_sub(1) });
            }
        }
        Ok(true)
    }

    /// Where the frame is that comes next: how many lines have been read, and what they are read from.
    pub(crate) fn place(&mut self) -> (usize, &mut R) {
        (self.line, &mut self.input)
    }

    /// Passes over the next frame without reading the numbers of its particles; `None` where nothing but blank lines is left. A frame that is
    /// cut off is seen as when it is read.
    ///
    /// # Errors
    /// As for frames that are read, but for what the lines of particles say.
    pub(crate) fn next_preamble(&mut self) -> Result<Option<Preamble>, ReadError> {
        let Some((count, comment)) = self.begin_frame()? else { return Ok(None) };
        let first = self.frame_line;
        let truncated = |found| ReadError::Truncated { line: first, expected: count, found };
        for found in 0..count {
            if self.next_line()?.is_none() {
                return Err(truncated(found));
            }
        }
        if count > 0 && self.text.last() != Some(&b'\n') {
            let mut table = SpeciesTable::new(Vec::new());
            let text = std::str::from_utf8(&self.text).unwrap_or_default().trim_end_matches('\r');
            let is_whole = parse_particle(text, self.line, 0, &comment.columns, &mut table).is_ok()
                && comment.columns.image.is_none_or(|first| parse_image(text, self.line, first).is_ok());
            if !is_whole {
                return Err(truncated(count - 1));
            }
        }
        Ok(Some(Preamble { count, time: comment.time, region: comment.region }))
    }

    /// The next line without its end, or `None` at the end of the file.
    fn next_line(&mut self) -> Result<Option<&str>, ReadError> {
        self.text.clear();
        self.line += 1;
        let line = self.line;
        let mut input = self.input.by_ref().take(LONGEST_LINE);
        let length = input.read_until(b'\n', &mut self.text).map_err(|source| ReadError::Io { line, source })?;
        if length as u64 == LONGEST_LINE && self.text.last() != Some(&b'\n') {
            return Err(ReadError::LineTooLong { line });
        }
        let text = std::str::from_utf8(&self.text).map_err(|_| ReadError::NotText { line })?;
        Ok(if length == 0 { None } else { Some(text.trim_end_matches(['\n', '\r'])) })
    }

    /// The number of particles of the next frame, or `None` where nothing but blank lines is left.
    fn next_count(&mut self) -> Result<Option<usize>, ReadError> {
        loop {
            match self.next_line()?.map(str::trim) {
                None => return Ok(None),
                Some("") => {}
                Some(text) => match text.parse::<u32>() {
                    // Ids have as many bits.
                    Ok(count) => return Ok(Some(count as usize)),
                    Err(_) => {
                        let text = shorten(text);
                        return Err(ReadError::Count { line: self.line, text });
                    }
                },
            }
        }
    }

    /// The number of particles and the comment of the next frame, or `None` where nothing but blank lines is left.
    fn begin_frame(&mut self) -> Result<Option<(usize, Comment)>, ReadError> {
        let Some(count) = self.next_count()? else { return Ok(None) };
        let first = self.line;
        self.frame_line = first;
        let comment = self.next_line()?.map(|text| Comment::parse(text, first + 1));
        let is_whole = self.text.last() == Some(&b'\n') || count == 0;
        let Some(comment) = comment.filter(|_| is_whole) else {
            return Err(ReadError::Truncated { line: first, expected: count, found: 0 });
        };
        Ok(Some((count, comment?)))
    }

    /// The next frame, or `None` where nothing but blank lines is left.
    fn next_frame(&mut self) -> Result<Option<Frame>, ReadError> {
        let Some((count, comment)) = self.begin_frame()? else { return Ok(None) };
        let first = self.frame_line;
        let truncated = |found| ReadError::Truncated { line: first, expected: count, found };
        let mut table = SpeciesTable::new(comment.species);
        let mut particles = Vec::with_capacity(count.min(TRUSTED_COUNT));
        let mut images = Vec::new();
        let mut beside = Beside { unused: comment.columns.unused.clone(), ..Beside::default() };
        let scalars = comment.columns.scalars.iter();
        let mut scalars: Vec<_> = scalars.map(|(name, _)| Scalar { name: name.clone(), values: Vec::new() }).collect();
        for (index, id) in (0..count).zip(0..) {
            let line = first + 2 + index;
            let Some(text) = self.next_line()? else { return Err(truncated(index)) };
            let particle = parse_particle(text, line, id, &comment.columns, &mut table);
            let image = comment.columns.image.map(|first| parse_image(text, line, first)).transpose();
            let read = beside.read(text, line, &comment.columns);
            match particle.and_then(|particle| Ok((particle, image?, read?))) {
                Ok((particle, image, ())) => {
                    particles.push(particle);
                    images.extend(image);
                    read_scalars(text, &comment.columns.scalars, &mut scalars);
                }
                // What was cut in the middle of a line is not malformed.
                Err(_) if self.text.last() != Some(&b'\n') => return Err(truncated(index)),
                Err(error) => return Err(error),
            }
        }
        self.beside = beside;
        scalars.retain(|scalar| scalar.values.len() == count);
        self.has_velocities = comment.columns.velocity.is_some();
        self.has_species = comment.columns.species.is_some();
        self.has_radii = comment.columns.radius.is_some();
        self.has_box = comment.region.is_some();
        let (lower, size) = comment.region.unwrap_or_else(|| bounds(&particles));
        let Comment { time, periodic, displacement, bonds, bond_names, bond_kinds, .. } = comment;
        Ok(Some(Frame {
            time,
            lower,
            size,
            periodic,
            displacement,
            species: table.species,
            particles,
            bonds,
            bond_names,
            bond_kinds,
            images,
            scalars,
        }))
    }
}

impl<R: BufRead> Iterator for FrameReader<R> {
    type Item = Result<Frame, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_finished {
            return None;
        }
        let frame = self.next_frame().transpose();
        self.is_finished = !matches!(frame, Some(Ok(_)));
        frame
    }
}

impl Beside {
    /// Reads the momentum and the mass of a particle, if there are such columns.
    fn read(&mut self, text: &str, line: usize, columns: &Columns) -> Result<(), ReadError> {
        let number = |at: usize, column: &'static str, is_good: fn(&f64) -> bool, expected: &'static str| {
            let word = text.split_ascii_whitespace().nth(at).unwrap_or_default();
            let wrong = || ReadError::Value { line, column, text: shorten(word), expected };
            finite(word).filter(is_good).ok_or_else(wrong)
        };
        if let Some(first) = columns.momentum {
            let component = |axis: usize| number(first + axis, "momentum", |_| true, "a finite number");
            self.momenta.push(Vector::new(component(0)?, component(1)?, component(2)?));
        }
        if let Some(at) = columns.mass {
            self.masses.push(number(at, "mass", |mass| *mass >= 0.0, "a finite mass, not negative")?);
        }
        Ok(())
    }
}

/// The species by name, in the order of the table of the file, then of their appearance.
struct SpeciesTable {
    species: Vec<FrameSpecies>,
    index: HashMap<String, u32>,
}

impl SpeciesTable {
    fn new(species: Vec<FrameSpecies>) -> Self {
        let index = (0..).zip(&species).map(|(index, species)| (species.name.clone(), index)).collect();
        Self { species, index }
    }

    fn id(&mut self, name: &str) -> SpeciesId {
        if let Some(&index) = self.index.get(name) {
            return SpeciesId(index);
        }
        let index = id(self.species.len());
        self.species.push(FrameSpecies { name: name.to_owned(), is_static: false, mass: None });
        self.index.insert(name.to_owned(), index);
        SpeciesId(index)
    }
}

fn parse_particle(
    text: &str,
    line: usize,
    id: u32,
    columns: &Columns,
    table: &mut SpeciesTable,
) -> Result<FrameParticle, ReadError> {
    // More columns than any file has are counted, but not kept.
    const KEPT: usize = 64;
    let mut words = [""; KEPT];
    let mut found = 0;
    for word in text.split_ascii_whitespace().take(columns.total.saturating_add(1)) {
        if let Some(slot) = words.get_mut(found) {
            *slot = word;
        }
        found += 1;
    }
    if found != columns.total {
        return Err(ReadError::Columns { line, expected: columns.total, found });
    }
    let word = |column: usize| match words.get(column) {
        Some(&word) => word,
        None => text.split_ascii_whitespace().nth(column).unwrap_or_default(),
    };
    let wrong = |column: &'static str, text: &str, expected: &'static str| ReadError::Value {
        line,
        column,
        text: shorten(text),
        expected,
    };
    let vector = |name: &'static str, first: usize| {
        let mut vector = Vector::zeros();
        for axis in 0..3 {
            let word = word(first + axis);
            vector[axis] = finite(word).ok_or_else(|| wrong(name, word, "a finite number"))?;
        }
        Ok(vector)
    };
    Ok(FrameParticle {
        position: vector("position", columns.position)?,
        velocity: columns.velocity.map_or(Ok(Vector::zeros()), |first| vector("velocity", first))?,
        radius: columns.radius.map(word).map_or(Ok(DEFAULT_RADIUS), |word| {
            let radius = finite(word).filter(|&radius| radius >= 0.0);
            radius.ok_or_else(|| wrong("radius", word, "a finite length, not negative"))
        })?,
        id: columns.id.map(word).map_or(Ok(ParticleId(id)), |word| {
            word.parse().map(ParticleId).map_err(|_| wrong("id", word, "a whole number, 0 to 4294967295"))
        })?,
        species: table.id(columns.species.map_or("X", word)),
    })
}

/// The periods that a particle has travelled.
fn parse_image(text: &str, line: usize, first: usize) -> Result<[i32; 3], ReadError> {
    let mut words = text.split_ascii_whitespace().skip(first);
    let mut image = [0; 3];
    for periods in &mut image {
        let word = words.next().unwrap_or_default();
        *periods = word.parse().map_err(|_| ReadError::Value {
            line,
            column: "map_shift",
            text: shorten(word),
            expected: "a whole number of periods",
        })?;
    }
    Ok(image)
}

/// Adds the scalars of a line that are finite.
fn read_scalars(text: &str, columns: &[(String, usize)], scalars: &mut [Scalar]) {
    let mut words = text.split_ascii_whitespace().enumerate();
    for ((_, column), scalar) in columns.iter().zip(scalars) {
        let word = words.find(|(index, _)| index == column);
        scalar.values.extend(word.and_then(|(_, word)| finite(word)));
    }
}

/// The smallest box that holds the spheres.
pub(crate) fn bounds(particles: &[FrameParticle]) -> (Vector, Vector) {
    let mut corners: Option<(Vector, Vector)> = None;
    for particle in particles {
        let (lower, upper) =
            (particle.position.add_scalar(-particle.radius), particle.position.add_scalar(particle.radius));
        corners = Some(corners.map_or((lower, upper), |(l, u)| (l.inf(&lower), u.sup(&upper))));
    }
    corners.map_or((Vector::zeros(), Vector::zeros()), |(lower, upper)| (lower, upper - lower))
}
