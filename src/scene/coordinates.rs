//! A start from a file: a frame of extended XYZ, with its bonds and its box.

use std::collections::HashMap;
use std::path::Path;

use crate::base::numbers::id;
use crate::model::InputFile;
use crate::model::input_file::is_checksum;
use crate::model::space::{AXES, Boundary};
use crate::scene::brought;
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, missing, unknown};
use crate::scene::file::{CoordinatesFile, SpaceFile};
use crate::scene::unvalidated::{Group, Listed, UnvalidatedBond};
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::{Beside, FrameReader, ReadError};

/// A frame, and what its file says about it.
#[derive(Debug)]
struct Start {
    frame: Frame,
    has_box: bool,
    has_radii: bool,
    beside: Beside,
    /// The line with the box and the bonds.
    comment: usize,
}

/// Adds the particles and the bonds of coordinate files to a scene, and their box if nothing else says how large it is.
pub(super) fn add(
    files: &[CoordinatesFile],
    directory: &Path,
    space: &SpaceFile,
    may_give_box: bool,
    scene: &mut SceneBuilder,
) -> Result<Vec<RadiiAndMasses>, SceneError> {
    let mut sizes = Vec::with_capacity(files.len());
    for (index, file) in files.iter().enumerate() {
        let at = ConfigPath::entry("file", index);
        let path = directory.join(&file.path);
        let unreadable = |source| SceneErrorKind::Unreadable { path: path.clone(), source };
        let text = brought::read(&path).map_err(|source| SceneError::new(at.key("path"), unreadable(source)))?;
        scene.parts.inputs.push(unchanged(&path, &text, file.checksum.as_deref(), &at)?);
        let mut start = parse(&text, file.frame).map_err(|(line, problem)| {
            SceneError::new(at.key("path"), SceneErrorKind::Coordinates { path: path.clone(), line, problem })
        })?;
        if may_give_box && start.has_box && scene.size.is_none() {
            take_box(&start.frame, space, scene)?;
        }
        if start.frame.displacement != 0.0 {
            scene.parts.displacement = start.frame.displacement;
        }
        add_bonds(&start, file, &path, &at, scene)?;
        if let Some(input) = scene.parts.inputs.last_mut() {
            input.unused = std::mem::take(&mut start.beside.unused);
        }
        sizes.push(RadiiAndMasses::of(&start, path, &at, scene.groups.len()));
        let listed = start.frame.particles.iter().map(|particle| Listed {
            species: start.frame.species[particle.species.0 as usize].name.clone(),
            position: particle.position,
            velocity: particle.velocity,
        });
        scene.push("file", Group::Listed(listed.collect()));
    }
    Ok(sizes)
}

/// Makes the box that of a frame. Sides that the scene does not mention are those of the frame, but for walls, which it does not have
/// from open sides.
fn take_box(frame: &Frame, space: &SpaceFile, scene: &mut SceneBuilder) -> Result<(), SceneError> {
    scene.size = Some(frame.size);
    if space.lower.is_none() {
        scene.parts.space.lower = frame.lower;
    }
    for (k, _) in [&space.x, &space.y, &space.z].into_iter().enumerate().filter(|(_, given)| given.is_none()) {
        scene.parts.space.boundary[k] = match (frame.is_flat(k), frame.periodic[k]) {
            (true, _) => Boundary::Flat,
            (false, true) => Boundary::Periodic,
            (false, false) => {
                let why = "the box of the file is not periodic along it";
                return Err(missing(&ConfigPath::root().key("space"), AXES[k], why));
            }
        };
    }
    Ok(())
}

