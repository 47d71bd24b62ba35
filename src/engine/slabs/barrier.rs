//! A barrier for threads that wait for each other for microseconds.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest time for which a thread waits actively before it sleeps `[ns]`.
const LONGEST: u64 = 400_000;
/// Shortest time for which a thread waits actively `[ns]`.
const SHORTEST: u64 = 4_000;

/// Number of checks between two looks at the clock.
const CHECKS: u32 = 16;

/// Lets threads wait for each other. A thread first waits actively, because waking a thread takes long. Then it sleeps, so
/// that it does not keep a slower thread from its core.
///
/// A thread waits actively for a shorter time if other programs use the cores: each wait that lasts longer than
/// [`LONGEST`] halves this time, and each shorter wait doubles it.
#[derive(Debug)]
pub struct Barrier {
    threads: usize,
    arrived: AtomicUsize,
    round: AtomicUsize,
    /// Whether a thread has panicked.
    is_broken: AtomicBool,
    /// Time for which a thread waits actively `[ns]`.
    active: AtomicU64,
    sleeping: Mutex<()>,
    wake: Condvar,
}

impl Barrier {
    pub fn new(threads: usize) -> Self {
        Self {
            threads,
            arrived: AtomicUsize::new(0),
            round: AtomicUsize::new(0),
            is_broken: AtomicBool::new(false),
            active: AtomicU64::new(LONGEST),
            sleeping: Mutex::new(()),
            wake: Condvar::new(),
        }
    }

    /// Returns when all threads have called this function. Returns false if a thread has panicked.
    #[must_use]
    pub fn wait(&self) -> bool {
        self.wait_for_all();
        !self.is_broken.load(Ordering::Acquire)
    }

    /// Releases all threads, now and in future.
    pub fn break_down(&self) {
        self.is_broken.store(true, Ordering::Release);
        let guard = self.sleeping.lock().unwrap_or_else(PoisonError::into_inner);
        self.round.fetch_add(1, Ordering::AcqRel);
        drop(guard);
        self.wake.notify_all();
    }

    fn wait_for_all(&self) {
        if self.is_broken.load(Ordering::Acquire) {
            return;
        }
        let round = self.round.load(Ordering::Acquire);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.threads {
            self.arrived.store(0, Ordering::Release);
            // The lock ensures that no thread falls asleep between its last check and the notification.
            let guard = self.sleeping.lock().unwrap_or_else(PoisonError::into_inner);
            self.round.store(round.wrapping_add(1), Ordering::Release);
            drop(guard);
            self.wake.notify_all();
            return;
        }
        let (begin, active) = (Instant::now(), self.active.load(Ordering::Relaxed));
        let is_over = self.wait_actively(round, begin + Duration::from_nanos(active));
        if !is_over {
            self.sleep(round);
        }
        if !is_over || active < LONGEST {
            let was_short = begin.elapsed() < Duration::from_nanos(LONGEST);
            let next = if was_short { 2 * active } else { active / 2 };
            self.active.store(next.clamp(SHORTEST, LONGEST), Ordering::Relaxed);
        }
    }

    /// Waits actively for the end of a round. Returns false if the round has not ended at the given time.
    fn wait_actively(&self, round: usize, end: Instant) -> bool {
        loop {
            for _ in 0..CHECKS {
                if self.round.load(Ordering::Acquire) != round {
                    return true;
                }
                std::hint::spin_loop();
            }
            if Instant::now() >= end {
                return false;
            }
        }
    }

    fn sleep(&self, round: usize) {
        let mut guard = self.sleeping.lock().unwrap_or_else(PoisonError::into_inner);
        while self.round.load(Ordering::Acquire) == round && !self.is_broken.load(Ordering::Acquire) {
            guard = self.wake.wait(guard).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_thread_passes_before_all_have_arrived() {
        let (barrier, count) = (Barrier::new(3), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    for round in 1..=2_000 {
                        count.fetch_add(1, Ordering::Relaxed);
                        assert!(barrier.wait());
                        assert_eq!(count.load(Ordering::Relaxed), 3 * round);
                        assert!(barrier.wait());
                    }
                });
            }
        });
    }

    #[test]
    fn a_broken_barrier_releases_all() {
        let barrier = Barrier::new(3);
        std::thread::scope(|scope| {
            let waiting = [(); 2].map(|()| scope.spawn(|| barrier.wait()));
            barrier.break_down();
            for thread in waiting {
                assert!(!thread.join().unwrap());
            }
        });
        assert!(!barrier.wait());
    }
}
