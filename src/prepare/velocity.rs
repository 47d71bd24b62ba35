//! Initial velocities: Maxwell velocities, or equal speeds in random directions.

mod anew;

use std::f64::consts::FRAC_PI_3;
use std::ops::Range;

use crate::Vector;
use crate::model::random::{Purpose, Random};
use crate::model::scene::mass_of;
use crate::model::space::{Boundary, Space};
use crate::model::{Particle, Scene, Species};

/// Draws Maxwell velocities without net momentum, scaled to exactly the temperature `T = 2 K / (D (N - 1))`.
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

/// Particles of one or more groups with the same temperature and the same common velocity.
struct Cloud {
    temperature: f64,
    conserved: [bool; 3],
    dimensions: usize,
}

pub(crate) struct Drawn {
    pub ids: Range<usize>,
    /// Index of the group. Each group has its own random numbers.
    pub group: usize,
    /// Temperature `[energy]`. If neither a temperature nor a speed is given, all particles have the common velocity.
    pub temperature: Option<f64>,
    /// Speed of every particle `[length / time]`, used if there is no temperature.
    pub speed: Option<f64>,
    /// Common velocity, added to all drawn velocities `[length / time]`.
    pub velocity: Vector,
}

/// Sets the velocities of groups, including the streaming velocity of a sheared box. Groups with the same temperature
/// and the same common velocity are corrected together.
pub(crate) fn set_velocities(groups: &[Drawn], scene: &mut Scene) {
    let (conserved, dimensions) = (scene.conserved_axes(), scene.space.dimensions());
    let Scene { particles, species, space, seed, shear_rate, .. } = scene;
    let mut clouds: Vec<(f64, Vector, Vec<Range<usize>>)> = Vec::new();
    for Drawn { ids, group, temperature, speed, velocity } in groups {
        let mut random = Random::new(*seed, Purpose::Velocities, *group);
        let Some(temperature) = *temperature else {
            if let Some(speed) = *speed {
                equal_speeds(&mut particles[ids.clone()], species, space, speed, &mut random);
            }
            continue;
        };
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

fn mass(particle: &Particle, (species, dimensions): (&[Species], usize)) -> f64 {
    mass_of(particle, species, dimensions)
}

/// Draws independent normal components of variance `T / m`, zero along flat axes. Static particles stay at rest.
fn draw(particles: &mut [Particle], species: &[Species], space: &Space, temperature: f64, random: &mut Random) {
    for particle in particles {
        let m = mass(particle, (species, space.dimensions()));
        if m.is_finite() {
            particle.velocity = random.normal_vector(space) * (temperature / m).sqrt();
        }
    }
}

/// Gives all moving particles the same speed, in random directions without net momentum.
///
/// Subtracting the velocity of the centre of mass would make the speeds differ. Instead, random pairs of one species
/// move in opposite directions. If a species has an odd number of particles, three of them move at 120 degrees to each
/// other. A particle without partners keeps its momentum: the only particle of a species, or the odd particle in one
/// dimension.
fn equal_speeds(particles: &mut [Particle], species: &[Species], space: &Space, speed: f64, random: &mut Random) {
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); species.len()];
    for (index, particle) in
        particles.iter().enumerate().filter(|(_, particle)| !species[particle.species.0 as usize].is_static())
    {
        members[particle.species.0 as usize].push(index);
    }
    for mut indices in members {
        random.shuffle(&mut indices);
        let has_three = indices.len() > 2 && indices.len() % 2 == 1 && space.dimensions() > 1;
        let (pairs, rest) = indices.split_at(if has_three { indices.len() - 3 } else { indices.len() });
        for pair in pairs.chunks(2) {
            let velocity = random.direction(space) * speed;
            for (&index, sign) in pair.iter().zip([1.0, -1.0]) {
                particles[index].velocity = velocity * sign;
            }
        }
        if let &[a, b, c] = rest {
            let directions = three_directions(space, random);
            for (index, direction) in [a, b, c].into_iter().zip(directions) {
                particles[index].velocity = direction * speed;
            }
        }
    }
}

