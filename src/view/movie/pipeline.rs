//! Draws and compresses images on several cores, and delivers them in order.
//!
//! Each worker draws the next image, and compresses it relative to the previous image, which another worker may still
//! be drawing. Workers are only a few images ahead of the delivered images, which limits the memory. Results and errors
//! do not depend on the number of workers.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use crate::view::ViewError;
use crate::view::render::Image;

const PATIENCE: Duration = Duration::from_millis(50);

type Draw<'a> = &'a (dyn Fn(usize) -> Result<Image, ViewError> + Sync);

type Compress<'a, P> = &'a (dyn Fn(usize, Option<&Image>, &Image) -> Result<P, ViewError> + Sync);

pub(super) struct Pipeline<'a, P> {
    pub draw: Draw<'a>,
    pub compress: Compress<'a, P>,
    pub count: usize,
    pub crew: usize,
    pub is_stopped: &'a AtomicBool,
}

/// An image to draw and compress. The index of the image in the movie is `place`.
struct Task {
    place: usize,
    before: Option<Receiver<Arc<Image>>>,
    next: Sender<Arc<Image>>,
}

type Piece<P> = (usize, Result<P, ViewError>);

impl<P: Send> Pipeline<'_, P> {
    /// Draws and compresses all images. `take` receives the images in order. `watch` receives the number of delivered
    /// images, and can stop the work.
    ///
    /// # Errors
    /// The error of the first image that fails, [`ViewError::Interrupted`] if `watch` breaks, [`ViewError::Threads`] if
    /// no worker can be started.
    pub fn run(
        &self,
        take: &mut dyn FnMut(P) -> Result<(), ViewError>,
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<(), ViewError> {
        let ((issue, tasks), (tell, pieces)) = (channel(), channel());
        let tasks = Mutex::new(tasks);
        thread::scope(|scope| {
            for _ in 0..self.crew {
                let (tasks, tell) = (&tasks, tell.clone());
                // If a worker cannot be started, other workers draw its images.
                let _ = thread::Builder::new().spawn_scoped(scope, move || self.work(tasks, &tell));
            }
            drop(tell);
            let result = self.collect(&issue, &pieces, take, watch);
            self.is_stopped.store(true, Ordering::Relaxed);
            // The workers end when the channel closes.
            drop(issue);
            result
        })
    }

    fn collect(
        &self,
        issue: &Sender<Task>,
        pieces: &Receiver<Piece<P>>,
        take: &mut dyn FnMut(P) -> Result<(), ViewError>,
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<(), ViewError> {
        let (mut issued, mut done, mut before) = (0, 0, None);
        let mut early = BTreeMap::new();
        while done < self.count {
            while issued < self.count.min(done + 2 * self.crew) {
                let (next, image) = channel();
                // Sending fails if all workers have ended. The receiver below reports the error.
                let _ = issue.send(Task { place: issued, before: before.replace(image), next });
                issued += 1;
            }
            if let Some(piece) = early.remove(&done) {
                take(piece?)?;
                done += 1;
            } else {
                match pieces.recv_timeout(PATIENCE) {
                    Ok((place, piece)) => drop(early.insert(place, piece)),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return Err(ViewError::Threads),
                }
            }
            if watch(done).is_break() {
                return Err(ViewError::Interrupted);
            }
        }
        Ok(())
    }

    fn work(&self, tasks: &Mutex<Receiver<Task>>, tell: &Sender<Piece<P>>) {
        let next = || tasks.lock().unwrap_or_else(PoisonError::into_inner).recv().ok();
        while let Some(task) = next().filter(|_| !self.is_stopped.load(Ordering::Relaxed)) {
            // Sending fails if the work has ended.
            let _ = tell.send((task.place, self.piece(task)));
        }
    }

    fn piece(&self, Task { place, before, next }: Task) -> Result<P, ViewError> {
        let image = Arc::new((self.draw)(place)?);
        // Sending fails if no later image is drawn.
        let _ = next.send(Arc::clone(&image));
        // Receiving fails if the previous image could not be drawn. Only the error of the previous image is reported.
        let previous = before.map(|before| before.recv()).transpose().map_err(|_| ViewError::Interrupted)?;
        if self.is_stopped.load(Ordering::Relaxed) {
            return Err(ViewError::Interrupted);
        }
        (self.compress)(place, previous.as_deref(), &image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    fn image(place: usize) -> Image {
        Image::new(1, 1, vec![[u8::try_from(place).unwrap(); 4]])
    }

    /// Index of an image, colour of the previous image, and colour of the image.
    type Compressed = (usize, Option<u8>, u8);

    /// Compresses 40 images. Some images take longer. Drawing fails from the image `failing` on.
    fn handed_on(crew: usize, failing: Option<usize>) -> (Vec<Compressed>, Result<(), ViewError>) {
        let (is_stopped, begun, taken) = (AtomicBool::new(false), AtomicUsize::new(0), AtomicUsize::new(0));
        let pipeline = Pipeline {
            draw: &|place: usize| {
                let ahead = begun.fetch_add(1, Ordering::SeqCst) + 1 - taken.load(Ordering::SeqCst);
                // Workers are at most `2 * crew` images ahead. The test allows one more.
                assert!(ahead <= 2 * crew + 1, "{ahead} ahead");
                thread::sleep(Duration::from_micros(if place.is_multiple_of(3) { 2000 } else { 100 }));
                match failing.is_some_and(|failing| place >= failing) {
                    true => Err(ViewError::FastGif(u32::try_from(place).unwrap())),
                    false => Ok(image(place)),
                }
            },
            compress: &|place, previous: Option<&Image>, image: &Image| {
                Ok((place, previous.map(|previous| previous.pixels()[0][0]), image.pixels()[0][0]))
            },
            count: 40,
            crew,
            is_stopped: &is_stopped,
        };
        let mut pieces = Vec::new();
        let result = pipeline.run(
            &mut |piece| {
                pieces.push(piece);
                taken.fetch_add(1, Ordering::SeqCst);
                Ok(())
            },
            &mut |_| ControlFlow::Continue(()),
        );
        (pieces, result)
    }

    #[test]
    fn output_is_in_order_for_any_number_of_workers() {
        let expected: Vec<_> = (0..40).map(|place: u8| (usize::from(place), place.checked_sub(1), place)).collect();
        for crew in [1, 2, 3, 7, 50] {
            let (pieces, result) = handed_on(crew, None);
            assert!(result.is_ok() && pieces == expected, "{crew}");
        }
    }

    #[test]
    fn the_first_error_counts_on_any_number_of_workers() {
        for crew in [1, 2, 3, 7] {
            for failing in [0, 1, 12, 39] {
                let (pieces, result) = handed_on(crew, Some(failing));
                assert!(matches!(result, Err(ViewError::FastGif(place)) if place as usize == failing), "{crew}");
                assert_eq!(pieces.len(), failing);
            }
        }
    }

    #[test]
    fn write_error_or_interrupt_stops_the_workers() {
        for is_break in [false, true] {
            let is_stopped = AtomicBool::new(false);
            let (count, crew, is_stopped) = (100, 3, &is_stopped);
            let (draw, compress) = (&|place| Ok(image(place)), &|_: usize, _: Option<&Image>, _: &Image| Ok(()));
            let pipeline = Pipeline { draw, compress, count, crew, is_stopped };
            let mut taken = 0;
            let result = pipeline.run(
                &mut |()| {
                    taken += 1;
                    if is_break || taken < 20 { Ok(()) } else { Err(ViewError::Ffmpeg("full".to_owned())) }
                },
                &mut |done| if is_break && done >= 20 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) },
            );
            assert_eq!(taken, 20);
            assert_eq!(matches!(result, Err(ViewError::Interrupted)), is_break);
            assert_eq!(matches!(result, Err(ViewError::Ffmpeg(_))), !is_break);
        }
    }
}
