//! Starts a scene from frames in extended XYZ files or from a program.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::Vector;
use crate::base::numbers::id;
use crate::model::input_file::is_checksum;
use crate::model::space::{AXES, Boundary};
use crate::model::{InputFile, Particle, Units};
use crate::scene::brought;
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, unknown};
use crate::scene::file::{CoordinatesFile, SpaceFile};
use crate::scene::given::GivenParticles;
use crate::scene::unvalidated::{Group, Listed, UnvalidatedBond};
use crate::trajectory::extended_xyz::{Beside, FrameReader, ReadError};
use crate::trajectory::frame::{FrameParticle, SPINS};
use crate::trajectory::{Frame, compressed};

#[derive(Debug)]
struct Start<'f> {
    frame: Cow<'f, Frame>,
    has_box: bool,
    has_radii: bool,
    beside: Beside,
    /// Number of the line that contains the box and the bonds of the frame.
    comment: usize,
}

#[derive(Debug, Clone)]
struct Origin {
    at: ConfigPath,
    path: Option<PathBuf>,
    bond: Option<String>,
}

impl Origin {
    fn wrong(&self, line: usize, problem: String) -> SceneError {
        match self.path.clone() {
            Some(path) => SceneError::new(self.at.key("path"), SceneErrorKind::Coordinates { path, line, problem }),
            None => SceneError::new(self.at.clone(), SceneErrorKind::Particles { problem }),
        }
    }
}

pub(super) struct Frames<'a> {
    pub given: Option<&'a GivenParticles>,
    pub files: &'a [CoordinatesFile],
    pub directory: &'a Path,
    pub space: &'a SpaceFile,
    pub may_give_box: bool,
}

/// Adds the particles and bonds of frames to a scene. The first frame with a box may also determine the box.
pub(super) fn add(frames: &Frames<'_>, scene: &mut SceneBuilder) -> Result<Vec<RadiiAndMasses>, SceneError> {
    let mut sizes = Vec::with_capacity(frames.files.len());
    if let Some(given) = frames.given {
        let at = ConfigPath::root().key(given.name.clone());
        let origin = Origin { at, path: None, bond: given.bond.clone() };
        let GivenParticles { has_box, has_radii, .. } = *given;
        let (frame, beside) = (Cow::Borrowed(&given.frame), Beside::default());
        add_start(&Start { frame, has_box, has_radii, beside, comment: 0 }, origin, frames, (scene, &mut sizes))?;
    }
    for (index, file) in frames.files.iter().enumerate() {
        let at = ConfigPath::entry("file", index);
        let path = frames.directory.join(&file.path);
        let unreadable = |source| SceneErrorKind::Unreadable { path: path.clone(), source };
        let text = brought::read(&path).map_err(|source| SceneError::new(at.key("path"), unreadable(source)))?;
        scene.parts.inputs.push(unchanged(&path, &text, file.checksum.as_deref(), &at)?);
        let origin = Origin { at, path: Some(path), bond: file.bond.clone() };
        let mut start = parse(&text, file.frame).map_err(|(line, problem)| origin.wrong(line, problem))?;
        if let Some(input) = scene.parts.inputs.last_mut() {
            input.unused = std::mem::take(&mut start.beside.unused);
            if start.frame.spins().is_some() {
                input.unused.retain(|name| !SPINS.contains(&name.as_str()));
            }
        }
        add_start(&start, origin, frames, (scene, &mut sizes))?;
    }
    Ok(sizes)
}

