//! Movies of a trajectory as GIF, APNG or MP4. Each frame is drawn by [`render`].
//!
//! All images have the same framing and the same scale of speeds. The framing shows the box, or else all particles of
//! all frames. The camera may move around the scene at constant speed. Each image shows the simulated time and a scale
//! bar. In perspective, the bar is valid in the middle of the scene.
//!
//! | format | how | colours |
//! |---|---|---|
//! | [`MovieFormat::Gif`] | by the crate `gif` | 256, the same in all images, chosen by NeuQuant from a few of them |
//! | [`MovieFormat::Apng`] | by the crate `png` | all |
//! | [`MovieFormat::Mp4`] | by the program `ffmpeg`, which receives the images through a pipe | H.264, or MPEG-4 if ffmpeg lacks it |
//!
//! GIF and APNG store only the changes from image to image, and repeat for ever. Frames are drawn and compressed in
//! parallel. The number of cores does not affect the bytes of GIF and APNG.
//!
//! ```no_run
//! use carom::io::Existing;
//! use carom::view::movie::{self, Movie};
//! use std::ops::ControlFlow;
//!
//! let movie = Movie { frames_per_second: 30, turn: 0.0, ..Movie::default() };
//! let go_on = &mut |_: &movie::MovieProgress| ControlFlow::Continue(());
//! let done = movie::write("runs/hopper/trajectory.xyz".as_ref(), "hopper.gif".as_ref(), &movie, Existing::Keep, go_on)?;
//! println!("{} frames", done.frames);
//! # Ok::<(), carom::view::ViewError>(())
//! ```

mod apng;
mod changes;
mod clock;
mod ffmpeg;
mod follow;
mod gif;
mod index;
mod palette;
mod pipeline;
mod process;
#[cfg(test)]
mod tests;
mod track;

use std::cell::{Cell, RefCell};
use std::fs;
use std::io::BufWriter;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::render::{self, BYTES_PER_PIXEL, Image, Shot, Style, Team};
use super::{Surfaces, ViewError};
use crate::base::memory;
use crate::base::numbers::index as count_of;
use crate::io::Existing;
use crate::io::draft::UnnamedFile;
use clock::Clock;
pub use follow::Follow;
use index::{Index, Selection};
use pipeline::Pipeline;
use track::{Codec, Track};

/// Largest memory for images drawn at the same time `[bytes]`. A single image may need more.
const MOST_MEMORY: u64 = 2 << 30;

/// Memory per particle while its frame is drawn `[bytes]`.
const BYTES_PER_PARTICLE: u64 = 2000;

const MOST_PER_SECOND: u32 = 120;

const LARGEST_TURN: f64 = 3600.0;

/// File format of a movie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MovieFormat {
    /// Graphics Interchange Format. It opens everywhere, but has only 256 colours and at most 50 images per second.
    Gif,
    /// Animated PNG. Files are large, have all colours, and open in browsers.
    Apng,
    /// MPEG-4 with H.264. Files are small and open in players, browsers and slides. Needs ffmpeg.
    Mp4,
}

impl MovieFormat {
    /// All formats, with their file extensions.
    pub const ENDINGS: [(Self, &'static str); 3] = [(Self::Mp4, "mp4"), (Self::Gif, "gif"), (Self::Apng, "apng")];

    /// Returns the format of a file name.
    ///
    /// # Errors
    /// [`ViewError::Format`] if no format has this extension.
    pub fn of(path: &Path) -> Result<Self, ViewError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let known = Self::ENDINGS.into_iter().find(|(_, known)| ending.eq_ignore_ascii_case(known));
        known.map(|(format, _)| format).ok_or_else(|| ViewError::Format(path.to_owned()))
    }
}

/// Options of a movie.
#[derive(Debug, Clone, PartialEq)]
pub struct Movie {
    /// Style of each image, with its exact width and height. The azimuth is for the first image.
    pub style: Style,
    /// Images per second, 1 to 120.
    pub frames_per_second: u32,
    /// First frame, from 0.
    pub first: u64,
    /// Last frame, inclusive; `None` for all later frames.
    pub last: Option<u64>,
    /// Only every N-th frame is shown.
    pub every: u64,
    /// Angle by which the camera moves around the scene to the right during the movie `[degrees]`. Flat and
    /// one-dimensional scenes are always seen from the front.
    pub turn: f64,
    /// Point that stays in the middle of all images, if any. Particles are wrapped around the point along periodic
    /// axes. The camera follows the point along other axes.
    pub follow: Option<Follow>,
}

impl Default for Movie {
    fn default() -> Self {
        let style = Style { width: 1280, height: 960, ..Style::default() };
        Self { style, frames_per_second: 25, first: 0, last: None, every: 1, turn: 30.0, follow: None }
    }
}

/// A finished movie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrittenMovie {
    /// Number of images.
    pub frames: u64,
    /// Size of the file `[bytes]`.
    pub bytes: u64,
    /// Whether the trajectory ends within a frame, for example because the run was killed.
    pub is_truncated: bool,
}

