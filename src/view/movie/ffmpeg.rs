//! MP4 files, written by the program `ffmpeg`.

use std::ffi::OsString;
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use super::process::{Process, printed_by};
use super::track::Codec;
use crate::view::ViewError;
use crate::view::render::{Image, Style};

/// ffmpeg is stopped after this time without progress. At the end of a large movie, ffmpeg pauses for a few seconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// Encoders in order of preference. The options keep the edges of particles clean.
const ENCODERS: [(&str, &[&str]); 3] =
    [("libx264", &["-preset", "medium", "-crf", "18"]), ("libopenh264", &["-b:v", "8M"]), ("mpeg4", &["-q:v", "3"])];

#[derive(Debug, Clone)]
pub(super) struct Ffmpeg {
    program: OsString,
    encoder: (&'static str, &'static [&'static str]),
    patience: Duration,
}

impl Ffmpeg {
    /// Searches `PATH` for ffmpeg, and chooses its best encoder.
    ///
    /// # Errors
    /// [`ViewError::NoFfmpeg`] if ffmpeg cannot be started, [`ViewError::Ffmpeg`] if it fails or has no known encoder.
    pub fn find() -> Result<Self, ViewError> {
        Self::at("ffmpeg".into(), PATIENCE)
    }

    fn at(program: OsString, patience: Duration) -> Result<Self, ViewError> {
        let mut command = Command::new(&program);
        command.args(["-hide_banner", "-loglevel", "error", "-encoders"]);
        let list = printed_by(&mut command, patience)?;
        let has = |name: &str| list.lines().any(|line| line.split_whitespace().nth(1) == Some(name));
        let encoder = ENCODERS.into_iter().find(|(name, _)| has(name));
        let names = || ENCODERS.map(|(name, _)| name).join(", ");
        let encoder = encoder.ok_or_else(|| ViewError::Ffmpeg(format!("it has none of the encoders {}", names())))?;
        Ok(Self { program, encoder, patience })
    }

    /// Starts ffmpeg, which overwrites `file`.
    pub fn begin(&self, file: &Path, style: &Style, per_second: u32) -> Result<Process, ViewError> {
        let mut command = Command::new(&self.program);
        command.args(["-hide_banner", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{}x{}", style.width, style.height)]);
        command.args(["-framerate", &per_second.to_string(), "-i", "pipe:0", "-an"]);
        // For small images, players do not assume the colour standard BT.709.
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
        // Without the prefix, ffmpeg could read the name as an option or a network address.
        let mut name = OsString::from("file:");
        name.push(file);
        command.arg(name).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        Process::start(&mut command, file, self.patience)
    }
}

/// Passes images to ffmpeg without compression.
pub(super) struct Raw;

impl Codec for Raw {
    type Piece = Vec<u8>;

    fn compress(&self, _place: usize, _previous: Option<&Image>, image: &Image) -> io::Result<Vec<u8>> {
        Ok(image.pixels().iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::view::movie::track::{Track, TrackError};
    use std::fs;
    use std::ops::ControlFlow;
    use std::os::unix::fs::PermissionsExt;

    const SHORT: Duration = Duration::from_millis(300);

    fn with(script: &str, ask: &mut dyn FnMut() -> ControlFlow<()>) -> Result<(), TrackError> {
        let folder = tempfile::tempdir().unwrap();
        let (program, file) = (folder.path().join("ffmpeg"), folder.path().join("film.mp4"));
        fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        fs::write(&file, "").unwrap();
        let ffmpeg = Ffmpeg { program: program.into(), encoder: ENCODERS[0], patience: SHORT };
        let style = Style { width: 256, height: 256, ..Style::default() };
        let mut process = loop {
            match ffmpeg.begin(&file, &style, 25) {
                Err(ViewError::NoFfmpeg(error)) if error.kind() == io::ErrorKind::ExecutableFileBusy => {}
                process => break process.unwrap(),
            }
        };
        for _ in 0..3 {
            process.add(vec![0; 3 << 16], ask)?;
        }
        process.finish(ask)
    }

    #[test]
    fn hanging_ffmpeg_is_killed() {
        let mut go_on = || ControlFlow::Continue(());
        // The last script starts a process that outlives the shell.
        for script in ["exec sleep 1000", "cat > /dev/null; exec sleep 1000", "sleep 20"] {
            let error = with(script, &mut go_on).unwrap_err();
            assert!(matches!(&error, TrackError::Ffmpeg(why) if why.contains("did nothing for 0.3 s")), "{error}");
        }
    }

    #[test]
    fn hanging_ffmpeg_can_be_interrupted() {
        let mut asked = 0;
        let mut stop = || {
            asked += 1;
            if asked < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        assert!(matches!(with("exec sleep 1000", &mut stop), Err(TrackError::Interrupted)));
    }

    #[test]
    fn unresponsive_ffmpeg_is_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("ffmpeg");
        fs::write(&program, "#!/bin/sh\nexec sleep 1000\n").unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let found = loop {
            match Ffmpeg::at(program.clone().into(), SHORT) {
                Err(ViewError::NoFfmpeg(error)) if error.kind() == io::ErrorKind::ExecutableFileBusy => {}
                found => break found,
            }
        };
        assert!(matches!(found, Err(ViewError::Ffmpeg(why)) if why.contains("did nothing for 0.3 s")));
    }
}