fn add_start(
    start: &Start<'_>,
    origin: Origin,
    frames: &Frames<'_>,
    (scene, sizes): (&mut SceneBuilder, &mut Vec<RadiiAndMasses>),
) -> Result<(), SceneError> {
    let frame = &*start.frame;
    check_units(start, &origin, &scene.parts.units)?;
    if frames.may_give_box && start.has_box && scene.size.is_none() {
        take_box(frame, frames.space, scene)?;
    }
    if frame.displacement != 0.0 {
        scene.parts.displacement = frame.displacement;
    }
    add_bonds(start, &origin, scene)?;
    let given = frames.given.filter(|_| origin.path.is_none());
    let space = scene.parts.space.clone();
    if given.is_some_and(|given| given.is_plane) && space.boundary[2] != Boundary::Flat {
        let problem =
            "positions have two columns, but z is not flat: give three columns, or set `z = \"flat\"` in [space]";
        return Err(origin.wrong(0, problem.to_owned()));
    }
    let place = |position: Vector| given.map_or(position, |given| given.placed(position, &space));
    // A radius in the frame sets an individual diameter. Without individual diameters, it must equal the species'
    // radius.
    let is_individual = |name: &str| {
        let named = scene.species.iter().find(|species| species.name == name);
        start.has_radii && named.is_some_and(|species| species.individual.is_some())
    };
    let are_individual: Vec<bool> = frame.species.iter().map(|species| is_individual(&species.name)).collect();
    let spins = frame.spins().filter(|_| origin.path.is_some()).unwrap_or_default();
    let particle = |(index, it): (usize, &FrameParticle)| {
        let is_sized = are_individual.get(it.species.0 as usize) == Some(&true);
        let diameter = is_sized.then_some(2.0 * it.radius);
        let spin = spins.get(index).copied().unwrap_or_default();
        Particle { spin, diameter, ..Particle::new(it.species, place(it.position), it.velocity) }
    };
    let listed = Group::Listed(Listed {
        names: frame.species.iter().map(|species| species.name.clone()).collect(),
        particles: frame.particles.iter().enumerate().map(particle).collect(),
        are_rows: origin.path.is_none(),
    });
    let group = scene.groups.len();
    match origin.path {
        Some(_) => scene.push("file", listed),
        None => scene.push_at(origin.at.clone(), listed),
    };
    sizes.push(RadiiAndMasses::of(start, origin, group));
    Ok(())
}

/// Rejects a file whose units have other names than those of the scene.
fn check_units(start: &Start<'_>, origin: &Origin, units: &Units) -> Result<(), SceneError> {
    match (start.frame.units.names(), units.names()) {
        (Some(found), Some(expected)) if found != expected => {
            let [found, expected] =
                [found, expected].map(|[length, mass, time]| format!("{length}, {mass} and {time}"));
            let problem = format!("the units are {found}, expected {expected} as in [units]: no number is converted");
            Err(origin.wrong(start.comment, problem))
        }
        _ => Ok(()),
    }
}

/// Takes the size of the box from a frame, and the lower corner and the sides if the scene does not give them. A frame
/// cannot distinguish walls from open sides, so the scene must give sides that are neither periodic nor flat.
fn take_box(frame: &Frame, space: &SpaceFile, scene: &mut SceneBuilder) -> Result<(), SceneError> {
    let boundary = scene.parts.space.boundary;
    scene.size = Some(Vector::from_fn(|k, _| if boundary[k] == Boundary::Flat { 0.0 } else { frame.size[k] }));
    if space.lower.is_none() {
        scene.parts.space.lower = frame.lower;
    }
    for (k, _) in [&space.x, &space.y, &space.z].into_iter().enumerate().filter(|(_, given)| given.is_none()) {
        scene.parts.space.boundary[k] = match (frame.is_flat(k), frame.periodic[k]) {
            (true, _) => Boundary::Flat,
            (false, true) => Boundary::Periodic,
            (false, false) => {
                let why = "the box that comes with the particles is not periodic along this axis, so give its sides";
                return Err(missing(&ConfigPath::root().key("space"), AXES[k], why));
            }
        };
    }
    Ok(())
}

