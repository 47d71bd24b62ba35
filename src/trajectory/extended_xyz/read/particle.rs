//! The line of a particle.

use std::collections::HashMap;

use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::numbers::id;
use crate::model::{ParticleId, SpeciesId};
use crate::trajectory::extended_xyz::ReadError;
use crate::trajectory::extended_xyz::comment::{Columns, finite};
use crate::trajectory::extended_xyz::error::shorten;
use crate::trajectory::frame::{FrameParticle, FrameSpecies};

/// Radius of particles in files that give none `[length]`: a diameter of 1 in reduced units.
const DEFAULT_RADIUS: f64 = 0.5;

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

impl Beside {
    /// Reads the momentum and the mass of a particle, if there are such columns.
    pub(super) fn read(&mut self, text: &str, line: usize, columns: &Columns) -> Result<(), ReadError> {
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
pub(super) struct SpeciesTable {
    pub species: Vec<FrameSpecies>,
    index: HashMap<String, u32>,
}

impl SpeciesTable {
    pub fn new(species: Vec<FrameSpecies>) -> Self {
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

pub(super) fn parse_particle(
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
pub(super) fn parse_image(text: &str, line: usize, first: usize) -> Result<[i32; 3], ReadError> {
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
pub(super) fn read_scalars(text: &str, columns: &[(String, usize)], scalars: &mut [Scalar]) {
    let mut words = text.split_ascii_whitespace().enumerate();
    for ((_, column), scalar) in columns.iter().zip(scalars) {
        let word = words.find(|(index, _)| index == column);
        scalar.values.extend(word.and_then(|(_, word)| finite(word)));
    }
}
