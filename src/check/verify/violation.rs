//! The kinds of violations of the event rule.

use super::contact::Contact;
use crate::engine::event::Outcome;
use crate::model::ParticleId;
use std::fmt;
use thiserror::Error;

/// A quantity that violates the collision rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Unit vector between the two particles, or normal of the wall or surface `[1]`.
    Normal,
    /// Changes of the particles' velocities, compared with the impulse of the event `[length / time]`.
    Velocity,
    /// Total momentum of the two particles `[mass length / time]`.
    Momentum,
    /// Kinetic energy, compared with the energy step and the dissipated energy `[energy]`.
    Energy,
    /// Dissipated energy, compared with the energy loss that the restitution requires `[energy]`.
    Dissipation,
    /// Energy step of the event, compared with the energy step of the discontinuity `[energy]`.
    EnergyStep,
    /// Impulse divided by the reduced mass, compared with the required change of velocity `[length / time]`.
    Impulse,
    /// Torques of the event, compared with the impulse and with the changes of the spins `[mass length^2 / time]`.
    Torque,
    /// Relative normal velocity after the event, if its direction does not fit the outcome `[length / time]`.
    Direction,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Normal => "the normal",
            Self::Velocity => "the change of velocity",
            Self::Momentum => "the momentum",
            Self::Energy => "the energy balance",
            Self::Dissipation => "the dissipated energy",
            Self::EnergyStep => "the energy step",
            Self::Impulse => "the impulse",
            Self::Torque => "the torque",
            Self::Direction => "the direction afterwards",
        })
    }
}

