//! Random sequential insertion of particles and of chains.

use crate::Vector;
use crate::model::Region;
use crate::model::random::Random;
use crate::model::space::{Boundary, Space};
use crate::scene::diagnostic::SceneErrorKind;
use crate::scene::packing::occupancy::{Occupancy, Overlapping};

/// Random attempts to place one particle before it is given up. At 90 % of the density where random insertion jams in
/// three dimensions, a place is found once in some 10^4 attempts.
pub(crate) const ATTEMPTS: usize = 200_000;

/// Attempts to place one chain before it is given up; each tries several directions for every particle.
pub(crate) const CHAIN_ATTEMPTS: usize = 2_000;

/// Directions to try for the next particle of a chain before the chain starts afresh.
const DIRECTIONS: usize = 50;

/// A place drawn evenly from a region, with the surface of the particle inside of it.
pub(crate) fn draw(region: &Region, space: &Space, radius: f64, random: &mut Random) -> Vector {
    Vector::from_fn(|k, _| {
        if space.boundary[k] == Boundary::Flat {
            return space.lower[k];
        }
        let full = region.lower[k] == space.lower[k] && region.upper[k] == space.upper()[k];
        let margin = if full && space.boundary[k] == Boundary::Periodic { 0.0 } else { radius };
        let (lower, upper) = (region.lower[k] + margin, region.upper[k] - margin);
        let drawn = lower + (upper - lower).max(0.0) * random.uniform();
        // Rounding must not put it on the upper side, which is the lower one of the next image.
        if drawn < upper { drawn } else { lower }
    })
}

/// Places particles one by one where they overlap nothing, in the order given: radius and species of each.
///
/// # Errors
/// [`SceneErrorKind::NoRoom`] if one finds no place.
pub(crate) fn insert(
    sizes: impl ExactSizeIterator<Item = (f64, u32)>,
    region: &Region,
    space: &Space,
    occupancy: &mut Occupancy<'_>,
    random: &mut Random,
) -> Result<Vec<Vector>, SceneErrorKind> {
    let count = sizes.len();
    let mut positions = Vec::with_capacity(count);
    for (radius, species) in sizes {
        let free = (0..ATTEMPTS)
            .map(|_| draw(region, space, radius, random))
            .find(|position| occupancy.overlap(position, species, |_| true).is_none());
        let Some(position) = free else {
            return Err(SceneErrorKind::NoRoom { placed: positions.len(), count, attempts: ATTEMPTS });
        };
        occupancy.take(position, species);
        positions.push(position);
    }
    Ok(positions)
}

/// What a grown chain is made of.
pub(crate) struct Links {
    pub length: usize,
    pub spacing: f64,
    pub radius: f64,
    pub species: u32,
    /// Contact of two particles of a chain that are not neighbours `[length]`.
    pub contact: f64,
}

/// Grows one chain from a random place, bead by bead in random directions, where it overlaps nothing.
pub(crate) fn grow(
    links: &Links,
    space: &Space,
    occupancy: &mut Occupancy<'_>,
    random: &mut Random,
) -> Option<Vec<Vector>> {
    let region = Region { lower: space.lower, upper: space.upper() };
    let chain = (0..CHAIN_ATTEMPTS).find_map(|_| try_to_grow(links, &region, space, occupancy, random))?;
    for position in &chain {
        occupancy.take(*position, links.species);
    }
    Some(chain)
}

fn try_to_grow(
    links: &Links,
    region: &Region,
    space: &Space,
    occupancy: &Occupancy<'_>,
    random: &mut Random,
) -> Option<Vec<Vector>> {
    let mut chain: Vec<Vector> = Vec::with_capacity(links.length);
    for _ in 0..links.length {
        let tries = if chain.is_empty() { 1 } else { DIRECTIONS };
        let next = (0..tries).find_map(|_| {
            let position = match chain.last() {
                None => draw(region, space, links.radius, random),
                Some(last) => wrapped(last + random.direction(space) * links.spacing, space),
            };
            let is_free = is_inside(&position, links.radius, space)
                && occupancy.overlap(&position, links.species, |_| true).is_none()
                && !meets_itself(&chain, &position, links.contact, space);
            is_free.then_some(position)
        })?;
        chain.push(next);
    }
    Some(chain)
}

/// Whether a particle would overlap its chain, but for the neighbour that it is bonded to.
fn meets_itself(chain: &[Vector], position: &Vector, contact: f64, space: &Space) -> bool {
    let others = &chain[..chain.len().saturating_sub(1)];
    let periods = space.periods();
    others
        .iter()
        .any(|other| crate::model::space::minimum_image(position - other, &periods).norm_squared() < contact * contact)
}

/// Whether a particle keeps clear of walls and, along open axes, inside of the box.
fn is_inside(position: &Vector, radius: f64, space: &Space) -> bool {
    (0..3).all(|k| {
        let range = space.lower[k] + radius..=space.upper()[k] - radius;
        !matches!(space.boundary[k], Boundary::Bounded { .. }) || range.contains(&position[k])
    })
}

/// The image of a position that lies in the box along periodic axes, and on the plane or line along flat ones.
pub(crate) fn wrapped(mut position: Vector, space: &Space) -> Vector {
    for k in 0..3 {
        match space.boundary[k] {
            Boundary::Flat => position[k] = space.lower[k],
            Boundary::Periodic => {
                let (lower, size, upper) = (space.lower[k], space.size[k], space.upper()[k]);
                if !(lower..upper).contains(&position[k]) {
                    let turned = lower + (position[k] - lower).rem_euclid(size);
                    // Rounding can turn a position just below the lower side into the upper one.
                    position[k] = if turned < upper { turned } else { lower };
                }
            }
            Boundary::Bounded { .. } => {}
        }
    }
    position
}

/// The first particle that overlaps an earlier one, with that one, in the order of ids. It is looked at where it is moved by each of
/// `images`.
pub(crate) fn first_overlap<'p>(
    particles: impl Iterator<Item = (&'p Vector, u32)>,
    images: &[Vector],
    mut occupancy: Occupancy<'_>,
    is_bonded: impl Fn(u32, u32) -> bool,
) -> Option<(u32, Overlapping)> {
    for (id, (position, species)) in (0..).zip(particles) {
        let overlap = |image| occupancy.overlap(&(position + image), species, |other| !is_bonded(other, id));
        if let Some(overlapping) = images.iter().find_map(overlap) {
            return Some((id, overlapping));
        }
        occupancy.take(*position, species);
    }
    None
}
