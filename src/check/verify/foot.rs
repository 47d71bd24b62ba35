//! The foot of a particle is its projection onto a bounded feature: an edge, or a face with three edges.

use crate::check::reference::{Extents, Polynomial};

/// The foot of a particle during a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    /// Distances of the foot from the ends, negative beyond an end, as polynomials of the flight time.
    pub extents: Extents,
    /// Error of the feature's normal in units of round-off.
    pub slenderness: f64,
}

impl Foot {
    pub fn polynomials(&self) -> [Polynomial; 4] {
        self.extents.map(|extent| Polynomial::new(&extent))
    }

    /// Distance of the foot from the nearest end after the flight time `dt`, negative beyond the end `[length]`.
    pub fn within(&self, dt: f64) -> f64 {
        self.extents.iter().map(|[at, rate, bend]| (bend * dt + rate) * dt + at).fold(f64::INFINITY, f64::min)
    }

    /// Returns the foot for a flight that starts later by `dt`.
    pub fn streamed(&self, dt: f64) -> Self {
        let later = |[at, rate, bend]: [f64; 3]| [(bend * dt + rate) * dt + at, rate + 2.0 * bend * dt, bend];
        Self { extents: self.extents.map(later), ..*self }
    }
}
