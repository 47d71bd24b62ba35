//! Random states: ordinary states, and hard states for which many programs fail.

use super::problem::{Pair, Problem};
use crate::oracle::cases::FAMILIES;
use crate::oracle::exact::State;
use crate::oracle::random::Random;
use carom::Vector;
use carom::physics::overlap::Side;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    Ordinary,
    Hard,
}

impl Class {
    pub fn name(self) -> &'static str {
        match self {
            Self::Ordinary => "ordinary",
            Self::Hard => "hard",
        }
    }
}

const SEED: u64 = 20_240_607;

/// Names of hard states in the oracle's tests. Lengths and times are of order one, as methods with fixed steps require.
const HARD: [&str; 5] = ["contact", "one float from contact", "grazing", "overlapped", "resting contact"];

pub fn pairs(problem: Problem, class: Class, count: usize) -> Vec<Pair> {
    let mut random = Random::new(SEED + u64::from(class == Class::Hard));
    let mut make = |k: usize| match class {
        Class::Ordinary => ordinary(&mut random, problem),
        Class::Hard => hard(&mut random, problem, k),
    };
    (0..count).map(|k| Pair::new(problem, make(k))).collect()
}

/// A random pair. Outside the discontinuity, at least half of the pairs approach each other.
fn ordinary(random: &mut Random, problem: Problem) -> State {
    let (along, across) = random.directions();
    let (position, velocity) = match problem.side {
        Side::Positive => {
            let aim = across * random.between(0.0, 1.3) - along * random.between(1.05, 3.0);
            let velocity = if random.chance(0.5) { aim.normalize() } else { random.vector() };
            (along * random.between(1.05, 3.0), velocity * random.between(0.5, 1.5))
        }
        Side::Negative => (along * random.between(0.1, 0.95), random.vector()),
    };
    let acceleration = random.vector() * random.between(0.1, 1.0);
    let acceleration = if problem.is_accelerated { acceleration } else { Vector::zeros() };
    State { position, velocity, acceleration, distance: 1.0 }
}

fn hard(random: &mut Random, problem: Problem, k: usize) -> State {
    let kinds = HARD.len() + usize::from(problem.is_accelerated);
    let Some(name) = HARD.get(k % kinds) else {
        let mut state = ordinary(random, problem);
        state.acceleration *= random.scale(-14.0, -6.0);
        return state;
    };
    let (_, family) = FAMILIES.iter().find(|(known, _)| known == name).expect("a family of the oracle");
    let mut state = family(random, problem.is_accelerated);
    if problem.is_accelerated && state.acceleration == Vector::zeros() {
        // Detection requires a nonzero relative acceleration.
        state.acceleration.z = -1.0;
    }
    state
}
