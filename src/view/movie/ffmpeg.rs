//! MP4, written by the program `ffmpeg`, which gets the images as they are through a pipe.

use std::ffi::OsString;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::{self, JoinHandle};

use super::MovieError;
use super::track::{Codec, Track, TrackError};
use crate::view::render::{Image, Style};

/// The most of what ffmpeg prints that is kept `[bytes]`.
const MOST_MESSAGE: usize = 4096;

/// How images are compressed, by the name of the encoder: well enough that grains have clean edges.
const ENCODERS: [(&str, &[&str]); 3] =
    [("libx264", &["-preset", "medium", "-crf", "18"]), ("libopenh264", &["-b:v", "8M"]), ("mpeg4", &["-q:v", "3"])];

/// An ffmpeg that can be started.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ffmpeg {
    encoder: (&'static str, &'static [&'static str]),
}

impl Ffmpeg {
    /// Looks for ffmpeg in `PATH`, and for the best of its encoders.
    ///
    /// # Errors
    /// [`MovieError::NoFfmpeg`] if it cannot be started, [`MovieError::Ffmpeg`] if it has no encoder that is known here.
    pub fn find() -> Result<Self, MovieError> {
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-encoders"]).stdin(Stdio::null());
        let output = command.output().map_err(MovieError::NoFfmpeg)?;
        let list = String::from_utf8_lossy(&output.stdout);
        let has = |name: &str| list.lines().any(|line| line.split_whitespace().nth(1) == Some(name));
        let encoder = ENCODERS.into_iter().find(|(name, _)| has(name));
        let names = || ENCODERS.map(|(name, _)| name).join(", ");
        let encoder = encoder.ok_or_else(|| MovieError::Ffmpeg(format!("it has none of the encoders {}", names())))?;
        Ok(Self { encoder })
    }

    /// Starts it for a file that is there already.
    ///
    /// # Errors
    /// [`MovieError::NoFfmpeg`] if it cannot be started.
    pub fn begin(&self, file: &Path, style: &Style, per_second: u32) -> Result<Process, MovieError> {
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{}x{}", style.width, style.height)]);
        command.args(["-framerate", &per_second.to_string(), "-i", "pipe:0", "-an"]);
        // Players take the colours of large images for those of this standard; so they are written, and named.
        command.args(["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p"]);
        command.args([
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "bt709",
            "-color_range",
            "tv",
        ]);
        command.args(["-c:v", self.encoder.0]).args(self.encoder.1);
        command.args(["-movflags", "+faststart", "-f", "mp4", "-y"]);
        // Whatever the name is, it is neither an option nor an address.
        let mut name = OsString::from("file:");
        name.push(file);
        command.arg(name).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        #[cfg(unix)]
        {
            // Ctrl-C is for this program, which ends ffmpeg then.
            std::os::unix::process::CommandExt::process_group(&mut command, 0);
        }
        let mut child = command.spawn().map_err(MovieError::NoFfmpeg)?;
        let (input, errors) = (child.stdin.take(), child.stderr.take());
        // It would block if what it prints were not read.
        let message = thread::Builder::new().spawn(move || errors.map_or_else(String::new, message_of)).ok();
        Ok(Process { child, input, message })
    }
}

/// The last that is printed, up to the end.
fn message_of(mut errors: impl Read) -> String {
    let (mut kept, mut buffer) = (Vec::new(), [0; MOST_MESSAGE]);
    while let Ok(count @ 1..) = errors.read(&mut buffer) {
        kept.extend_from_slice(&buffer[..count]);
        kept.drain(..kept.len().saturating_sub(MOST_MESSAGE));
    }
    String::from_utf8_lossy(&kept).trim().to_owned()
}

/// Images as ffmpeg reads them: red, green and blue, row by row.
pub(super) struct Raw;

impl Codec for Raw {
    type Piece = Vec<u8>;

    fn compress(&self, _place: usize, _previous: Option<&Image>, image: &Image) -> io::Result<Vec<u8>> {
        Ok(image.pixels().iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect())
    }
}

/// An ffmpeg at work; dropped, it is ended.
pub(super) struct Process {
    child: Child,
    input: Option<ChildStdin>,
    message: Option<JoinHandle<String>>,
}

impl Process {
    /// Waits for its end.
    fn end(&mut self) -> Result<(), TrackError> {
        drop(self.input.take());
        let status = self.child.wait()?;
        let message = self.message.take().and_then(|message| message.join().ok()).unwrap_or_default();
        match (status.success(), message.is_empty()) {
            (true, _) => Ok(()),
            (false, true) => Err(TrackError::Ffmpeg(format!("it ended with {status}"))),
            (false, false) => Err(TrackError::Ffmpeg(message)),
        }
    }
}

impl Track for Process {
    type Piece = Vec<u8>;

    fn add(&mut self, piece: Vec<u8>) -> Result<(), TrackError> {
        let Some(input) = &mut self.input else { return Err(io::Error::from(io::ErrorKind::BrokenPipe).into()) };
        match input.write_all(&piece) {
            // It has ended by itself: what it says is the reason.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(match self.end() {
                Err(reason) => reason,
                Ok(()) => TrackError::Ffmpeg("it ended before the last image".to_owned()),
            }),
            result => Ok(result?),
        }
    }

    fn finish(mut self) -> Result<(), TrackError> {
        self.end()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // One that has ended is neither there to be killed nor waited for again.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
