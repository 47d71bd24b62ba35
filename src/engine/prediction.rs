//! The prediction of a particle: its next contact and its next transition.

use super::array::Array;
use super::state::Body;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::marks::Marks;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::neighbours::grid::CellFace;
use crate::engine::schedule::{EventQueue, Pending, QueueEntry};
use crate::physics::overlap::Side;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Contact {
    /// Contact with another particle. The pair reaches a discontinuity of its potential from this side.
    Pair(Side),
    /// Contact with a surface. [`Prediction::partner_version`] is then the index of the surface.
    Surface,
}

/// The next contact and the next transition of a particle. A prediction fills half a cache line.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(align(32))]
pub(super) struct Prediction {
    /// Time of the contact since the epoch, or infinity.
    pub contact_time: f64,
    /// Time since the epoch at which the particle leaves its cell or skin, or infinity.
    pub transition_time: f64,
    pub partner: u32,
    /// Version of the partner's motion at the time of prediction, or the index of the surface.
    pub partner_version: u32,
    /// Order of simultaneous contacts. Pairs come before surfaces, and lower ids come first.
    pub tie_order: u32,
    pub contact: Contact,
    /// The face through which the particle leaves its cell; unused with neighbour lists.
    pub exit: CellFace,
}

const _: () = assert!(size_of::<Prediction>() == 32);

/// An engine for a part of the system stores partners outside its memory as `FIRST_ABSENT + id`. A contact with an
/// absent partner is void, because the partner has changed its motion since the prediction.
pub(super) const FIRST_ABSENT: u32 = 1 << 31;

pub(super) fn absent(id: u32) -> u32 {
    FIRST_ABSENT | id
}

#[inline]
pub(super) fn id_of(number: u32, bodies: &Array<Body>) -> u32 {
    number.checked_sub(FIRST_ABSENT).unwrap_or_else(|| bodies[number as usize].id)
}

impl Prediction {
    pub const NONE: Self = Self {
        contact_time: f64::INFINITY,
        transition_time: f64::INFINITY,
        partner: NO_PARTICLE,
        partner_version: 0,
        tie_order: 0,
        contact: Contact::Pair(Side::Positive),
        exit: CellFace { axis: 0, is_upper: false },
    };

    #[inline]
    pub fn is_transition(&self) -> bool {
        self.transition_time < self.contact_time
    }

    #[inline]
    pub fn due_time(&self) -> f64 {
        self.contact_time.min(self.transition_time)
    }

    /// Whether a pair contact comes before the predicted contact. Of simultaneous contacts, lower ids come first.
    #[inline]
    pub fn is_before(&self, particle: u32, other: u32, time: f64, bodies: &Array<Body>) -> bool {
        let id = |particle: u32| id_of(particle, bodies);
        let pair = |other: u32| (id(particle).min(id(other)), id(particle).max(id(other)));
        time < self.contact_time
            || (time == self.contact_time
                && matches!(self.contact, Contact::Pair(_))
                && pair(other) < pair(self.partner))
    }

    #[inline]
    pub fn meet(&mut self, particle: u32, other: u32, side: Side, time: f64, bodies: &Array<Body>) {
        let partner = &bodies[other as usize];
        self.contact_time = time;
        self.partner = other;
        self.partner_version = partner.version;
        let id = bodies[particle as usize].id;
        self.tie_order = partner.id.min(id) << 1 | u32::from(partner.id < id);
        self.contact = Contact::Pair(side);
    }

    #[inline]
    pub fn partner_in_contact(&self) -> Option<u32> {
        match self.contact {
            Contact::Pair(_) => Some(self.partner),
            Contact::Surface => None,
        }
    }

    /// Whether the predicted event continues an interrupted search for contacts with moving surfaces.
    #[inline]
    pub fn is_search(&self) -> bool {
        self.contact == Contact::Surface && self.partner_version == SEARCH
    }

