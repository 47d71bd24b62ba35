//! Images drawn and compressed on several cores, and handed on in the order of time.
//!
//! Each worker takes the next place, draws its image, compresses it against the image before, which another worker may still be drawing,
//! and leaves the piece for the file. No worker runs ahead of what has been handed on by more than a few places, so that memory is bounded however many
//! images there are. What is handed on does not depend on the number of workers, nor does the place whose error is reported.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use crate::view::ViewError;
use crate::view::render::Image;

/// How often is asked whether to go on, at least.
const PATIENCE: Duration = Duration::from_millis(50);

/// Draws the image of a place.
type Draw<'a> = &'a (dyn Fn(usize) -> Result<Image, ViewError> + Sync);

/// Compresses the image of a place, given the one before it.
type Compress<'a, P> = &'a (dyn Fn(usize, Option<&Image>, &Image) -> Result<P, ViewError> + Sync);

/// Work of each worker.
pub(super) struct Stages<'a, P> {
    pub draw: Draw<'a>,
    pub compress: Compress<'a, P>,
}

pub(super) struct Pipeline<'a, P> {
    stages: Stages<'a, P>,
    /// Number of places.
    count: usize,
    /// Number of workers.
    crew: usize,
    is_stopped: &'a AtomicBool,
    board: Mutex<Board<P>>,
    /// Notified of each change of the board.
    change: Condvar,
}

/// Where the work stands.
struct Board<P> {
    /// The place that is drawn next.
    next: usize,
    /// Number of places that have been handed on.
    done: usize,
    /// Images that the one after them is compressed against.
    images: BTreeMap<usize, Arc<Image>>,
    pieces: BTreeMap<usize, Result<P, ViewError>>,
    /// Number of workers that are at work.
    workers: usize,
}

/// State of the next piece to hand on.
enum Found<P> {
    Piece(Result<P, ViewError>),
    NotYet,
    /// No worker is left.
    Never,
}

impl<'a, P: Send> Pipeline<'a, P> {
    /// For a number of places and of workers.
    pub fn new(stages: Stages<'a, P>, count: usize, crew: usize, is_stopped: &'a AtomicBool) -> Self {
        let board = Board { next: 0, done: 0, images: BTreeMap::new(), pieces: BTreeMap::new(), workers: crew };
        Self { stages, count, crew, is_stopped, board: Mutex::new(board), change: Condvar::new() }
    }

