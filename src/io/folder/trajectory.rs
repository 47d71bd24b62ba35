//! The trajectory of a run. A separate thread writes large frames while the run continues.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, JoinHandle};

use super::frames::Frames;
use crate::analysis::instruments::Scalar;
use crate::engine::{Simulation, Snapshot};
use crate::io::error::OutputError;
use crate::io::partial::PartialFile;
use crate::run::checkpoint::ManifestEntry;
use crate::trajectory::extended_xyz::WriteError;

/// Smaller frames are written at once, because starting a thread would take longer.
const LEAST: usize = 256;

/// The trajectory of a run. The next frame, a checkpoint and the end of the run wait for the current frame.
#[derive(Debug)]
pub(super) struct Trajectory {
    path: PathBuf,
    desk: Arc<Mutex<Desk>>,
    writer: Option<JoinHandle<()>>,
    /// Length of the file before the current frame `[bytes]`.
    before: u64,
}

#[derive(Debug)]
struct Desk {
    file: PartialFile,
    frames: Frames,
    due: Option<(Snapshot, Vec<Scalar>)>,
    written: Result<(), OutputError>,
}

impl Desk {
    fn write(&mut self) {
        if let Some((snapshot, scalars)) = self.due.take() {
            let written = self.frames.write(self.file.writer(), &snapshot, scalars);
            self.written = self.end(written);
        }
    }

    /// Flushes a frame to the operating system, so that other programs can read it.
    fn end(&mut self, written: Result<(), WriteError>) -> Result<(), OutputError> {
        written.map_err(|source| OutputError::Frame { path: self.file.path().to_owned(), source })?;
        self.file.flush()
    }
}

impl Trajectory {
    pub fn new(file: PartialFile, frames: Frames) -> Self {
        let path = file.path().to_owned();
        let desk = Desk { file, frames, due: None, written: Ok(()) };
        Self { path, desk: Arc::new(Mutex::new(desk)), writer: None, before: 0 }
    }

    /// Appends a frame, and returns the error of the previous frame.
    pub fn add(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), OutputError> {
        self.settled()?.due = Some((snapshot.clone(), scalars));
        self.begin()
    }

    /// Appends the current state of a simulation. Returns the error of the previous frame. If the new frame is written
    /// at once, its error is returned, too.
    pub fn add_now(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        let mut desk = self.settled()?;
        if simulation.population().iter().sum::<usize>() < LEAST {
            let Desk { file, frames, .. } = &mut *desk;
            let written = frames.write_now(file.writer(), simulation);
            return desk.end(written);
        }
        desk.due = Some((simulation.snapshot(), Vec::new()));
        drop(desk);
        self.begin()
    }

    fn begin(&mut self) -> Result<(), OutputError> {
        self.before = locked(&self.desk).file.length();
        let desk = Arc::clone(&self.desk);
        let writer = thread::Builder::new().name("trajectory".to_owned());
        match writer.spawn(move || locked(&desk).write()) {
            Ok(writer) => self.writer = Some(writer),
            Err(_) => locked(&self.desk).write(),
        }
        Ok(())
    }

    fn settled(&mut self) -> Result<MutexGuard<'_, Desk>, OutputError> {
        let is_lost = self.writer.take().is_some_and(|writer| writer.join().is_err());
        let mut desk = locked(&self.desk);
        std::mem::replace(&mut desk.written, Ok(()))?;
        if is_lost { Err(lost(&self.path)) } else { Ok(desk) }
    }

    /// Length of the file without the current frame `[bytes]`.
    pub fn length(&self) -> u64 {
        self.desk.try_lock().map_or(self.before, |desk| desk.file.length())
    }

    /// Whether the last frame could not be written. The next call returns the error.
    pub fn has_failed(&self) -> bool {
        match self.desk.try_lock() {
            Ok(desk) => desk.written.is_err(),
            Err(TryLockError::Poisoned(_)) => true,
            Err(TryLockError::WouldBlock) => false,
        }
    }

    /// Waits for the current frame, and syncs the file to disk.
    pub fn keep(&mut self, run: &Path) -> Result<ManifestEntry, OutputError> {
        self.settled()?.file.keep(run)
    }

    /// Waits for the last frame, and returns the complete file.
    pub fn into_file(mut self) -> Result<PartialFile, OutputError> {
        drop(self.settled()?);
        let (desk, path) = (Arc::clone(&self.desk), self.path.clone());
        drop(self);
        let desk = Arc::into_inner(desk).ok_or_else(|| lost(&path))?;
        Ok(desk.into_inner().unwrap_or_else(PoisonError::into_inner).file)
    }
}

impl Drop for Trajectory {
    /// Waits for the thread, so that nothing is written after the lock of the folder has been released.
    fn drop(&mut self) {
        let _ = self.writer.take().map(JoinHandle::join);
    }
}

fn lost(path: &Path) -> OutputError {
    OutputError::write(path)(io::Error::other("a frame could not be written completely"))
}

fn locked(desk: &Mutex<Desk>) -> MutexGuard<'_, Desk> {
    desk.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    #[test]
    fn frames_written_in_a_thread_equal_frames_written_directly() {
        for count in [32, 500] {
            let scene = SceneBuilder::new("fluid")
                .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
                .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(0.3))
                .temperature(1.0)
                .build()
                .unwrap();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("trajectory.xyz");
            let mut trajectory = Trajectory::new(PartialFile::create(path.clone()).unwrap(), Frames::of(&scene));
            let (mut frames, mut expected) = (Frames::of(&scene), Vec::new());
            let mut simulation = Simulation::without_plan(scene);
            for end in 1..=5 {
                simulation.advance(Until::events(100 * end)).unwrap();
                trajectory.add_now(&simulation).unwrap();
                frames.write_now(&mut expected, &simulation).unwrap();
                if end == 3 {
                    let entry = trajectory.keep(folder.path()).unwrap();
                    assert_eq!((entry.length, trajectory.length()), (expected.len() as u64, expected.len() as u64));
                    assert_eq!(entry.checksum, crate::base::checksum::checksum(&expected));
                }
            }
            assert!(!trajectory.has_failed());
            trajectory.into_file().unwrap().complete().unwrap();
            assert!(std::fs::read(&path).unwrap() == expected, "{count}");
        }
    }
}
