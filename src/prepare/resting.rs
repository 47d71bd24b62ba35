//! Finds particles that rest on a wall, a surface or a static particle at the start of a scene.
//!
//! A sphere that leaves the ground with the speed `v` falls back after the time `2 v / a`, where `a` is the
//! acceleration. For particles that are almost at rest, events are so frequent that time hardly advances.

use crate::Vector;
use crate::base::numbers::id;
use crate::engine::CellList;
use crate::engine::surfaces::{Surface, Surfaces};
use crate::model::{ParticleId, Scene, SpeciesId, SurfaceLaw};
use crate::prepare::packing::occupancy::Kind;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Ground {
    /// A wall of the box: its axis, and true for the upper wall.
    Wall(u8, bool),
    Surface(String),
    Particle(ParticleId),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Resting {
    pub particle: ParticleId,
    pub ground: Ground,
    /// Time until the next contact `[time]`.
    pub bounce: f64,
}

/// Relative rounding error of coordinates. Smaller gaps are contacts.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// A particle is at rest if it bounces for less than this fraction of `sqrt(diameter / acceleration)`.
const OF_FALL: f64 = 1e-8;

pub(crate) fn resting(scene: &Scene) -> Vec<Resting> {
    let rows: Vec<SpeciesId> = (0..scene.species.len()).map(|row| SpeciesId(id(row))).collect();
    let surfaces = Surfaces::of(scene, &rows);
    let mut found: Vec<Option<Resting>> = vec![None; scene.particles.len()];
    for (number, particle) in scene.particles.iter().enumerate() {
        let species = &scene.species[particle.species.0 as usize];
        if species.is_static() || species.acceleration == Vector::zeros() {
            continue;
        }
        let radius = 0.5 * scene.diameter(particle);
        let row = u16::try_from(particle.species.0).unwrap_or(u16::MAX);
        let around = radius * (1.0 + ROUNDING);
        surfaces.for_each_near((&particle.position, around), row, surfaces.start_time(), |surface, position| {
            let rounding = ROUNDING * (surface.shape.terms(position) + radius);
            let reflects = matches!(surface.law, SurfaceLaw::Reflecting(_));
            if !reflects || !surface.is_at_rest() || surface.shape.gap(position, radius) > rounding {
                return;
            }
            let ground = || match surface.shape.side() {
                Some((axis, is_upper)) => Ground::Wall(axis, is_upper),
                None => Ground::Surface(surfaces.name(surface.number).to_owned()),
            };
            let normal = surface.shape.normal(position);
            note(scene, &mut found[number], number, &normal, ground);
        });
    }
    rest_on_particles(scene, &mut found);
    found.into_iter().flatten().collect()
}

fn rest_on_particles(scene: &Scene, found: &mut [Option<Resting>]) {
    let contacts = scene.contacts();
    let particle = |number: u32| &scene.particles[number as usize];
    let largest = |a: SpeciesId, b: SpeciesId| contacts.get(a.0 as usize, b.0 as usize);
    let all = || (0..).zip(&scene.species).map(|(row, species)| (SpeciesId(row), species));
    let statics = || all().filter(|(_, species)| species.is_static());
    let falling = || all().filter(|(_, species)| !species.is_static() && species.acceleration != Vector::zeros());
    let longest = statics().flat_map(|(a, _)| falling().map(move |(b, _)| largest(a, b))).fold(0.0, f64::max);
    let range = longest * (1.0 + ROUNDING);
    if longest == 0.0 || range > CellList::largest_range(&scene.space) {
        return;
    }
    let points = (0..).zip(&scene.particles).map(|(number, particle)| (number, particle.position));
    let cells = CellList::new(&scene.space, scene.displacement, range, points);
    cells.for_each_pair(|a, b, separation, squared| {
        let [is_a_static, is_b_static] = [a, b].map(|number| scene.is_static(particle(number)));
        if is_a_static == is_b_static {
            return;
        }
        let contact = contacts.between(&Kind::of(particle(a)), &Kind::of(particle(b)));
        let places = [a, b].map(|it| scene.particles[it as usize].position.amax());
        let rounding = ROUNDING * (places[0] + places[1] + 2.0 * scene.space.farthest_side() + contact);
        let distance = squared.sqrt();
        if contact == 0.0 || (distance - contact).abs() > rounding {
            return;
        }
        let (mover, fixed, sign) = if is_a_static { (b, a, -1.0) } else { (a, b, 1.0) };
        let normal = separation * (sign / distance);
        note(scene, &mut found[mover as usize], mover as usize, &normal, || Ground::Particle(ParticleId(fixed)));
    });
}

/// Records a particle that touches the ground, if it is at rest. `normal` points from the ground to the particle.
fn note(scene: &Scene, found: &mut Option<Resting>, number: usize, normal: &Vector, ground: impl Fn() -> Ground) {
    let particle = &scene.particles[number];
    let species = &scene.species[particle.species.0 as usize];
    let acceleration = -species.acceleration.dot(normal);
    if acceleration <= ROUNDING * species.acceleration.norm() {
        return;
    }
    let speed = particle.velocity.dot(normal).abs();
    let bounce = 2.0 * speed / acceleration;
    let shortest = OF_FALL * (scene.diameter(particle) / acceleration).sqrt();
    if bounce < shortest && found.as_ref().is_none_or(|other| bounce < other.bounce) {
        *found = Some(Resting { particle: ParticleId(id(number)), ground: ground(), bounce });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: &str = r#"
        [space]
        size = [20.0, 20.0, 20.0]
        x = "open"
        y = "open"
        z = { lower = "wall", upper = "wall", restitution = 0.7 }

        [[species]]
        name = "A"
        mass = 1.3
        diameter = 1.0

        [[species]]
        name = "fixed"
        static = true
        diameter = 2.0

        [[interaction]]
        species = ["A", "A"]
        potential = "hard-sphere"

        [[interaction]]
        species = ["A", "fixed"]
        potential = "hard-sphere"

        [[surface]]
        name = "slope"
        shape = "plane"
        point = [15.0, 0.0, 0.0]
        normal = [-1.0, 0.0, 1.0]

        [[particle]]
        species = "fixed"
        position = [5.0, 5.0, 5.0]
    "#;

    fn scene(places: &[([f64; 3], [f64; 3])]) -> Scene {
        let mut text = BOX.to_owned();
        for (position, velocity) in places {
            text += &format!("[[particle]]\nspecies = 'A'\nposition = {position:?}\nvelocity = {velocity:?}\n");
        }
        text += "[run]\nuntil_time = 1.0\n[dynamics]\ngravity = [0.0, 0.0, -2.0]\n";
        Scene::from_toml(text, "rest.toml").unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
    }

    const REST: [f64; 3] = [0.0; 3];

    #[test]
    fn particles_rest_on_walls_surfaces_and_static_particles() {
        // A particle at this x and at z = 1 touches the slope `z = x - 15`.
        let on_slope = 15.0 + 1.0 - libm::sqrt(0.5);
        let scene = scene(&[
            ([2.0, 2.0, 0.5], REST),
            ([on_slope, 9.0, 1.0], REST),
            ([5.0, 5.0, 6.5], REST),
            // This particle lies on a particle that can move.
            ([2.0, 2.0, 1.5], REST),
            // Gravity does not press these particles against the ceiling or the static particle.
            ([9.0, 9.0, 19.5], REST),
            ([5.0, 5.0, 3.5], REST),
            ([6.5, 5.0, 5.0], REST),
        ]);
        let found = resting(&scene);
        let grounds: Vec<(u32, &Ground)> = found.iter().map(|it| (it.particle.0, &it.ground)).collect();
        let expected = [
            (1, &Ground::Wall(2, false)),
            (2, &Ground::Surface("slope".to_owned())),
            (3, &Ground::Particle(ParticleId(0))),
        ];
        assert_eq!(grounds, expected);
        assert!(found.iter().all(|it| it.bounce == 0.0));
    }

    #[test]
    fn noticeably_bouncing_particle_is_not_at_rest() {
        let with =
            |place: [f64; 3], speed: f64| resting(&scene(&[(place, [3.0, 0.0, speed])])).pop().map(|it| it.bounce);
        let above = |height: f64| [2.0, 2.0, 0.5 + height];
        for speed in [1e-12, -1e-12] {
            assert_eq!(with(above(0.0), speed), Some(1e-12), "2 v / g");
        }
        // On the slope of 45 degrees, the speed and the acceleration along the normal are both lower.
        let on_slope = [15.0 + 1.0 - libm::sqrt(0.5), 9.0, 1.0];
        let bounce = resting(&scene(&[(on_slope, [0.0, 0.0, 1e-12])])).pop().map(|it| it.bounce);
        assert!(bounce.is_some_and(|bounce| (bounce / 1e-12 - 1.0).abs() < 1e-14), "{bounce:?}");
        assert_eq!(with(above(0.0), 1e-7), None);
        assert_eq!(with(above(1e-9), 0.0), None);
    }
}
