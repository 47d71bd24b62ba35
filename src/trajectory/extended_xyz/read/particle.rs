use std::collections::HashMap;

use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::numbers::id;
use crate::model::{ParticleId, SpeciesId};
use crate::trajectory::extended_xyz::ReadError;
use crate::trajectory::extended_xyz::comment::{Columns, finite};
use crate::trajectory::frame::{FrameParticle, FrameSpecies};

/// Radius of particles in files without radii: a diameter of 1 in reduced units `[length]`.
const DEFAULT_RADIUS: f64 = 0.5;

/// Data of a trajectory file that have no field in [`Frame`](crate::trajectory::Frame).
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Beside {
    /// Momenta of the particles; empty if the frame has velocities `[mass length / time]`.
    pub momenta: Vec<Vector>,
    /// Mass of each particle `[mass]`, 0 if static. Empty if masses are unknown or in the species table.
    pub masses: Vec<f64>,
    pub unused: Vec<String>,
}

impl Beside {
    pub(super) fn read(&mut self, words: &Words<'_>, columns: &Columns) -> Result<(), ReadError> {
        if let Some(first) = columns.momentum {
            self.momenta.push(words.vector(first, "momentum")?);
        }
        if let Some(at) = columns.mass {
            self.masses.push(words.read(at, "mass", "a finite mass, not negative", not_negative)?);
        }
        Ok(())
    }
}

/// Species of the species table, then other species in the order of appearance.
pub(super) struct SpeciesTable {
    pub species: Vec<FrameSpecies>,
    index: HashMap<String, u32>,
}

impl SpeciesTable {
    pub fn new(species: Vec<FrameSpecies>) -> Self {
        let index = (0..).zip(&species).map(|(index, species)| (species.name.clone(), index)).collect();
        Self { species, index }
    }

    pub fn has(&self, name: &str) -> bool {
        self.index.contains_key(name)
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

/// Number of words of a line that are stored. Further words are found by scanning the line again.
const KEPT: usize = 64;

pub(super) struct Words<'a> {
    line: usize,
    text: &'a str,
    kept: [&'a str; KEPT],
}

impl<'a> Words<'a> {
    pub fn of(text: &'a str, line: usize, columns: &Columns) -> Result<Self, ReadError> {
        let mut kept = [""; KEPT];
        let mut found = 0;
        for word in text.split_ascii_whitespace().take(columns.total.saturating_add(1)) {
            if let Some(slot) = kept.get_mut(found) {
                *slot = word;
            }
            found += 1;
        }
        if found != columns.total {
            let problem = format!("expected {} columns, found {found}", columns.total);
            return Err(ReadError::Malformed { line, problem });
        }
        Ok(Self { line, text, kept })
    }

    fn word(&self, column: usize) -> &'a str {
        let again = || self.text.split_ascii_whitespace().nth(column).unwrap_or_default();
        self.kept.get(column).copied().unwrap_or_else(again)
    }

    fn read<T>(
        &self,
        at: usize,
        column: &str,
        expected: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, ReadError> {
        let word = self.word(at);
        parse(word).ok_or_else(|| ReadError::unexpected(self.line, column, word, expected))
    }

    fn vector(&self, first: usize, column: &str) -> Result<Vector, ReadError> {
        let component = |axis: usize| self.read(first + axis, column, "a finite number", finite);
        Ok(Vector::new(component(0)?, component(1)?, component(2)?))
    }

    /// Reads a particle. `id` is used if the file has no ids.
    pub fn particle(&self, id: u32, columns: &Columns, table: &mut SpeciesTable) -> Result<FrameParticle, ReadError> {
        let length = |at| self.read(at, "radius", "a finite length, not negative", not_negative);
        let whole = |at| self.read(at, "id", "a whole number, 0 to 4294967295", |word| word.parse().ok());
        Ok(FrameParticle {
            position: self.vector(columns.position, "position")?,
            velocity: columns.velocity.map_or(Ok(Vector::zeros()), |first| self.vector(first, "velocity"))?,
            radius: columns.radius.map_or(Ok(DEFAULT_RADIUS), length)?,
            id: ParticleId(columns.id.map_or(Ok(id), whole)?),
            species: table.id(columns.species.map_or("X", |at| self.word(at))),
        })
    }

    /// Reads the periods that a particle has travelled, if the file has them.
    pub fn image(&self, columns: &Columns) -> Result<Option<[i32; 3]>, ReadError> {
        let Some(first) = columns.image else { return Ok(None) };
        let periods =
            |axis: usize| self.read(first + axis, "map_shift", "a whole number of periods", |word| word.parse().ok());
        Ok(Some([periods(0)?, periods(1)?, periods(2)?]))
    }

    /// Appends the finite scalars of the particle. The reader drops incomplete scalars at the end of the frame.
    pub fn scalars(&self, columns: &Columns, scalars: &mut [Scalar]) {
        for ((_, column), scalar) in columns.scalars.iter().zip(scalars) {
            scalar.values.extend(finite(self.word(*column)));
        }
    }
}

fn not_negative(word: &str) -> Option<f64> {
    finite(word).filter(|number| *number >= 0.0)
}
