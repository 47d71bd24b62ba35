//! A trajectory in the form that the player of the page reads.
//!
//! Constants (radii, species, static particles, bonds) are stored once. Each frame stores three coordinates
//! of 16 bits and one byte per scalar for every moving particle. Coordinates are wrapped into the box along
//! periodic axes and rounded to the nearest of 65,534 steps of the frame's *field*: the box plus anything
//! outside of it along open axes, up to three edges on each side. Particles beyond the field are left out. A
//! coordinate has an error of at most 1/131,068 of the field. Scalars are rounded to the nearest of 255 steps
//! between the smallest and the largest value of their frame; counts up to 255 are exact.
//!
//! Each frame ends with one bit per particle: whether the particle flies freely until the next frame. Frames
//! are read one at a time. When the frames become too large for the page, every second frame is dropped.

mod channel;
mod flight;
mod frame;
mod look;
mod neighbours;
mod surface;

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

/// Largest size of all frames `[bytes]`; in base64 this is 40 MB.
const MOST_BYTES: usize = 29_000_000;

/// Largest number of frames; a page with more elements opens slowly.
const MOST_FRAMES: usize = 2_000;

/// Radius of a bond, relative to the smaller of its two ends.
const BOND_RADIUS: f64 = 0.36;

/// A trajectory for the player.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recording {
    /// Description of the numbers.
    pub head: Head,
    /// Radii (f32, moving particles first), positions of static particles (f32), ends of bonds (u32), radii
    /// of bonds (f32) and species (u8), in little-endian order.
    pub constants: Vec<u8>,
    /// For each frame: coordinates (u16), padded to four bytes, then each scalar (u8), then bits of free
    /// flights, lowest first.
    pub frames: Vec<Vec<u8>>,
    /// Bytes of the surfaces in the layout of [`SurfaceData`].
    pub surfaces: Option<Vec<u8>>,
    /// Notes on everything in the file that the player does not show.
    pub notes: Vec<String>,
}

/// Description of the numbers in a recording; the player reads it as JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Head {
    pub moving: usize,
    pub fixed: usize,
    pub bonds: usize,
    pub species: Vec<SpeciesHead>,
    pub channels: Vec<ChannelHead>,
    /// Lower and upper corner of the camera's view.
    pub view: [[f64; 3]; 2],
    /// Index of the axis that points up in the picture, and whether it points down instead.
    pub up: usize,
    pub is_upside_down: bool,
    /// Azimuth and elevation of the first view, if requested `[degrees]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<[f64; 2]>,
    /// The first colouring, if requested: the index of a channel, or -1 for species.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<i64>,
    pub flat: [bool; 3],
    pub periodic: [bool; 3],
    /// Accelerations between frames, by species `[length / time^2]`.
    pub falls: Vec<Vec<[f64; 3]>>,
    /// Difference of the velocity along x between a particle and its image one period up along y `[length /
    /// time]`.
    pub slide: f64,
    /// Number of frames in the file.
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

/// A scalar of every moving particle.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ChannelHead {
    pub name: String,
    pub unit: String,
    /// The ends of the colour scale.
    pub low: f64,
    pub high: f64,
    /// Whether some values are above `high`.
    pub is_exceeded: bool,
    /// Whether it is a count.
    pub is_count: bool,
}

/// Positions of the numbers of a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct FrameHead {
    pub time: f64,
    /// Lower corner and edges of the box.
    pub lower: [f64; 3],
    pub size: [f64; 3],
    /// Displacement along x of the periodic image of the box one period up along y.
    pub displacement: f64,
    /// Lower corner and edges of the field.
    pub field: [[f64; 3]; 2],
    /// The smallest and the largest value of each channel.
    pub ranges: Vec<[f64; 2]>,
    /// Number of particles beyond the field.
    pub beyond: usize,
    /// Index of the acceleration until the next frame.
    pub fall: usize,
    /// Position of each surface: the columns of `R` and `d` in `R x + d` for its points `x`, or `None` if it
    /// is absent. Empty if all surfaces are where their vertices say.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<Option<[f64; 12]>>,
    /// Whether each surface of the scene is present.
    #[serde(skip)]
    pub surfaces: Vec<bool>,
}

impl Recording {
    /// Adds surfaces. The camera frames them unless they are much larger than the rest.
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

/// Reads a trajectory; `scene` provides gravity and wells. `Err` says why there is nothing to play.
pub(super) fn read(input: impl BufRead, scene: Option<&Scene>) -> Result<Recording, String> {
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
            notes.push(format!("trajectory.xyz: frame {} has other particles; the player ends before", index + 1));
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
    up: (usize, bool),
    /// Frames with the flights until the next one.
    kept: Vec<(Encoded, Option<Flights>)>,
    /// The last frame read, if it is not kept.
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
        let size = channels.bytes(first.particles.iter().filter(|particle| !first.is_static(particle)).count());
        let most_frames = (MOST_BYTES / size).min(MOST_FRAMES);
        if most_frames < 2 {
            return Err(format!("{} particles are too many for a page", first.particles.len()));
        }
        let flight_finder = FlightFinder::of(&first, scene);
        Ok(Self { first, channels, flight_finder, up, kept: Vec::new(), last: None, stride: 1, seen: 0, most_frames })
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
        let encoded = Encoded::of(frame, &mut self.channels);
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
        // One slot is reserved for the last frame.
        if self.kept.len() >= self.most_frames && self.most_frames > 2 {
            self.thin();
        }
    }

    /// Drops every second frame.
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

/// Flights over two successive intervals. Nothing is known about an interval of zero length.
fn joined(first: Option<Flights>, second: Option<Flights>) -> Option<Flights> {
    match (first, second) {
        (Some(first), Some(second)) => Some(first.then(&second)),
        (first, second) => first.or(second),
    }
}

/// The axis against gravity, and whether it is negative; without gravity z, or y if z is flat.
pub(in crate::view) fn upwards(flat: [bool; 3], scene: Option<&Scene>) -> (usize, bool) {
    let falls = |scene: &Scene| scene.species.iter().map(|species| species.acceleration).find(|a| a.norm() > 0.0);
    match scene.and_then(falls) {
        Some(down) => (down.iamax(), down[down.iamax()] > 0.0),
        None if flat[2] => (if flat[1] { 2 } else { 1 }, false),
        None => (2, false),
    }
}

/// The box of the first frame, or the particles if it is unbounded.
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

/// Constants of all frames, and the number of bonds.
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
        bytes.extend(single(BOND_RADIUS * a.radius.min(b.radius)).to_le_bytes());
    }
    // The recorder accepts no frame with more species.
    bytes.extend(all().map(|particle| u8::try_from(particle.species.0).unwrap_or(u8::MAX)));
    (bytes, bonds.len())
}

#[cfg(test)]
mod tests;