/// Progress of a movie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovieProgress {
    /// Whether the images are being drawn. Before, the trajectory is scanned, and the colours of a GIF are chosen.
    pub is_drawing: bool,
    /// Number of frames scanned, trial images drawn, or images written.
    pub frames: u64,
    /// Simulated time of the last frame or image `[time]`.
    pub time: f64,
    /// Completed fraction of the scan, the trial images or the movie, 0 to 1.
    pub fraction: f64,
}

/// Callback for the progress of a movie. It can stop the work.
pub type Watch<'a> = dyn FnMut(&MovieProgress) -> ControlFlow<()> + 'a;

/// Writes a movie of a trajectory in extended XYZ. The extension of `path` determines the format. The file appears once
/// it is complete. An incomplete last frame is ignored.
///
/// # Errors
/// - [`ViewError::Format`], [`ViewError::Option`], [`ViewError::FastGif`] or [`ViewError::OddSize`] if the
///   options are invalid, [`ViewError::NoFfmpeg`] if an MP4 is requested without ffmpeg;
/// - [`ViewError::Trajectory`], [`ViewError::NotFile`], [`ViewError::Changed`], [`ViewError::NoSuchFrame`],
///   [`ViewError::EmptyMovie`] or [`ViewError::Frame`] if the trajectory is not usable;
/// - [`ViewError::SurfaceFile`] or [`ViewError::Surface`] if a surface beside the trajectory cannot be read;
/// - [`ViewError::Exists`] or [`ViewError::NotReplaceable`] if the target must not be replaced,
///   [`ViewError::Write`] if the file cannot be written, [`ViewError::Ffmpeg`] if ffmpeg fails,
///   [`ViewError::Threads`] if no thread can be started;
/// - [`ViewError::Interrupted`] if `watch` breaks.
///
/// After an error, there is no new file, and an existing file is unchanged.
pub fn write(
    trajectory: &Path,
    path: &Path,
    movie: &Movie,
    existing: Existing,
    watch: &mut Watch,
) -> Result<WrittenMovie, ViewError> {
    let format = MovieFormat::of(path)?;
    movie.refuse(format)?;
    let ffmpeg = (format == MovieFormat::Mp4).then(ffmpeg::Ffmpeg::find).transpose()?;
    refuse_existing(path, existing)?;
    let selection = Selection { first: movie.first, last: movie.last, every: movie.every };
    let movie = &Movie { style: movie.style.beside(trajectory), ..movie.clone() };
    let index = Index::of(trajectory, selection, &movie.style, watch)?;
    let surfaces = Surfaces::beside(trajectory)?;
    let shot = index.shot(&surfaces, &movie.style, movie.turn)?;
    let reel = Reel { trajectory, path, movie, clock: Clock::of(&index), index, surfaces, shot };
    let palette = (format == MovieFormat::Gif).then(|| reel.palette(watch)).transpose()?;
    let (draft, file) = UnnamedFile::beside(path).map_err(ViewError::write(path))?;
    let (style, per_second) = (&movie.style, movie.frames_per_second);
    match (ffmpeg, palette) {
        (Some(ffmpeg), _) => {
            drop(file);
            reel.write(&ffmpeg::Raw, ffmpeg.begin(draft.path(), style, per_second)?, watch)?;
        }
        (None, Some(palette)) => {
            let track = gif::GifTrack::begin(BufWriter::new(file), &palette, style);
            reel.write(&gif::GifCodec { palette: &palette, per_second }, reel.open(track)?, watch)?;
        }
        (None, None) => {
            let track = apng::ApngTrack::begin(BufWriter::new(file), style, reel.index.places.len(), per_second);
            reel.write(&apng::ApngCodec, reel.open(track)?, watch)?;
        }
    }
    let written = fs::OpenOptions::new().write(true).open(draft.path()).and_then(|file| {
        file.sync_all()?;
        Ok(file.metadata()?.len())
    });
    let bytes = written.map_err(ViewError::write(path))?;
    if bytes == 0 {
        return Err(ViewError::Ffmpeg("it wrote nothing".to_owned()));
    }
    draft.publish(existing).map_err(ViewError::write(path))?;
    Ok(WrittenMovie { frames: reel.index.places.len() as u64, bytes, is_truncated: reel.index.is_truncated })
}

impl Movie {
    fn refuse(&self, format: MovieFormat) -> Result<(), ViewError> {
        render::refuse_style(&self.style)?;
        let option = |name, value: f64, expected| Err(ViewError::Option { name, value, expected });
        let per_second = self.frames_per_second;
        if !(1..=MOST_PER_SECOND).contains(&per_second) {
            return option("the number of images per second", f64::from(per_second), "1 to 120");
        }
        if self.every == 0 {
            return option("the number of frames from one image to the next", 0.0, "at least 1");
        }
        if self.turn.is_nan() || self.turn.abs() > LARGEST_TURN {
            return option("the turn of the camera", self.turn, "-3600 to 3600 degrees");
        }
        let (width, height) = (self.style.width, self.style.height);
        match format {
            MovieFormat::Gif if per_second > gif::MOST_PER_SECOND => Err(ViewError::FastGif(per_second)),
            MovieFormat::Mp4 if !(width.is_multiple_of(2) && height.is_multiple_of(2)) => {
                Err(ViewError::OddSize { width, height })
            }
            _ => Ok(()),
        }
    }
}

