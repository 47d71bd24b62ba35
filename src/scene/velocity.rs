//! Maxwell velocities: normal components of variance `T / m`, no net momentum, exactly the temperature asked for.

use crate::Vector;
use crate::scene::random::Random;
use crate::scene::{Particle, Species};
use crate::space::Space;

/// Draws velocities for the moving ones among `particles`.
///
/// Their total momentum is removed and their velocities are rescaled so that `T = 2 K / (D (N - 1))`, with `D` the
/// number of axes along which they move: the momentum takes `D` degrees of freedom away. A single particle keeps its
/// own, `T = 2 K / D`.
pub(crate) fn maxwell(
    particles: &mut [Particle],
    species: &[Species],
    space: &Space,
    temperature: f64,
    random: &mut Random,
) {
    let mass = |particle: &Particle| species[particle.species.0 as usize].mass;
    let mut moving: Vec<&mut Particle> = particles.iter_mut().filter(|p| mass(p).is_finite()).collect();
    let (mut momentum, mut total_mass) = (Vector::zeros(), 0.0);
    for particle in &mut moving {
        let m = mass(particle);
        particle.velocity = random.normal_vector(space) * (temperature / m).sqrt();
        momentum += particle.velocity * m;
        total_mass += m;
    }
    let mut degrees = (space.dimensions() * moving.len()) as f64;
    if moving.len() > 1 {
        degrees -= space.dimensions() as f64;
        let drift = momentum / total_mass;
        moving.iter_mut().for_each(|particle| particle.velocity -= drift);
    }
    let twice_kinetic: f64 = moving.iter().map(|particle| mass(particle) * particle.velocity.norm_squared()).sum();
    if twice_kinetic > 0.0 {
        let scale = (temperature * degrees / twice_kinetic).sqrt();
        moving.iter_mut().for_each(|particle| particle.velocity *= scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SpeciesId;
    use crate::scene::random::Purpose;
    use crate::space::Boundary;

    fn start(masses: &[f64], count: usize, space: &Space) -> (Vec<Particle>, Vec<Species>) {
        let species: Vec<Species> = masses
            .iter()
            .map(|&mass| Species { name: String::new(), mass, diameter: 1.0, acceleration: Vector::zeros() })
            .collect();
        let mut particles: Vec<Particle> = (0..count)
            .map(|i| Particle {
                species: SpeciesId((i % masses.len()) as u32),
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
}
