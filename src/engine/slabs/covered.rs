//! Contacts of a strip that cannot conflict with steps of the slabs.

use crate::engine::marks::Marks;

/// A slab has held back these contacts, and has marked the places of both particles of each contact.
///
/// No slab executes a later step at a marked place. A contact in this set therefore conflicts with no step of a slab. If
/// another step changes one of its particles, the contact leaves the set.
#[derive(Debug, Clone, Default)]
pub struct Covered {
    contacts: Marks,
    changed: Marks,
    listed: Vec<u32>,
}

impl Covered {
    pub fn clear(&mut self) {
        for particle in self.listed.drain(..) {
            self.contacts.put(particle, false);
            self.changed.put(particle, false);
        }
    }

    /// Adds the next contact of a particle.
    pub fn add(&mut self, particle: u32) {
        self.contacts.put(particle, true);
        self.listed.push(particle);
    }

    /// Notes a step that changes a particle.
    pub fn change(&mut self, particle: u32) {
        self.contacts.put(particle, false);
        self.changed.put(particle, true);
        self.listed.push(particle);
    }

    /// Whether the next contact of a particle, with this partner, is in the set.
    #[inline]
    pub fn has(&self, particle: u32, partner: Option<u32>) -> bool {
        self.contacts.has(particle) && partner.is_none_or(|partner| !self.changed.has(partner))
    }
}
