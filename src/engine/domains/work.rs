//! Why a system runs in one thread, and how the work in several went.

use std::fmt;
use std::time::Duration;

/// Why a system runs in one thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SingleThread {
    /// Particles of a heat bath are drawn among all.
    HeatBath,
    /// Diameters grow.
    Growth,
    /// The sides of the box slide past each other.
    SlidingImages,
    /// Some pairs have interactions of their own that the neighbour search does not reach, or may start further apart than they reach.
    LongInteractions,
}

impl fmt::Display for SingleThread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::HeatBath => "a heat bath acts on all particles",
            Self::Growth => "the diameters grow",
            Self::SlidingImages => "the box is sheared",
            Self::LongInteractions => "bonds or starts reach further than the neighbour search",
        })
    }
}

/// How the work of domains went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DomainWork {
    /// Windows whose steps agreed.
    pub windows: u64,
    /// Windows that ended before a difference.
    pub differences: u64,
    /// Windows that ended because a particle came too far.
    pub uncovered: u64,
    /// Times that the domains were cut anew.
    pub cuts: u64,
    /// Stretches that one engine did for all.
    pub serial: u64,
    /// Steps of all particles, and of all domains together, which do those of copies, too.
    pub steps: [u64; 2],
    /// Wall time in the steps of windows.
    pub simulating: Duration,
    /// Wall time in the comparison of domains.
    pub comparing: Duration,
    /// Wall time in the exchange of copies.
    pub exchanging: Duration,
    /// Wall time until one engine has all.
    pub gathering: Duration,
    /// Wall time until domains have what one engine has.
    pub cutting: Duration,
}

impl fmt::Display for DomainWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { windows, differences, uncovered, cuts, serial, steps, .. } = self;
        let undone = differences + uncovered;
        let [own, all] = steps.map(|steps| steps as f64);
        let times = [self.simulating, self.comparing, self.exchanging, self.gathering, self.cutting];
        let [simulating, comparing, exchanging, gathering, cutting] = times.map(|time| time.as_secs_f64());
        write!(
            f,
            "{windows} windows, {undone} undone; domains cut {cuts} times, {serial} stretches in one thread\n\
             {:.2} steps for each one needed; {simulating:.1} s simulating, {comparing:.1} s comparing, {exchanging:.1} s exchanging, \
             {gathering:.1} s gathering, {cutting:.1} s cutting",
            if own > 0.0 { all / own } else { 1.0 },
        )
    }
}
