//! Maxwell velocities: normal components of variance `T / m`, no net momentum where that is conserved, exactly the temperature asked for.

use std::ops::Range;

use crate::Vector;
use crate::model::random::{Purpose, Random};
use crate::model::space::{Boundary, Space};
use crate::model::{Particle, Scene, Species};

/// Draws velocities for the moving ones among `particles`, at rest as a whole and exactly at a temperature, `T = 2 K / (D (N - 1))`.
pub(crate) fn maxwell(
    particles: &mut [Particle],
    species: &[Species],
    space: &Space,
    temperature: f64,
    random: &mut Random,
) {
    let conserved = std::array::from_fn(|k| space.boundary[k] != Boundary::Flat);
    draw(particles, species, space, temperature, random);
    let all = 0..particles.len();
    settle(particles, &[all], species, &Cloud { temperature, conserved, dimensions: space.dimensions() });
}

/// Particles of one temperature around one common velocity, from one or more groups of the scene.
struct Cloud {
    temperature: f64,
    /// Axes along which their momentum is conserved.
    conserved: [bool; 3],
    dimensions: usize,
}

/// The velocities that particles of one group start with: Maxwell velocities around a common one.
pub(crate) struct Drawn {
    /// Ids of the particles.
    pub ids: Range<usize>,
    /// Index of the group, which has random numbers of its own.
    pub group: usize,
    /// `[energy]`; without one they only have the common velocity.
    pub temperature: Option<f64>,
    /// `[length / time]`
    pub velocity: Vector,
}

/// Gives groups of particles their velocities: those of their temperature, the one that they share, and that of what streams in a sheared
/// box.
///
/// All that have the same temperature and velocity are one cloud, so that it does not matter in how many groups they are given.
pub(crate) fn set_velocities(groups: &[Drawn], scene: &mut Scene) {
    let (conserved, dimensions) = (scene.conserved_axes(), scene.space.dimensions());
    let Scene { particles, species, space, seed, shear_rate, .. } = scene;
    let mut clouds: Vec<(f64, Vector, Vec<Range<usize>>)> = Vec::new();
    for Drawn { ids, group, temperature, velocity } in groups {
        let Some(temperature) = *temperature else { continue };
        let mut random = Random::new(*seed, Purpose::Velocities, *group);
        draw(&mut particles[ids.clone()], species, space, temperature, &mut random);
        match clouds.iter_mut().find(|(t, v, _)| (t, v) == (&temperature, velocity)) {
            Some((_, _, members)) => members.push(ids.clone()),
            None => clouds.push((temperature, *velocity, vec![ids.clone()])),
        }
    }
    for (temperature, _, members) in clouds {
        settle(particles, &members, species, &Cloud { temperature, conserved, dimensions });
    }
    let middle = space.lower.y + 0.5 * space.size.y;
    for Drawn { ids, velocity, .. } in groups {
        for particle in &mut particles[ids.clone()] {
            particle.velocity += velocity;
            if let Some(rate) = *shear_rate {
                particle.velocity.x += rate * (particle.position.y - middle);
            }
        }
    }
}

fn mass(particle: &Particle, species: &[Species]) -> f64 {
    species[particle.species.0 as usize].mass
}

/// Independent normal components of variance `T / m`, zero along flat axes; static particles stay at rest.
fn draw(particles: &mut [Particle], species: &[Species], space: &Space, temperature: f64, random: &mut Random) {
    for particle in particles {
        let m = mass(particle, species);
        if m.is_finite() {
            particle.velocity = random.normal_vector(space) * (temperature / m).sqrt();
        }
    }
}

