//! Index of a trajectory: the place of each frame, and data that all images need.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use super::{MovieProgress, Watch};
use crate::Vector;
use crate::trajectory::Frame;
use crate::trajectory::compressed::is_compressed;
use crate::trajectory::extended_xyz::{FrameReader, Preamble, ReadError, bounds};
use crate::view::render::{
    Extent, Framing, Scale, Shot, Style, corners, fitted, joined, reach, refuse_numbers, shown_numbers,
};
use crate::view::{Surfaces, ViewError};

/// Number of frames that determine the extent of the particles.
const PROBES: usize = 8;

#[derive(Debug, Clone, Copy)]
pub(super) struct Selection {
    pub first: u64,
    pub last: Option<u64>,
    pub every: u64,
}

impl Selection {
    fn has(&self, index: u64) -> bool {
        index >= self.first && !self.is_over(index) && (index - self.first).is_multiple_of(self.every)
    }

    fn is_over(&self, index: u64) -> bool {
        self.last.is_some_and(|last| index > last)
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Index of the frame in the file, from 0.
    pub index: u64,
    pub time: f64,
    offset: u64,
    lines: usize,
}

#[derive(Debug)]
pub(super) struct Index {
    pub places: Vec<Place>,
    pub most_particles: u64,
    pub is_truncated: bool,
    /// First frame, without particles.
    stage: Frame,
    framing: Framing,
    /// Lower corner and edges of a region `[length]`. It contains the boxes or the particles of all frames.
    region: Option<(Vector, Vector)>,
    /// Largest radius `[length]`. Particles with centres in the region may extend beyond it by this radius.
    margin: f64,
    /// Corners of the region of the particles in a few frames `[length]`.
    reach: Option<[Vector; 2]>,
    scale: Scale,
}

type Reader = FrameReader<BufReader<File>>;

impl Index {
    /// Scans a file. Particles are read only if there is a scale of speeds or no box.
    ///
    /// # Errors
    /// [`ViewError::Trajectory`], [`ViewError::NotFile`], [`ViewError::NoSuchFrame`] or [`ViewError::Frame`] if no
    /// frame can be drawn, [`ViewError::EmptyMovie`] if there are no particles, [`ViewError::Interrupted`] if `watch`
    /// returns `Break`.
    pub fn of(path: &Path, selection: Selection, style: &Style, watch: &mut Watch) -> Result<Self, ViewError> {
        let unreadable = ViewError::trajectory(path);
        let file = open(path)?;
        let metadata = file.metadata().map_err(|source| unreadable(ReadError::Open { path: path.into(), source }))?;
        if !metadata.is_file() {
            return Err(ViewError::NotFile(path.to_owned()));
        }
        let mut input = BufReader::with_capacity(1 << 16, file);
        let start = input.fill_buf().map_err(|source| unreadable(ReadError::Open { path: path.into(), source }))?;
        if is_compressed(start) {
            return Err(unreadable(ReadError::Compressed(path.to_owned())));
        }
        let mut reader = FrameReader::new(input);
        let mut survey = Survey { style, path, index: None, needs_numbers: false, is_truncated: false };
        let mut count = 0;
        while !selection.is_over(count) {
            let (lines, input) = reader.place();
            let offset = input.stream_position().map_err(|source| unreadable(ReadError::Io { line: lines, source }))?;
            let place = Place { index: count, time: 0.0, offset, lines };
            let found = if selection.has(count) { survey.add(&mut reader, place) } else { pass(&mut reader, path) };
            match found {
                Ok(true) => count += 1,
                Ok(false) => break,
                Err(ViewError::Trajectory { source: ReadError::Truncated { .. }, .. }) if count > 0 => {
                    survey.is_truncated = true;
                    break;
                }
                Err(error) => return Err(error),
            }
            let time = survey.index.as_ref().and_then(|index| index.places.last()).map_or(0.0, |place| place.time);
            let fraction = (offset as f64 / metadata.len().max(1) as f64).min(1.0);
            if watch(&MovieProgress { is_drawing: false, frames: count, time, fraction }).is_break() {
                return Err(ViewError::Interrupted);
            }
        }
        match survey.index {
            Some(index) => Self { is_truncated: survey.is_truncated, ..index }.completed(path),
            None if count == 0 => Err(unreadable(ReadError::NoFrame)),
            None => Err(ViewError::NoSuchFrame { path: path.to_owned(), first: selection.first, count }),
        }
    }

    /// Determines the extent of the particles from a few frames.
    fn completed(mut self, path: &Path) -> Result<Self, ViewError> {
        if self.most_particles == 0 {
            return Err(ViewError::EmptyMovie(path.to_owned()));
        }
        let (Framing::Box | Framing::Fitted, Some((lower, size))) = (self.framing, self.region) else {
            return Ok(self);
        };
        let upper = lower + size;
        let is_inside = |position: &Vector| (0..3).all(|k| (lower[k]..=upper[k]).contains(&position[k]));
        let probes = if self.framing == Framing::Fitted { PROBES } else { 2 };
        for place in self.spread(probes).collect::<Vec<_>>() {
            let frame = self.read(path, place)?;
            let own = reach(&frame, &Surfaces::default());
            self.reach = Some(self.reach.map_or(own, |all| joined(all, own)));
            let inside = frame.particles.iter().filter(|particle| is_inside(&particle.position));
            self.margin = inside.map(|particle| particle.radius).fold(self.margin, f64::max);
        }
        Ok(self)
    }