/// Kind of a violation, with values in `[length]` or `[length / time]`. Round-off can explain values up to `bound`.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// The number of positions or velocities differs from the number of particles.
    #[error("{found} states of {particles} particles")]
    Incomplete {
        /// Number of particles in the scene.
        particles: usize,
        /// Number of states received.
        found: usize,
    },
    /// The time of an event is not finite, or earlier than the time of the previous states.
    #[error("time went back by {by:.3e}")]
    Backwards {
        /// Amount by which the time decreased `[time]`.
        by: f64,
    },
    /// An event was due but did not happen: it was missed, or executed too late.
    #[error(
        "{contact} were due at t = {due}, and went {deeper:.3e} deeper into the invalid side since then; round-off explains \
        {bound:.1e}"
    )]
    Missed {
        /// The contact.
        contact: Contact,
        /// Simulated time at which the event was due.
        due: f64,
        /// Growth of the overlap since the event was due.
        deeper: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// An event happened away from its discontinuity, before the particles reached it.
    #[error("{contact} had an event {gap:.3e} away from the discontinuity; round-off explains {bound:.1e}")]
    Early {
        /// The contact.
        contact: Contact,
        /// The distance.
        gap: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// An event happened while the particles moved away from the discontinuity.
    #[error("{contact} had an event while leaving the discontinuity with speed {speed:.3e}")]
    NotClosing {
        /// The contact.
        contact: Contact,
        /// Speed at which the particles move away from the discontinuity.
        speed: f64,
    },
    /// The contact of an event does not exist: no such particle, wall or surface, or no discontinuity at this distance.
    /// Also reported for thermostat events, and for a pair that cannot be in its given state.
    #[error("{contact} had an event at the distance {distance}, where their pair state {state} has no discontinuity")]
    Unknown {
        /// The contact.
        contact: Contact,
        /// Distance of the event.
        distance: f64,
        /// State of the pair.
        state: usize,
    },
    /// The outcome differs from the outcome that the energies require.
    #[error("{contact} had the outcome {found:?}, expected {expected:?}")]
    WrongOutcome {
        /// The contact.
        contact: Contact,
        /// Outcome that the energies require.
        expected: Outcome,
        /// Outcome of the event in the run.
        found: Outcome,
    },
    /// The outcome is right, but a quantity of the event violates the collision rule.
    #[error("{contact}: {quantity} is off by {by:.3e}; round-off explains {bound:.1e}")]
    WrongNumbers {
        /// The contact.
        contact: Contact,
        /// The quantity.
        quantity: Quantity,
        /// Deviation of the quantity.
        by: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// The spin of a particle changed without an event.
    #[error("the spin of particle {} changed without an event", particle.0)]
    Turned {
        /// The particle.
        particle: ParticleId,
    },
    /// A particle fell asleep that was not at rest, or not at a search.
    #[error("particle {} fell asleep, but was not at rest at a search", particle.0)]
    FellAsleep {
        /// The particle.
        particle: ParticleId,
    },
    /// A particle at rest did not fall asleep.
    #[error("particle {} was at rest, but did not fall asleep", particle.0)]
    StayedAwake {
        /// The particle.
        particle: ParticleId,
    },
    /// A sleeping particle woke up without a cause.
    #[error("particle {} woke up, but nothing disturbed it", particle.0)]
    WokeUp {
        /// The particle.
        particle: ParticleId,
    },
    /// A sleeping particle was hit, or a neighbour moved away, but it did not wake up.
    #[error("particle {} was disturbed, but did not wake up", particle.0)]
    StayedAsleep {
        /// The particle.
        particle: ParticleId,
    },
    /// The velocity of a particle changed without an event.
    #[error("the velocity of particle {} changed by {by:.3e} without an event", particle.0)]
    Disturbed {
        /// The particle.
        particle: ParticleId,
        /// Change of the velocity.
        by: f64,
    },
    /// The position of a particle differs from the position after its free flight.
    #[error("particle {} is {by:.3e} away from where its flight leads; round-off explains {bound:.1e}", particle.0)]
    Jumped {
        /// The particle.
        particle: ParticleId,
        /// Distance between the two positions.
        by: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// A particle travels around the box in a time shorter than the resolution of the simulated time.
    #[error(
        "particle {} is so fast ({speed:.3e}) that it crosses the box in less than the resolution of the time: nothing can \
        be proven", particle.0
    )]
    TooFast {
        /// The particle.
        particle: ParticleId,
        /// Speed of the particle.
        speed: f64,
    },
    /// A gap or overlap is far too large, but in numbers of this size, round-off can explain it.
    #[error(
        "{contact} had an event {by:.3e} away from a discontinuity at {distance}: the numbers are so large that \
        round-off can explain this deviation, so nothing can be proven"
    )]
    WithoutDigits {
        /// The contact.
        contact: Contact,
        /// Distance `[length]`.
        by: f64,
        /// Distance of the discontinuity `[length]`.
        distance: f64,
    },
    /// The run ended although an event was due.
    #[error("the run ended as if no further event were possible, but an event of {contact} is due at t = {due}")]
    EndedEarly {
        /// The contact.
        contact: Contact,
        /// Simulated time at which the event is due.
        due: f64,
    },
    /// The run ended, but a further event cannot be excluded.
    #[error(
        "the run ended as if no further event were possible, but {contact} or their periodic images pass each other \
        for ever, and it cannot be proven that they never meet"
    )]
    EndNotShown {
        /// The contact.
        contact: Contact,
    },
    /// The caller stopped the verification.
    #[error("interrupted")]
    Interrupted,
    /// At the end, the engine's state of a pair differs from the state that follows from the events.
    #[error("particles {} and {} are in pair state {engine}, but their events lead to state {events}", pair[0].0, pair[1].0)]
    PairState {
        /// The pair.
        pair: [ParticleId; 2],
        /// Pair state that follows from the events since the start of the range.
        events: usize,
        /// Pair state in the engine.
        engine: usize,
    },
}

impl Fault {
    /// Returns the contact at which the violation was found, if there is one.
    #[must_use]
    pub fn contact(&self) -> Option<Contact> {
        match *self {
            Self::Missed { contact, .. }
            | Self::Early { contact, .. }
            | Self::NotClosing { contact, .. }
            | Self::Unknown { contact, .. }
            | Self::WrongOutcome { contact, .. }
            | Self::WrongNumbers { contact, .. }
            | Self::WithoutDigits { contact, .. }
            | Self::EndedEarly { contact, .. }
            | Self::EndNotShown { contact } => Some(contact),
            _ => None,
        }
    }
}

/// A violation of the event rule: its kind, and the event at which it was found.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("at event {event}, t = {time}: {fault}")]
#[non_exhaustive]
pub struct Violation {
    /// Number of the event since the start of the simulation, counted from 1.
    pub event: u64,
    /// Simulated time.
    pub time: f64,
    /// Kind of the violation.
    pub fault: Fault,
}
