//! The comment line of a frame: box, time, species, and the meaning of each column.

use std::ops::Range;

use super::ReadError;
use crate::Vector;
use crate::model::space::displacement_within_period;
use crate::model::{ParticleId, Units};
use crate::trajectory::Frame;
use crate::trajectory::frame::FrameSpecies;

/// Positions of the columns in the line of a particle, counted from 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Columns {
    pub total: usize,
    pub position: usize,
    pub species: Option<usize>,
    /// All columns that may contain the species. Other programs insert a column before the original one.
    pub may_be_species: Vec<usize>,
    pub velocity: Option<usize>,
    pub radius: Option<usize>,
    pub id: Option<usize>,
    pub image: Option<usize>,
    /// Column of the momenta, if there are no velocities.
    pub momentum: Option<usize>,
    pub mass: Option<usize>,
    pub unused: Vec<String>,
    pub scalars: Vec<(String, usize)>,
}

const POSITION: &[&str] = &["pos"];
const SPECIES: &[&str] = &["species", "type", "element"];
const VELOCITY: &[&str] = &["velo", "vel", "velocity", "velocities"];
const MOMENTUM: &[&str] = &["momenta", "momentum"];
const MASS: &[&str] = &["masses", "mass"];
const RADIUS: &[&str] = &["radius"];
const ID: &[&str] = &["id"];
const IMAGE: &[&str] = &["map_shift", "images", "image"];

const LATTICE: &str = "a box aligned with the axes, `Lx 0 0 0 Ly 0 0 0 Lz`, or one whose images along y slide along x, \
    `Lx 0 0 d Ly 0 0 0 Lz`, where both are periodic";

/// Off-diagonal entries of `Lattice` below this fraction of a box edge are round-off from a rotation of the box.
const ALIGNED: f64 = 1e-14;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Comment {
    /// What the line says about the frame, without particles.
    pub frame: Frame,
    /// Whether the line has a `Lattice`.
    pub has_box: bool,
    pub columns: Columns,
}

impl Comment {
    /// Parses a comment line. Unknown keys are ignored.
    pub fn parse(text: &str, line: usize) -> Result<Self, ReadError> {
        let value_of = |key: &'static str| {
            let found = pairs(text).find(|(k, _)| k.eq_ignore_ascii_case(key));
            found.map(|(_, value)| Value { key, value, line })
        };
        let lattice = value_of("Lattice").map(|value| value.lattice()).transpose()?;
        let origin = value_of("Origin").map(|value| value.numbers::<3>("three finite numbers")).transpose()?;
        let flat = value_of("flat").map(|value| value.three_flags()).transpose()?.unwrap_or_default();
        let region = lattice.map(|(edges, _)| {
            let size = Vector::from_fn(|k, _| if flat[k] { 0.0 } else { edges[k] });
            (Vector::from(origin.unwrap_or_default()), size)
        });
        let periodic = match value_of("pbc") {
            Some(value) => value.periodic()?,
            None => [region.is_some(); 3],
        };
        let displacement = lattice.map_or(0.0, |(_, displacement)| displacement);
        let is_sliding = |axis: usize| periodic[axis] && !flat[axis];
        if displacement != 0.0 && !(is_sliding(0) && is_sliding(1)) {
            return Err(value_of("Lattice").map_or(ReadError::NoFrame, |value| value.expected(LATTICE)));
        }
        // A time that is not a plain number is ignored.
        let time = value_of("Time").map_or(Some(0.0), |value| finite(value.value));
        let mut species: Vec<FrameSpecies> = Vec::new();
        if let Some(value) = value_of("species_table") {
            species = value.species(value_of("static"), value_of("species_mass"))?;
        }
        let bonds = value_of("bonds").map(|value| value.bonds()).transpose()?.unwrap_or_default();
        let (bond_names, bond_kinds) = match value_of("bond_table") {
            Some(table) => table.kinds_of_bonds(value_of("bond_kind"), bonds.len())?,
            None => Default::default(),
        };
        let surfaces = value_of("surfaces").map(|value| value.flags()).transpose()?.unwrap_or_default();
        let units = value_of("units").and_then(|value| value.units()).unwrap_or_default();
        let mut columns = match value_of("Properties") {
            Some(value) => value.columns()?,
            None => Columns { total: 4, position: 1, species: Some(0), ..Columns::default() },
        };
        if time.is_none() {
            columns.unused.push("Time".to_owned());
        }
        let time = time.unwrap_or(0.0);
        // Masses in the table of species take precedence over a column of masses.
        columns.mass = columns.mass.filter(|_| species.iter().all(|species| species.mass.is_none()));
        let (lower, size) = region.unwrap_or_default();
        let frame = Frame { time, lower, size, periodic, displacement, species, bonds, ..Frame::default() };
        let frame = Frame { bond_names, bond_kinds, surfaces, units, ..frame };
        Ok(Self { frame, has_box: region.is_some(), columns })
    }
}

