//! Scenes that are built from lists of particles.

use carom::Vector;
use carom::engine::Snapshot;
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::{Amount, Lattice, SceneBuilder};

/// Position and velocity.
pub type State = (Vector, Vector);

/// A one-dimensional box from `-length / 2` to `length / 2`.
pub fn line(length: f64, boundary: Boundary) -> Space {
    Space {
        lower: Vector::new(-0.5 * length, 0.0, 0.0),
        size: Vector::new(length, 0.0, 0.0),
        boundary: [boundary, Boundary::Flat, Boundary::Flat],
    }
}

/// An open box around the origin.
pub fn open_box(length: f64) -> Space {
    Space { lower: Vector::repeat(-0.5 * length), size: Vector::repeat(length), boundary: [Boundary::OPEN; 3] }
}

/// Particles of one species and diameter 1 in a given box.
pub fn listed(space: &Space, potential: &Potential, restitution: f64, particles: &[State]) -> SceneBuilder {
    let mut builder = SceneBuilder::new("listed").space(space.clone()).species("A", 1.0, 1.0).interaction(
        "A",
        "A",
        potential.clone(),
        restitution,
    );
    for (position, velocity) in particles {
        builder = builder.particle("A", *position, *velocity);
    }
    builder
}

/// A fluid of hard spheres on a face-centred cubic lattice, as a source of particles.
pub fn fluid(count: u64, amount: Amount) -> Scene {
    SceneBuilder::new("fluid")
        .species("A", 1.0, 1.0)
        .interaction("A", "A", hard_sphere(), 1.0)
        .fill(Lattice::FaceCentredCubic, "A", count, amount)
        .temperature(1.0)
        .build()
        .unwrap()
}

/// The particles of a scene.
pub fn particles(scene: &Scene) -> Vec<State> {
    scene.particles().iter().map(|p| (p.position, p.velocity)).collect()
}

/// The positions and velocities of a snapshot.
pub fn states(snapshot: &Snapshot) -> Vec<State> {
    snapshot.positions.iter().copied().zip(snapshot.velocities.iter().copied()).collect()
}

/// Spheres of diameter 1.
pub fn hard_sphere() -> Potential {
    Potential::hard_sphere(1.0).unwrap()
}

/// Spheres of diameter 1 with a well that reaches to 1.5.
pub fn well() -> Potential {
    Potential::square_well(1.0, 1.5, 1.0).unwrap()
}

/// Along the line.
pub fn along(x: f64) -> Vector {
    Vector::new(x, 0.0, 0.0)
}
