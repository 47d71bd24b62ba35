//! Random sequential insertion.

use crate::Vector;
use crate::model::FillRegion;
use crate::model::random::Random;
use crate::prepare::NoPlace;
use crate::prepare::packing::occupancy::{Kind, Occupancy};

/// At 90 % of the jamming density in three dimensions, one in about 10^4 attempts succeeds.
const ATTEMPTS: usize = 200_000;

/// Places particles with given radii one by one. Stops when a particle has no room.
pub(crate) fn insert(
    sizes: impl ExactSizeIterator<Item = (f64, Kind)>,
    region: &FillRegion,
    occupancy: &mut Occupancy<'_>,
    random: &mut Random,
) -> Vec<Vector> {
    let mut positions = Vec::with_capacity(sizes.len());
    for (radius, kind) in sizes {
        let free = (0..ATTEMPTS)
            .map(|_| region.draw(occupancy.space, radius, random))
            .find(|position| occupancy.is_free(position, &kind));
        let Some(position) = free else { break };
        occupancy.take(position, kind);
        positions.push(position);
    }
    positions
}

pub(crate) fn no_room(placed: usize, count: usize) -> NoPlace {
    NoPlace::NoRoom { placed, count, attempts: ATTEMPTS }
}