/// Splits a line into `key=value` pairs by the rules of ASE. Words without `=` are ignored.
fn pairs(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            rest = rest.trim_start();
            let end = rest.find(|c: char| c == '=' || c.is_whitespace())?;
            let (key, tail) = rest.split_at(end);
            let Some(tail) = tail.trim_start().strip_prefix('=') else {
                rest = tail;
                continue;
            };
            let (value, tail) = value(tail.trim_start());
            rest = tail;
            return Some((key, value));
        }
    })
}

/// Splits off the value at the beginning of a text, without quotes or brackets.
fn value(text: &str) -> (&str, &str) {
    let inside = text.get(1..).unwrap_or_default();
    match text.chars().next() {
        Some(quote @ ('"' | '\'')) => inside.split_once(quote).unwrap_or((inside, "")),
        Some('{') => inside.split_once('}').unwrap_or((inside, "")),
        Some('[') => {
            let mut depth = 1_usize;
            let end = inside.char_indices().find(|(_, c)| {
                match c {
                    '[' => depth += 1,
                    ']' => depth -= 1,
                    _ => {}
                }
                depth == 0
            });
            end.map_or((inside, ""), |(end, _)| (&inside[..end], &inside[end + 1..]))
        }
        _ => text.split_once(char::is_whitespace).unwrap_or((text, "")),
    }
}

struct Value<'a> {
    key: &'static str,
    value: &'a str,
    line: usize,
}

impl<'a> Value<'a> {
    fn expected(&self, expected: &'static str) -> ReadError {
        ReadError::unexpected(self.line, self.key, self.value, expected)
    }

