//! Conversion of trajectories from extended XYZ to formats of other programs.
//!
//! | format | file | precision | contents |
//! |---|---|---|---|
//! | [`Format::Lammps`] | text dump | exact | box and its flags, time, id, species, position, velocity, radius |
//! | [`Format::Gsd`] | GSD 2.0, schema `hoomd` 1.4 | `f32` | box, time, species, position, velocity, diameter, mass, bonds |
//! | [`Format::Vtk`] | a folder: `.vtp` per frame, `.pvd` with the times, the box | exact | everything except masses |
//! | [`Format::Npy`] | a folder of NumPy arrays | exact | everything |
//! | [`Format::Csv`] | one table | exact | time, id, species, position, velocity, radius |
//! | [`Format::Xyz`] | extended XYZ, compressed if its name ends with `.gz` or `.zst` | exact | everything |
//!
//! At most two frames are in memory. Unfinished files have names that end with `.partial`.

mod bonds;
mod error;
mod packed;
mod series;
mod target;
#[cfg(test)]
pub(crate) mod tests;

use std::io::BufRead;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

pub use error::{ConvertError, FrameError};
pub use series::FrameSeries;

pub(super) use bonds::bond_ends;
pub(super) use target::{Draft, draft, finish, foreign_in, remove_converted};

use super::atomic::folder_of;
use super::folder::TRAJECTORY;
use super::owned::note;
use super::{csv, gsd, lammps, npy, vtk};
use crate::model::Format;
use crate::trajectory::extended_xyz::{FrameReader, ReadError, write_frame};
use crate::trajectory::{Frame, compressed};
use packed::{Compressed, Text};
use target::Target;

impl Format {
    /// Returns the default path of a conversion: the path of the source with another extension or suffix.
    #[must_use]
    pub fn target_beside(self, source: &Path) -> PathBuf {
        let ending = match self {
            Self::Lammps => ".lammpstrj",
            Self::Gsd => ".gsd",
            Self::Vtk => "-vtk",
            Self::Npy => "-npy",
            Self::Csv => ".csv",
            Self::Xyz => "-piece.xyz",
        };
        let mut name = source.file_stem().unwrap_or_default().to_owned();
        name.push(ending);
        source.with_file_name(name)
    }

    /// Returns the format for a name, such as GSD for a name that ends with `.gsd`. See [`Self::ENDINGS`].
    #[must_use]
    pub fn of_name(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        let is_ending = |ending: &str| name.len() > ending.len() && name.ends_with(ending);
        Self::ENDINGS.into_iter().find(|(_, ending)| is_ending(ending)).map(|(format, _)| format)
    }

    /// File name extensions and folder name suffixes, by format.
    pub const ENDINGS: [(Self, &str); 12] = [
        (Self::Lammps, ".lammpstrj"),
        (Self::Lammps, ".lammps"),
        (Self::Gsd, ".gsd"),
        (Self::Vtk, "-vtk"),
        (Self::Npy, "-npy"),
        (Self::Csv, ".csv"),
        (Self::Xyz, ".extxyz"),
        (Self::Xyz, ".xyz"),
        (Self::Xyz, ".extxyz.gz"),
        (Self::Xyz, ".xyz.gz"),
        (Self::Xyz, ".extxyz.zst"),
        (Self::Xyz, ".xyz.zst"),
    ];

    /// Whether the output is a folder of files.
    #[must_use]
    pub fn is_folder(self) -> bool {
        self.folder_of().is_some()
    }

    /// Returns the name of a converted trajectory in the list of a run's files.
    pub(super) fn listed(self) -> String {
        let name = self.target_beside(Path::new(TRAJECTORY));
        format!("{}{}", name.display(), if self.is_folder() { "/" } else { "" })
    }

    /// Returns the format that writes the listed folder.
    pub(super) fn filling(listed: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.is_folder() && format.listed() == listed)
    }

    /// Extensions of the files in an output folder. `None` if the format is a single file.
    fn folder_of(self) -> Option<&'static [&'static str]> {
        match self {
            Self::Vtk => Some(&["vtp", "pvd"]),
            Self::Npy => Some(&["npy"]),
            _ => None,
        }
    }
}

/// Options of a conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// Index of the first frame to convert, from 0.
    pub first: u64,
    /// Index of the last frame to convert. By default, all later frames are converted.
    pub last: Option<u64>,
    /// Whether to replace an existing file, or a folder with only files of the format.
    pub replace: bool,
}

/// Result of a conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Converted {
    /// Number of frames written.
    pub frames: u64,
    /// Whether the last frame of the source is incomplete and was skipped, for example because the run was killed.
    pub is_truncated: bool,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Moment<'a> {
    pub index: u64,
    pub frame: &'a Frame,
    pub has_velocities: bool,
}

pub(super) trait Writer: Send {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError>;

    /// Writes the data after all frames, and syncs all files to disk.
    fn finish(self: Box<Self>) -> Result<(), FrameError>;
}

/// Converts a trajectory in extended XYZ, frame by frame.
///
/// Existing output is replaced only if the options permit it. A folder is replaced only if it contains only files of
/// the format. Failed conversions leave no output. The conversions of a run at [`Format::target_beside`] are removed
/// when a new run replaces the run.
///
/// # Errors
/// - [`ConvertError::Read`] if the source cannot be read, is malformed or has no frames;
/// - [`ConvertError::NoSuchFrame`] if the source ends before the first requested frame;
/// - [`ConvertError::Exists`], [`ConvertError::Foreign`], [`ConvertError::Source`] if the target may not be replaced;
/// - [`ConvertError::Frame`] if the format cannot represent a frame;
/// - [`ConvertError::Surface`] if the format has surfaces, and the file of a surface cannot be read;
/// - [`ConvertError::Write`] if the target cannot be written.
pub fn convert(source: &Path, format: Format, target: &Path, options: &Options) -> Result<Converted, ConvertError> {
    convert_watched((source, format, target), options, &mut || ControlFlow::Continue(()))
}

