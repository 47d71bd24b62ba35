use std::fmt;
use std::time::Duration;

/// Statistics of a simulation that runs in several domains.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DomainWork {
    /// Number of windows that were accepted.
    pub windows: u64,
    /// Number of windows that were rolled back because two domains disagreed.
    pub differences: u64,
    /// Number of windows that were rolled back because a domain could not complete them, for example because a particle
    /// had left the region of the domain.
    pub uncovered: u64,
    /// Number of times that the system was divided into domains.
    pub cuts: u64,
    /// Number of times that a single engine took over from the domains.
    pub serial: u64,
    /// Number of steps without the steps of copies, and number of all steps.
    pub steps: [u64; 2],
    /// Wall time spent on the steps of windows.
    pub simulating: Duration,
    /// Wall time of the slowest domain of this process, summed over all windows. With one core per domain, the steps
    /// would take this time.
    pub slowest: Duration,
    /// Wall time in which threads and processes waited for the slowest thread or process.
    pub waiting: Duration,
    /// Wall time spent on comparing the results of domains.
    pub comparing: Duration,
    /// Wall time spent on updating the domains' copies of particles.
    pub exchanging: Duration,
    /// Wall time spent on transferring all particles to the single engine.
    pub gathering: Duration,
    /// Wall time spent on dividing the system into domains.
    pub cutting: Duration,
    /// Wall time spent on the transition to new epochs.
    pub moving: Duration,
    /// Number of bytes that this process has sent to other processes.
    pub sent: u64,
}

impl DomainWork {
    /// Adds the wall time `took` of a window, and the times of its domains, which ran on `threads` threads.
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
