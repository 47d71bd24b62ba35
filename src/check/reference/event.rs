use super::response::Outcome;
use crate::Vector;
use crate::model::ParticleId;

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// Two particles at a discontinuity of their potential.
    Pair(Outcome),
    /// A particle at a wall of the box.
    Wall {
        /// Axis of the wall: 0, 1 or 2.
        axis: u8,
        /// Whether the wall is at the upper end of the axis.
        is_upper: bool,
    },
    /// A particle at a surface of the scene.
    Surface {
        /// Index of the surface in the scene.
        number: usize,
    },
    /// A particle leaves at an outlet.
    Exit {
        /// Index of the outlet among the surfaces of the scene.
        number: usize,
    },
    /// A particle at rest falls asleep.
    Rest,
    /// A sleeping particle wakes up.
    Wake,
}

/// An event executed by the reference engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// The particle; in a pair, the particle with the lower id.
    pub particle: ParticleId,
    /// The other particle of a pair.
    pub partner: Option<ParticleId>,
    /// Unit vector from the partner, the wall or the surface to the particle.
    pub normal: Vector,
    /// Momentum that the particle gained along `normal` `[mass length / time]`.
    pub impulse: f64,
    /// Angular momenta that the particle and its partner gained about their centres `[mass length^2 / time]`.
    pub torques: [Vector; 2],
    /// Potential energy gained `[energy]`.
    pub energy_step: f64,
    /// Kinetic energy lost at an infinite barrier `[energy]`.
    pub dissipated: f64,
    /// Velocities of the particle and its partner before the event `[length / time]`; zero for a wall or surface.
    pub before: [Vector; 2],
    /// Velocities of the particle and its partner after the event `[length / time]`.
    pub after: [Vector; 2],
}