    /// Updates the index of the partner. A partner that is no longer in memory is marked as absent, with the old index.
    pub fn renumber(&mut self, new: &[u32]) {
        if let Some(&number) = new.get(self.partner as usize) {
            self.partner = if number == NO_PARTICLE { absent(self.partner) } else { number };
        }
    }

    /// Returns the id of an absent partner. Directly after [`Self::renumber`], returns the old index.
    pub fn absent_partner(&self) -> Option<u32> {
        self.partner.checked_sub(FIRST_ABSENT).filter(|_| self.partner != NO_PARTICLE)
    }

    #[inline]
    pub fn reach(&mut self, surface: u32, time: f64, id: u32) {
        self.contact_time = time;
        self.partner = NO_PARTICLE;
        self.partner_version = surface;
        self.tie_order = SURFACE | id << 1;
        self.contact = Contact::Surface;
    }
}

/// Marks an interrupted search for contacts with moving surfaces. Stored in place of the index of a surface.
pub(super) const SEARCH: u32 = u32::MAX;

/// Bits of the tie order for contacts with surfaces and for transitions. Contacts of pairs do not use these bits,
/// because all ids are less than `2^29`.
const SURFACE: u32 = 1 << 30;
const TRANSITION: u32 = 2 << 30;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Schedule {
    pub predictions: Array<Prediction>,
    pub queue: EventQueue,
    /// The particles whose events the queue may hold, if other threads simulate the other particles.
    #[serde(skip)]
    pub part: Option<Marks>,
}

impl Schedule {
    pub fn new(predictions: Array<Prediction>, queue: EventQueue) -> Self {
        Self { predictions, queue, part: None }
    }

    #[inline]
    pub fn due<'a>(&'a self, bodies: &'a Array<Body>) -> Due<'a> {
        Due { predictions: &self.predictions, bodies, part: self.part.as_ref() }
    }

    /// Returns the queue, and what it needs to order its entries.
    #[inline]
    pub fn split<'a>(&'a mut self, bodies: &'a Array<Body>) -> (&'a mut EventQueue, Due<'a>) {
        (&mut self.queue, Due { predictions: &self.predictions, bodies, part: self.part.as_ref() })
    }

    /// Whether the queue may hold events of a particle.
    #[inline]
    pub fn has(&self, particle: u32) -> bool {
        self.part.as_ref().is_none_or(|part| part.has(particle))
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Due<'a> {
    pub predictions: &'a Array<Prediction>,
    pub bodies: &'a Array<Body>,
    /// The particles whose predictions may be read; `None` for all.
    pub part: Option<&'a Marks>,
}

impl Due<'_> {
    #[inline]
    fn has(&self, particle: u32) -> bool {
        self.part.is_none_or(|part| part.has(particle))
    }
}

impl Pending for Due<'_> {
    #[inline]
    fn entry(&self, particle: u32) -> QueueEntry {
        if !self.has(particle) {
            return QueueEntry { time: f64::INFINITY, particle, tie_order: 0 };
        }
        let prediction = &self.predictions[particle as usize];
        let tie_order = if prediction.is_transition() { TRANSITION } else { prediction.tie_order };
        QueueEntry { time: prediction.due_time(), particle, tie_order }
    }

    /// Orders contacts of pairs by the higher id, and then by the id of the particle that stores the prediction.
    fn rank(&self, particle: u32) -> u64 {
        let id = |particle: u32| u64::from(id_of(particle, self.bodies));
        let prediction = &self.predictions[particle as usize];
        let partner = if prediction.is_transition() { None } else { prediction.partner_in_contact() };
        // Contacts with particles of other threads are never executed in this order. They are held back.
        let partner = partner.filter(|partner| self.has(*partner));
        partner.map_or(0, |partner| id(partner).max(id(particle))) << 32 | id(particle)
    }

    #[inline]
    fn prefetch(&self, particle: u32) {
        prefetch(self.predictions, particle as usize);
    }
}
