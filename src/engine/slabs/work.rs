use super::PHASES;
use std::fmt;

/// Statistics of a simulation on several threads of one process.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ThreadWork {
    /// Number of windows of simulated time.
    pub windows: u64,
    /// Number of windows that one thread repeated, because two steps conflicted.
    pub conflicts: u64,
    /// Number of times that one thread continued alone for a while.
    pub alone: u64,
    /// Number of times that the box was cut into slabs.
    pub cuts: u64,
    /// Numbers of steps deep in the slabs, near the faces between slabs, and of one thread alone.
    pub steps: [u64; PHASES],
}

impl fmt::Display for ThreadWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { windows, conflicts, alone, cuts, steps } = self;
        let all = steps.iter().sum::<u64>().max(1) as f64;
        let [_, near, rest] = steps.map(|steps| 100.0 * steps as f64 / all);
        write!(
            f,
            "{windows} windows of {:.0} steps, {conflicts} repeated; box cut {cuts} times, {alone} stretches in one thread\n\
             {near:.1} % of the steps near the faces of slabs, {rest:.1} % in one thread",
            all / (*windows).max(1) as f64,
        )
    }
}
