//! Runs the replicas of an exchange on several threads.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::error::ExchangeError;
use super::replica::Replica;
use super::replicas::{Exchange, ExchangeRow};
use crate::engine::{EngineError, Simulation};

/// Shortest wall time between two calls of the watch function.
const PAUSE: Duration = Duration::from_millis(20);

/// Receives the rows, frames and checkpoints of an exchange. The recorder `()` discards all data.
pub trait ExchangeRecorder {
    /// Error of the recorder. The exchange ends with this error.
    type Error;

    /// Called after each swap attempt, except during the equilibration.
    ///
    /// # Errors
    /// If the row cannot be recorded.
    fn row(&mut self, _row: &ExchangeRow<'_>) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Called for each temperature or window when a frame is due. `_place` is the index of the temperature or window.
    ///
    /// # Errors
    /// If the frame cannot be recorded.
    fn frame(&mut self, _place: usize, _simulation: &Simulation) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Whether it is time for a checkpoint.
    fn is_checkpoint_due(&self) -> bool {
        false
    }

    /// Called when a checkpoint is due, and at the end. An exchange that continues from a checkpoint has bitwise the
    /// same results as an uninterrupted exchange.
    ///
    /// # Errors
    /// If the checkpoint cannot be recorded.
    fn checkpoint(&mut self, _exchange: &Exchange) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl ExchangeRecorder for () {
    type Error = Infallible;
}

struct Task {
    number: usize,
    replica: Box<Replica>,
    time: f64,
}

struct Done {
    number: usize,
    replica: Box<Replica>,
    /// True if the replica has reached the time of its task. The outer error is a panic of the thread.
    result: thread::Result<Result<bool, EngineError>>,
}

/// A function of the caller that is called regularly and may end the exchange.
struct Watch<'w> {
    ask: &'w mut dyn FnMut([u64; 2]) -> ControlFlow<()>,
    asked: Instant,
    is_over: bool,
}

impl Watch<'_> {
    fn look(&mut self, attempts: [u64; 2]) {
        if self.asked.elapsed() >= PAUSE {
            self.asked = Instant::now();
            self.is_over |= (self.ask)(attempts).is_break();
        }
    }
}

impl Exchange {
    /// Runs the exchange, and passes rows and frames to a recorder, such as an
    /// [`ExchangeFolder`](super::ExchangeFolder). `jobs` replicas run at a time. Returns when the exchange is complete
    /// or `watch` stops it.
    ///
    /// Every few hundredths of a second, `watch` receives the number of completed attempts and the total number of
    /// attempts. The results do not depend on `watch`, `recorder` or `jobs`.
    ///
    /// # Errors
    /// [`ExchangeError::Recorder`] if something cannot be recorded. [`ExchangeError::Engine`] if a replica cannot
    /// continue. [`ExchangeError::NoOverlap`] if the equilibration determines no multicanonical weights.
    /// [`ExchangeError::OutsideOfWindow`] if a replica does not reach its window.
    pub fn execute<R: ExchangeRecorder>(
        mut self,
        jobs: usize,
        recorder: &mut R,
        watch: &mut dyn FnMut([u64; 2]) -> ControlFlow<()>,
    ) -> Result<Self, ExchangeError<R::Error>> {
        let mut watch = Watch { ask: watch, asked: Instant::now(), is_over: false };
        let jobs = jobs.clamp(1, self.temperatures().len());
        if jobs == 1 {
            self.drive(recorder, &mut watch, &mut advance_here::<R>)?;
            return Ok(self);
        }
        let pauses = AtomicBool::new(false);
        let (tasks, queue) = mpsc::channel();
        let queue = Mutex::new(queue);
        let (results, done) = mpsc::channel();
        thread::scope(|scope| {
            for _ in 0..jobs {
                let results = results.clone();
                scope.spawn(|| work(&queue, results, &pauses));
            }
            // Dropping the crew closes the task queue and thereby ends the threads.
            let crew = Crew { tasks, done, pauses: &pauses };
            self.drive(recorder, &mut watch, &mut |exchange, recorder, watch| crew.advance(exchange, recorder, watch))
        })?;
        Ok(self)
    }

    /// Runs the exchange to the end on one thread, without a recorder.
    ///
    /// # Errors
    /// As for [`Self::execute`], except for [`ExchangeError::Recorder`].
    pub fn finish(self) -> Result<Self, ExchangeError<Infallible>> {
        self.execute(1, &mut (), &mut |_| ControlFlow::Continue(()))
    }

