//! A program that receives images through a pipe and writes a file. The program is stopped if it makes no progress.
//! Calls that may block run in their own threads.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, SystemTime};

use super::track::{Ask, Track, TrackError};
use crate::view::ViewError;

const MOST_MESSAGE: usize = 4096;

/// Bytes written at a time. Progress is counted in pieces of this size, so a slow program is not stopped.
const PIECE: usize = 1 << 14;

const TICK: Duration = Duration::from_millis(20);

/// Time limit for reading the messages of a program that has ended. Child processes may keep the pipe open.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// A running program. It is killed when dropped.
pub(super) struct Process {
    child: Child,
    images: Option<SyncSender<Vec<u8>>>,
    written: Receiver<io::Result<()>>,
    taken: Arc<AtomicU64>,
    message: Receiver<String>,
    file: PathBuf,
    patience: Duration,
}

/// Number of pieces that the program has read, and length and last change of its output file.
type Done = (u64, Option<(u64, SystemTime)>);

/// Detects a program that makes no progress. Time is counted in ticks, so a sleep of the machine does not count.
struct Idleness {
    before: Done,
    waited: Duration,
    patience: Duration,
}

impl Idleness {
    /// Returns an error after `patience` without progress.
    fn tick(&mut self, now: Done) -> Result<(), TrackError> {
        let is_something = now != self.before;
        self.waited = if is_something { Duration::ZERO } else { self.waited + TICK };
        self.before = now;
        if self.waited < self.patience { Ok(()) } else { Err(hung(self.patience)) }
    }
}

fn hung(patience: Duration) -> TrackError {
    TrackError::Ffmpeg(format!("it did nothing for {} s and was stopped", patience.as_secs_f64()))
}

impl Process {
    /// Starts a program that writes a file.
    ///
    /// # Errors
    /// [`ViewError::NoFfmpeg`] if the program cannot be started, [`ViewError::Threads`] if no thread can be started.
    pub fn start(command: &mut Command, file: &Path, patience: Duration) -> Result<Self, ViewError> {
        #[cfg(unix)]
        {
            // Ctrl-C must reach only the calling program, which stops the child process.
            std::os::unix::process::CommandExt::process_group(command, 0);
        }
        let mut child = command.spawn().map_err(ViewError::NoFfmpeg)?;
        let (input, errors) = (child.stdin.take(), child.stderr.take());
        let taken = Arc::new(AtomicU64::new(0));
        let (images, to_write) = sync_channel::<Vec<u8>>(1);
        let (say, written) = channel();
        let counter = Arc::clone(&taken);
        let feed = move || {
            let Some(mut input) = input else { return };
            for image in to_write {
                if say.send(write(&mut input, &image, &counter)).is_err() {
                    return;
                }
            }
        };
        let (tell, message) = channel();
        // A full pipe of unread error messages would block the program.
        let listen = move || drop(tell.send(errors.map_or_else(String::new, message_of)));
        let process = Self { child, images: Some(images), written, taken, message, file: file.to_owned(), patience };
        for work in [Box::new(feed) as Box<dyn FnOnce() + Send>, Box::new(listen)] {
            thread::Builder::new().spawn(work).map_err(|_| ViewError::Threads)?;
        }
        Ok(process)
    }

    fn wait_for<T>(
        &mut self,
        ask: &mut Ask,
        mut answer: impl FnMut(&mut Self) -> Result<Option<T>, TrackError>,
    ) -> Result<T, TrackError> {
        let mut idleness = Idleness { before: self.done(), waited: Duration::ZERO, patience: self.patience };
        loop {
            if let Some(answer) = answer(self)? {
                return Ok(answer);
            }
            if ask().is_break() {
                return Err(TrackError::Interrupted);
            }
            idleness.tick(self.done())?;
        }
    }

    fn done(&self) -> Done {
        let file = std::fs::metadata(&self.file).ok();
        let state = file.and_then(|file| Some((file.len(), file.modified().ok()?)));
        (self.taken.load(Ordering::Relaxed), state)
    }

