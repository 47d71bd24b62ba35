//! Chains: straight chains, and random chains that grow without overlaps.

use crate::Vector;
use crate::base::numbers::index;
use crate::model::Region;
use crate::model::random::Random;
use crate::model::space::{Boundary, Space, minimum_image};
use crate::prepare::NoPlace;
use crate::prepare::packing::occupancy::{Kind, Occupancy};

const CHAIN_ATTEMPTS: usize = 2_000;

/// Number of directions to try for the next particle. If all directions fail, the whole chain is restarted.
const DIRECTIONS: usize = 50;

pub(crate) fn straight(start: &Vector, direction: &Vector, length: u64, spacing: f64) -> Vec<Vector> {
    let step = direction.normalize() * spacing;
    (0..length).map(|k| start + step * k as f64).collect()
}

pub(crate) struct Links {
    pub length: usize,
    pub spacing: f64,
    pub radius: f64,
    pub kind: Kind,
    /// Contact distance of two particles of a chain that are not neighbours `[length]`.
    pub contact: f64,
}

/// Grows `count` chains, one after the other.
pub(crate) fn grow_all(
    links: &Links,
    count: u64,
    occupancy: &mut Occupancy<'_>,
    random: &mut Random,
) -> Result<Vec<Vector>, NoPlace> {
    let beads = links.length * index(count);
    let mut positions = Vec::with_capacity(beads);
    for _ in 0..count {
        let Some(chain) = grow(links, occupancy, random) else {
            return Err(NoPlace::NoRoom { placed: positions.len(), count: beads, attempts: CHAIN_ATTEMPTS });
        };
        positions.extend(chain);
    }
    Ok(positions)
}

fn grow(links: &Links, occupancy: &mut Occupancy<'_>, random: &mut Random) -> Option<Vec<Vector>> {
    let chain = (0..CHAIN_ATTEMPTS).find_map(|_| try_to_grow(links, occupancy, random))?;
    for position in &chain {
        occupancy.take(*position, links.kind);
    }
    Some(chain)
}

fn try_to_grow(links: &Links, occupancy: &Occupancy<'_>, random: &mut Random) -> Option<Vec<Vector>> {
    let space = occupancy.space;
    let region = Region { lower: space.lower, upper: space.upper() };
    let mut chain: Vec<Vector> = Vec::with_capacity(links.length);
    for _ in 0..links.length {
        let tries = if chain.is_empty() { 1 } else { DIRECTIONS };
        let next = (0..tries).find_map(|_| {
            let position = match chain.last() {
                None => region.draw(space, links.radius, random),
                Some(last) => space.wrapped(last + random.direction(space) * links.spacing),
            };
            let is_free = is_inside(&position, links.radius, space)
                && occupancy.is_free(&position, &links.kind)
                && !meets_itself(&chain, &position, links.contact, space);
            is_free.then_some(position)
        })?;
        chain.push(next);
    }
    Some(chain)
}

/// Whether a particle would overlap its chain. The last particle of the chain is its bonded neighbour and is ignored.
fn meets_itself(chain: &[Vector], position: &Vector, contact: f64, space: &Space) -> bool {
    let others = &chain[..chain.len().saturating_sub(1)];
    let periods = space.periods();
    others.iter().any(|other| minimum_image(position - other, &periods).norm_squared() < contact * contact)
}

/// Whether a particle lies entirely inside the box along all axes with walls or open sides.
fn is_inside(position: &Vector, radius: f64, space: &Space) -> bool {
    (0..3).all(|k| {
        let range = space.lower[k] + radius..=space.upper()[k] - radius;
        !matches!(space.boundary[k], Boundary::Bounded { .. }) || range.contains(&position[k])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::SpeciesId;
    use crate::model::random::Purpose;
    use crate::prepare::packing::occupancy::Contacts;

    fn chains(count: u64, length: f64) -> Result<Vec<Vector>, NoPlace> {
        let space = Space::periodic_cube(length);
        let mut contacts = Contacts::new(1);
        contacts.set(0, 0, 1.0);
        let links = Links { length: 10, spacing: 1.1, radius: 0.5, kind: Kind::of_species(SpeciesId(0)), contact: 1.0 };
        let mut random = Random::new(2, Purpose::Placement, 0);
        grow_all(&links, count, &mut Occupancy::new(&space, &contacts, 100), &mut random)
    }

    #[test]
    fn chains_grow_bead_by_bead_where_they_overlap_nothing() {
        let beads = chains(8, 9.0).unwrap();
        let periods = Vector::repeat(9.0);
        for (i, a) in beads.iter().enumerate() {
            for (j, b) in beads[..i].iter().enumerate() {
                let distance = minimum_image(a - b, &periods).norm();
                // Coordinates up to 9 are rounded by about 1e-15.
                assert!(distance >= 1.0 - 1e-14, "{i} {j}: {distance}");
                assert!(i - j > 1 || i.is_multiple_of(10) || (distance - 1.1).abs() < 1e-14, "{i} {j}: {distance}");
            }
        }
        let error = chains(8, 4.0).unwrap_err();
        let NoPlace::NoRoom { placed, count, .. } = error else { panic!("{error:?}") };
        assert!(placed < 80 && placed.is_multiple_of(10) && count == 80, "{placed} of {count}");
    }
}
