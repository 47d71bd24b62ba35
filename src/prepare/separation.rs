//! Moves particles apart at the start of a scene, until none overlap. Bonds, sheared boxes and surfaces that move are not
//! supported.
//!
//! In packings from programs with soft grains, neighbours overlap by 1e-6 to 1e-3 of a diameter. Here, overlapping
//! particles move apart along the line of their centres, one pair after the other, until a pass over all pairs finds no
//! overlap. This is a relaxation method for linear inequalities (S. Agmon, Canad. J. Math. 6, 382, 1954). The inequalities
//! say that no pair is closer than its contact distance; they are linear if the displacements are small.

use crate::Vector;
use crate::engine::CellList;
use crate::engine::surfaces::{Surface, Surfaces};
use crate::model::scene::mass_of;
use crate::model::space::nearest_image;
use crate::model::{Particle, Separated, Space, Species};
use crate::prepare::packing::occupancy::{Contacts, Kind, ROUNDING, rounding};

pub(crate) struct Separation<'a> {
    pub space: &'a Space,
    pub contacts: &'a Contacts,
    pub species: &'a [Species],
    pub surfaces: &'a Surfaces,
    /// Longest distance by which a particle may be moved `[length]`.
    pub limit: f64,
}

/// Largest ratio of contact distances. With more unlike sizes, the search for pairs would be slow.
pub(crate) const UNLIKE: f64 = 10.0;

/// Upper bound for the limit, in units of the shortest contact distance. Longer moves could reach too many pairs.
pub(crate) const LONGEST_MOVE: f64 = 0.25;

/// Gap between two particles after a move, divided by the deepest overlap at the start. Larger gaps need fewer passes.
const GAP: f64 = 0.1;

/// Maximum number of passes. A column of `n` particles needs about `n^2` passes.
const MOST_PASSES: usize = 100_000;

/// Maximum number of pairs and particles that all passes look at, which takes about a minute.
const MOST_LOOKS: usize = 4_000_000_000;

struct Pair {
    particles: [u32; 2],
    contact: f64,
    /// Smaller overlaps are round-off `[length]`.
    rounding: f64,
    /// Fraction of the distance by which the first particle moves. The second particle moves the rest.
    share: f64,
}