    /// Alternately advances the replicas and attempts swaps. `advance` moves all replicas towards the time of the next
    /// attempt, and returns true if they have reached this time.
    fn drive<R: ExchangeRecorder>(
        &mut self,
        recorder: &mut R,
        watch: &mut Watch<'_>,
        advance: &mut dyn FnMut(&mut Self, &R, &mut Watch<'_>) -> Result<bool, Failed>,
    ) -> Result<(), ExchangeError<R::Error>> {
        while !self.is_over() && !watch.is_over {
            let is_there = advance(self, recorder, watch).map_err(|failed| self.failure(failed))?;
            if is_there {
                self.attempt()?;
                if self.is_measured() {
                    recorder.row(&self.row()).map_err(ExchangeError::Recorder)?;
                }
                if self.has_frame() {
                    for (place, simulation) in self.simulations().enumerate() {
                        recorder.frame(place, simulation).map_err(ExchangeError::Recorder)?;
                    }
                }
            }
            watch.look(self.attempts());
            if recorder.is_checkpoint_due() && !self.is_over() && !watch.is_over {
                recorder.checkpoint(self).map_err(ExchangeError::Recorder)?;
            }
        }
        recorder.checkpoint(self).map_err(ExchangeError::Recorder)
    }

    fn failure<E>(&self, failed: Failed) -> ExchangeError<E> {
        let place = self.row().replicas.iter().position(|number| *number == failed.number).unwrap_or(failed.number);
        let temperature = self.temperatures()[place];
        ExchangeError::Engine { replica: failed.number, temperature, source: failed.source }
    }
}

struct Failed {
    number: usize,
    source: EngineError,
}

/// Advances the replicas one by one in this thread. Returns false if `watch` ends the exchange or a checkpoint is due.
fn advance_here<R: ExchangeRecorder>(
    exchange: &mut Exchange,
    recorder: &R,
    watch: &mut Watch<'_>,
) -> Result<bool, Failed> {
    let (time, attempts) = (exchange.next_time(), exchange.attempts());
    for (number, replica) in exchange.replicas.iter_mut().enumerate() {
        let mut pauses = || {
            watch.look(attempts);
            watch.is_over || recorder.is_checkpoint_due()
        };
        if !replica.go(time, &mut pauses).map_err(|source| Failed { number, source })? {
            return Ok(false);
        }
    }
    Ok(true)
}

struct Crew<'p> {
    tasks: Sender<Task>,
    done: Receiver<Done>,
    pauses: &'p AtomicBool,
}

fn work(queue: &Mutex<Receiver<Task>>, results: Sender<Done>, pauses: &AtomicBool) {
    loop {
        // No thread panics while it holds the lock.
        let task = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok(Task { number, mut replica, time }) = task else { return };
        // Unwinding is safe, because a replica is never used after a panic.
        let result = catch_unwind(AssertUnwindSafe(|| replica.go(time, || pauses.load(Ordering::Relaxed))));
        if results.send(Done { number, replica, result }).is_err() {
            return;
        }
    }
}

impl Crew<'_> {
    fn advance<R: ExchangeRecorder>(
        &self,
        exchange: &mut Exchange,
        recorder: &R,
        watch: &mut Watch<'_>,
    ) -> Result<bool, Failed> {
        let (time, attempts) = (exchange.next_time(), exchange.attempts());
        self.pauses.store(false, Ordering::Relaxed);
        let mut all: Vec<Option<Done>> = exchange.replicas.iter().map(|_| None).collect();
        for (number, replica) in exchange.replicas.drain(..).enumerate() {
            // The receiver outlives the crew, so sending cannot fail.
            let _ = self.tasks.send(Task { number, replica: Box::new(replica), time });
        }
        let mut left = all.len();
        while left > 0 {
            if let Ok(done) = self.done.recv_timeout(PAUSE) {
                let number = done.number;
                all[number] = Some(done);
                left -= 1;
            }
            watch.look(attempts);
            if watch.is_over || recorder.is_checkpoint_due() {
                self.pauses.store(true, Ordering::Relaxed);
            }
        }
        let (mut is_there, mut failed) = (true, None);
        for Done { number, replica, result } in all.into_iter().flatten() {
            exchange.replicas.push(*replica);
            match result.unwrap_or_else(|panic| resume_unwind(panic)) {
                Ok(is_done) => is_there &= is_done,
                Err(source) => failed = failed.or(Some(Failed { number, source })),
            }
        }
        failed.map_or(Ok(is_there), Err)
    }
}
