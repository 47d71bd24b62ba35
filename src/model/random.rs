//! Random numbers from one seed, identical on every platform.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::Vector;
use crate::model::space::{Boundary, Space};

/// Purpose of random numbers. Each purpose has its own stream, so that parts of a scene can change independently.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    Placement,
    Velocities,
    Composition,
    Thermostat,
    Growth,
    Exchange,
    Surface,
    Bootstrap,
    /// Velocities that `Simulation::thermalize` draws.
    Thermalizing,
    Volume,
    /// Particles that enter at inlets.
    Inlet,
    /// Pairs of particles that exchange their species.
    Swap,
}

impl Purpose {
    /// Number of the random stream for a group of particles. A change would change the initial states of all scenes.
    fn stream(self, group: usize) -> u64 {
        match self {
            Self::Growth => (1 << 63) + group as u64,
            Self::Exchange => (1 << 62) + group as u64,
            Self::Bootstrap => (1 << 61) + group as u64,
            Self::Thermalizing => (1 << 60) + group as u64,
            Self::Volume => (1 << 59) + group as u64,
            Self::Inlet => (1 << 58) + group as u64,
            Self::Swap => (1 << 57) + group as u64,
            Self::Surface => (1 << 42) + 4 * group as u64 + 3,
            _ => 4 * group as u64 + self as u64,
        }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64, purpose: Purpose, group: usize) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(purpose.stream(group));
        Self(generator)
    }

    /// Selects 64 random numbers for event number `count` of a particle. Each particle has numbers for `2^29` events.
    pub(crate) fn seek(&mut self, particle: u32, count: u32) {
        let block = (u128::from(particle) << 32) + u128::from(count << 3);
        self.0.set_word_pos(16 * block);
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-53.
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniformly distributed integer in `0..count`; the bias is below `count / 2^64`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, reason = "below count")]
        let number = ((u128::from(self.0.next_u64()) * count as u128) >> 64) as usize;
        number
    }

    /// Exponential with mean 1. Finite, because `uniform` is below 1.
    pub(crate) fn exponential(&mut self) -> f64 {
        -libm::log1p(-self.uniform())
    }

    /// Normal with mean 0 and variance 1, by Marsaglia's polar method.
    pub(crate) fn normal(&mut self) -> f64 {
        loop {
            let (x, y) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let s = x * x + y * y;
            if s > 0.0 && s < 1.0 {
                return x * (-2.0 * libm::log(s) / s).sqrt();
            }
        }
    }

    /// Vector of normal deviates, with exact zeros along flat axes.
    pub(crate) fn normal_vector(&mut self, space: &Space) -> Vector {
        Vector::from_fn(|k, _| if space.boundary[k] == Boundary::Flat { 0.0 } else { self.normal() })
    }

    /// A uniformly distributed direction, perpendicular to all flat axes.
    pub(crate) fn direction(&mut self, space: &Space) -> Vector {
        loop {
            let vector = self.normal_vector(space);
            let length = vector.norm();
            if length > 0.0 {
                return vector / length;
            }
        }
    }

    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_streams_are_reproducible_and_distinct() {
        let draw = |seed, purpose, group| Random::new(seed, purpose, group).uniform();
        assert_eq!(draw(1, Purpose::Placement, 0), draw(1, Purpose::Placement, 0));
        assert_ne!(draw(1, Purpose::Placement, 0), draw(1, Purpose::Velocities, 0));
        assert_ne!(draw(1, Purpose::Placement, 0), draw(1, Purpose::Placement, 1));
        assert_ne!(draw(1, Purpose::Placement, 0), draw(2, Purpose::Placement, 0));
    }

    #[test]
    fn each_particle_and_event_count_has_its_own_random_number() {
        let mut random = Random::new(1, Purpose::Thermostat, 0);
        let mut draw = |particle, count| {
            random.seek(particle, count);
            random.uniform()
        };
        let draws = [(0, 0), (0, 1), (1, 0), (1, 1), (u32::MAX, 0), (0, (1 << 29) - 1)].map(|(p, n)| draw(p, n));
        let mut distinct = draws.to_vec();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        assert_eq!(distinct.len(), draws.len());
        assert_eq!(draw(0, 1), draws[1], "independent of earlier draws");
    }

    #[test]
    fn stream_numbers_of_purposes_never_change() {
        let first_four = [Purpose::Placement, Purpose::Velocities, Purpose::Composition, Purpose::Thermostat];
        assert_eq!(first_four.map(|purpose| purpose.stream(3)), [12, 13, 14, 15]);
        assert_eq!([Purpose::Growth, Purpose::Exchange].map(|it| it.stream(3)), [(1 << 63) + 3, (1 << 62) + 3]);
        assert_eq!(Purpose::Surface.stream(3), (1 << 42) + 15);
        assert_eq!(Purpose::Volume.stream(3), (1 << 59) + 3);
        assert_eq!([Purpose::Bootstrap, Purpose::Thermalizing].map(|it| it.stream(3)), [(1 << 61) + 3, (1 << 60) + 3]);
    }

    #[test]
    fn normal_deviates_have_the_right_moments() {
        let mut random = Random::new(7, Purpose::Velocities, 0);
        let count = 100_000;
        let (mut m1, mut m2, mut m4) = (0.0, 0.0, 0.0);
        for _ in 0..count {
            let x = random.normal();
            m1 += x;
            m2 += x * x;
            m4 += x * x * x * x;
        }
        let n = f64::from(count);
        // Four standard errors: 1/sqrt(n), sqrt(2/n) and sqrt(96/n) for the first, second and fourth moment.
        assert!((m1 / n).abs() < 4.0 / n.sqrt());
        assert!((m2 / n - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
        assert!((m4 / n - 3.0).abs() < 4.0 * (96.0 / n).sqrt());
    }

    #[test]
    fn a_shuffle_is_a_permutation() {
        let mut items: Vec<usize> = (0..100).collect();
        Random::new(3, Purpose::Composition, 0).shuffle(&mut items);
        assert_ne!(items, (0..100).collect::<Vec<_>>());
        items.sort_unstable();
        assert_eq!(items, (0..100).collect::<Vec<_>>());
    }
}