impl Separation<'_> {
    /// Moves particles apart. Returns the deepest remaining overlap as an error, if this needs moves beyond the limit.
    pub(crate) fn apply(&self, particles: &mut [Particle]) -> Result<Separated, f64> {
        let pairs = self.pairs(particles);
        let mut found = Separated::default();
        let mut note = |depth: f64| {
            found.overlaps += 1;
            found.deepest = found.deepest.max(depth);
        };
        pairs.iter().filter_map(|pair| self.overlap(pair, particles)).for_each(|(depth, _)| note(depth));
        particles.iter().filter_map(|particle| self.deepest_in_surface(particle)).for_each(|(depth, _)| note(depth));
        if found.overlaps == 0 {
            return Ok(found);
        }
        // At least one of the two particles would have to move by half of the overlap.
        if found.deepest > 2.0 * self.limit {
            return Err(found.deepest);
        }
        let start: Vec<Vector> = particles.iter().map(|particle| particle.position).collect();
        let (gap, mut deepest) = (GAP * found.deepest, found.deepest);
        for pass in 1..=MOST_PASSES.min(MOST_LOOKS / (pairs.len() + particles.len()) + 1) {
            deepest = self.pass(&pairs, particles, gap, pass.is_multiple_of(2));
            let moved =
                particles.iter().zip(&start).map(|(particle, start)| self.apart(&particle.position, start).norm());
            found.farthest = moved.fold(0.0, f64::max);
            if deepest == 0.0 {
                return Ok(found);
            }
            if found.farthest > self.limit {
                break;
            }
        }
        Err(deepest)
    }

    /// Removes the overlaps of all pairs and surfaces, one after the other. Returns the deepest one.
    ///
    /// Passes in both directions carry a displacement quickly through a column.
    fn pass(&self, pairs: &[Pair], particles: &mut [Particle], gap: f64, is_reversed: bool) -> f64 {
        let mut deepest = 0.0_f64;
        let mut separate = |pair: &Pair| {
            if let Some((depth, line)) = self.overlap(pair, particles) {
                let by = line * (depth + gap);
                let [a, b] = pair.particles.map(|id| id as usize);
                particles[a].position += by * pair.share;
                particles[b].position -= by * (1.0 - pair.share);
                deepest = deepest.max(depth);
            }
        };
        if is_reversed {
            pairs.iter().rev().for_each(&mut separate)
        } else {
            pairs.iter().for_each(&mut separate)
        }
        for particle in particles {
            particle.position = self.space.wrapped(particle.position);
            if let Some((depth, normal)) = self.deepest_in_surface(particle) {
                particle.position += normal * (depth + gap);
                deepest = deepest.max(depth);
            }
        }
        deepest
    }

    /// Returns all pairs that can meet if no particle moves farther than the limit.
    fn pairs(&self, particles: &[Particle]) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let longest = self.contacts.largest();
        if longest == 0.0 {
            return pairs;
        }
        let range = (longest + 2.0 * self.limit).min(CellList::largest_range(self.space));
        let points = (0..).zip(particles).map(|(id, particle)| (id, particle.position));
        let cells = CellList::new(self.space, 0.0, range, points);
        let side = self.space.farthest_side();
        cells.for_each_pair(|a, b, _, squared| {
            let both = [a, b].map(|id| &particles[id as usize]);
            let contact = self.contacts.between(&Kind::of(both[0]), &Kind::of(both[1]));
            let reach = contact + 2.0 * self.limit;
            if contact <= 0.0 || squared >= reach * reach {
                return;
            }
            // Light particles move farther than heavy ones, and static particles stay.
            let dimensions = self.space.dimensions();
            let weights = both.map(|particle| mass_of(particle, self.species, dimensions).recip());
            if weights[0] + weights[1] > 0.0 {
                let rounding = rounding(both.map(|particle| &particle.position), side, contact);
                let share = weights[0] / (weights[0] + weights[1]);
                pairs.push(Pair { particles: [a, b], contact, rounding, share });
            }
        });
        pairs.sort_unstable_by_key(|pair| pair.particles);
        pairs
    }

    fn apart(&self, a: &Vector, b: &Vector) -> Vector {
        nearest_image(a - b, &self.space.periods(), 0.0)
    }

    /// Returns the depth of an overlap, and the direction from the second to the first particle.
    fn overlap(&self, pair: &Pair, particles: &[Particle]) -> Option<(f64, Vector)> {
        let [a, b] = pair.particles.map(|id| &particles[id as usize].position);
        let apart = self.apart(a, b);
        let (squared, least) = (apart.norm_squared(), pair.contact - pair.rounding);
        if squared >= least * least {
            return None;
        }
        let distance = squared.sqrt();
        Some((pair.contact - distance, apart / distance.max(f64::MIN_POSITIVE)))
    }

    /// Returns the depth of a moving particle in the surface at rest that it overlaps most, and the direction out of it.
    fn deepest_in_surface(&self, particle: &Particle) -> Option<(f64, Vector)> {
        let species = &self.species[particle.species.0 as usize];
        if species.is_static() {
            return None;
        }
        let radius = 0.5 * particle.diameter.unwrap_or(species.diameter);
        let row = u16::try_from(particle.species.0).unwrap_or(u16::MAX);
        let mut deepest: Option<(f64, Vector)> = None;
        self.surfaces.for_each_near(
            (&particle.position, radius),
            row,
            self.surfaces.start_time(),
            |placed, position| {
                let depth = -placed.shape.gap(position, radius);
                let is_real = depth > ROUNDING * (placed.shape.terms(position) + radius);
                if placed.is_at_rest() && is_real && deepest.is_none_or(|(other, _)| depth > other) {
                    deepest = Some((depth, placed.shape.normal(position)));
                }
            },
        );
        deepest
    }
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::model::Scene;

    /// A box with walls along z. Small and large grains, which have different masses, are at the given places in turn.
    fn column(places: &[[f64; 3]], more: &str) -> Result<Scene, String> {
        let mut toml = format!(
            "
            {more}
            space = {{ size = [5.0, 5.0, 130.0], z = 'walls' }}
            species = [
                {{ name = 'small', mass = 1.3, diameter = 1.0 }},
                {{ name = 'large', mass = 3.1, diameter = 1.5 }},
                {{ name = 'fixed', diameter = 2.0, static = true }},
            ]
            interaction = [
                {{ species = ['small', 'small'], potential = 'hard-sphere' }},
                {{ species = ['small', 'large'], potential = 'hard-sphere' }},
                {{ species = ['large', 'large'], potential = 'hard-sphere' }},
                {{ species = ['small', 'fixed'], potential = 'hard-sphere' }},
                {{ species = ['large', 'fixed'], potential = 'hard-sphere' }},
            ]
            run = {{ until_time = 1.0 }}
            "
        );
        for (k, position) in places.iter().enumerate() {
            let species = ["small", "large"][k % 2];
            toml += &format!("[[particle]]\nspecies = '{species}'\nposition = {position:?}\n");
        }
        Scene::from_toml(&toml, "column.toml").map_err(|error| error.to_string())
    }

    #[test]
    fn overlaps_disappear_and_the_centre_of_mass_stays_unless_a_wall_pushes() {
        let places = [[1.0, 0.001, 9.0], [1.0, 1.2, 9.348], [1.0, 4.9, 20.0], [1.0, 1.0, 20.5]];
        assert!(column(&places, "").unwrap_err().contains("overlap"));
        let scene = column(&places, "separate_overlaps = 0.1").unwrap();
        let separated = scene.separated();
        // The first and second particles, and the third and the image of the fourth one.
        assert_eq!(separated.overlaps, 2);
        let deepest = 1.25 - libm::hypot(0.5, 1.1);
        assert!((separated.deepest - deepest).abs() < 1e-12, "{separated:?} {deepest}");
        let [a, b] = [0, 1].map(|k| scene.particles()[k].position);
        // The first particle moves across a side of the box.
        assert!(a.y > 4.99 && a.y < 5.0, "{a}");
        let a = a - 5.0 * Vector::y();
        let distance = (b - a).norm();
        assert!(distance > 1.25 && distance < 1.25 + 0.2 * deepest);
        let centre = 1.3 * Vector::new(1.0, 0.001, 9.0) + 3.1 * Vector::new(1.0, 1.2, 9.348);
        assert!((1.3 * a + 3.1 * b - centre).norm() < 1e-13);
        assert!(separated.farthest < 0.1);
        // In a column on the floor, all particles move up.
        let places = [[1.0, 1.0, 0.499], [1.0, 1.0, 1.748], [1.0, 1.0, 2.997], [1.0, 1.0, 4.246]];
        let scene = column(&places, "separate_overlaps = 0.1").unwrap();
        assert_eq!(scene.separated().overlaps, 4);
        assert_eq!(
            Scene::new(scene.clone().into_parts()).unwrap(),
            scene,
            "nothing more is moved, and the record stays"
        );
        let heights: Vec<f64> = scene.particles().iter().map(|particle| particle.position.z).collect();
        assert!(heights[0] >= 0.5 && heights.windows(2).all(|two| two[1] - two[0] >= 1.25), "{heights:?}");
        assert!(heights[3] < 4.26, "{heights:?}");
    }

    #[test]
    fn high_columns_need_thousands_of_passes() {
        let spacing = 1.25 * 0.9999;
        let places: Vec<[f64; 3]> = (0..100).map(|k| [1.0, 1.0, 0.5 + spacing * f64::from(k)]).collect();
        let scene = column(&places, "separate_overlaps = 0.25").unwrap();
        let (separated, overlap) = (scene.separated(), 1.25 * 1e-4);
        assert_eq!(separated.overlaps, 99);
        // The highest particle moves up by all overlaps, and by the gaps, each up to a tenth of an overlap.
        assert!((99.0..99.0 * 1.1 + 1.0).contains(&(separated.farthest / overlap)), "{separated:?}");
        let heights: Vec<f64> = scene.particles().iter().map(|particle| particle.position.z).collect();
        assert!(heights.windows(2).all(|two| two[1] - two[0] > 1.25 - 1e-13));
    }

    #[test]
    fn particles_without_overlaps_keep_their_bits() {
        // The first two overlap by the last bit.
        let places = [[1.0, 1.0, 0.5], [1.0, 1.0, 1.749_999_999_999_999_8], [0.1 + 0.2, 3.0, 7.7]];
        let [plain, separated] = ["", "separate_overlaps = 0.2"].map(|more| column(&places, more).unwrap());
        assert_eq!(plain.particles(), separated.particles());
        assert_eq!(separated.separated().overlaps, 0);
    }

    #[test]
    fn particles_leave_static_particles_and_moves_are_limited() {
        let fixed = |limit: f64| {
            let more = format!("separate_overlaps = {limit}");
            let mut scene = column(&[[2.5, 2.5, 11.4]], &more).unwrap().into_parts();
            let fixed = crate::model::SpeciesId(2);
            scene.particles.push(crate::model::Particle::new(fixed, Vector::new(2.5, 2.5, 10.0), Vector::zeros()));
            Scene::new(scene)
        };
        let scene = fixed(0.2).unwrap();
        assert_eq!(scene.particles()[1].position.z, 10.0);
        assert!((1.5..1.52).contains(&(scene.particles()[0].position.z - 10.0)));
        let refused = fixed(0.05).unwrap_err().to_string();
        assert!(refused.contains("separate_overlaps") && refused.contains("0.05"), "{refused}");
    }

    #[test]
    fn particles_leave_surfaces_at_rest_and_no_moving_ones() {
        let with = |motion: &str| {
            let plane = "name = 'floor', shape = 'plane', point = [0.0, 0.0, 3.0], normal = [0.0, 0.0, 1.0]";
            column(&[[1.0, 1.0, 3.49]], &format!("separate_overlaps = 0.1\nsurface = [{{ {plane}{motion} }}]"))
        };
        assert!((3.5..3.502).contains(&with("").unwrap().particles()[0].position.z));
        let motion = ", motion = [{ kind = 'translation', velocity = [0.0, 0.0, -0.05] }]";
        let refused = with(motion).unwrap_err();
        assert!(refused.contains("floor") && !refused.contains("moves of up to"), "{refused}");
    }

    #[test]
    fn disks_stay_in_their_plane_and_particles_at_the_same_place_are_refused() {
        let toml = "
            separate_overlaps = 0.25
            space = { size = [0.0, 9.0, 9.0], x = 'flat' }
            species = [{ name = 'disk', mass = 1.3, diameter = 1.0 }]
            interaction = [{ species = ['disk', 'disk'], potential = 'hard-sphere' }]
            particle = [{ species = 'disk', position = [0.0, 4.0, 3.0] }, { species = 'disk', position = [0.0, 4.0, 3.9] }]
            run = { until_time = 1.0 }";
        let scene = Scene::from_toml(toml, "disks.toml").unwrap();
        assert!(scene.particles()[1].position.z - scene.particles()[0].position.z >= 1.0);
        let same = Scene::from_toml(toml.replace("3.9]", "3.0]"), "disks.toml").unwrap_err().to_string();
        assert!(same.contains("moves of up to 0.25"), "{same}");
    }

    #[test]
    fn spheres_in_a_slit_that_is_too_narrow_are_refused_soon() {
        let places = [[1.0, 1.0, 0.5], [1.0, 1.0, 1.7], [1.0, 1.0, 2.9], [1.0, 1.0, 4.1], [1.0, 1.0, 5.3]];
        let mut scene = column(&places, "separate_overlaps = 0.25").unwrap().into_parts();
        // The column of three small and two large spheres is 6 high.
        for upper in [6.2, 5.99] {
            scene.space.size.z = upper;
            let sizes = [0.5, 1.749, 2.998, 4.247, 5.496];
            for (particle, z) in scene.particles.iter_mut().zip(sizes) {
                particle.position = Vector::new(1.0, 1.0, z - 0.02);
            }
            let result = Scene::new(scene.clone());
            assert_eq!(result.is_ok(), upper > 6.0, "{result:?}");
        }
    }
}
