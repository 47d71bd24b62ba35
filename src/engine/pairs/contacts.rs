//! The time of the last contact of each particle, for the TC model.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ContactTimes {
    pub contact_time: f64,
    pub last: Vec<f64>,
}

impl ContactTimes {
    #[must_use]
    pub fn new(contact_time: f64, particles: usize) -> Self {
        Self { contact_time, last: vec![f64::NEG_INFINITY; particles] }
    }

    /// Records a contact. Returns true if a particle had its previous contact less than the contact time ago.
    pub fn note(&mut self, particles: &[u32], time: f64) -> bool {
        let mut is_recent = false;
        for &particle in particles {
            let last = &mut self.last[particle as usize];
            is_recent |= time - *last < self.contact_time;
            *last = time;
        }
        is_recent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::columns::Column;

    #[test]
    fn a_contact_is_recent_if_either_particle_had_one_within_the_contact_time() {
        let mut times = ContactTimes::new(0.5, 3);
        assert!(!times.note(&[0, 1], 1.0));
        assert!(!times.note(&[2], 1.25));
        assert!(times.note(&[0, 2], 1.5), "2 had one a quarter ago");
        times.shift(1.0);
        assert!(!times.note(&[1], 0.5), "a contact exactly one contact time ago is not recent");
        assert!(times.note(&[1, 0], 0.75));
    }
}
