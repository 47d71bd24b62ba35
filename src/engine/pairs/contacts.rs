//! The time of the last contact of each particle, for the TC model.

use crate::engine::array::Array;
use crate::physics::response::TcRule;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ContactTimes {
    pub contact_time: f64,
    pub rule: TcRule,
    pub last: Array<f64>,
}

impl ContactTimes {
    #[must_use]
    pub fn new(contact_time: f64, rule: TcRule, particles: usize) -> Self {
        Self { contact_time, rule, last: vec![f64::NEG_INFINITY; particles].into() }
    }

    /// Records a contact of one or two particles. Returns the time since the latest previous contact of any of them;
    /// infinity if there was none.
    pub fn note(&mut self, particles: &[u32], time: f64) -> f64 {
        let mut since = f64::INFINITY;
        for &particle in particles {
            let last = &mut self.last[particle as usize];
            since = since.min(time - *last);
            *last = time;
        }
        since
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::columns::Column;

    #[test]
    fn the_latest_contact_of_either_particle_counts() {
        let mut times = ContactTimes::new(0.5, TcRule::Resting, 3);
        assert_eq!(times.note(&[0, 1], 1.0), f64::INFINITY);
        assert_eq!(times.note(&[2], 1.25), f64::INFINITY);
        assert_eq!(times.note(&[0, 2], 1.5), 0.25);
        times.shift(1.0);
        assert_eq!(times.note(&[1], 0.5), 0.5);
        assert_eq!(times.note(&[1, 0], 0.75), 0.25);
    }
}
