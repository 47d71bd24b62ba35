//! A trajectory for the player of the page.
//!
//! Radii, species, static particles and bonds are constant and are stored once. A frame stores three coordinates of 16
//! bits and one byte per scalar for each moving particle. Coordinates are wrapped into the box along periodic axes, and
//! rounded to 65,534 steps of the *field*. The field is the box, extended along open axes to particles up to three edge
//! lengths outside. Farther particles are left out. Scalars are rounded to 255 steps between the smallest and the
//! largest value in the frame. If particles have spins, a frame also stores their orientations, in four bytes each.
//!
//! Each frame ends with one bit per particle, which is set if the particle flies freely until the next frame. If the
//! frames become too large for the page, every second frame is dropped.

mod channel;
mod flight;
mod frame;
mod look;
mod neighbours;
mod surface;
mod turns;

use std::collections::HashMap;
use std::io::BufRead;

use serde::Serialize;

use crate::Vector;
use crate::base::numbers::single;
use crate::model::Scene;
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::FrameReader;
use crate::trajectory::frame::FrameParticle;
use crate::view::Surfaces;
use channel::Channels;
use flight::{FlightFinder, Flights};
use frame::Encoded;
pub(in crate::view) use surface::{MOST_TRIANGLES, SurfaceData, SurfaceHead};
use turns::Turns;

/// Maximum total size of all frames `[bytes]`. In base64, the size is about 39 MB.
const MOST_BYTES: usize = 29_000_000;

const MOST_FRAMES: usize = 2_000;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recording {
    pub head: Head,
    /// Constants, little-endian: radii (f32, moving particles first), positions of static particles (f32), indices of
    /// bonded particles (u32), radii of bonds (f32) and species (u8).
    pub constants: Vec<u8>,
    /// Bytes of each frame: coordinates (u16), padded to a multiple of four bytes, orientations if particles have spins
    /// (four i8), each scalar (u8), and free flights (a bit per particle, lowest bit first).
    pub frames: Vec<Vec<u8>>,
    /// Bytes of the surfaces in the layout of [`SurfaceData`].
    pub surfaces: Option<Vec<u8>>,
    /// Notes on parts of the file that the player does not show.
    pub notes: Vec<String>,
}

