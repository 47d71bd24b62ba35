use serde::{Deserialize, Serialize};

/// Relative round-off of sums of energies.
const SAME: f64 = 1e-9;

/// Weights of a multicanonical ensemble. Configurations of energy `U` have the probability density `exp(-w(U))`.
///
/// `w` is linear between its nodes. Outside the nodes, `w` has the slope `1 / T` of a canonical ensemble. The
/// temperatures below and above the nodes may differ. If `w` equals the logarithm of the density of states at the
/// nodes, all energies between the nodes are visited equally often.
///
/// B. A. Berg and T. Neuhaus, Phys. Rev. Lett. 68, 9 (1992), [doi:10.1103/PhysRevLett.68.9](https://doi.org/10.1103/PhysRevLett.68.9).
#[doc(alias = "multicanonical")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EnergyWeights {
    nodes: Vec<(f64, f64)>,
    /// Slopes of `w` below and above the nodes `[1 / energy]`.
    slopes: [f64; 2],
}

impl EnergyWeights {
    /// Creates weights from nodes `(E, w(E))` with ascending energies, and from the temperatures below and above the
    /// nodes `[energy]`. Without nodes, `w` is zero at zero energy.
    #[must_use]
    pub fn new(nodes: Vec<(f64, f64)>, temperatures: [f64; 2]) -> Self {
        let nodes = if nodes.is_empty() { vec![(0.0, 0.0)] } else { nodes };
        Self { nodes, slopes: temperatures.map(f64::recip) }
    }

    /// Value of `w(E)` at an energy `[energy]`.
    #[must_use]
    pub fn at(&self, energy: f64) -> f64 {
        let above = self.nodes.partition_point(|node| node.0 <= energy);
        match (above.checked_sub(1).map(|below| self.nodes[below]), self.nodes.get(above)) {
            (Some((from, w)), Some(&(to, next))) => w + (next - w) * ((energy - from) / (to - from)),
            (Some((last, w)), None) => w + (energy - last) * self.slopes[1],
            (None, Some(&(first, w))) => w + (energy - first) * self.slopes[0],
            (None, None) => 0.0,
        }
    }

    /// The nodes `(E, w(E))`, with ascending energies.
    #[must_use]
    pub fn nodes(&self) -> &[(f64, f64)] {
        &self.nodes
    }

    /// Whether an energy `[energy]` is at or below the lowest node, and whether it is at or above the highest node.
    #[must_use]
    pub fn is_beyond(&self, energy: f64) -> [bool; 2] {
        let [first, last] = [self.nodes.first(), self.nodes.last()].map(|node| node.map_or(0.0, |node| node.0));
        [energy <= first + SAME * first.abs(), energy >= last - SAME * last.abs()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_linear_between_nodes_and_canonical_outside() {
        let weights = EnergyWeights::new(vec![(-3.0, 1.0), (-2.0, 4.0), (0.0, 5.0)], [0.5, 4.0]);
        for (energy, expected) in
            [(-3.0, 1.0), (-2.75, 1.75), (-2.0, 4.0), (-0.5, 4.75), (0.0, 5.0), (2.0, 5.5), (-4.0, -1.0)]
        {
            assert_eq!(weights.at(energy), expected, "{energy}");
        }
        assert_eq!([-3.1, -3.0 * (1.0 - 1e-12), -2.9].map(|energy| weights.is_beyond(energy)[0]), [true, true, false]);
        assert_eq!([0.1, 0.0, -0.1].map(|energy| weights.is_beyond(energy)[1]), [true, true, false]);
        assert_eq!(EnergyWeights::new(Vec::new(), [0.5, 4.0]).at(-1.0), -2.0);
    }
}