/// Converts a trajectory as [`convert`] does, and calls `watch` after each frame.
///
/// # Errors
/// The errors of [`convert`]. [`ConvertError::Interrupted`] if `watch` breaks; the output is then removed.
pub fn convert_watched(
    (source, format, target): (&Path, Format, &Path),
    options: &Options,
    watch: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Converted, ConvertError> {
    let read_error = |error| ConvertError::Read { path: source.to_owned(), source: error };
    if format != Format::Xyz && Compressed::of_name(target).is_some() {
        return Err(ConvertError::Compressed(target.to_owned()));
    }
    let text = compressed::open(source);
    let mut reader =
        FrameReader::new(text.map_err(|error| read_error(ReadError::Open { path: source.into(), source: error }))?);
    let mut reading = Reading { index: 0, is_truncated: false };
    while reading.index < options.first {
        if reading.next(&mut reader).map_err(read_error)?.is_none() {
            return Err(reading.ended_early(source, options.first));
        }
        go_on(watch)?;
    }
    let mut next = reading.next(&mut reader).map_err(read_error)?;
    if next.is_none() {
        return Err(reading.ended_early(source, options.first));
    }
    let place = target;
    let target = Target::claim(target, format, Some(source), options.replace)?;
    let mut writer = open(format, &target, Some(source))?;
    let mut frames = 0;
    while let Some(frame) = next {
        let index = reading.index - 1;
        let moment = Moment { index, frame: &frame, has_velocities: reader.has_velocities() };
        writer.write(&moment).map_err(|error| error.at(Some(source), index, target.path()))?;
        frames += 1;
        go_on(watch)?;
        if options.last.is_some_and(|last| index >= last) {
            break;
        }
        next = reading.next(&mut reader).map_err(read_error)?;
    }
    writer.finish().map_err(|error| error.at(Some(source), reading.index.saturating_sub(1), target.path()))?;
    target.complete()?;
    if is_listed(source, format, place) {
        note(place);
    }
    Ok(Converted { frames, is_truncated: reading.is_truncated })
}

fn go_on(watch: &mut dyn FnMut() -> ControlFlow<()>) -> Result<(), ConvertError> {
    if watch().is_break() { Err(ConvertError::Interrupted) } else { Ok(()) }
}

/// Whether the source is the trajectory of a run, and the target is its default path.
fn is_listed(source: &Path, format: Format, target: &Path) -> bool {
    let expected = format.target_beside(source);
    let [one, other] = [source, target].map(|path| std::fs::canonicalize(folder_of(path)).ok());
    let is_beside = one.is_some() && one == other;
    source.file_name() == Some(TRAJECTORY.as_ref()) && expected.file_name() == target.file_name() && is_beside
}

struct Reading {
    index: u64,
    is_truncated: bool,
}

impl Reading {
    /// A truncated first frame is an error. A truncated later frame ends the file.
    fn next(&mut self, reader: &mut FrameReader<Box<dyn BufRead>>) -> Result<Option<Frame>, ReadError> {
        match reader.next() {
            Some(Ok(frame)) => {
                self.index += 1;
                Ok(Some(frame))
            }
            Some(Err(ReadError::Truncated { .. })) if self.index > 0 => {
                self.is_truncated = true;
                Ok(None)
            }
            Some(Err(error)) => Err(error),
            None => Ok(None),
        }
    }

    fn ended_early(&self, source: &Path, first: u64) -> ConvertError {
        let path = source.to_owned();
        match self.index {
            0 => ConvertError::Read { path, source: ReadError::NoFrame },
            count => ConvertError::NoSuchFrame { path, first, count },
        }
    }
}

fn open(format: Format, target: &Target, source: Option<&Path>) -> Result<Box<dyn Writer>, ConvertError> {
    let file = || draft(target.partial()).map_err(ConvertError::write(target.partial()));
    Ok(match format {
        Format::Lammps => Box::new(lammps::Dump::new(file()?)),
        Format::Gsd => Box::new(gsd::Trajectory::new(file()?)),
        Format::Csv => Box::new(csv::Table::new(file()?)),
        Format::Xyz => Box::new(Piece(Text::new(file()?, Compressed::of_name(target.path())))),
        Format::Vtk => {
            let unreadable = |(path, problem)| ConvertError::Surface { path, problem };
            let surfaces = source.map(vtk::Surfaces::beside).transpose().map_err(unreadable)?.unwrap_or_default();
            Box::new(vtk::Series::new(target.partial(), surfaces))
        }
        Format::Npy => Box::new(npy::Arrays::new(target.partial())),
    })
}

/// Writes extended XYZ. If the source has no velocities, they are written as zero.
struct Piece(Text);

impl Writer for Piece {
    fn write(&mut self, moment: &Moment) -> Result<(), FrameError> {
        Ok(write_frame(&mut self.0, moment.frame)?)
    }

    fn finish(self: Box<Self>) -> Result<(), FrameError> {
        Ok(self.0.finish()?)
    }
}
