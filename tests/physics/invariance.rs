//! Splitting a run into pieces changes nothing. With flat axes, particles never leave their plane or line.

use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn lattice(boundary: [Boundary; 3], lattice: Lattice, count: u64, density: f64) -> Scene {
    SceneBuilder::new("lattice")
        .boundary(boundary)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(lattice, "A").count(count).number_density(density))
        .temperature(1.0)
        .build()
        .unwrap()
}

fn listed(space: &Space, potential: &Potential, particles: &[(Vector, Vector)]) -> SceneBuilder {
    let mut builder = SceneBuilder::new("listed")
        .space(space.clone())
        .allow_invalid_start(true)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential.clone()).between("A", "A"));
    for (position, velocity) in particles {
        builder = builder.particle("A", *position, *velocity);
    }
    builder
}

fn particles(scene: &Scene) -> Vec<(Vector, Vector)> {
    scene.particles().iter().map(|p| (p.position, p.velocity)).collect()
}

const BULK: [Boundary; 3] = [Boundary::Periodic; 3];

fn well() -> Potential {
    Potential::square_well(1.0, 1.5, 1.0).unwrap()
}

#[test]
fn trajectory_does_not_depend_on_how_the_run_is_split() {
    let start = lattice(BULK, Lattice::FaceCentredCubic, 256, 0.6);
    let scene = || listed(start.space(), &well(), &particles(&start)).build().unwrap();
    let whole = |until: Until| {
        let mut simulation = Simulation::without_plan(scene());
        simulation.advance(until).unwrap();
        (simulation.snapshot(), *simulation.event_counts())
    };
    let by_time = whole(Until::time(20.0));
    assert_eq!(by_time, whole(Until::time(20.0)));
    let mut simulation = Simulation::without_plan(scene());
    for part in 1..=1999 {
        simulation.advance(Until::time(0.01 * f64::from(part))).unwrap();
        let _ = (simulation.snapshot(), simulation.energy(), simulation.deepest_overlap());
    }
    simulation.advance(Until::time(20.0)).unwrap();
    assert_eq!(by_time, (simulation.snapshot(), *simulation.event_counts()));

    let by_events = whole(Until::events(30_000));
    let mut simulation = Simulation::without_plan(scene());
    for part in 1..=30_000 {
        simulation.advance(Until::events(part)).unwrap();
    }
    let cut = (simulation.snapshot(), *simulation.event_counts());
    assert_eq!((by_events.0.positions, by_events.0.velocities), (cut.0.positions, cut.0.velocities));
    assert_eq!(by_events.1.virial, cut.1.virial);
}

#[test]
fn particles_never_leave_a_flat_or_straight_scene() {
    let plane = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    let line = [Boundary::Periodic, Boundary::Flat, Boundary::Flat];
    for (boundary, arrangement, axes) in [(plane, Lattice::Square, 2), (line, Lattice::Line, 1)] {
        for potential in [Potential::hard_sphere(1.0).unwrap(), well()] {
            let scene = lattice(boundary, arrangement, 100, 0.5);
            let space = Space { lower: Vector::new(0.1, 0.2, 0.3), ..scene.space().clone() };
            let moved: Vec<_> = particles(&scene).iter().map(|(r, v)| (r + space.lower, *v)).collect();
            let scene = listed(&space, &potential, &moved).build().unwrap();
            let mut simulation = Simulation::without_plan(scene);
            simulation.advance(Until::events(100_000)).unwrap();
            let end = simulation.snapshot();
            for (position, velocity) in end.positions.iter().zip(&end.velocities) {
                for k in axes..3 {
                    assert_eq!((position[k], velocity[k]), (space.lower[k], 0.0));
                }
            }
        }
    }
}