    /// Does the work. `take` gets the pieces in the order of their places; `watch` is asked with the number of them whether to go on.
    ///
    /// # Errors
    /// The error of the first place that has one, [`ViewError::Interrupted`] if `watch` breaks, [`ViewError::Threads`] if no worker can
    /// be started.
    pub fn run(
        &self,
        take: &mut dyn FnMut(P) -> Result<(), ViewError>,
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<(), ViewError> {
        thread::scope(|scope| {
            for _ in 0..self.crew {
                if thread::Builder::new().spawn_scoped(scope, || self.work()).is_err() {
                    // The others do its share.
                    self.leave();
                }
            }
            let result = self.collect(take, watch);
            self.stop();
            result
        })
    }

    fn collect(
        &self,
        take: &mut dyn FnMut(P) -> Result<(), ViewError>,
        watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<(), ViewError> {
        let mut done = 0;
        while done < self.count {
            match self.wait_for(done) {
                Found::Piece(piece) => {
                    take(piece?)?;
                    done += 1;
                    self.board().done = done;
                    self.change.notify_all();
                }
                Found::NotYet => {}
                Found::Never => return Err(ViewError::Threads),
            }
            if watch(done).is_break() {
                return Err(ViewError::Interrupted);
            }
        }
        Ok(())
    }

    fn wait_for(&self, place: usize) -> Found<P> {
        let mut board = self.board();
        loop {
            if let Some(piece) = board.pieces.remove(&place) {
                return Found::Piece(piece);
            }
            if board.workers == 0 {
                return Found::Never;
            }
            let (woken, timeout) = self.change.wait_timeout(board, PATIENCE).unwrap_or_else(PoisonError::into_inner);
            board = woken;
            if timeout.timed_out() {
                return Found::NotYet;
            }
        }
    }

    fn work(&self) {
        /// Also a worker that panics is missed.
        struct Leaving<'p, 'a, P: Send>(&'p Pipeline<'a, P>);
        impl<P: Send> Drop for Leaving<'_, '_, P> {
            fn drop(&mut self) {
                self.0.leave();
            }
        }
        let _leaving = Leaving(self);
        while let Some(place) = self.next_place() {
            let piece = self.piece(place);
            self.board().pieces.insert(place, piece);
            self.change.notify_all();
        }
    }

    /// The next place, when the others are not far behind; `None` when there is nothing left to do.
    fn next_place(&self) -> Option<usize> {
        let mut board = self.board();
        while !self.is_stopped() && board.next < self.count && board.next >= board.done + 2 * self.crew {
            board = self.change.wait(board).unwrap_or_else(PoisonError::into_inner);
        }
        if self.is_stopped() || board.next >= self.count {
            return None;
        }
        board.next += 1;
        Some(board.next - 1)
    }

    fn piece(&self, place: usize) -> Result<P, ViewError> {
        let image = Arc::new((self.stages.draw)(place)?);
        let previous = self.exchange(place, &image);
        if self.is_stopped() {
            return Err(ViewError::Interrupted);
        }
        (self.stages.compress)(place, previous.as_deref(), &image)
    }

    /// Leaves an image for the next place, and waits for that of the one before.
    fn exchange(&self, place: usize, image: &Arc<Image>) -> Option<Arc<Image>> {
        let mut board = self.board();
        board.images.insert(place, Arc::clone(image));
        self.change.notify_all();
        let before = place.checked_sub(1)?;
        loop {
            if let Some(previous) = board.images.remove(&before) {
                return Some(previous);
            }
            // If it could not be drawn, its error ends the work.
            if self.is_stopped() {
                return None;
            }
            board = self.change.wait(board).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Lets all workers leave soon.
    fn stop(&self) {
        // While no worker is about to wait.
        let board = self.board();
        self.is_stopped.store(true, Ordering::Relaxed);
        drop(board);
        self.change.notify_all();
    }

    fn leave(&self) {
        self.board().workers -= 1;
        self.change.notify_all();
    }

    fn board(&self) -> MutexGuard<'_, Board<P>> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    /// An image of one pixel, whose colour is its place.
    fn image(place: usize) -> Image {
        Image::new(1, 1, vec![[u8::try_from(place).unwrap(); 4]])
    }

    /// A place, the colour of the image before, and that of its own.
    type Piece = (usize, Option<u8>, u8);

    /// Pieces that a crew hands on of 40 places, some of which take longer, up to the first that fails.
    fn handed_on(crew: usize, failing: Option<usize>) -> (Vec<Piece>, Result<(), ViewError>) {
        let (is_stopped, begun, taken) = (AtomicBool::new(false), AtomicUsize::new(0), AtomicUsize::new(0));
        let stages = Stages {
            draw: &|place: usize| {
                let ahead = begun.fetch_add(1, Ordering::SeqCst) + 1 - taken.load(Ordering::SeqCst);
                // One more may have been taken that is not yet counted.
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
        };
        let mut pieces = Vec::new();
        let pipeline = Pipeline::new(stages, 40, crew, &is_stopped);
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
    fn any_number_of_workers_hands_on_the_same_in_order() {
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
    fn an_error_of_the_file_or_a_break_ends_the_work() {
        for is_break in [false, true] {
            let is_stopped = AtomicBool::new(false);
            let stages = Stages { draw: &|place| Ok(image(place)), compress: &|_, _, _: &Image| Ok(()) };
            let pipeline = Pipeline::new(stages, 100, 3, &is_stopped);
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
