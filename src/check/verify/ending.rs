//! Proof that no event will ever happen again, by a search of all future times.

use super::approach::{Approach, Boundary};
use super::contact::Contact;
use super::facet::Facet;
use super::moving::is_searched;
use super::rules::{Side, Step};
use super::verifier::Verifier;
use super::violation::Fault;
use super::window::{MARGIN, reach_along, wall_approach};
use crate::Vector;
use crate::model::ParticleId;

/// Largest number of images that are searched, for all pairs together.
const MOST_IMAGES: f64 = 1e6;

/// Result of a search for an event at any future time.
enum Search {
    Never,
    /// Time from now to the next event `[time]`.
    Due(f64),
    /// The search found no event but cannot exclude one.
    Open,
}

impl Verifier {
    /// Proves that no event follows the last states. Searches all images of pairs, and all walls and surfaces.
    ///
    /// # Errors
    /// [`Fault::EndedEarly`] if an event is due; [`Fault::EndNotShown`] if an event cannot be excluded.
    pub fn witness_end(&mut self) -> Result<(), Fault> {
        let mut left = MOST_IMAGES;
        let mut open: Option<Contact> = None;
        for at in 0..self.world.moving.len() {
            let i = self.world.moving[at];
            open = open.or(self.search_walls(i)?);
            open = open.or(self.search_facets(i)?);
            for (j, _) in (0..).zip(&self.states.positions) {
                if self.world.is_first(i, j) && self.search_pair(i, j, &mut left)? {
                    open = open.or(Some(Contact::pair(ParticleId(i), ParticleId(j))));
                }
            }
        }
        open.map_or(Ok(()), |contact| Err(Fault::EndNotShown { contact }))
    }

    /// Returns an error if the particle will touch a wall. Returns a contact if the search cannot exclude it.
    fn search_walls(&self, i: u32) -> Result<Option<Contact>, Fault> {
        let mut open = None;
        for wall in &self.world.walls {
            let approach = wall_approach(&self.world, &self.before, i, wall, 0.0);
            let contact = Contact::Wall { particle: ParticleId(i), axis: wall.axis, is_upper: wall.is_upper };
            if let Some(after) = approach.next_event(f64::INFINITY) {
                return Err(self.ended_early(contact, after));
            }
            let size = self.before.positions[i as usize].norm() + wall.at.abs() + self.world.radius(i);
            if !approach.is_clear(size) {
                open = Some(contact);
            }
        }
        Ok(open)
    }

    /// Returns an error if the particle will touch a surface. Returns a contact if the search cannot exclude it.
    fn search_facets(&self, i: u32) -> Result<Option<Contact>, Fault> {
        let (world, states) = (&self.world, &self.before);
        let at = i as usize;
        let rests = states.velocities[at] == Vector::zeros() && world.accelerations[at] == Vector::zeros();
        let at_rest = world.facets_near(states, i, f64::INFINITY).filter(|facet| !world.motions.moves(facet.surface));
        let is_met = world.meets(i);
        let moving = |facet: &&Facet| is_met[facet.surface as usize] && world.motions.moves(facet.surface);
        let mut open = None;
        for facet in at_rest.filter(|_| !rests).chain(world.facets.iter().filter(moving)) {
            let is_missed = self.search_facet(facet, i)?;
            // Along a periodic axis, a feature with ends has infinitely many images. Only some images are searched.
            let has_images = (0..3).any(|k| world.periods[k] > 0.0 && !facet.is_endless(k));
            if open.is_none() && (has_images || !is_missed) {
                open = Some(facet.contact(i));
            }
        }
        Ok(open)
    }

    /// Whether a particle provably misses a feature during all future motion of the surface.
    fn search_facet(&self, facet: &Facet, i: u32) -> Result<bool, Fault> {
        let (motions, elapsed) = (&self.world.motions, &self.before.elapsed);
        let (motion, now) = (self.world.motion(&self.before, i), motions.now(elapsed));
        if !motions.moves(facet.surface) {
            let due = facet.approach_in(None, &motion, now, 0.0).next_event(f64::INFINITY);
            return match due {
                Some(after) => Err(self.ended_early(facet.contact(i), after)),
                None => Ok(facet.is_clear(&motion, 0.0)),
            };
        }
        for piece in motions.pieces_from(facet.surface, elapsed) {
            let (from, until) = ((piece.from - now).max(0.0), piece.until - now);
            if !is_searched(piece, until - from) {
                return Ok(false);
            }
            let later = motion.after(from);
            let found = facet.approach_in(Some(piece), &later, now + from, from).next_event(until);
            if let Some(after) = found.filter(|after| *after < until) {
                return Err(self.ended_early(facet.contact(i), after));
            }
            if until == f64::INFINITY {
                let size = motions.sway_beside(facet.surface, later, elapsed).length;
                return Ok(facet.is_clear(&later.seen(piece, now + from), size));
            }
        }
        Ok(false)
    }