/// Adds the bonds of a frame: each is held by an interaction of the scene that has the name in the file, or the one that the scene
/// names for all of them.
fn add_bonds(
    start: &Start,
    file: &CoordinatesFile,
    path: &Path,
    at: &ConfigPath,
    scene: &mut SceneBuilder,
) -> Result<(), SceneError> {
    let frame = &start.frame;
    if frame.bonds.is_empty() {
        return Ok(());
    }
    let wrong = |problem: String| {
        let kind = SceneErrorKind::Coordinates { path: path.to_owned(), line: start.comment, problem };
        Err(SceneError::new(at.key("path"), kind))
    };
    let known: Vec<&str> = scene.interactions.iter().filter_map(|draft| draft.name.as_deref()).collect();
    let names: Vec<&str> = match &file.bond {
        Some(name) if known.contains(&name.as_str()) => vec![name],
        Some(name) => return Err(unknown(&at.key("bond"), "interaction", name, known)),
        None if frame.bond_kinds.is_empty() => {
            return wrong(
                "`bonds` do not say which interaction holds them: name one of the scene with `bond` in [[file]]".into(),
            );
        }
        None => frame.bond_names.iter().map(String::as_str).collect(),
    };
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        return wrong(format!(
            "bonds are held by `{name}`, expected the name of an [[interaction]] of the scene{}; `bond` in [[file]] names another",
            if known.is_empty() { ", which has none".to_owned() } else { format!(", {}", known.join(", ")) },
        ));
    }
    let first: usize =
        scene.groups.iter().map(|placed| if let Group::Listed(it) = &placed.group { it.len() } else { 0 }).sum();
    let mut id_of = HashMap::with_capacity(frame.particles.len());
    for (place, particle) in frame.particles.iter().enumerate() {
        if id_of.insert(particle.id, id(first + place)).is_some() {
            return wrong(format!("bonds refer to ids, but two particles have the id {}", particle.id.0));
        }
    }
    let mut bonds = Vec::with_capacity(frame.bonds.len());
    for (index, ends) in frame.bonds.iter().enumerate() {
        let kind = if file.bond.is_some() { 0 } else { frame.bond_kinds[index] as usize };
        let mut pair = [0; 2];
        for (end, id) in ends.iter().zip(&mut pair) {
            let Some(found) = id_of.get(end) else {
                return wrong(format!("bond {}-{} ends at a particle that is not in the frame", ends[0].0, ends[1].0));
            };
            *id = *found;
        }
        if pair[0] == pair[1] {
            return wrong(format!("bond {}-{} holds a particle to itself", ends[0].0, ends[1].0));
        }
        bonds.push(UnvalidatedBond { pair, interaction: names[kind].to_owned(), at: at.key("path") });
    }
    scene.bonds.extend(bonds);
    Ok(())
}

/// Path and checksum of a file, which must have the checksum that the scene has for it.
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

/// A frame, or the line and what is wrong with it.
fn parse(text: &[u8], frame: i64) -> Result<Start, (usize, String)> {
    let lines = || text.iter().filter(|&&byte| byte == b'\n').count().max(1);
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
            let mut all = FrameReader::new(text);
            let mut frames = 0_u64;
            while all.skip_frame().map_err(wrong)? {
                frames += 1;
            }
            frames.checked_sub(frame.unsigned_abs()).ok_or_else(|| ends_after(frames))?
        }
    };
    let mut reader = FrameReader::new(text);
    for passed in 0..from_start {
        if !reader.skip_frame().map_err(wrong)? {
            return Err(ends_after(passed));
        }
    }
    match reader.next() {
        None => Err((lines(), format!("the file ends after {frame} frames, expected frame {frame}"))),
        Some(Err(error)) => Err(wrong(error)),
        Some(Ok(_)) if !reader.has_species() => Err((reader.frame_line() + 1, "Properties has no type:S:1".to_owned())),
        Some(Ok(frame)) => {
            let (has_box, has_radii, comment) = (reader.has_box(), reader.has_radii(), reader.frame_line() + 1);
            Ok(Start { frame, has_box, has_radii, beside: reader.beside(), comment })
        }
    }
}

mod radii_and_masses;

pub(super) use radii_and_masses::RadiiAndMasses;

#[cfg(test)]
mod tests;
