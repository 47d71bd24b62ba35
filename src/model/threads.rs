//! Number of threads for a system.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Minimum number of particles per thread. More threads bring little or no gain in speed.
pub(crate) const PARTICLES_PER_THREAD: usize = 50_000;

/// Number of threads for a system. The results are the same, bit for bit, for any number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Threads {
    /// A fixed number from 1 to 64.
    Number(usize),
    /// One thread for each core, but at most one per 50,000 particles.
    Auto,
}

impl Threads {
    /// Largest number of threads, over all processes. A set of threads is stored as the bits of one integer.
    pub const MOST: usize = 64;

    /// Returns the number of threads for a system of `particles` on a machine with `cores`.
    #[must_use]
    pub fn of(self, particles: usize, cores: usize) -> usize {
        let number = match self {
            Self::Number(number) => number,
            Self::Auto => (particles / PARTICLES_PER_THREAD).min(cores),
        };
        number.clamp(1, Self::MOST)
    }
}

impl Default for Threads {
    fn default() -> Self {
        Self::Number(1)
    }
}

impl From<usize> for Threads {
    fn from(number: usize) -> Self {
        Self::Number(number)
    }
}

impl FromStr for Threads {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(number @ 1..=Self::MOST) => Ok(Self::Number(number)),
            Err(_) if text == "auto" => Ok(Self::Auto),
            _ => Err("expected a number of threads from 1 to 64, or auto".to_owned()),
        }
    }
}

impl fmt::Display for Threads {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Auto => f.write_str("auto"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_a_number_or_auto() {
        for (text, threads) in [("1", Threads::Number(1)), ("64", Threads::Number(64)), ("auto", Threads::Auto)] {
            assert_eq!(text.parse(), Ok(threads));
            assert_eq!(threads.to_string(), text);
        }
        for bad in ["0", "65", "-2", "1.5", "", "Auto", "99999999999999999999"] {
            assert!(bad.parse::<Threads>().is_err(), "{bad}");
        }
    }

    #[test]
    fn auto_threads_grow_with_particles_up_to_cores_and_limit() {
        let auto = |particles, cores| Threads::Auto.of(particles, cores);
        assert_eq!([0, 49_999, 99_999, 100_000, 1_000_000].map(|n| auto(n, 8)), [1, 1, 1, 2, 8]);
        assert_eq!(auto(100_000_000, 500), 64);
        assert_eq!(Threads::Number(3).of(10, 1), 3);
        assert_eq!(Threads::Number(0).of(10, 1), 1);
    }
}
