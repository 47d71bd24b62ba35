//! `--threads`: on how many threads a run simulates.

use carom::engine::Simulation;

use super::cores;

/// Domains of fewer particles than this on average have been no faster than one engine for all, or hardly so.
const PARTICLES_PER_THREAD: usize = 250_000;

/// Choice of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threads {
    Number(usize),
    /// As many as there are cores, where it pays.
    Auto,
}

/// A number of threads, or `auto`.
pub fn threads(text: &str) -> Result<Threads, String> {
    match text.parse() {
        Ok(number @ 1..=64) => Ok(Threads::Number(number)),
        Err(_) if text == "auto" => Ok(Threads::Auto),
        _ => Err("expected a number of threads from 1 to 64, or auto".to_owned()),
    }
}

impl Threads {
    /// The number of threads for a simulation.
    pub fn of(self, simulation: &Simulation) -> usize {
        match self {
            Self::Number(number) => number,
            Self::Auto => enough_for(simulation.population().iter().sum(), cores()),
        }
    }
}

fn enough_for(particles: usize, cores: usize) -> usize {
    (particles / PARTICLES_PER_THREAD).min(cores).clamp(1, 64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_a_number_or_auto() {
        assert_eq!(threads("1"), Ok(Threads::Number(1)));
        assert_eq!(threads("64"), Ok(Threads::Number(64)));
        assert_eq!(threads("auto"), Ok(Threads::Auto));
        for bad in ["0", "65", "-2", "1.5", "", "Auto", "99999999999999999999"] {
            assert!(threads(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn auto_takes_cores_where_there_are_particles_for_them() {
        assert_eq!([0, 249_999, 499_999, 500_000, 10_000_000].map(|n| enough_for(n, 8)), [1, 1, 1, 2, 8]);
        assert_eq!(enough_for(100_000_000, 500), 64);
    }
}