/// Description of a recording, as JSON for the player.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Head {
    pub moving: usize,
    pub fixed: usize,
    pub bonds: usize,
    pub species: Vec<SpeciesHead>,
    pub channels: Vec<ChannelHead>,
    /// Whether the frames contain orientations.
    pub has_turns: bool,
    /// Corners of the first view.
    pub view: [[f64; 3]; 2],
    /// Vertical axis of the picture. The axis points down if `is_upside_down` is set.
    pub up: usize,
    pub is_upside_down: bool,
    /// Azimuth and elevation of the first view, if the scene sets them `[degrees]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<[f64; 2]>,
    /// Colours of the first picture, if the scene sets them. The number is the index of a channel, or -1 for species.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<i64>,
    pub flat: [bool; 3],
    pub periodic: [bool; 3],
    /// Accelerations `[length / time^2]` of each species: first for the scene, then for each stage with its own
    /// gravity.
    pub falls: Vec<Vec<[f64; 3]>>,
    /// Velocity along x of a particle relative to its next image along y in a sheared box `[length / time]`.
    pub slide: f64,
    pub frames_in_file: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surfaces: Option<SurfaceHead>,
    pub frames: Vec<FrameHead>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SpeciesHead {
    pub name: String,
    pub is_static: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ChannelHead {
    pub name: String,
    pub unit: String,
    pub low: f64,
    pub high: f64,
    pub is_exceeded: bool,
    pub is_count: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct FrameHead {
    pub time: f64,
    pub lower: [f64; 3],
    pub size: [f64; 3],
    /// Shift along x of the next image along y in a sheared box `[length]`.
    pub displacement: f64,
    /// Lower corner and edges of the field.
    pub field: [[f64; 3]; 2],
    /// Smallest and largest value of each channel, stored as the bytes 0 and 255.
    pub ranges: Vec<[f64; 2]>,
    pub beyond: usize,
    /// Index in [`Head::falls`] of the accelerations until the next frame.
    pub fall: usize,
    /// Pose of each surface: the columns of the rotation `R`, then the displacement `d`. A vertex `x` is drawn at the
    /// point `R x + d`. An absent surface has no pose. The list is empty if all surfaces are present and at rest.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<Option<[f64; 12]>>,
    /// Whether each surface of the scene is present.
    #[serde(skip)]
    pub surfaces: Vec<bool>,
}

impl Recording {
    /// Adds surfaces to the recording. Surfaces that are far too large do not extend the view.
    pub fn add_surfaces(&mut self, surfaces: &Surfaces) {
        let Some(SurfaceData { head, bytes }) = SurfaceData::of(surfaces) else { return };
        for frame in &mut self.head.frames {
            frame.poses = surfaces.poses(frame.time, &frame.surfaces);
        }
        let surfaces = &surfaces.clone().around(self.head.frames.iter().map(|frame| frame.time));
        let view = self.head.view.map(Vector::from);
        let [lower, upper] =
            surfaces.framed(view).iter().fold(view, |[lower, upper], corner| [lower.inf(corner), upper.sup(corner)]);
        self.head.view = [lower.into(), upper.into()];
        self.head.surfaces = Some(head);
        self.surfaces = Some(bytes);
    }
}

/// Reads a trajectory for the player. The scene provides gravity and the ranges of wells. The error is the reason why
/// there is no player.
pub(super) fn read(input: impl BufRead, scene: Option<&Scene>) -> Result<Recording, String> {
    if scene.is_some_and(Scene::has_flow) {
        return Err("particles enter or leave, and the player shows the same particles at all times".to_owned());
    }
    let mut notes = Vec::new();
    let mut recorder: Option<Recorder> = None;
    for (index, frame) in FrameReader::new(input).enumerate() {
        let frame = match frame {
            Ok(frame) => frame,
            Err(error) if recorder.is_none() => return Err(error.to_string()),
            Err(error) => {
                notes.push(format!("trajectory.xyz: {error}; the player ends before"));
                break;
            }
        };
        let recorder = match &mut recorder {
            Some(recorder) => recorder,
            none => none.insert(Recorder::new(frame.clone(), scene)?),
        };
        if !recorder.is_like_first(&frame) {
            let what = "has other particles, or particles of other species";
            notes.push(format!("trajectory.xyz: frame {} {what}; the player ends before", index + 1));
            break;
        }
        recorder.push(&frame);
    }
    let recorder = recorder.ok_or("the file holds no frame")?;
    Ok(recorder.finish(notes))
}

struct Recorder {
    first: Frame,
    channels: Channels,
    flight_finder: FlightFinder,
    turns: Option<Turns>,
    up: (usize, bool),
    /// Recorded frames. The flights last until the next recorded frame.
    kept: Vec<(Encoded, Option<Flights>)>,
    /// Last frame of the file so far, if it is not recorded.
    last: Option<Encoded>,
    stride: usize,
    seen: usize,
    most_frames: usize,
}

impl Recorder {
    fn new(first: Frame, scene: Option<&Scene>) -> Result<Self, String> {
        if first.particles.is_empty() {
            return Err("the first frame has no particles".to_owned());
        }
        if first.species.len() > 255 {
            return Err("there are more than 255 species".to_owned());
        }
        let up = upwards([0, 1, 2].map(|axis| first.is_flat(axis)), scene);
        let channels = Channels::of(&first, scene, up);
        let turns = Turns::of(&first);
        let moving = first.particles.iter().filter(|particle| !first.is_static(particle)).count();
        let size = channels.bytes(moving) + if turns.is_some() { turns::BYTES * moving } else { 0 };
        let most_frames = (MOST_BYTES / size).min(MOST_FRAMES);
        if most_frames < 2 {
            return Err(format!("{} particles are too many for a page", first.particles.len()));
        }
        let flight_finder = FlightFinder::of(&first, scene);
        let (kept, last, stride, seen) = (Vec::new(), None, 1, 0);
        Ok(Self { first, channels, flight_finder, turns, up, kept, last, stride, seen, most_frames })
    }

    fn is_like_first(&self, frame: &Frame) -> bool {
        let is_same =
            |(a, b): (&FrameParticle, &FrameParticle)| (a.id, a.species, a.radius) == (b.id, b.species, b.radius);
        frame.particles.len() == self.first.particles.len()
            && frame.species == self.first.species
            && frame.bonds == self.first.bonds
            && frame.particles.iter().zip(&self.first.particles).all(is_same)
    }

    fn push(&mut self, frame: &Frame) {
        if let Some(turns) = &mut self.turns {
            turns.advance(frame);
        }
        let encoded = Encoded::of(frame, &mut self.channels, self.turns.as_ref());
        let flights = self.flight_finder.next(frame);
        if let Some((_, since)) = self.kept.last_mut() {
            *since = joined(since.take(), flights);
        }
        if self.seen.is_multiple_of(self.stride) {
            self.kept.push((encoded, None));
            self.last = None;
        } else {
            self.last = Some(encoded);
        }
        self.seen += 1;
        // One frame is reserved for the last frame of the file.
        if self.kept.len() >= self.most_frames && self.most_frames > 2 {
            self.thin();
        }
    }

    fn thin(&mut self) {
        let mut kept: Vec<(Encoded, Option<Flights>)> = Vec::with_capacity(self.most_frames);
        for (index, (encoded, flights)) in self.kept.drain(..).enumerate() {
            match kept.last_mut() {
                Some((_, since)) if index % 2 == 1 => {
                    *since = joined(since.take(), flights);
                    self.last = Some(encoded);
                }
                _ => {
                    kept.push((encoded, flights));
                    self.last = None;
                }
            }
        }
        self.kept = kept;
        self.stride *= 2;
    }

    fn finish(mut self, notes: Vec<String>) -> Recording {
        self.kept.extend(self.last.take().map(|last| (last, None)));
        let first = &self.first;
        let fixed = first.particles.iter().filter(|particle| first.is_static(particle)).count();
        let moving = first.particles.len() - fixed;
        let complete = |(encoded, flights): (Encoded, Option<Flights>)| encoded.with_flights(flights.as_ref(), moving);
        let (heads, frames): (Vec<FrameHead>, Vec<Vec<u8>>) = self.kept.into_iter().map(complete).unzip();
        let species = first
            .species
            .iter()
            .map(|species| SpeciesHead { name: species.name.clone(), is_static: species.is_static });
        let (constants, bonds) = constants(first);
        let head = Head {
            moving,
            fixed,
            bonds,
            species: species.collect(),
            channels: self.channels.heads(),
            has_turns: self.turns.is_some(),
            view: view(first, &heads),
            up: self.up.0,
            is_upside_down: self.up.1,
            look: None,
            colour: None,
            flat: [0, 1, 2].map(|axis| first.is_flat(axis)),
            periodic: first.periodic,
            falls: self.flight_finder.falls.iter().map(|fall| fall.iter().map(|a| (*a).into()).collect()).collect(),
            slide: self.flight_finder.slide,
            frames_in_file: self.seen,
            surfaces: None,
            frames: heads,
        };
        Recording { head, constants, frames, surfaces: None, notes }
    }
}

/// Joins the flights of two successive intervals. `None` stands for an empty interval.
fn joined(first: Option<Flights>, second: Option<Flights>) -> Option<Flights> {
    match (first, second) {
        (Some(first), Some(second)) => Some(first.then(&second)),
        (first, second) => first.or(second),
    }
}

/// Returns the vertical axis, and whether it points down. Up is against gravity. Without gravity, up is z, or y if z is
/// flat.
pub(in crate::view) fn upwards(flat: [bool; 3], scene: Option<&Scene>) -> (usize, bool) {
    let falls = |scene: &Scene| scene.species.iter().map(|species| species.acceleration).find(|a| a.norm() > 0.0);
    match scene.and_then(falls) {
        Some(down) => (down.iamax(), down[down.iamax()] > 0.0),
        None if flat[2] => (if flat[1] { 2 } else { 1 }, false),
        None => (2, false),
    }
}

/// Returns the corners of the box in the first frame. Without a box, returns the corners of all particles in all
/// frames.
fn view(first: &Frame, heads: &[FrameHead]) -> [[f64; 3]; 2] {
    if first.size.iter().any(|edge| *edge > 0.0) {
        return [first.lower.into(), (first.lower + first.size).into()];
    }
    let ends = heads.iter().map(|FrameHead { field: [lower, size], .. }| [*lower, axes(|k| lower[k] + size[k])]);
    let joined = ends.reduce(|a, b| [axes(|k| a[0][k].min(b[0][k])), axes(|k| a[1][k].max(b[1][k]))]);
    joined.unwrap_or_default()
}

fn axes(value: impl Fn(usize) -> f64) -> [f64; 3] {
    [0, 1, 2].map(value)
}

fn constants(first: &Frame) -> (Vec<u8>, usize) {
    let (fixed, moving): (Vec<&FrameParticle>, Vec<&FrameParticle>) =
        first.particles.iter().partition(|particle| first.is_static(particle));
    let all = || moving.iter().chain(&fixed);
    let place: HashMap<_, (u32, &FrameParticle)> =
        (0_u32..).zip(all()).map(|(k, particle)| (particle.id, (k, *particle))).collect();
    let bonds: Vec<_> = first.bonds.iter().filter_map(|[a, b]| Some([*place.get(a)?, *place.get(b)?])).collect();
    let mut bytes = Vec::new();
    let mut push = |x: f64| bytes.extend(single(x).to_le_bytes());
    all().for_each(|particle| push(particle.radius));
    for particle in &fixed {
        let inside = first.wrapped(&particle.position);
        inside.iter().for_each(|x| push(*x));
    }
    bonds.iter().flatten().for_each(|(index, _)| bytes.extend(index.to_le_bytes()));
    for [(_, a), (_, b)] in &bonds {
        bytes.extend(single(crate::view::render::BOND_RADIUS * a.radius.min(b.radius)).to_le_bytes());
    }
    // There are at most 255 species.
    bytes.extend(all().map(|particle| u8::try_from(particle.species.0).unwrap_or(u8::MAX)));
    (bytes, bonds.len())
}

#[cfg(test)]
mod tests;
