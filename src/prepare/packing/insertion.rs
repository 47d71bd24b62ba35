//! Random sequential insertion.

use crate::Vector;
use crate::model::Region;
use crate::model::random::Random;
use crate::model::space::{Boundary, Space};
use crate::prepare::NoPlace;
use crate::prepare::packing::occupancy::Occupancy;
use crate::prepare::region::FillRegion;

/// At 90 % of the jamming density in three dimensions, one in about 10^4 attempts succeeds.
const ATTEMPTS: usize = 200_000;

/// Draws a random position such that the whole particle is inside a box.
pub(crate) fn draw(region: &Region, space: &Space, radius: f64, random: &mut Random) -> Vector {
    Vector::from_fn(|k, _| {
        if space.boundary[k] == Boundary::Flat {
            return space.lower[k];
        }
        let full = region.lower[k] == space.lower[k] && region.upper[k] == space.upper()[k];
        let margin = if full && space.boundary[k] == Boundary::Periodic { 0.0 } else { radius };
        let (lower, upper) = (region.lower[k] + margin, region.upper[k] - margin);
        let drawn = lower + (upper - lower).max(0.0) * random.uniform();
        // The upper side is part of the next image of the box.
        if drawn < upper { drawn } else { lower }
    })
}

/// Places particles with given radii and species one by one. Stops when a particle has no room.
pub(crate) fn insert(
    sizes: impl ExactSizeIterator<Item = (f64, u32)>,
    region: &FillRegion,
    occupancy: &mut Occupancy<'_>,
    random: &mut Random,
) -> Vec<Vector> {
    let mut positions = Vec::with_capacity(sizes.len());
    for (radius, species) in sizes {
        let free = (0..ATTEMPTS)
            .map(|_| region.draw(occupancy.space, radius, random))
            .find(|position| occupancy.is_free(position, species));
        let Some(position) = free else { break };
        occupancy.take(position, species);
        positions.push(position);
    }
    positions
}

pub(crate) fn no_room(placed: usize, count: usize) -> NoPlace {
    NoPlace::NoRoom { placed, count, attempts: ATTEMPTS }
}
