//! The foot of a particle on a feature with ends: an edge, or a face between its three edges.

use crate::check::reference::{Extents, Polynomial};

/// Position of a foot between the ends of a feature, as a function of the time since the start of a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    /// Distances from the ends as polynomials, negative beyond them.
    pub extents: Extents,
    /// Error of the direction of the feature in units of round-off.
    pub slenderness: f64,
}

impl Foot {
    pub fn polynomials(&self) -> [Polynomial; 4] {
        self.extents.map(|extent| Polynomial::new(&extent))
    }

    /// The distance from the nearest end at the time `dt`, negative beyond the end `[length]`.
    pub fn within(&self, dt: f64) -> f64 {
        self.extents.iter().map(|[at, rate, bend]| (bend * dt + rate) * dt + at).fold(f64::INFINITY, f64::min)
    }

    /// The foot at a later time.
    pub fn streamed(&self, dt: f64) -> Self {
        let later = |[at, rate, bend]: [f64; 3]| [(bend * dt + rate) * dt + at, rate + 2.0 * bend * dt, bend];
        Self { extents: self.extents.map(later), ..*self }
    }
}
