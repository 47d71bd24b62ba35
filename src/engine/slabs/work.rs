use super::stretch::PHASES;
use std::fmt;

/// Statistics of a simulation on several threads of one process.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ThreadWork {
    /// Number of windows of simulated time.
    pub windows: u64,
    /// Number of windows that one thread repeated, because two steps conflicted.
    pub conflicts: u64,
    /// Number of steps that one thread executed alone, because it was faster or because the threads could not continue.
    pub alone: u64,
    /// Number of times that the box was cut into slabs.
    pub cuts: u64,
    /// Numbers of steps in windows: deep in the slabs, near the faces between slabs, and in the last phase.
    pub steps: [u64; PHASES],
}

impl fmt::Display for ThreadWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { windows, conflicts, alone, cuts, steps } = self;
        let in_windows = steps.iter().sum::<u64>();
        let [_, near, rest] = steps.map(|steps| 100.0 * steps as f64 / in_windows.max(1) as f64);
        write!(
            f,
            "{windows} windows of {:.0} steps, {conflicts} repeated; box cut {cuts} times; {:.1} % of all steps without threads\n\
             {near:.1} % of the steps in windows near the faces of slabs, {rest:.1} % in the last phase",
            in_windows as f64 / (*windows).max(1) as f64,
            100.0 * *alone as f64 / (in_windows + alone).max(1) as f64,
        )
    }
}
