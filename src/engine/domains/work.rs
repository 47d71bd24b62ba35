//! The reason why a system runs in one thread, and statistics of the work in several threads.

use crate::model::Scene;
use std::fmt;
use std::time::Duration;

/// The reason why a system runs in one thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SingleThread {
    /// Diameters grow.
    ChangingDistances,
    /// The sides of the box slide past each other.
    SlidingImages,
    /// Pairs with interactions of their own are not held together by them, or may start further apart than
    /// the range of the interaction.
    LongInteractions,
}

impl SingleThread {
    /// The reason why a scene runs in one thread from start to end; `None` if it can run in several threads.
    /// While diameters grow, every scene runs in one thread.
    #[must_use]
    pub fn of(scene: &Scene) -> Option<Self> {
        match () {
            () if scene.shear_rate().is_some() => Some(Self::SlidingImages),
            () if scene.has_loose_bonds() || scene.allow_invalid_start() => Some(Self::LongInteractions),
            () => None,
        }
    }
}

impl fmt::Display for SingleThread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ChangingDistances => "the diameters grow",
            Self::SlidingImages => "the box is sheared",
            Self::LongInteractions => "some pairs have interactions of their own at any distance",
        })
    }
}

/// Statistics of the work in domains.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DomainWork {
    /// Windows whose steps agreed.
    pub windows: u64,
    /// Windows that were rolled back and repeated up to a difference.
    pub differences: u64,
    /// Windows that were rolled back because a particle came too far.
    pub uncovered: u64,
    /// Number of times that the domains were cut.
    pub cuts: u64,
    /// Stretches that a single engine ran.
    pub serial: u64,
    /// Number of steps of all particles, and the sum of the steps of all domains, which includes the steps of
    /// copies.
    pub steps: [u64; 2],
    /// Wall time in the steps of windows.
    pub simulating: Duration,
    /// Wall time of the slowest domain of this process in each window: the time of the steps if each domain
    /// has its own core.
    pub slowest: Duration,
    /// Wall time in which threads and processes wait for the slowest thread or process.
    pub waiting: Duration,
    /// Wall time in the comparison of domains.
    pub comparing: Duration,
    /// Wall time in the exchange of copies.
    pub exchanging: Duration,
    /// Wall time in which the single engine collects all particles.
    pub gathering: Duration,
    /// Wall time in which domains are cut.
    pub cutting: Duration,
    /// Wall time in which domains begin new epochs.
    pub moving: Duration,
    /// Bytes that this process has sent to others.
    pub sent: u64,
}

impl DomainWork {
    /// Adds the wall time of a window, and the times of its domains on `threads` threads.
    pub(super) fn simulate(&mut self, took: Duration, domains: &[Duration], threads: u32) {
        let busy = domains.iter().sum::<Duration>() / threads;
        self.simulating += busy.min(took);
        self.waiting += took.saturating_sub(busy);
        self.slowest += domains.iter().max().copied().unwrap_or_default();
    }
}

impl fmt::Display for DomainWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { windows, differences, uncovered, cuts, serial, steps, .. } = self;
        let undone = differences + uncovered;
        let [own, all] = steps.map(|steps| steps as f64);
        let times =
            [self.simulating, self.waiting, self.comparing, self.exchanging, self.gathering, self.cutting, self.moving];
        let [simulating, waiting, comparing, exchanging, gathering, cutting, moving] =
            times.map(|time| time.as_secs_f64());
        write!(
            f,
            "{windows} windows of {:.0} steps, {undone} undone; domains cut {cuts} times, {serial} stretches in one thread\n\
             {:.2} steps per necessary step; {simulating:.1} s simulating, {waiting:.1} s waiting, {comparing:.1} s comparing, {exchanging:.1} s exchanging, \
             {gathering:.1} s gathering, {cutting:.1} s cutting, {moving:.1} s in new epochs",
            own / (*windows).max(1) as f64,
            if own > 0.0 { all / own } else { 1.0 },
        )?;
        if self.sent > 0 {
            write!(f, "; {:.1} MB sent by each process", self.sent as f64 / 1e6)?;
        }
        Ok(())
    }
}
