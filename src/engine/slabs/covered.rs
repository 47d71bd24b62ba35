//! Contacts of a strip that cannot conflict with steps of the slabs.

use crate::engine::marks::Marks;

/// Contacts that a slab has held back, and of which it knows the places of both particles.
///
/// After it had held back a contact, the slab executed no later step near these places. Other slabs execute no steps there
/// at all. So the contact does not conflict with the steps of slabs. This is no longer true when another step has changed
/// one of its particles.
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
