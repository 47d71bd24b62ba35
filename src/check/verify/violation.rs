//! Violations of the event rule by a run.

use super::contact::Contact;
use crate::engine::event::Outcome;
use crate::model::ParticleId;
use std::fmt;
use thiserror::Error;

/// A quantity of an event that differs from what the collision rule gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// The unit vector between the two `[1]`.
    Normal,
    /// The changes of the two velocities against the impulse of the event `[length / time]`.
    Velocity,
    /// Total momentum of the two `[mass length / time]`.
    Momentum,
    /// Kinetic energy against the energy step and what was dissipated `[energy]`.
    Energy,
    /// Kinetic energy lost, against the restitution `[energy]`.
    Dissipation,
    /// Energy step of the discontinuity `[energy]`.
    EnergyStep,
    /// The impulse, against the speed that a barrier leaves, over the reduced mass `[length / time]`.
    Impulse,
    /// Relative normal velocity afterwards, in the direction that the outcome excludes `[length / time]`.
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
            Self::Direction => "the direction afterwards",
        })
    }
}

/// Kind of a violation. Lengths are `[length]`, speeds `[length / time]`; a bound is what round-off explains.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// Not as many positions or velocities as the scene has particles.
    #[error("{found} states of {particles} particles")]
    Incomplete {
        /// Particles of the scene.
        particles: usize,
        /// States that are there.
        found: usize,
    },
    /// Time went backwards, or to no finite number.
    #[error("time went back by {by:.3e}")]
    Backwards {
        /// By how much `[time]`.
        by: f64,
    },
    /// An event that the rule demanded earlier did not take place: it was missed, or put behind others.
    #[error(
        "{contact} were due at t = {due}, and went {deeper:.3e} deeper into the invalid side since then; round-off explains \
        {bound:.1e}"
    )]
    Missed {
        /// The contact.
        contact: Contact,
        /// Simulated time at which it was due.
        due: f64,
        /// By how much the overlap function's distance decreased while it was negative.
        deeper: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// An event at a distance from its discontinuity.
    #[error("{contact} had an event {gap:.3e} away from the discontinuity; round-off explains {bound:.1e}")]
    Early {
        /// The contact.
        contact: Contact,
        /// How far.
        gap: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// An event of two that move apart.
    #[error("{contact} had an event while leaving the discontinuity with speed {speed:.3e}")]
    NotClosing {
        /// The contact.
        contact: Contact,
        /// How fast.
        speed: f64,
    },
    /// An event at a discontinuity, a wall or a particle that is not there.
    #[error("{contact} had an event at the distance {distance}, where nothing is for their pair state {state}")]
    Unknown {
        /// The contact.
        contact: Contact,
        /// Where.
        distance: f64,
        /// The state of the pair.
        state: usize,
    },
    /// Another outcome than the table's.
    #[error("{contact} had a {found:?} where the physics demands a {expected:?}")]
    WrongOutcome {
        /// The contact.
        contact: Contact,
        /// Outcome by the energies.
        expected: Outcome,
        /// Outcome in the run.
        found: Outcome,
    },
    /// The right outcome with wrong numbers.
    #[error("{contact}: {quantity} is off by {by:.3e}; round-off explains {bound:.1e}")]
    WrongNumbers {
        /// The contact.
        contact: Contact,
        /// The quantity.
        quantity: Quantity,
        /// By how much.
        by: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// The velocity of a particle changed without an event.
    #[error("the velocity of particle {} changed by {by:.3e} without an event", particle.0)]
    Disturbed {
        /// Which.
        particle: ParticleId,
        /// By how much.
        by: f64,
    },
    /// A particle is not where its flight leads.
    #[error("particle {} is {by:.3e} away from where its flight leads; round-off explains {bound:.1e}", particle.0)]
    Jumped {
        /// Which.
        particle: ParticleId,
        /// How far.
        by: f64,
        /// Round-off bound.
        bound: f64,
    },
    /// A particle that goes round the box in less time than the digits of the simulated time resolve.
    #[error(
        "particle {} is so fast ({speed:.3e}) that it goes round the box in less than the digits of the time resolve: nothing can \
        be proven", particle.0
    )]
    TooFast {
        /// Which.
        particle: ParticleId,
        /// How fast.
        speed: f64,
    },
    /// A gap or an overlap that round-off explains, because the numbers have so few digits, and that is far too large all the same.
    #[error(
        "{contact} had an event {by:.3e} away from a discontinuity at {distance}: round-off explains even that, in numbers of this size, \
        and so nothing can be proven"
    )]
    WithoutDigits {
        /// The contact.
        contact: Contact,
        /// Distance `[length]`.
        by: f64,
        /// The distance of the discontinuity `[length]`.
        distance: f64,
    },
    /// The run ended as if nothing would ever happen again, though something is due.
    #[error("the run ended because nothing would happen any more, but {contact} are due at t = {due}")]
    EndedEarly {
        /// The contact.
        contact: Contact,
        /// Simulated time at which it is due.
        due: f64,
    },
    /// The run ended as if nothing would ever happen again, which cannot be shown.
    #[error(
        "the run ended because nothing would happen any more, but {contact} pass each other, or each other's periodic images, for ever: \
        nothing shows that they never meet"
    )]
    EndNotShown {
        /// The contact.
        contact: Contact,
    },
    /// The caller wanted no more.
    #[error("interrupted")]
    Interrupted,
    /// At the end, the engine remembers another state of a pair than the events make it.
    #[error("particles {} and {} are in pair state {engine}, but their events lead to state {events}", pair[0].0, pair[1].0)]
    PairState {
        /// Which.
        pair: [ParticleId; 2],
        /// By the events since the start of the range.
        events: usize,
        /// In the engine's memory.
        engine: usize,
    },
}

impl Fault {
    /// The contact that it is about, if it is about one.
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
    /// Number of the event since the start of the simulation, from 1.
    pub event: u64,
    /// Simulated time.
    pub time: f64,
    /// Kind of the violation.
    pub fault: Fault,
}
