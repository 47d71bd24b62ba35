//! Reproducible random numbers, with distributions for hard cases.

use carom::Vector;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.uniform()
    }

    pub fn below(&mut self, count: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, reason = "below count")]
        let number = (self.uniform() * count as f64) as usize;
        number
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Returns a log-uniform number between `10^lower` and `10^upper`.
    pub fn scale(&mut self, lower: f64, upper: f64) -> f64 {
        10_f64.powf(self.between(lower, upper))
    }

    /// Products with a power of two are exact.
    pub fn power_of_two(&mut self, lower: i32, upper: i32) -> f64 {
        2_f64.powi(lower + i32::try_from(self.below((upper - lower + 1) as usize)).unwrap())
    }

    pub fn vector(&mut self) -> Vector {
        Vector::from_fn(|_, _| self.between(-1.0, 1.0))
    }

    /// Returns two directions that are orthogonal up to rounding.
    pub fn directions(&mut self) -> (Vector, Vector) {
        loop {
            let (first, second) = (self.vector(), self.vector());
            let across = first.cross(&second);
            if first.norm() > 0.1 && across.norm() > 0.01 {
                return (first.normalize(), across.normalize());
            }
        }
    }

    /// Permutes and mirrors the coordinates without rounding. Overlap functions are unchanged.
    pub fn turned(&mut self, vectors: [Vector; 3]) -> [Vector; 3] {
        let first = self.below(3);
        let step = 1 + self.below(2);
        let signs = [self.sign(), self.sign(), self.sign()];
        vectors.map(|x| Vector::from_fn(|k, _| signs[k] * x[(first + step * k) % 3]))
    }

    /// Returns the number or an adjacent floating-point number. Zero stays zero to prevent underflows.
    pub fn neighbour(&mut self, x: f64) -> f64 {
        match self.below(3) {
            0 => x,
            _ if x == 0.0 => x,
            1 => x.next_up(),
            _ => x.next_down(),
        }
    }
}
