//! Umbrella windows: intervals of a distance, for umbrella sampling.

use serde::{Deserialize, Serialize};

use super::ParticleId;

/// Umbrella sampling plan: the distance of two particles, or of two centres of mass, is confined to windows.
///
/// G. M. Torrie and J. P. Valleau, J. Comput. Phys. 23, 187 (1977),
/// [doi:10.1016/0021-9991(77)90121-8](https://doi.org/10.1016/0021-9991(77)90121-8).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UmbrellaPlan {
    /// The two groups, each of one or more particles.
    pub between: [Vec<ParticleId>; 2],
    /// Lower and upper end of each window `[length]`, in ascending order. Adjacent windows overlap.
    pub windows: Vec<[f64; 2]>,
    /// Approximate number of histogram bins in the whole range. Ends of windows are edges of bins.
    pub bins: usize,
}

pub(crate) const USUAL_BINS: usize = 100;

pub(crate) const MOST_BINS: usize = 2000;

/// Largest number of particles in a group. Each change of a velocity in the group needs a new centre of mass.
pub(crate) const MOST_MEMBERS: usize = 1000;

impl UmbrellaPlan {
    /// Lower and upper end of all windows together `[length]`.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let [[from, _], [_, to]] =
            [self.windows.first(), self.windows.last()].map(|it| it.copied().unwrap_or_default());
        [from, to]
    }

    /// Edges of the histogram bins, including the ends of all windows `[length]`.
    pub(crate) fn edges(&self) -> Vec<f64> {
        let mut ends: Vec<f64> = self.windows.iter().flatten().copied().collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let [from, to] = self.range();
        let part = |pair: &[f64]| {
            let (lower, upper) = (pair[0], pair[1]);
            let share = self.bins as f64 * (upper - lower) / (to - from);
            let bins = crate::base::numbers::trunc_to_usize((share + 0.5).max(1.0));
            (0..bins).map(move |bin| lower + (upper - lower) * (bin as f64 / bins as f64))
        };
        let inner: Vec<f64> = ends.windows(2).flat_map(part).collect();
        inner.into_iter().chain(ends.last().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_windows_are_edges_of_bins() {
        let plan = UmbrellaPlan {
            between: [vec![ParticleId(0)], vec![ParticleId(1)]],
            windows: vec![[0.9, 2.0], [1.6, 3.0], [2.6, 5.0]],
            bins: 41,
        };
        assert_eq!(plan.range(), [0.9, 5.0]);
        let edges = plan.edges();
        assert!(plan.windows.iter().flatten().all(|end| edges.contains(end)), "{edges:?}");
        assert!(edges.windows(2).all(|pair| (pair[1] - pair[0] - 0.1).abs() < 1e-12), "{edges:?}");
        let coarse = UmbrellaPlan { bins: 1, ..plan };
        assert_eq!(coarse.edges(), [0.9, 1.6, 2.0, 2.6, 3.0, 5.0]);
    }
}