/// Removes the total momentum along the axes on which it is conserved, and scales velocities to exactly the temperature, `T = 2 K / f`.
///
/// Of the `D N` components of `N` particles that move, each conserved component of the momentum takes one away, and nothing else does:
/// `f = D N - c`, as in the temperature that is measured. A single particle keeps its own, `T = 2 K / D`.
fn settle(particles: &mut [Particle], members: &[Range<usize>], species: &[Species], cloud: &Cloud) {
    let moving = || members.iter().cloned().flatten();
    let (mut momentum, mut total_mass, mut count) = (Vector::zeros(), 0.0, 0_usize);
    for particle in moving().map(|id| &particles[id]).filter(|particle| mass(particle, species).is_finite()) {
        momentum += particle.velocity * mass(particle, species);
        total_mass += mass(particle, species);
        count += 1;
    }
    let mut degrees = cloud.dimensions * count;
    let mut drift = Vector::zeros();
    if count > 1 {
        for axis in (0..3).filter(|&axis| cloud.conserved[axis]) {
            drift[axis] = momentum[axis] / total_mass;
            degrees -= 1;
        }
    }
    let mut twice_kinetic = 0.0;
    for id in moving() {
        let m = mass(&particles[id], species);
        if m.is_finite() {
            particles[id].velocity -= drift;
            twice_kinetic += m * particles[id].velocity.norm_squared();
        }
    }
    if twice_kinetic > 0.0 {
        let scale = (cloud.temperature * degrees as f64 / twice_kinetic).sqrt();
        for id in moving() {
            if mass(&particles[id], species).is_finite() {
                particles[id].velocity *= scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::numbers::id;
    use crate::model::SpeciesId;
    use crate::model::potential::Potential;
    use crate::scene::{Arrangement, Fill, SceneBuilder};

    fn start(masses: &[f64], count: usize, space: &Space) -> (Vec<Particle>, Vec<Species>) {
        let species: Vec<Species> = masses
            .iter()
            .map(|&mass| Species { name: String::new(), mass, diameter: 1.0, acceleration: Vector::zeros() })
            .collect();
        let mut particles: Vec<Particle> = (0..count)
            .map(|i| Particle {
                species: SpeciesId(id(i % masses.len())),
                position: space.lower,
                velocity: Vector::zeros(),
            })
            .collect();
        maxwell(&mut particles, &species, space, 1.5, &mut Random::new(1, Purpose::Velocities, 0));
        (particles, species)
    }

    #[test]
    fn the_temperature_is_exact_and_the_momentum_zero() {
        let mut space = Space::periodic_cube(10.0);
        space.boundary[2] = Boundary::Flat;
        let (particles, species) = start(&[1.0, 4.0], 1000, &space);
        let mass = |p: &Particle| species[p.species.0 as usize].mass;
        let momentum: Vector = particles.iter().map(|p| p.velocity * mass(p)).sum();
        let twice_kinetic: f64 = particles.iter().map(|p| p.velocity.norm_squared() * mass(p)).sum();
        // Sums of a thousand terms of size one.
        assert!(momentum.norm() < 1e-11);
        assert!((twice_kinetic / (2.0 * 999.0) - 1.5).abs() < 1e-13);
        assert!(particles.iter().all(|p| p.velocity.z == 0.0));
    }

    #[test]
    fn static_particles_stay_at_rest_and_one_particle_moves() {
        let space = Space::periodic_cube(10.0);
        let (particles, _) = start(&[f64::INFINITY, 1.0], 2, &space);
        assert_eq!(particles[0].velocity, Vector::zeros());
        assert!((particles[1].velocity.norm_squared() - 4.5).abs() < 1e-13);
    }

    /// The momentum, and twice the kinetic energy, of two fills of 10 and 6 with masses .7 and 3.
    fn two_fills(boundary: [Boundary; 3]) -> (Vector, f64) {
        let hard = || Potential::hard_sphere(1.0).unwrap();
        let scene = SceneBuilder::new("two_fills")
            .space(Space { boundary, ..Space::periodic_cube(9.0) })
            .species("A", 0.7, 1.0)
            .species("B", 3.0, 1.0)
            .interaction("A", "A", hard(), 1.0)
            .interaction("A", "B", hard(), 1.0)
            .interaction("B", "B", hard(), 1.0)
            .add_fill(Fill::new(Arrangement::Random, "A").count(10))
            .add_fill(Fill::new(Arrangement::Random, "B").count(6))
            .temperature(1.5)
            .build()
            .unwrap();
        let momentum = |p: &Particle| p.velocity * scene.species[p.species.0 as usize].mass;
        (scene.particles.iter().map(momentum).sum(), scene.particles.iter().map(|p| momentum(p).dot(&p.velocity)).sum())
    }

    #[test]
    fn groups_of_one_temperature_share_what_the_momentum_takes() {
        let (momentum, twice_kinetic) = two_fills([Boundary::Periodic; 3]);
        assert!(momentum.norm() < 1e-13 && (twice_kinetic / 45.0 - 1.5).abs() < 1e-14, "{momentum} {twice_kinetic}");
        let (momentum, twice_kinetic) = two_fills([Boundary::walls(1.0), Boundary::Periodic, Boundary::walls(0.9)]);
        assert!(momentum.y.abs() < 1e-13 && momentum.x.abs().min(momentum.z.abs()) > 0.1, "{momentum}");
        assert!((twice_kinetic / 47.0 - 1.5).abs() < 1e-14, "{twice_kinetic}");
    }
}
