//! Connected components of bonded particles.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::ParticleId;
use crate::Vector;
use crate::base::numbers::id;

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Component {
    /// Ids of the particles. Every parent precedes its children. A linear chain runs from one end to the other.
    pub ids: Vec<u32>,
    /// For each particle, the index of its parent in `ids`. Particles are bonded to their parents, except in the result
    /// of [`Self::side_by_side`]. The first particle is its own parent.
    pub parents: Vec<u32>,
    pub is_linear: bool,
}

impl Component {
    /// Returns a connected group as one component, or `None` if the group is not connected. Ids are indices into
    /// `group`.
    pub fn of_group(group: &[ParticleId], bonds: impl Iterator<Item = [ParticleId; 2]>) -> Option<Self> {
        if group.len() == 1 {
            return Some(Self::side_by_side(1));
        }
        let place = |member: ParticleId| group.iter().position(|other| *other == member).map(id);
        let inner: Vec<[u32; 2]> = bonds.filter_map(|[a, b]| Some([place(a)?, place(b)?])).collect();
        components(group.len(), &inner).into_iter().find(|all| all.ids.len() == group.len())
    }

    /// Returns a component of `count` particles in which the first particle is the parent of all others.
    pub fn side_by_side(count: usize) -> Self {
        Self { ids: (0..id(count)).collect(), parents: vec![0; count], is_linear: count < 3 }
    }

    /// Returns unwrapped positions relative to the first particle. `nearest` returns the minimum image of a separation.
    pub fn path(&self, positions: &[Vector], nearest: impl Fn(Vector) -> Vector) -> Vec<Vector> {
        let mut path: Vec<Vector> = Vec::with_capacity(self.ids.len());
        for (&id, &parent) in self.ids.iter().zip(&self.parents) {
            let from = self.ids[parent as usize] as usize;
            let step = nearest(positions[id as usize] - positions[from]);
            path.push(path.get(parent as usize).map_or(step, |at| at + step));
        }
        path
    }
}

/// Returns the components of bonded particles, without single particles. Components with a free end come first.
pub(crate) fn components(particles: usize, bonds: &[[u32; 2]]) -> Vec<Component> {
    let (starts, partners) = adjacency(particles, bonds);
    let partners_of = |id: u32| &partners[starts[id as usize]..starts[id as usize + 1]];
    let count = id(particles);
    let ends = (0..count).filter(|&id| partners_of(id).len() == 1);
    let others = (0..count).filter(|&id| partners_of(id).len() > 1);
    let mut is_known = vec![false; count as usize];
    let mut components = Vec::new();
    for first in ends.chain(others) {
        if is_known[first as usize] {
            continue;
        }
        is_known[first as usize] = true;
        let (mut ids, mut parents) = (vec![first], vec![0]);
        let mut waiting = VecDeque::from([0]);
        while let Some(place) = waiting.pop_front() {
            for &partner in partners_of(ids[place as usize]) {
                if !std::mem::replace(&mut is_known[partner as usize], true) {
                    waiting.push_back(id(ids.len()));
                    ids.push(partner);
                    parents.push(place);
                }
            }
        }
        let ends: usize = ids.iter().map(|&id| partners_of(id).len()).sum();
        let is_linear = ids.iter().all(|&id| partners_of(id).len() <= 2) && ends == 2 * (ids.len() - 1);
        components.push(Component { ids, parents, is_linear });
    }
    components
}

/// Returns where the partners of each particle begin, and the bonded partners of all particles in one array.
fn adjacency(particles: usize, bonds: &[[u32; 2]]) -> (Vec<usize>, Vec<u32>) {
    let mut starts = vec![0; particles + 1];
    bonds.iter().flatten().for_each(|&id| starts[id as usize + 1] += 1);
    (1..starts.len()).for_each(|id| starts[id] += starts[id - 1]);
    let mut next = starts.clone();
    let mut partners = vec![0; 2 * bonds.len()];
    for &[a, b] in bonds {
        for (one, other) in [(a, b), (b, a)] {
            partners[next[one as usize]] = other;
            next[one as usize] += 1;
        }
    }
    (starts, partners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_runs_from_end_to_end() {
        let components = components(7, &[[3, 1], [1, 5], [5, 2], [0, 6]]);
        assert_eq!(components.len(), 2);
        assert_eq!(components[0], Component { ids: vec![0, 6], parents: vec![0, 0], is_linear: true });
        assert_eq!(components[1].ids, [2, 5, 1, 3]);
        assert_eq!((&components[1].parents[..], components[1].is_linear), (&[0, 0, 1, 2][..], true));
    }

    #[test]
    fn a_group_is_ordered_along_its_bonds() {
        let bonds = [[3, 1], [1, 5], [2, 5], [0, 6]].map(|pair: [u32; 2]| pair.map(ParticleId));
        let order = |group: &[u32]| {
            let ids: Vec<ParticleId> = group.iter().map(|id| ParticleId(*id)).collect();
            let all = Component::of_group(&ids, bonds.into_iter().filter(|pair| pair[0] != ParticleId(0)))?;
            Some((all.ids.iter().map(|place| group[*place as usize]).collect::<Vec<_>>(), all.parents))
        };
        assert_eq!(order(&[5, 1, 3, 2]), Some((vec![3, 1, 5, 2], vec![0, 0, 1, 2])));
        assert_eq!(order(&[4]), Some((vec![4], vec![0])));
        assert_eq!((order(&[1, 2]), order(&[0, 6])), (None, None));
    }

    #[test]
    fn rings_and_stars_are_not_linear() {
        let components = components(8, &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [4, 6]]);
        assert_eq!(components.iter().map(|c| (c.ids.len(), c.is_linear)).collect::<Vec<_>>(), [(4, false), (3, false)]);
    }
}
