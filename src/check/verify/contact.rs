//! Contacts: a pair of particles, or a particle and a wall or another surface, in words.

use super::rules::Side;
use crate::engine::event::{Event, Other};
use crate::model::ParticleId;
use std::fmt;

/// In events, surfaces of the scene have this number or a larger one; smaller numbers are walls.
const FIRST_SURFACE: u32 = 6;

/// A contact: a pair of particles, or a particle and a wall of the box or a surface of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Contact {
    /// Two particles, with the lower id first.
    Pair([ParticleId; 2]),
    /// A particle at a wall.
    Wall {
        /// The particle.
        particle: ParticleId,
        /// The wall's axis: 0, 1 or 2.
        axis: u8,
        /// Whether it is the wall at the upper corner.
        is_upper: bool,
    },
    /// A particle at a surface of the scene.
    Surface {
        /// The particle.
        particle: ParticleId,
        /// Index of the surface in the scene, from 0.
        surface: u32,
    },
}

impl Contact {
    /// The contact of an event.
    #[must_use]
    pub fn of(event: &Event) -> Self {
        let particle = event.particle;
        match (event.wall(), event.other) {
            (Some((axis, is_upper)), _) => Self::Wall { particle, axis, is_upper },
            (None, Other::Surface { surface, .. }) => {
                Self::Surface { particle, surface: surface.saturating_sub(FIRST_SURFACE) }
            }
            _ => Self::pair(particle, event.partner().unwrap_or(particle)),
        }
    }

    /// Two particles, in any order.
    #[must_use]
    pub fn pair(a: ParticleId, b: ParticleId) -> Self {
        Self::Pair([a.min(b), a.max(b)])
    }

    /// The particles.
    pub(super) fn particles(&self) -> impl Iterator<Item = u32> + use<> {
        let (first, second) = match self {
            Self::Pair([a, b]) => (a.0, Some(b.0)),
            Self::Wall { particle, .. } | Self::Surface { particle, .. } => (particle.0, None),
        };
        [Some(first), second].into_iter().flatten()
    }
}

impl fmt::Display for Contact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pair([a, b]) => write!(f, "particles {} and {}", a.0, b.0),
            Self::Wall { particle, axis, is_upper } => {
                let end = if *is_upper { "upper" } else { "lower" };
                let axis = ["x", "y", "z"].get(usize::from(*axis)).unwrap_or(&"?");
                write!(f, "particle {} and the wall at the {end} end of {axis}", particle.0)
            }
            Self::Surface { particle, surface } => {
                write!(f, "particle {} and surface {} of the scene", particle.0, u64::from(*surface) + 1)
            }
        }
    }
}

/// An event that the rule demands at one discontinuity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Claim {
    pub contact: Contact,
    pub side: Side,
}
