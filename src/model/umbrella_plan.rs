//! Windows of a distance, for umbrella sampling.

use serde::{Deserialize, Serialize};

use super::{Bond, ParticleId};

/// Umbrella sampling plan: the distance of two particles, or of the centres of mass of two groups, and the windows that it is held in.
///
/// G. M. Torrie and J. P. Valleau, J. Comput. Phys. 23, 187 (1977), [doi:10.1016/0021-9991(77)90121-8](https://doi.org/10.1016/0021-9991(77)90121-8).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UmbrellaPlan {
    /// The two groups: of one particle each, or of several.
    pub between: [Vec<ParticleId>; 2],
    /// Lower and upper end of each window, both ascending, so that each overlaps with the next one `[length]`.
    pub windows: Vec<[f64; 2]>,
    /// Bins of the distance over all windows together, about; ends of windows are edges of bins.
    pub bins: usize,
}

/// Bins if nothing else is asked for.
pub(crate) const USUAL_BINS: usize = 100;

/// Most bins.
pub(crate) const MOST_BINS: usize = 2000;

/// Most particles of a group: the centre of mass is found anew whenever one of them changes its velocity.
pub(crate) const MOST_MEMBERS: usize = 1000;

impl UmbrellaPlan {
    /// Lower and upper end of all windows together `[length]`.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let [[from, _], [_, to]] =
            [self.windows.first(), self.windows.last()].map(|it| it.copied().unwrap_or_default());
        [from, to]
    }

    /// Edges of the bins, among which are all ends of windows `[length]`.
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

/// Members of a group in an order in which each comes after one that it is bonded to, with the place of that one; the first has its own. `None` of a group that bonds do not hold together.
pub(crate) fn bonded_order(
    group: &[ParticleId],
    bonds: &[Bond],
    holds: impl Fn(&Bond) -> bool,
) -> Option<Vec<(ParticleId, usize)>> {
    let own = |id: &ParticleId| group.contains(id);
    let inner: Vec<[ParticleId; 2]> =
        bonds.iter().filter(|bond| bond.pair.iter().all(own) && holds(bond)).map(|bond| bond.pair).collect();
    let mut order = vec![(*group.first()?, 0)];
    let mut next = 0;
    while let Some(&(here, _)) = order.get(next) {
        for &[a, b] in &inner {
            let partner = if a == here { b } else { a };
            if (a == here || b == here) && !order.iter().any(|(id, _)| *id == partner) {
                order.push((partner, next));
            }
        }
        next += 1;
    }
    (order.len() == group.len()).then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::InteractionId;

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

    #[test]
    fn a_group_is_ordered_along_its_bonds() {
        let bonds = [[3, 1], [1, 5], [2, 5], [0, 6]].map(|[a, b]: [u32; 2]| Bond {
            pair: [ParticleId(a.min(b)), ParticleId(a.max(b))],
            interaction: InteractionId(0),
        });
        let order = |group: &[u32]| {
            let group: Vec<ParticleId> = group.iter().map(|id| ParticleId(*id)).collect();
            let order = bonded_order(&group, &bonds, |bond| bond.pair[0] != ParticleId(0))?;
            Some(order.into_iter().map(|(id, parent)| (id.0, parent)).collect::<Vec<_>>())
        };
        assert_eq!(order(&[5, 1, 3, 2]), Some(vec![(5, 0), (1, 0), (2, 0), (3, 1)]));
        assert_eq!(order(&[4]), Some(vec![(4, 0)]));
        assert_eq!((order(&[1, 2]), order(&[0, 6])), (None, None));
    }
}