fn refuse_existing(path: &Path, existing: Existing) -> Result<(), ViewError> {
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => Err(ViewError::NotReplaceable(path.to_owned())),
        Ok(_) if existing == Existing::Keep => Err(ViewError::Exists(path.to_owned())),
        _ => Ok(()),
    }
}

struct Reel<'a> {
    trajectory: &'a Path,
    path: &'a Path,
    movie: &'a Movie,
    index: Index,
    surfaces: Surfaces,
    shot: Shot,
    clock: Clock,
}

impl Reel<'_> {
    fn write<C: Codec>(
        &self,
        codec: &C,
        mut track: impl Track<Piece = C::Piece>,
        watch: &mut Watch,
    ) -> Result<(), ViewError> {
        let count = self.index.places.len();
        let at_once = self.at_once();
        let is_stopped = AtomicBool::new(false);
        let team = Team { threads: render::cores().div_ceil(at_once), is_stopped: Some(&is_stopped) };
        let pipeline = Pipeline {
            draw: &|place| self.draw(place, &self.shot, &team),
            compress: &|place, previous: Option<&Image>, image: &Image| {
                codec.compress(place, previous, image).map_err(ViewError::write(self.path))
            },
            count,
            crew: at_once,
            is_stopped: &is_stopped,
        };
        let (watch, done) = (RefCell::new(watch), Cell::new(0));
        let ask = |written: usize| {
            done.set(written);
            let time = self.index.places[written.saturating_sub(1).min(count - 1)].time;
            let fraction = written as f64 / count as f64;
            watch.borrow_mut()(&MovieProgress { is_drawing: true, frames: written as u64, time, fraction })
        };
        let mut ask_again = || ask(done.get());
        pipeline.run(&mut |piece| self.open(track.add(piece, &mut ask_again)), &mut |written| ask(written))?;
        track.finish(&mut || ask(count)).map_err(|error| self.failed(error))
    }

    /// One image per core is drawn at the same time, if memory allows.
    fn at_once(&self) -> usize {
        let style = &self.movie.style;
        let pixels = u64::from(style.width) * u64::from(style.height);
        let bytes = BYTES_PER_PIXEL * pixels + BYTES_PER_PARTICLE * self.index.most_particles;
        let bytes = bytes + self.surfaces.image_bytes();
        let fitting = count_of(MOST_MEMORY.min(memory::total() / 4) / bytes);
        render::cores().min(fitting).min(self.index.places.len()).max(1)
    }

    fn draw(&self, place: usize, shot: &Shot, team: &Team) -> Result<Image, ViewError> {
        let fault = |source| self.index.fault(self.trajectory, place, source);
        let frame = self.index.read(self.trajectory, place)?;
        let (frame, focus) = match self.movie.follow {
            Some(follow) => follow.centred(frame).map_err(fault)?,
            None => (frame, [None; 3]),
        };
        let last = self.index.places.len() - 1;
        let part = if last == 0 { 0.0 } else { place as f64 / last as f64 };
        let azimuth = self.movie.style.azimuth + part * self.movie.turn;
        let time = self.clock.text(frame.time);
        shot.draw(&frame, (azimuth, focus), &time, team).map_err(fault)
    }

    fn palette(&self, watch: &mut Watch) -> Result<palette::Palette, ViewError> {
        let style = palette::pilot_style(&self.movie.style);
        let shot = self.index.shot(&self.surfaces, &style, self.movie.turn)?;
        let mut images = Vec::new();
        let pilots: Vec<usize> = self.index.spread(palette::PILOTS).collect();
        for (done, &place) in (1_u32..).zip(&pilots) {
            images.push(self.draw(place, &shot, &Team::whole())?);
            let time = self.index.places[place].time;
            let fraction = f64::from(done) / pilots.len() as f64;
            if watch(&MovieProgress { is_drawing: false, frames: u64::from(done), time, fraction }).is_break() {
                return Err(ViewError::Interrupted);
            }
        }
        Ok(palette::Palette::of(&images))
    }

    fn open<T>(&self, result: Result<T, track::TrackError>) -> Result<T, ViewError> {
        result.map_err(|error| self.failed(error))
    }

    fn failed(&self, error: track::TrackError) -> ViewError {
        match error {
            track::TrackError::Output(source) => ViewError::write(self.path)(source),
            track::TrackError::Interrupted => ViewError::Interrupted,
            track::TrackError::Ffmpeg(message) => ViewError::Ffmpeg(message),
        }
    }
}
