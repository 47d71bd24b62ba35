use carom::Vector;
use carom::engine::Snapshot;
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::{Amount, Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

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
    let mut builder = SceneBuilder::new("listed")
        .space(space.clone())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential.clone()).between("A", "A").restitution(restitution));
    for (position, velocity) in particles {
        builder = builder.particle("A", *position, *velocity);
    }
    builder
}

pub fn fluid(count: u64, amount: Amount) -> Scene {
    SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard_sphere()).between("A", "A"))
        .fill(Fill { amount: Some(amount), ..Fill::new(Lattice::FaceCentredCubic, "A").count(count) })
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
