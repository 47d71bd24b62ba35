//! Inlets: places where particles enter during a run.

use serde::{Deserialize, Serialize};

use super::{FillRegion, SpeciesId};
use crate::Vector;

/// An inlet: a region where new particles appear at a constant rate, or where particles return from outlets.
///
/// A particle appears at a random place of the region where it interacts with no other particle and touches no surface.
/// If no such place is found, the particle waits, and enters as soon as a later attempt succeeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Inlet {
    /// Name, unique among the inlets of the scene.
    pub name: String,
    /// Species of the new particles, and their shares. The shares sum to 1. Empty if there are no new particles.
    pub composition: Vec<(SpeciesId, f64)>,
    /// Region in which whole particles appear.
    pub region: FillRegion,
    /// New particles per time `[1 / time]`. One particle is due at [`Self::from`], and then one in each interval
    /// `1 / rate`. 0 if particles only return.
    pub rate: f64,
    /// Mean velocity of the particles that enter `[length / time]`.
    pub velocity: Vector,
    /// Temperature of the Maxwell velocities that are added to [`Self::velocity`] `[energy]`.
    pub temperature: f64,
    /// Simulated time at which the first new particle is due `[time]`.
    pub from: f64,
    /// Simulated time after which no new particle is due `[time]`; may be infinite.
    pub until: f64,
    /// Number of new particles that enter in all; no limit if `None`.
    pub count: Option<u64>,
    /// No particle enters while this number of moving particles is in the system; no limit if `None`.
    pub keep: Option<u64>,
    /// Names of the outlets whose particles return here. A particle that has left enters again as soon as it finds a
    /// place, with the same species, a new id and the velocity of the inlet.
    pub recirculate: Vec<String>,
}

impl Inlet {
    /// Whether new particles enter, and not only particles that return.
    pub(crate) fn has_new_particles(&self) -> bool {
        self.rate > 0.0
    }

    /// Species of the new particles.
    pub(crate) fn species(&self) -> impl Iterator<Item = SpeciesId> + '_ {
        self.composition.iter().map(|(species, _)| *species)
    }

    /// Time at which new particle number `k` is due, counted from 0 `[time]`; infinite after [`Self::until`], and without
    /// new particles.
    pub(crate) fn attempt(&self, k: u64) -> f64 {
        if !self.has_new_particles() {
            return f64::INFINITY;
        }
        let time = self.from + k as f64 / self.rate;
        if time > self.until { f64::INFINITY } else { time }
    }

    /// Returns the species for a random number from 0 to 1.
    pub(crate) fn species_for(&self, mut number: f64) -> SpeciesId {
        for (species, share) in &self.composition {
            number -= share;
            if number < 0.0 {
                return *species;
            }
        }
        // Because of round-off, the shares may sum to less than 1.
        self.composition.last().map_or(SpeciesId(0), |(species, _)| *species)
    }
}
