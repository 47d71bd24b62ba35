use super::rules::Side;
use crate::engine::event::{Event, Other};
use crate::model::ParticleId;
use std::fmt;

/// Number of the first surface of the scene in events. Lower numbers denote the six walls of the box.
const FIRST_SURFACE: u32 = 6;

/// A contact of two particles, or of a particle with a wall of the box or a surface of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Contact {
    /// Two particles. The lower id comes first.
    Pair([ParticleId; 2]),
    /// A particle at a wall.
    Wall {
        /// The particle.
        particle: ParticleId,
        /// Axis of the wall: 0, 1 or 2 for x, y or z.
        axis: u8,
        /// Whether the wall is at the upper end of the axis.
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
    /// Returns the contact at which an event happens.
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

    /// Returns the contact of two particles, given in any order.
    #[must_use]
    pub fn pair(a: ParticleId, b: ParticleId) -> Self {
        Self::Pair([a.min(b), a.max(b)])
    }

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
            Self::Pair([a, b]) if a == b => write!(f, "particle {}", a.0),
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

/// A predicted event: its contact, and the side of the discontinuity on which the pair is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Claim {
    pub contact: Contact,
    pub side: Side,
}