    /// Returns an error if the pair has a future event. Returns true if an event cannot be excluded.
    fn search_pair(&self, i: u32, j: u32, left: &mut f64) -> Result<bool, Fault> {
        let Some(interaction) = self.world.interaction(i, j) else { return Ok(false) };
        let state = self.pairs.get(i, j).unwrap_or(0);
        let size = [i, j].iter().map(|&id| self.before.positions[id as usize].norm()).sum();
        let mut is_open = false;
        for side in [Side::Positive, Side::Negative] {
            let Some(seen) = Step::seen(&interaction.potential, state, side) else { continue };
            let boundary = Boundary::Sphere { distance: seen.distance, side };
            let nearest = Approach::of_pair(&self.world, &self.before, [i, j], 0.0, boundary);
            // A captured pair interacts through its nearest image only.
            let found = match side {
                Side::Positive => self.search_images(&nearest, seen.distance, size, left),
                Side::Negative => nearest.next_event(f64::INFINITY).map_or(Search::Never, Search::Due),
            };
            match found {
                Search::Never => {}
                Search::Due(after) => return Err(self.ended_early(Contact::pair(ParticleId(i), ParticleId(j)), after)),
                Search::Open => is_open = true,
            }
        }
        Ok(is_open)
    }

    fn ended_early(&self, contact: Contact, after: f64) -> Fault {
        Fault::EndedEarly { contact, due: self.start_time + (self.before.elapsed.total() + after) }
    }

    /// Searches for the next event of a pair in all images, at any time. Coordinates are as large as `size` `[length]`.
    fn search_images(&self, nearest: &Approach, distance: f64, size: f64, left: &mut f64) -> Search {
        let (within, mut none) = self.long_enough(nearest, distance, *left);
        let reach = reach_along(&nearest.velocity, &nearest.acceleration, within).add_scalar(distance) * MARGIN;
        let Some(images) = self.world.images(&nearest.position, &reach, *left) else { return Search::Open };
        *left -= images.len() as f64;
        let mut soonest: Option<f64> = None;
        for approach in images.into_iter().map(|position| Approach { position, ..nearest.clone() }) {
            match approach.next_event(f64::INFINITY) {
                Some(after) => soonest = Some(soonest.map_or(after, |soonest| soonest.min(after))),
                None if matches!(none, Search::Never) && !approach.is_clear(size) => none = Search::Open,
                None => {}
            }
        }
        soonest.map_or(none, Search::Due)
    }

    /// Returns how long the images of a pair must be searched, and the result if the search finds no event.
    fn long_enough(&self, flight: &Approach, distance: f64, most_images: f64) -> (f64, Search) {
        let moves = |k: usize| flight.velocity[k] != 0.0 || flight.acceleration[k] != 0.0;
        let round: Vec<usize> = (0..3).filter(|&k| self.world.periods[k] > 0.0 && moves(k)).collect();
        if round.is_empty() {
            return (f64::INFINITY, Search::Never);
        }
        let out = (0..3).filter(|&k| self.world.periods[k] == 0.0 && moves(k));
        let leaves = |k| last_within(flight.position[k], flight.velocity[k], flight.acceleration[k], distance * MARGIN);
        let left_after = out.map(leaves).fold(f64::INFINITY, f64::min);
        if left_after.is_finite() {
            return (left_after * MARGIN, Search::Never);
        }
        if let [axis] = round[..]
            && flight.acceleration[axis] == 0.0
        {
            // The pair moves along one periodic axis only. After one period, the separations of the images repeat.
            return (self.world.periods[axis] / flight.velocity[axis].abs() * MARGIN, Search::Never);
        }
        // The search covers about `along` periods along each axis. In 3D, these are a tenth of the permitted images.
        let along = libm::cbrt(0.1 * most_images);
        let time = |&k: &usize| 0.5 * along * self.world.periods[k] / flight.velocity[k].abs().max(f64::MIN_POSITIVE);
        (round.iter().map(time).fold(f64::INFINITY, f64::min), Search::Open)
    }
}

/// Last time `[time]` at which a flight along one axis is within `distance` of the origin; 0 if there is no such time.
fn last_within(x: f64, v: f64, a: f64, distance: f64) -> f64 {
    let mut last = 0.0_f64;
    for edge in [x - distance, x + distance] {
        // The roots `t` of `a t^2 / 2 + v t + edge = 0`.
        let roots = if a == 0.0 {
            [-edge / v, 0.0]
        } else {
            let discriminant = v * v - 2.0 * a * edge;
            if discriminant < 0.0 {
                continue;
            }
            let q = -(v + discriminant.sqrt().copysign(v));
            [q / a, if q == 0.0 { 0.0 } else { 2.0 * edge / q }]
        };
        last = roots.into_iter().fold(last, f64::max);
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_time_within_an_interval_is_exact() {
        assert_eq!(last_within(0.0, 2.0, 0.0, 1.0), 0.5);
        assert_eq!(last_within(-5.0, 2.0, 0.0, 1.0), 3.0);
        assert_eq!(last_within(5.0, 2.0, 0.0, 1.0), 0.0);
        // The particle starts at 0 with speed 4, turns, and leaves the interval from -1 to 1 at the lower end.
        let last = last_within(0.0, 4.0, -2.0, 1.0);
        assert!((last - (2.0 + 5.0_f64.sqrt())).abs() < 1e-14, "{last}");
        assert_eq!(last_within(0.0, 0.0, 2.0, 1.0), 1.0);
        assert_eq!(last_within(3.0, 0.0, 2.0, 1.0), 0.0);
    }
}