    pub fn shot(&self, surfaces: &Surfaces, style: &Style, turn: f64) -> Result<Shot, ViewError> {
        let (lower, size) = self.region.unwrap_or((self.stage.lower, self.stage.size));
        let surfaces = surfaces.clone().around(self.places.iter().map(|place| place.time));
        let (lower, size) = match self.reach.filter(|_| self.framing == Framing::Fitted) {
            Some(particles) => {
                let all = joined(particles, reach(&self.stage, &surfaces));
                fitted((lower, size), self.stage.periodic, &all, style)
            }
            None => (lower, size),
        };
        let framed = corners(&lower, &size).map(|position| Extent { position, radius: self.margin });
        Shot::new((self.stage.clone(), surfaces), style, framed.to_vec(), turn, self.scale)
    }

    pub fn read(&self, path: &Path, place: usize) -> Result<Frame, ViewError> {
        let Place { offset, lines, .. } = self.places[place];
        let unreadable = ViewError::trajectory(path);
        let mut file = open(path)?;
        file.seek(SeekFrom::Start(offset)).map_err(|source| unreadable(ReadError::Io { line: lines, source }))?;
        match FrameReader::behind(BufReader::with_capacity(1 << 16, file), lines).next() {
            Some(Ok(frame)) => Ok(frame),
            Some(Err(ReadError::Truncated { .. })) | None => Err(ViewError::Changed(path.to_owned())),
            Some(Err(source)) => Err(unreadable(source)),
        }
    }

    /// Returns the indices of up to `count` evenly spaced frames.
    pub fn spread(&self, count: usize) -> impl Iterator<Item = usize> {
        let last = self.places.len() - 1;
        let count = count.min(self.places.len());
        (0..count).map(move |k| k * last / (count - 1).max(1))
    }

    pub fn fault(&self, path: &Path, place: usize, source: ViewError) -> ViewError {
        ViewError::Frame { path: path.to_owned(), index: self.places[place].index, source: Box::new(source) }
    }
}

fn open(path: &Path) -> Result<File, ViewError> {
    File::open(path).map_err(|source| ViewError::trajectory(path)(ReadError::Open { path: path.into(), source }))
}

/// Skips a frame. Returns `false` at the end of the trajectory.
fn pass(reader: &mut Reader, path: &Path) -> Result<bool, ViewError> {
    let found = reader.next_preamble();
    found.map(|found| found.is_some()).map_err(|source| ViewError::Trajectory { path: path.to_owned(), source })
}

struct Survey<'a> {
    style: &'a Style,
    path: &'a Path,
    index: Option<Index>,
    needs_numbers: bool,
    is_truncated: bool,
}

impl Survey<'_> {
    /// Adds a frame. Returns `false` at the end of the trajectory.
    fn add(&mut self, reader: &mut Reader, place: Place) -> Result<bool, ViewError> {
        let unreadable = |source| ViewError::Trajectory { path: self.path.to_owned(), source };
        let is_first = self.index.is_none();
        if is_first || self.needs_numbers {
            let Some(frame) = reader.next().transpose().map_err(unreadable)? else { return Ok(false) };
            let refused =
                |source| ViewError::Frame { path: self.path.to_owned(), index: place.index, source: Box::new(source) };
            refuse_numbers(&frame).map_err(refused)?;
            let scale = Scale::of(&frame, &shown_numbers(&frame, self.style).map_err(refused)?, self.style);
            let frame_time = frame.time;
            let has_box = reader.has_box() && frame.size.iter().any(|edge| *edge > 0.0);
            let framing = if has_box { self.style.framing } else { Framing::Particles };
            let framing = self.index.as_ref().map_or(framing, |index| index.framing);
            self.needs_numbers = self.style.colour_by.has_scale() || framing == Framing::Particles;
            self.add_frame(frame, scale, Place { time: frame_time, ..place }, framing);
            return Ok(true);
        }
        let Some(Preamble { count, time, region }) = reader.next_preamble().map_err(unreadable)? else {
            return Ok(false);
        };
        if let Some(index) = &mut self.index {
            index.places.push(Place { time, ..place });
            index.most_particles = index.most_particles.max(count as u64);
            index.region = joined_regions(index.region, region);
        }
        Ok(true)
    }

    fn add_frame(&mut self, frame: Frame, scale: Scale, place: Place, framing: Framing) {
        let region = match framing {
            Framing::Box | Framing::Fitted => Some((frame.lower, frame.size)),
            Framing::Particles => (!frame.particles.is_empty()).then(|| bounds(&frame.particles)),
        };
        let most_particles = frame.particles.len() as u64;
        match &mut self.index {
            Some(index) => {
                index.places.push(place);
                index.most_particles = index.most_particles.max(most_particles);
                index.scale = index.scale.joined(&scale);
                index.region = joined_regions(index.region, region);
            }
            none => {
                let (particles, images, scalars) = (Vec::new(), Vec::new(), Vec::new());
                let stage = Frame { particles, images, scalars, bonds: Vec::new(), bond_kinds: Vec::new(), ..frame };
                let (places, is_truncated, margin, reach) = (vec![place], false, 0.0, None);
                *none =
                    Some(Index { places, most_particles, is_truncated, stage, framing, region, margin, reach, scale });
            }
        }
    }
}

/// Returns the smallest box that contains two boxes. A box is given by its lower corner and its edges.
fn joined_regions(one: Option<(Vector, Vector)>, other: Option<(Vector, Vector)>) -> Option<(Vector, Vector)> {
    let (Some((lower_1, size_1)), Some((lower_2, size_2))) = (one, other) else { return one.or(other) };
    let [lower, upper] = joined([lower_1, lower_1 + size_1], [lower_2, lower_2 + size_2]);
    Some((lower, upper - lower))
}
