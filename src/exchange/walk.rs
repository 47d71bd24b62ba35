//! Round trips of each replica from the upper end of the temperatures or energies to the lower end and back.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Heading {
    /// The replica has not yet visited the upper end.
    Nowhere,
    /// The replica has visited the upper end, but not the lower end afterwards.
    Down,
    /// The replica has visited the upper end and then the lower end.
    Up,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Walk {
    /// Indices of the highest and the lowest temperature, or of the last and the first window.
    ends: [usize; 2],
    headings: Vec<Heading>,
    trips: Vec<u64>,
}

impl Walk {
    /// Temperatures ascend or descend. In an exchange between windows, they are equal, and the windows ascend.
    pub fn new(temperatures: &[f64]) -> Self {
        let count = temperatures.len();
        let last = count - 1;
        let ends = if temperatures[0] > temperatures[last] { [0, last] } else { [last, 0] };
        Self { ends, headings: vec![Heading::Nowhere; count], trips: vec![0; count] }
    }

    /// Follows the replicas. Round trips that end before the measurement are not counted.
    pub fn see(&mut self, places: &[usize], is_measured: bool) {
        let [highest, lowest] = self.ends.map(|end| places[end]);
        self.visit(highest, [false, true], is_measured);
        self.visit(lowest, [true, false], is_measured);
    }

    pub fn visit(&mut self, replica: usize, [is_low, is_high]: [bool; 2], is_measured: bool) {
        let heading = &mut self.headings[replica];
        if is_high {
            self.trips[replica] += u64::from(*heading == Heading::Up && is_measured);
            *heading = Heading::Down;
        } else if is_low && *heading == Heading::Down {
            *heading = Heading::Up;
        }
    }

    pub fn trips(&self) -> &[u64] {
        &self.trips
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trip_begins_and_ends_at_the_highest_temperature() {
        let mut walk = Walk::new(&[1.0, 2.0, 3.0]);
        // Replica 0 goes from the lowest temperature to the highest, back to the lowest, and up again.
        for places in [[0, 1, 2], [1, 0, 2], [1, 2, 0], [1, 0, 2], [0, 1, 2], [1, 0, 2]] {
            walk.see(&places, true);
        }
        assert_eq!(walk.trips(), [0, 0, 0]);
        walk.see(&[1, 2, 0], true);
        walk.see(&[1, 2, 0], true);
        assert_eq!(walk.trips(), [1, 0, 0]);
        let mut other = Walk::new(&[3.0, 1.0]);
        for (places, is_measured) in [([0, 1], false), ([1, 0], false), ([0, 1], false), ([1, 0], true), ([0, 1], true)]
        {
            other.see(&places, is_measured);
        }
        assert_eq!(other.trips(), [1, 1]);
    }
}
