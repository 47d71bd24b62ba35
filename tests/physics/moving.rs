//! Moving surfaces, and gravity that changes from stage to stage.

use carom::engine::Simulation;
use carom::model::run_plan::StagePlan;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, MotionKind, RunPlan, Scene, SurfaceMotion, SurfaceShape, Until};
use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use carom::{Run, Vector};

#[test]
fn gravity_of_each_stage_acts_in_turn() {
    let (down, aside) = (Vector::new(0.0, 0.0, -1.5), Vector::new(0.7, 0.0, 0.2));
    let stage = |name: &str, time: f64, gravity: Option<Vector>| StagePlan {
        name: name.to_owned(),
        limit: Until::time(time),
        gravity,
        ..StagePlan::default()
    };
    let plan = RunPlan {
        stages: vec![stage("first", 2.0, None), stage("aside", 3.0, Some(aside)), stage("again", 1.0, None)],
        limit: Until::time(0.5),
        gravity: Some(Vector::zeros()),
        ..RunPlan::default()
    };
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let (place, velocity) = (Vector::new(5.0, 6.0, 7.0), Vector::new(0.3, -0.2, 1.1));
    let scene = SceneBuilder::new("turning")
        .space(space)
        .gravity(down)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", place, velocity)
        .particle("A", place + Vector::y() * 4.0, velocity)
        .run(plan)
        .build()
        .unwrap();
    let finished = Run::new(scene).finish().unwrap();
    let (mut expected, mut speed) = (place, velocity);
    for (time, gravity) in [(2.0, down), (3.0, aside), (1.0, down), (0.5, Vector::zeros())] {
        expected += (speed + gravity * (0.5 * time)) * time;
        speed += gravity * time;
    }
    let snapshot = finished.simulation.snapshot();
    assert!((snapshot.positions[0] - expected).norm() < 1e-13 * expected.norm(), "{}", snapshot.positions[0]);
    assert!((snapshot.velocities[0] - speed).norm() < 1e-14 * speed.norm());
    assert_eq!(finished.audit.faults(), []);
    assert!(finished.simulation.event_counts().supplied.total() != 0.0);
}

/// Unlike balls in a box, with gravity that changes in a second stage.
fn shaken() -> Scene {
    let wall = Boundary::walls(0.9);
    let mut scene = SceneBuilder::new("shaken")
        .seed(3)
        .space(Space { boundary: [wall; 3], ..Space::periodic_cube(7.0) })
        .gravity(-Vector::z());
    for (name, mass, diameter) in [("A", 0.7, 0.5), ("B", 1.9, 1.3)] {
        scene = scene.species(SpeciesDraft::new(name).mass(mass).diameter(diameter));
        scene = scene.fill(Fill::new(Arrangement::Random, name).count(25));
    }
    for (one, other) in [("A", "A"), ("A", "B"), ("B", "B")] {
        scene = scene.interaction(InteractionDraft::new(Model::HardSphere).between(one, other).restitution(0.9));
    }
    let stage = StagePlan { name: "down".to_owned(), limit: Until::time(2.0), ..StagePlan::default() };
    let plan = RunPlan {
        stages: vec![stage],
        limit: Until::time(4.0),
        gravity: Some(Vector::new(1.0, 0.2, 0.1)),
        ..RunPlan::default()
    };
    scene.temperature(1.0).run(plan).build().unwrap()
}

#[test]
fn unlike_balls_collide_at_their_distances_after_gravity_has_changed() {
    // A run that frees the particles of its scene must not take the mixture for a fluid of one species.
    let whole = Run::new(shaken()).finish().unwrap();
    assert_eq!(whole.audit.faults(), []);
    assert!(whole.simulation.event_counts().core > 200);
    let freed = Run::without_start(shaken()).finish().unwrap();
    assert_eq!(freed.audit.faults(), []);
    assert_eq!(freed.simulation.snapshot().positions, whole.simulation.snapshot().positions);
}

/// A piston halves the height `L` that the centres of balls can reach. Returns the relative changes of `v_z L`.
fn changes(speed: f64) -> Vec<f64> {
    let walls = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(1.0)), upper: Face::Open };
    let space = Space { boundary: [Boundary::OPEN, Boundary::OPEN, walls], ..Space::periodic_cube(10.0) };
    let piston = SurfaceShape::Plane { point: Vector::z() * 10.0, normal: -Vector::z() };
    let kind = MotionKind::Translation { velocity: Vector::z() * -speed, acceleration: Vector::zeros() };
    let motion = SurfaceMotion { from: 3.0, until: 3.0 + 4.7 / speed, kind };
    let mut scene = SceneBuilder::new("piston")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.6))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .surface(SurfaceDraft::new("piston", piston).motion(motion));
    for k in 0..20 {
        let k = f64::from(k);
        let place = Vector::new(5.0, 5.0, 0.5 + 0.45 * k);
        scene = scene.particle("A", place, Vector::new(0.01 * k, 0.0, 1.3 + 0.11 * k));
    }
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let before = simulation.snapshot();
    simulation.advance(Until::time(motion.until + 1.0)).unwrap();
    let after = simulation.snapshot();
    // Balls have a radius of 0.3, so `L` is 10 - 0.6 = 9.4 at first, and 9.4 - 4.7 at the end.
    let change = |(a, b): (&Vector, &Vector)| b.z.abs() * (9.4 - 4.7) / (a.z.abs() * 9.4) - 1.0;
    before.velocities.iter().zip(&after.velocities).map(change).collect()
}

#[test]
fn slow_piston_conserves_the_adiabatic_invariant_of_each_ball() {
    // The product `v_z L` oscillates, but does not drift. The relative amplitude is about the speed of the piston
    // divided by the speed of the ball.
    for speed in [0.1, 0.01, 0.001] {
        for (k, change) in (0_u32..).zip(changes(speed)) {
            let slowest = 1.3 + 0.11 * f64::from(k);
            assert!(change.abs() < 2.0 * speed / slowest, "{speed}: ball {k} by {change}");
        }
    }
}