    fn end(&mut self, ask: &mut Ask) -> Result<(), TrackError> {
        drop(self.images.take());
        let status = self.wait_for(ask, |process| ended(&mut process.child))?;
        let message = self.message.recv_timeout(LAST_WORDS).unwrap_or_default();
        match (status.success(), message.is_empty()) {
            (true, _) => Ok(()),
            (false, true) => Err(TrackError::Ffmpeg(format!("it ended with {status}"))),
            (false, false) => Err(TrackError::Ffmpeg(message)),
        }
    }
}

impl Track for Process {
    type Piece = Vec<u8>;

    fn add(&mut self, piece: Vec<u8>, ask: &mut Ask) -> Result<(), TrackError> {
        let is_sent = self.images.as_ref().is_some_and(|images| images.send(piece).is_ok());
        let broken = || Some(Err(io::ErrorKind::BrokenPipe.into()));
        let result = if is_sent {
            self.wait_for(ask, |process| match process.written.recv_timeout(TICK) {
                Ok(result) => Ok(Some(result)),
                Err(RecvTimeoutError::Timeout) => Ok(None),
                Err(RecvTimeoutError::Disconnected) => Ok(broken()),
            })?
        } else {
            Err(io::ErrorKind::BrokenPipe.into())
        };
        match result {
            // The program has ended early. Its messages give the reason.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(match self.end(ask) {
                Err(reason) => reason,
                Ok(()) => TrackError::Ffmpeg("it ended before the last image".to_owned()),
            }),
            result => Ok(result?),
        }
    }

    fn finish(mut self, ask: &mut Ask) -> Result<(), TrackError> {
        self.end(ask)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Fails if the program has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns the standard output of a program.
///
/// # Errors
/// [`ViewError::NoFfmpeg`] if the program cannot be started, [`ViewError::Ffmpeg`] if it does not finish within
/// `patience`, [`ViewError::Threads`] if no thread can be started.
pub(super) fn printed_by(command: &mut Command, patience: Duration) -> Result<String, ViewError> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(ViewError::NoFfmpeg)?;
    let output = child.stdout.take();
    let (tell, told) = channel();
    let listen = move || {
        let mut bytes = Vec::new();
        let _ = output.map(|mut output| output.read_to_end(&mut bytes));
        let _ = tell.send(String::from_utf8_lossy(&bytes).into_owned());
    };
    let printed = match thread::Builder::new().spawn(listen) {
        Ok(_) => told.recv_timeout(patience).map_err(|_| ViewError::Ffmpeg(hung(patience).to_string())),
        Err(_) => Err(ViewError::Threads),
    };
    let _ = child.kill();
    let _ = child.wait();
    printed
}

/// Returns the exit status of a program that has ended. Otherwise, sleeps for one tick.
fn ended(child: &mut Child) -> Result<Option<ExitStatus>, TrackError> {
    let ended = child.try_wait()?;
    if ended.is_none() {
        thread::sleep(TICK);
    }
    Ok(ended)
}

fn write(input: &mut impl Write, image: &[u8], taken: &AtomicU64) -> io::Result<()> {
    for piece in image.chunks(PIECE) {
        input.write_all(piece)?;
        taken.fetch_add(1, Ordering::Relaxed);
    }
    Ok(())
}

fn message_of(mut errors: impl Read) -> String {
    let (mut kept, mut buffer) = (Vec::new(), [0; MOST_MESSAGE]);
    while let Ok(count @ 1..) = errors.read(&mut buffer) {
        kept.extend_from_slice(&buffer[..count]);
        kept.drain(..kept.len().saturating_sub(MOST_MESSAGE));
    }
    String::from_utf8_lossy(&kept).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_but_active_process_is_not_killed() {
        let mut idleness = Idleness { before: (0, None), waited: Duration::ZERO, patience: 5 * TICK };
        for k in 0..100 {
            let done = (k / 8, Some((k / 4, SystemTime::UNIX_EPOCH)));
            assert!(idleness.tick(done).is_ok(), "{k}");
        }
        let same = idleness.before;
        let ticks = (0..10).take_while(|_| idleness.tick(same).is_ok()).count();
        assert!(ticks < 5, "{ticks}");
    }
}
