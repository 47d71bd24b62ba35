//! Compares a sheared box with images of a sheared lattice in infinite space.

use crate::sheared::boxes;
use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

/// Spheres whose images form a sheared lattice. Positions are never wrapped.
struct Unbounded {
    size: Vector,
    rate: f64,
    time: f64,
    positions: Vec<Vector>,
    velocities: Vec<Vector>,
}

impl Unbounded {
    fn relative(&self, i: usize, j: usize, [a, b, c]: [f64; 3]) -> (Vector, Vector) {
        let slid = self.rate * self.size.y * self.time;
        let image = Vector::new(a * self.size.x + b * slid, b * self.size.y, c * self.size.z);
        let faster = Vector::new(b * self.rate * self.size.y, 0.0, 0.0);
        (self.positions[i] - self.positions[j] - image, self.velocities[i] - self.velocities[j] - faster)
    }

    /// Returns the images of sphere `j` that are at most two periods away from the image nearest to sphere `i`.
    fn images(&self, i: usize, j: usize) -> Vec<[f64; 3]> {
        let apart = self.positions[i] - self.positions[j];
        let around = |middle: f64| [-2.0, -1.0, 0.0, 1.0, 2.0].map(|step| middle.round() + step);
        let mut images = Vec::new();
        for b in around(apart.y / self.size.y) {
            let x = apart.x - b * self.rate * self.size.y * self.time;
            for a in around(x / self.size.x) {
                images.extend(around(apart.z / self.size.z).map(|c| [a, b, c]));
            }
        }
        images
    }

    /// Advances to the next contact, or by `most` without a contact. Returns whether there was a contact. Spheres have
    /// diameter and mass 1, and paths must be shorter than a period.
    fn step(&mut self, most: f64) -> bool {
        let mut next = (most, None);
        for i in 0..self.positions.len() {
            for j in 0..i {
                for image in self.images(i, j) {
                    let (r, v) = self.relative(i, j, image);
                    let (b, v2) = (r.dot(&v), v.norm_squared());
                    let root = b * b - v2 * (r.norm_squared() - 1.0);
                    if b < 0.0 && root > 0.0 {
                        let after = ((-b - root.sqrt()) / v2).max(0.0);
                        next = if after < next.0 { (after, Some((i, j, image))) } else { next };
                    }
                }
            }
        }
        self.time += next.0;
        for (position, velocity) in self.positions.iter_mut().zip(&self.velocities) {
            *position += velocity * next.0;
        }
        let Some((i, j, image)) = next.1 else { return false };
        let (r, v) = self.relative(i, j, image);
        let change = r * (r.dot(&v) / r.norm_squared());
        self.velocities[i] -= change;
        self.velocities[j] += change;
        true
    }
}

#[test]
fn contacts_are_those_of_an_unbounded_lattice_of_images() {
    for (space, rate) in boxes().into_iter().take(2).zip([2.0, -0.4]) {
        let scene = SceneBuilder::new("few")
            .space(space.clone())
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::SimpleCubic, "A").count(27))
            .temperature(1.0)
            .shear(rate)
            .build()
            .unwrap();
        let start = Simulation::without_plan(scene.clone()).snapshot();
        let (positions, velocities) = (start.positions, start.velocities);
        let mut unbounded = Unbounded { size: space.size, rate, time: 0.0, positions, velocities };
        let mut simulation = Simulation::without_plan(scene);
        let (mut contacts, mut across) = (0, 0);
        while contacts < 40 {
            // In a time of 0.1, no sphere moves farther than a period.
            contacts += u64::from(unbounded.step(0.1));
        }
        // Rounding could otherwise end one of the simulations just before the last contact.
        contacts += u64::from(unbounded.step(1e-6));
        simulation.advance(Until::time(unbounded.time)).unwrap();
        let now = simulation.snapshot();
        assert_eq!(simulation.event_counts().core, contacts);
        for (id, (position, velocity)) in unbounded.positions.iter().zip(&unbounded.velocities).enumerate() {
            let up = now.images[id][1];
            let faster = rate * space.size.y * f64::from(up);
            across += up.abs();
            // Each contact multiplies errors by about 7. No sphere has more than ten contacts.
            let expected = now.velocities[id] + Vector::new(faster, 0.0, 0.0);
            assert!((velocity - expected).amax() < 1e-7, "{id}: {velocity} {expected}");
            let y = now.positions[id].y + f64::from(up) * space.size.y;
            assert!((position.y - y).abs() < 1e-7, "{id}: {position} {y}");
            let beside =
                (position.x - now.positions[id].x - f64::from(up) * rate * space.size.y * now.time) / space.size.x;
            assert!((beside - beside.round()).abs() < 1e-7, "{id}: {beside}");
        }
        assert!(across > 2, "{across}");
    }
}