/// Returns three directions at 120 degrees to each other, in a random plane. Needs at least two dimensions.
fn three_directions(space: &Space, random: &mut Random) -> [Vector; 3] {
    let first = random.direction(space);
    let across = loop {
        let second = random.direction(space);
        let across = second - first * first.dot(&second);
        // If the two directions are nearly parallel, `across` is mostly rounding error.
        if across.norm_squared() > 0.01 {
            break across.normalize();
        }
    };
    let (cosine, sine) = (0.5, libm::sin(FRAC_PI_3));
    [first, across * sine - first * cosine, -across * sine - first * cosine].map(|direction| direction.normalize())
}

/// Removes the total momentum along axes where momentum is conserved. Then scales the velocities to exactly the
/// temperature `T = 2 K / f`.
///
/// `N` moving particles have `f = D N - c` degrees of freedom, where `c` is the number of conserved components of the
/// momentum. A single particle keeps its momentum and has `f = D`.
fn settle(particles: &mut [Particle], members: &[Range<usize>], species: &[Species], cloud: &Cloud) {
    let moving = || members.iter().cloned().flatten();
    let mass = |particle: &Particle| mass(particle, (species, cloud.dimensions));
    let (mut momentum, mut total_mass, mut count) = (Vector::zeros(), 0.0, 0_usize);
    for particle in moving().map(|id| &particles[id]).filter(|particle| mass(particle).is_finite()) {
        momentum += particle.velocity * mass(particle);
        total_mass += mass(particle);
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
        let m = mass(&particles[id]);
        if m.is_finite() {
            particles[id].velocity -= drift;
            twice_kinetic += m * particles[id].velocity.norm_squared();
        }
    }
    if twice_kinetic > 0.0 {
        let scale = (cloud.temperature * degrees as f64 / twice_kinetic).sqrt();
        for id in moving() {
            if mass(&particles[id]).is_finite() {
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
    use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn start(masses: &[f64], count: usize, space: &Space) -> (Vec<Particle>, Vec<Species>) {
        let species: Vec<Species> = masses.iter().map(|&mass| Species::new("", mass, 1.0)).collect();
        let mut particles: Vec<Particle> =
            (0..count).map(|i| Particle::new(SpeciesId(id(i % masses.len())), space.lower, Vector::zeros())).collect();
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

    /// Returns masses and velocities at the speed 1.3. `numbers` counts the particles of mass 0.7, 3 and 11.
    fn equal(numbers: [usize; 3], boundary: [Boundary; 3], seed: u64) -> Vec<(f64, Vector)> {
        let species: Vec<Species> = [0.7, 3.0, 11.0].iter().map(|&mass| Species::new("", mass, 1.0)).collect();
        let space = Space { boundary, ..Space::periodic_cube(9.0) };
        let kinds = numbers.iter().enumerate().flat_map(|(kind, &number)| std::iter::repeat_n(kind, number));
        let mut particles: Vec<Particle> =
            kinds.map(|kind| Particle::new(SpeciesId(id(kind)), space.lower, Vector::zeros())).collect();
        equal_speeds(&mut particles, &species, &space, 1.3, &mut Random::new(seed, Purpose::Velocities, 0));
        particles.iter().map(|particle| (mass(particle, (&species, 3)), particle.velocity)).collect()
    }

    #[test]
    fn equal_speeds_are_exact_with_zero_momentum() {
        let (periodic, flat) = (Boundary::Periodic, Boundary::Flat);
        for boundary in [[periodic; 3], [periodic, flat, periodic], [flat, periodic, flat]] {
            let is_line = boundary[0] == flat;
            for numbers in [[100, 0, 0], [101, 7, 3], [2, 3, 5]] {
                let numbers = if is_line { numbers.map(|number| number / 2 * 2) } else { numbers };
                let started = equal(numbers, boundary, 1);
                assert_eq!(started.len(), numbers.iter().sum::<usize>());
                for (_, velocity) in &started {
                    assert!((velocity.norm() / 1.3 - 1.0).abs() < 4.0 * f64::EPSILON, "{velocity}");
                    assert!((0..3).all(|k| boundary[k] != flat || velocity[k] == 0.0));
                }
                let momentum: Vector = started.iter().map(|(mass, velocity)| velocity * *mass).sum();
                let largest: f64 = started.iter().map(|(mass, _)| mass).sum();
                assert!(momentum.norm() < 4.0 * f64::EPSILON * 1.3 * largest, "{numbers:?}: {momentum}");
            }
        }
        // A single particle cannot have zero momentum, nor can an odd number of particles on a line with equal speeds.
        let momentum =
            |numbers, boundary| equal(numbers, boundary, 1).iter().map(|(m, v)| v * *m).sum::<Vector>().norm();
        assert!((momentum([5, 0, 0], [flat, periodic, flat]) / (0.7 * 1.3) - 1.0).abs() < 1e-14);
        assert!((momentum([4, 1, 0], [periodic; 3]) / (3.0 * 1.3) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn directions_of_equal_speeds_are_spread_evenly() {
        for boundary in [[Boundary::Periodic; 3], [Boundary::Periodic, Boundary::Flat, Boundary::Periodic]] {
            let dimensions = boundary.iter().filter(|side| **side != Boundary::Flat).count() as f64;
            let (mut square, mut fourth, mut count) = (0.0, 0.0, 0.0);
            for seed in 0..400 {
                for (_, velocity) in equal([51, 0, 0], boundary, seed) {
                    let along = velocity.x / 1.3;
                    square += along * along;
                    fourth += along * along * along * along;
                    count += 1.0;
                }
            }
            // A random unit vector in D dimensions has <u_x^2> = 1 / D and <u_x^4> = 3 / (D (D + 2)). Only half of the
            // directions are independent. The standard deviation of u_x^2 and u_x^4 is about 0.36 or less.
            let error = 4.0 * 0.36 / (0.5_f64 * count).sqrt();
            assert!((square / count - 1.0 / dimensions).abs() < error, "{}", square / count);
            assert!((fourth / count - 3.0 / (dimensions * (dimensions + 2.0))).abs() < error, "{}", fourth / count);
        }
    }

    #[test]
    fn equal_speeds_are_added_to_the_velocity_of_the_fill() {
        let velocity = Vector::new(2.0, 0.0, 0.0);
        let scene = SceneBuilder::new("equal")
            .space(Space::periodic_cube(9.0))
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill { velocity, speed: Some(0.5), ..Fill::new(Arrangement::Random, "A").count(31) })
            .fill(Fill::new(Arrangement::Random, "A").count(10))
            .temperature(1.5)
            .build()
            .unwrap();
        let speeds: Vec<f64> = scene.particles.iter().map(|particle| particle.velocity.norm()).collect();
        assert!(scene.particles[..31].iter().all(|p| ((p.velocity - velocity).norm() / 0.5 - 1.0).abs() < 1e-14));
        assert!(
            speeds[31..].iter().any(|speed| (speed - speeds[31]).abs() > 0.1),
            "the speeds in the second fill are equal"
        );
    }

    /// Returns the total momentum and twice the kinetic energy of 10 particles of mass 0.7 and 6 particles of mass 3.
    fn two_fills(boundary: [Boundary; 3]) -> (Vector, f64) {
        let hard = || Potential::hard_sphere(1.0).unwrap();
        let scene = SceneBuilder::new("two_fills")
            .space(Space { boundary, ..Space::periodic_cube(9.0) })
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(3.0).diameter(1.0))
            .interaction(InteractionDraft::new(hard()).between("A", "A"))
            .interaction(InteractionDraft::new(hard()).between("A", "B"))
            .interaction(InteractionDraft::new(hard()).between("B", "B"))
            .fill(Fill::new(Arrangement::Random, "A").count(10))
            .fill(Fill::new(Arrangement::Random, "B").count(6))
            .temperature(1.5)
            .build()
            .unwrap();
        let momentum = |p: &Particle| p.velocity * scene.species[p.species.0 as usize].mass;
        (scene.particles.iter().map(momentum).sum(), scene.particles.iter().map(|p| momentum(p).dot(&p.velocity)).sum())
    }

    #[test]
    fn fills_of_one_temperature_share_the_momentum_correction() {
        let (momentum, twice_kinetic) = two_fills([Boundary::Periodic; 3]);
        assert!(momentum.norm() < 1e-13 && (twice_kinetic / 45.0 - 1.5).abs() < 1e-14, "{momentum} {twice_kinetic}");
        let (momentum, twice_kinetic) = two_fills([Boundary::walls(1.0), Boundary::Periodic, Boundary::walls(0.9)]);
        assert!(momentum.y.abs() < 1e-13 && momentum.x.abs().min(momentum.z.abs()) > 0.1, "{momentum}");
        assert!((twice_kinetic / 47.0 - 1.5).abs() < 1e-14, "{twice_kinetic}");
    }
}
