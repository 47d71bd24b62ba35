//! The prediction of a particle: its earliest contact, its transition, and the earlier of their two times.

use super::state::Body;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::neighbours::grid::CellFace;
use crate::engine::schedule::{EventQueue, Pending, QueueEntry};
use crate::physics::overlap::Side;
use serde::{Deserialize, Serialize};

/// Kind of a predicted contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Contact {
    /// A discontinuity of the particle's potential with the partner.
    Pair(Side),
    /// A surface. Its index is stored instead of the partner's event count.
    Surface,
}

/// The pending prediction of a particle: its earliest contact and its transition. It fills half a cache line
/// and is aligned to it.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(align(32))]
pub(super) struct Prediction {
    /// Time of the contact since the epoch; infinite if there is none.
    pub contact_time: f64,
    /// Time since the epoch at which the particle leaves its cell, or the skin of its list; infinite if it
    /// never does.
    pub transition_time: f64,
    /// The partner of a pair contact.
    pub partner: u32,
    /// The partner's event count at the time of prediction, or the index of a surface.
    pub partner_events: u32,
    /// Orders simultaneous contacts. Pairs come before surfaces. Then the lower id of the pair or particle
    /// decides, and then the prediction of the lower particle comes first.
    pub tie_order: u32,
    pub contact: Contact,
    /// The face of the cell through which the particle leaves; unused with lists.
    pub exit: CellFace,
}

const _: () = assert!(size_of::<Prediction>() == 32);

/// In a part of a system, numbers from this number on denote absent partners: the number minus this number is
/// the partner's id. Contacts with absent partners are void, because these partners have changed course.
/// There are fewer than `2^29` particles.
pub(super) const FIRST_ABSENT: u32 = 1 << 31;

/// The number that denotes an absent partner with the given id.
pub(super) fn absent(id: u32) -> u32 {
    FIRST_ABSENT | id
}

/// The id of a particle, or of an absent partner.
#[inline]
pub(super) fn id_of(number: u32, bodies: &[Body]) -> u32 {
    number.checked_sub(FIRST_ABSENT).unwrap_or_else(|| bodies[number as usize].name)
}

impl Prediction {
    pub const NONE: Self = Self {
        contact_time: f64::INFINITY,
        transition_time: f64::INFINITY,
        partner: NO_PARTICLE,
        partner_events: 0,
        tie_order: 0,
        contact: Contact::Pair(Side::Positive),
        exit: CellFace { axis: 0, is_upper: false },
    };

    /// Whether the particle leaves its cell or the skin of its list before its next contact.
    #[inline]
    pub fn is_transition(&self) -> bool {
        self.transition_time < self.contact_time
    }

    #[inline]
    pub fn due_time(&self) -> f64 {
        self.contact_time.min(self.transition_time)
    }

    /// Returns whether a pair's event comes before the predicted event. If they are simultaneous, the event
    /// with the lower ids comes first.
    #[inline]
    pub fn is_before(&self, particle: u32, other: u32, time: f64, bodies: &[Body]) -> bool {
        let name = |particle: u32| id_of(particle, bodies);
        let pair = |other: u32| (name(particle).min(name(other)), name(particle).max(name(other)));
        time < self.contact_time
            || (time == self.contact_time
                && matches!(self.contact, Contact::Pair(_))
                && pair(other) < pair(self.partner))
    }

    /// Replaces the predicted contact by a pair's event.
    #[inline]
    pub fn meet(&mut self, particle: u32, other: u32, side: Side, time: f64, bodies: &[Body]) {
        let partner = &bodies[other as usize];
        self.contact_time = time;
        self.partner = other;
        self.partner_events = partner.events;
        let name = bodies[particle as usize].name;
        self.tie_order = partner.name.min(name) << 1 | u32::from(partner.name < name);
        self.contact = Contact::Pair(side);
    }

    /// Returns the partner, if the contact is a pair contact.
    #[inline]
    pub fn partner_in_contact(&self) -> Option<u32> {
        match self.contact {
            Contact::Pair(_) => Some(self.partner),
            Contact::Surface => None,
        }
    }

    /// Returns whether no contact is predicted, but the search for contacts with moving surfaces must
    /// continue.
    #[inline]
    pub fn is_search(&self) -> bool {
        self.contact == Contact::Surface && self.partner_events == SEARCH
    }

    /// Renumbers the particles in the prediction. A partner without a new number keeps its old one, marked as
    /// absent.
    pub fn renumber(&mut self, new: &[u32]) {
        if let Some(&number) = new.get(self.partner as usize) {
            self.partner = if number == NO_PARTICLE { absent(self.partner) } else { number };
        }
    }

    /// The id of the partner if it is absent, or its old number.
    pub fn absent_partner(&self) -> Option<u32> {
        self.partner.checked_sub(FIRST_ABSENT).filter(|_| self.partner != NO_PARTICLE)
    }

    /// Replaces the predicted contact by a contact with a surface.
    #[inline]
    pub fn reach(&mut self, surface: u32, time: f64, name: u32) {
        self.contact_time = time;
        self.partner = NO_PARTICLE;
        self.partner_events = surface;
        self.tie_order = SURFACE | name << 1;
        self.contact = Contact::Surface;
    }
}

/// Stored instead of the index of a surface: the search for contacts with moving surfaces is not complete.
pub(super) const SEARCH: u32 = u32::MAX;

/// Bits in the tie orders of surface contacts and transitions that are not used by pairs, because there are
/// fewer than `2^29` particles.
const SURFACE: u32 = 1 << 30;
const TRANSITION: u32 = 2 << 30;

/// The pending predictions of all particles, and the queue that orders them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Schedule {
    pub predictions: Vec<Prediction>,
    pub queue: EventQueue,
}

/// Predictions and the particles that they belong to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Due<'a> {
    pub predictions: &'a [Prediction],
    pub bodies: &'a [Body],
}

impl Pending for Due<'_> {
    #[inline]
    fn entry(&self, particle: u32) -> QueueEntry {
        let prediction = &self.predictions[particle as usize];
        let tie_order = if prediction.is_transition() { TRANSITION } else { prediction.tie_order };
        QueueEntry { time: prediction.due_time(), particle, tie_order }
    }

    /// The higher id of a pair, then the id of the particle.
    fn rank(&self, particle: u32) -> u64 {
        let name = |particle: u32| u64::from(id_of(particle, self.bodies));
        let prediction = &self.predictions[particle as usize];
        let partner = if prediction.is_transition() { None } else { prediction.partner_in_contact() };
        partner.map_or(0, |partner| name(partner).max(name(particle))) << 32 | name(particle)
    }

    #[inline]
    fn prefetch(&self, particle: u32) {
        prefetch(self.predictions, particle as usize);
    }
}