/// Adds the bonds of a frame. The interactions are named in the scene or in the file.
fn add_bonds(start: &Start<'_>, origin: &Origin, scene: &mut SceneBuilder) -> Result<(), SceneError> {
    let frame = &*start.frame;
    if frame.bonds.is_empty() {
        return Ok(());
    }
    let wrong = |problem: String| Err(origin.wrong(start.comment, problem));
    let of_file = if origin.path.is_some() { " in [[file]]" } else { "" };
    let known: Vec<&str> = scene.interactions.iter().filter_map(|draft| draft.name.as_deref()).collect();
    let names: Vec<&str> = match &origin.bond {
        Some(name) if known.contains(&name.as_str()) => vec![name],
        Some(name) => return Err(unknown(&origin.at.key("bond"), "interaction", name, known)),
        None if frame.bond_kinds.len() != frame.bonds.len() => {
            return wrong(format!(
                "`bonds` do not name their interaction: set `bond`{of_file} to the name of an [[interaction]]"
            ));
        }
        None => frame.bond_names.iter().map(String::as_str).collect(),
    };
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        return wrong(format!(
            "bonds are held by `{name}`, expected the name of an [[interaction]] of the scene{}; `bond`{of_file} names another",
            if known.is_empty() { ", which has none".to_owned() } else { format!(", {}", known.join(", ")) },
        ));
    }
    let first: usize =
        scene.groups.iter().map(|it| if let Group::Listed(it) = &it.group { it.particles.len() } else { 0 }).sum();
    let mut id_of = HashMap::with_capacity(frame.particles.len());
    for (place, particle) in frame.particles.iter().enumerate() {
        if id_of.insert(particle.id, id(first + place)).is_some() {
            return wrong(format!("bonds refer to ids, but two particles have the id {}", particle.id.0));
        }
    }
    let at = if origin.path.is_some() { origin.at.key("path") } else { origin.at.clone() };
    let mut bonds = Vec::with_capacity(frame.bonds.len());
    for (index, ends) in frame.bonds.iter().enumerate() {
        let kind = if origin.bond.is_some() { 0 } else { frame.bond_kinds[index] as usize };
        let Some(name) = names.get(kind) else {
            return wrong(format!("bond {}-{} has the kind {kind}, which has no name", ends[0].0, ends[1].0));
        };
        let mut pair = [0; 2];
        for (end, id) in ends.iter().zip(&mut pair) {
            let Some(found) = id_of.get(end) else {
                return wrong(format!("bond {}-{} ends at a particle that is not in the frame", ends[0].0, ends[1].0));
            };
            *id = *found;
        }
        if pair[0] == pair[1] {
            return wrong(format!("bond {}-{} connects a particle to itself", ends[0].0, ends[1].0));
        }
        bonds.push(UnvalidatedBond { pair, interaction: (*name).to_owned(), at: at.clone() });
    }
    scene.bonds.extend(bonds);
    Ok(())
}

/// Returns the path and checksum of a file. If the scene contains another checksum, returns an error.
pub(super) fn unchanged(
    path: &Path,
    text: &[u8],
    expected: Option<&str>,
    at: &ConfigPath,
) -> Result<InputFile, SceneError> {
    let input = InputFile::new(path, text);
    let Some(expected) = expected.filter(|expected| *expected != input.checksum) else { return Ok(input) };
    let kind = if is_checksum(expected) {
        let (found, expected) = (input.checksum, expected.to_owned());
        SceneErrorKind::InputChanged { path: path.to_owned(), found, expected }
    } else {
        SceneErrorKind::value(format!("{expected:?}"), "`crc32:` and eight hexadecimal digits")
    };
    Err(SceneError::new(at.key("checksum"), kind))
}

fn parse(text: &[u8], frame: i64) -> Result<Start<'_>, (usize, String)> {
    let open = || compressed::unpacked(text).map_err(|error| (1, error.to_string()));
    let lines = || open().map_or(1, |text| BufReader::new(text).split(b'\n').map_while(Result::ok).count().max(1));
    let wrong = |error: ReadError| match error.line() {
        Some(line) => (line, error.problem()),
        None => (lines(), error.to_string()),
    };
    let ends_after = |frames: u64| {
        let frames = if frames == 1 { "1 frame".to_owned() } else { format!("{frames} frames") };
        (lines(), format!("the file ends after {frames}, expected frame {frame}"))
    };
    let from_start = match u64::try_from(frame) {
        Ok(frame) => frame,
        Err(_) => {
            let mut all = FrameReader::new(open()?);
            let mut frames = 0_u64;
            while all.skip_frame().map_err(wrong)? {
                frames += 1;
            }
            frames.checked_sub(frame.unsigned_abs()).ok_or_else(|| ends_after(frames))?
        }
    };
    let mut reader = FrameReader::new(open()?);
    for passed in 0..from_start {
        if !reader.skip_frame().map_err(wrong)? {
            return Err(ends_after(passed));
        }
    }
    match reader.next() {
        None => Err(ends_after(from_start)),
        Some(Err(error)) => Err(wrong(error)),
        Some(Ok(_)) if !reader.has_species() => Err((
            reader.frame_line() + 1,
            "Properties has no column for the species: expected type:S:1 or species:S:1".to_owned(),
        )),
        Some(Ok(frame)) => {
            let (has_box, has_radii, comment) = (reader.has_box(), reader.has_radii(), reader.frame_line() + 1);
            Ok(Start { frame: Cow::Owned(frame), has_box, has_radii, beside: reader.beside(), comment })
        }
    }
}

mod radii_and_masses;

pub(super) use radii_and_masses::RadiiAndMasses;

#[cfg(test)]
mod tests;
