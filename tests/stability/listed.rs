use carom::Vector;
use carom::engine::Snapshot;
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::{Amount, Lattice, SceneBuilder};

/// Position and velocity.
pub type State = (Vector, Vector);

pub fn line(length: f64, boundary: Boundary) -> Space {
    Space {
        lower: Vector::new(-0.5 * length, 0.0, 0.0),
        size: Vector::new(length, 0.0, 0.0),
        boundary: [boundary, Boundary::Flat, Boundary::Flat],
    }
}

pub fn open_box(length: f64) -> Space {
    Space { lower: Vector::repeat(-0.5 * length), size: Vector::repeat(length), boundary: [Boundary::OPEN; 3] }
}

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

pub fn fluid(count: u64, amount: Amount) -> Scene {
    SceneBuilder::new("fluid")
        .species("A", 1.0, 1.0)
        .interaction("A", "A", hard_sphere(), 1.0)
        .fill(Lattice::FaceCentredCubic, "A", count, amount)
        .temperature(1.0)
        .build()
        .unwrap()
}

pub fn particles(scene: &Scene) -> Vec<State> {
    scene.particles().iter().map(|p| (p.position, p.velocity)).collect()
}

pub fn states(snapshot: &Snapshot) -> Vec<State> {
    snapshot.positions.iter().copied().zip(snapshot.velocities.iter().copied()).collect()
}

pub fn hard_sphere() -> Potential {
    Potential::hard_sphere(1.0).unwrap()
}

pub fn well() -> Potential {
    Potential::square_well(1.0, 1.5, 1.0).unwrap()
}

pub fn along(x: f64) -> Vector {
    Vector::new(x, 0.0, 0.0)
}