    /// Words of a list. ASE writes `_JSON` before some lists.
    fn words(&self) -> impl Iterator<Item = &'a str> {
        let list = self.value.trim_start();
        list.strip_prefix("_JSON")
            .unwrap_or(list)
            .split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'))
            .filter(|word| !word.is_empty())
    }

    fn as_many<T>(
        &self,
        count: usize,
        expected: &'static str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<Vec<T>, ReadError> {
        let values: Option<Vec<T>> = self.words().map(read).collect();
        values.filter(|values| values.len() == count).ok_or_else(|| self.expected(expected))
    }

    fn numbers<const N: usize>(&self, expected: &'static str) -> Result<[f64; N], ReadError> {
        let numbers = self.as_many(N, expected, finite)?;
        Ok(std::array::from_fn(|k| numbers[k]))
    }

    fn lattice(&self) -> Result<(Vector, f64), ReadError> {
        let mut vectors = self.numbers::<9>("nine finite numbers")?;
        let longest = [0, 4, 8].map(|entry| vectors[entry].abs()).into_iter().fold(0.0, f64::max);
        for entry in (0..9).filter(|entry| entry % 4 != 0) {
            // Entry 3 is a displacement along x, so its period is the edge along x.
            let edge = if entry == 3 { vectors[0] } else { longest };
            if vectors[entry].abs() <= ALIGNED * edge {
                vectors[entry] = 0.0;
            }
        }
        let [x, _, _, displacement, y, _, _, _, z] = vectors;
        let is_known = |entry: usize| match entry {
            0 | 4 | 8 => vectors[entry] >= 0.0,
            3 => displacement == 0.0 || x > 0.0 && y > 0.0,
            _ => vectors[entry] == 0.0,
        };
        if !(0..9).all(is_known) {
            return Err(self.expected(LATTICE));
        }
        let within = if displacement == 0.0 { 0.0 } else { displacement_within_period(displacement, x) };
        Ok((Vector::new(x, y, z), within))
    }

    fn periodic(&self) -> Result<[bool; 3], ReadError> {
        flag(self.value.trim()).map_or_else(|| self.three_flags(), |flag| Ok([flag; 3]))
    }

    fn three_flags(&self) -> Result<[bool; 3], ReadError> {
        let flags = self.as_many(3, "three of `T` and `F`", flag)?;
        Ok(std::array::from_fn(|k| flags[k]))
    }

    fn flags(&self) -> Result<Vec<bool>, ReadError> {
        self.as_many(self.words().count(), "`T` or `F` for each surface", flag)
    }

    /// Three names of units. Other texts, such as `units=metal` of another program, are ignored.
    fn units(&self) -> Option<Units> {
        let names: Vec<&str> = self.words().filter(|word| Units::is_name(word)).collect();
        let [length, mass, time] = names[..] else { return None };
        (self.words().count() == 3).then(|| Units::new(length, mass, time))
    }

    fn species(&self, is_static: Option<Value>, mass: Option<Value>) -> Result<Vec<FrameSpecies>, ReadError> {
        const FLAGS: &str = "a `T` or `F` for each species";
        const MASSES: &str = "a positive number, or `inf`, for each species";
        let names: Vec<&str> = self.value.split_whitespace().collect();
        let flags = is_static.map(|value| value.as_many(names.len(), FLAGS, flag)).transpose()?;
        let is_static = flags.unwrap_or_else(|| vec![false; names.len()]);
        let known = |word: &str| word.parse().ok().filter(is_mass).map(Some);
        let masses = mass.map(|value| value.as_many(names.len(), MASSES, known)).transpose()?;
        let masses = masses.unwrap_or_else(|| vec![None; names.len()]);
        let species = names.into_iter().zip(is_static).zip(masses);
        Ok(species.map(|((name, is_static), mass)| FrameSpecies { name: name.to_owned(), is_static, mass }).collect())
    }

    fn bonds(&self) -> Result<Vec<[ParticleId; 2]>, ReadError> {
        let id = |word: &str| word.parse().ok().map(ParticleId);
        let bond = |word: &str| word.split_once('-').and_then(|(a, b)| Some([id(a)?, id(b)?]));
        let bonds: Option<_> = self.words().map(bond).collect();
        bonds.ok_or_else(|| self.expected("pairs of ids such as `0-1 1-2`"))
    }

    fn kinds_of_bonds(&self, kinds: Option<Value>, bonds: usize) -> Result<(Vec<String>, Vec<u32>), ReadError> {
        let names: Vec<String> = self.value.split_whitespace().map(str::to_owned).collect();
        if bonds == 0 {
            return Ok(Default::default());
        }
        let is_known = |kind: &u32| (*kind as usize) < names.len();
        let place = |word: &str| word.parse().ok().filter(is_known);
        let kinds = match kinds {
            None if names.len() == 1 => vec![0; bonds],
            None => return Err(self.expected("a single name, or several names together with `bond_kind`")),
            Some(value) => value.as_many(bonds, "an index into `bond_table`, from 0, for each bond", place)?,
        };
        Ok((names, kinds))
    }

    fn columns(&self) -> Result<Columns, ReadError> {
        const EXPECTED: &str = "`name:type:number` for each group of columns, such as `species:S:1:pos:R:3`";
        let mut total = 0_usize;
        let mut groups: Vec<(&str, Range<usize>)> = Vec::new();
        let mut scalars: Vec<(String, usize)> = Vec::new();
        let fields: Vec<&str> = self.value.split(':').collect();
        for group in fields.chunks(3) {
            let [name, kind, number] = group else { return Err(self.expected(EXPECTED)) };
            let number: Option<usize> = number.parse().ok().filter(|&number| number > 0);
            let end = number.and_then(|number| total.checked_add(number)).ok_or_else(|| self.expected(EXPECTED))?;
            groups.push((name, total..end));
            let is_new = scalars.iter().all(|(other, _)| other != name);
            if *kind == "R" && end == total + 1 && is_new && Frame::is_name_of_scalar(name) {
                scalars.push(((*name).to_owned(), total));
            }
            total = end;
        }
        let find = |names: &[&str], width: usize| {
            let is_it = |(name, range): &&(&str, Range<usize>)| names.contains(name) && range.len() == width;
            groups.iter().find(is_it).map(|(_, range)| range.start)
        };
        let (velocity, momentum) = (find(VELOCITY, 3), find(MOMENTUM, 3));
        let is_named = |names: &[&str]| groups.iter().any(|(name, _)| names.contains(name));
        if velocity.is_none() && momentum.is_none() && (is_named(VELOCITY) || is_named(MOMENTUM)) {
            return Err(self.expected("three columns of velocities, `velo:R:3`, or of momenta, `momenta:R:3`"));
        }
        let names_species = |(name, range): &&(&str, Range<usize>)| SPECIES.contains(name) && range.len() == 1;
        let may_be_species: Vec<usize> = groups.iter().filter(names_species).map(|(_, range)| range.start).collect();
        let columns = Columns {
            total,
            position: find(POSITION, 3).ok_or_else(|| self.expected("positions, `pos:R:3`"))?,
            species: may_be_species.first().copied(),
            may_be_species,
            velocity,
            radius: find(RADIUS, 1),
            id: find(ID, 1),
            image: find(IMAGE, 3),
            momentum: momentum.filter(|_| velocity.is_none()),
            mass: find(MASS, 1),
            unused: Vec::new(),
            scalars,
        };
        let used = [Some(columns.position), columns.species, velocity, columns.radius, columns.id, columns.image];
        // Momenta beside velocities are redundant, not unused.
        let used = [&used[..], &[momentum, columns.mass]].concat();
        let is_used = |at: usize| used.contains(&Some(at)) || columns.may_be_species.contains(&at);
        let unused = groups.iter().filter(|(_, range)| !is_used(range.start));
        Ok(Columns { unused: unused.map(|(name, _)| (*name).to_owned()).collect(), ..columns })
    }
}

/// Static particles may have an infinite mass.
pub(super) fn is_mass(mass: &f64) -> bool {
    *mass > 0.0
}

fn flag(word: &str) -> Option<bool> {
    match word {
        "T" | "True" | "true" | "TRUE" | "1" => Some(true),
        "F" | "False" | "false" | "FALSE" | "0" => Some(false),
        _ => None,
    }
}

pub(super) fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}
