//! Search for pairs of particles closer than a distance.

use thiserror::Error;

use super::system::Sample;
use crate::Vector;
use crate::engine::CellList;
use crate::model::space::Space;

/// Two particles whose nearest images are within a distance of each other.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct NearPair {
    /// Ids of the two particles, the lower id first.
    pub ids: [u32; 2],
    /// Position of the second particle relative to the first, `r_2 - r_1`, by nearest image `[length]`.
    pub separation: Vector,
    /// Squared length of the separation `[length^2]`.
    pub square: f64,
}

/// Error of a search for near pairs in a sample.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum NearPairsError {
    /// The distance is not positive, or so long that two images of a particle could be within it.
    #[error(
        "the distance of near pairs is {distance}, expected a positive number up to half of the shortest period, {largest}"
    )]
    Distance {
        /// The distance `[length]`.
        distance: f64,
        /// Half of the shortest period; infinite in a box without periodic axes `[length]`.
        largest: f64,
    },
    /// The sample has no particle with this id.
    #[error("there is no particle {id}: the sample has {count}")]
    NoParticle {
        /// The id.
        id: u32,
        /// Number of particles.
        count: usize,
    },
}

impl Sample<'_> {
    /// Calls `visit` once for each pair of the given particles that is closer than a distance, in no particular order.
    ///
    /// `ids` contains each particle once, for example [`SystemDescription::moving`](super::SystemDescription::moving).
    /// `space` is the box, [`SystemDescription::space`](super::SystemDescription::space). Separations use nearest
    /// images along periodic axes, even in a sheared box. Particles are sorted into cells, so the work grows with the
    /// number of particles plus the number of pairs found.
    ///
    /// ```
    /// use carom::analysis::instruments::{NearPairsError, Sample, SystemDescription};
    ///
    /// /// The mean number of neighbours of a particle.
    /// fn coordination(sample: &Sample<'_>, system: &SystemDescription) -> Result<f64, NearPairsError> {
    ///     let mut pairs = 0;
    ///     sample.for_each_pair_within(1.5, &system.space, &system.moving, |_| pairs += 1)?;
    ///     Ok(2.0 * f64::from(pairs) / system.moving.len() as f64)
    /// }
    /// ```
    ///
    /// # Errors
    /// [`NearPairsError::Distance`] if the distance is not positive or is more than half of the shortest period.
    /// [`NearPairsError::NoParticle`] if the sample has no particle with one of the ids. After an error, `visit` has
    /// not been called.
    #[doc(alias = "neighbours")]
    #[doc(alias = "cell list")]
    pub fn for_each_pair_within(
        &self,
        distance: f64,
        space: &Space,
        ids: &[u32],
        mut visit: impl FnMut(NearPair),
    ) -> Result<(), NearPairsError> {
        let largest = CellList::largest_range(space);
        if !(distance > 0.0 && distance <= largest) {
            return Err(NearPairsError::Distance { distance, largest });
        }
        let count = self.positions.len();
        if let Some(&id) = ids.iter().find(|id| **id as usize >= count) {
            return Err(NearPairsError::NoParticle { id, count });
        }
        self.cell_list(space, distance, ids).for_each_pair(|a, b, from_b, square| {
            let (ids, separation) = if a < b { ([a, b], -from_b) } else { ([b, a], *from_b) };
            visit(NearPair { ids, separation, square });
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::random::{Purpose, Random};
    use crate::model::space::Boundary;

    fn sample(positions: &[Vector], displacement: f64) -> Sample<'_> {
        Sample { positions, displacement, ..Sample::default() }
    }

    fn space(boundary: [Boundary; 3], size: [f64; 3]) -> Space {
        Space { lower: Vector::new(-1.0, 2.0, 0.0), size: size.into(), boundary }
    }

    fn points(count: usize, space: &Space) -> Vec<Vector> {
        let mut random = Random::new(7, Purpose::Exchange, 0);
        (0..count).map(|_| space.lower + Vector::from_fn(|k, _| random.uniform() * space.size[k])).collect()
    }

    fn images(apart: Vector, space: &Space, displacement: f64, distance: f64) -> Vec<Vector> {
        let along = |k: usize| if space.boundary[k] == Boundary::Periodic { -2..=2 } else { 0..=0 };
        let mut all = Vec::new();
        for (i, j, k) in along(0).flat_map(|i| along(1).flat_map(move |j| along(2).map(move |k| (i, j, k)))) {
            let [i, j, k] = [i, j, k].map(f64::from);
            let image = Vector::new(i * space.size.x + j * displacement, j * space.size.y, k * space.size.z);
            all.push(apart + image);
        }
        all.retain(|separation| separation.norm() < distance);
        all
    }

    #[test]
    fn near_pairs_match_brute_force_over_images() {
        let (periodic, flat, walls) = (Boundary::Periodic, Boundary::Flat, Boundary::walls(1.0));
        for (boundary, size, displacement) in [
            ([periodic; 3], [6.0, 7.0, 5.0], 0.0),
            ([periodic; 3], [6.0, 7.0, 5.0], 1.7),
            ([periodic, periodic, flat], [9.0, 8.0, 0.0], 0.0),
            ([walls; 3], [5.0, 6.0, 7.0], 0.0),
            ([periodic, Boundary::OPEN, walls], [5.0, 9.0, 4.0], 0.0),
            ([Boundary::OPEN; 3], [6.0, 6.0, 6.0], 0.0),
        ] {
            let space = space(boundary, size);
            let positions = points(120, &space);
            let ids: Vec<u32> = (0..120).rev().filter(|id| id % 5 != 2).collect();
            let half = 0.5 * space.periods().min();
            for distance in [0.4, 1.3, half.min(1e3)] {
                let mut found = Vec::new();
                let sample = sample(&positions, displacement);
                sample.for_each_pair_within(distance, &space, &ids, |pair| found.push(pair)).unwrap();
                let mut expected = 0;
                for [a, b] in ids.iter().flat_map(|&a| ids.iter().map(move |&b| [a, b])).filter(|[a, b]| a < b) {
                    let near = images(positions[b as usize] - positions[a as usize], &space, displacement, distance);
                    let pairs: Vec<&NearPair> = found.iter().filter(|pair| pair.ids == [a, b]).collect();
                    assert_eq!(pairs.len(), near.len(), "{boundary:?} {distance} {a} {b}");
                    for (pair, near) in pairs.iter().zip(&near) {
                        assert!((pair.separation - near).amax() < 1e-12, "{boundary:?} {distance} {pair:?} {near}");
                        assert!((pair.square - near.norm_squared()).abs() < 1e-12 * (1.0 + pair.square), "{pair:?}");
                    }
                    expected += near.len();
                }
                assert_eq!(found.len(), expected, "each near pair is found once, and no other pair");
                assert!(expected > 0, "{boundary:?} {distance}");
            }
        }
    }

    #[test]
    fn invalid_pair_distances_are_rejected() {
        let space = space([Boundary::Periodic, Boundary::walls(1.0), Boundary::Periodic], [6.0, 2.0, 5.0]);
        let positions = points(10, &space);
        let sample = sample(&positions, 0.0);
        let visit = |pair: NearPair| panic!("{pair:?}");
        for distance in [2.5_f64.next_up(), 0.0, -1.0, f64::INFINITY] {
            let refused = sample.for_each_pair_within(distance, &space, &[0, 1], visit);
            assert_eq!(refused, Err(NearPairsError::Distance { distance, largest: 2.5 }));
        }
        assert!(sample.for_each_pair_within(f64::NAN, &space, &[0, 1], visit).is_err());
        let beyond = sample.for_each_pair_within(1.0, &space, &[0, 10], visit);
        assert_eq!(beyond, Err(NearPairsError::NoParticle { id: 10, count: 10 }));
        assert_eq!(sample.for_each_pair_within(2.5, &space, &[], visit), Ok(()));

        let open = Space { boundary: [Boundary::OPEN; 3], ..space };
        let mut count = 0;
        let ids: Vec<u32> = (0..10).collect();
        sample.for_each_pair_within(f64::INFINITY, &open, &ids, |_| count += 1).unwrap();
        assert_eq!(count, 45);
    }
}
