//! The audit must not report round-off as a fault. It accepts valid runs in long boxes, in boxes far from the origin,
//! and across periodic sides.
//!
//! The error of a coordinate is about a unit in the last place of its largest value so far. At a contact near
//! coordinate 0, a particle may have come from the far side of the box, where the error is much larger.

use carom::Vector;
use carom::engine::Simulation;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::model::{ContactLaw, Growth, GrowthTarget, RunPlan, Scene, StagePlan, Thermostat, Until};
use carom::run::{Finished, run};
use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use std::ops::ControlFlow;

fn finished(scene: Scene) -> Finished {
    let Ok(finished) = run(scene, &mut (), &mut |_| ControlFlow::Continue(()));
    finished
}

fn periodic(dimensions: usize, lower: f64, length: f64) -> Space {
    let is_flat = |k: usize| k >= dimensions;
    Space {
        lower: Vector::from_fn(|k, _| if is_flat(k) { 0.0 } else { lower }),
        size: Vector::from_fn(|k, _| if is_flat(k) { 0.0 } else { length }),
        boundary: std::array::from_fn(|k| if is_flat(k) { Boundary::Flat } else { Boundary::Periodic }),
    }
}

/// Adds particles at positions relative to the lower corner of the box, with their centre of mass at rest.
fn placed(mut builder: SceneBuilder, space: &Space, places: &[Vector]) -> SceneBuilder {
    let velocity = |k: usize| {
        let part = |factor: f64| (k as f64 * factor + 0.3).fract() - 0.5;
        Vector::from_fn(|axis, _| if space.size[axis] > 0.0 { part([0.618, 0.414, 0.732][axis]) } else { 0.0 })
    };
    let mean = (0..places.len()).map(velocity).sum::<Vector>() / places.len() as f64;
    for (k, place) in places.iter().enumerate() {
        let inside =
            Vector::from_fn(
                |axis, _| if space.size[axis] > 0.0 { place[axis].rem_euclid(space.size[axis]) } else { 0.0 },
            );
        builder = builder.particle("A", space.lower + inside, velocity(k) - mean);
    }
    builder
}

/// A chain across the corner of a periodic box. The centre of mass is at rest, so the chain stays there.
fn chain(space: Space, beads: u32, events: u64) -> Scene {
    let builder = SceneBuilder::new("chain")
        .space(space.clone())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .interaction(InteractionDraft::new(Potential::bond(0.9, 1.2).unwrap()).named("link"))
        .run(RunPlan { limit: Until::events(events), ..RunPlan::default() });
    let places: Vec<Vector> =
        (0..beads).map(|k| Vector::new(1.05 * (f64::from(k) - 0.5 * f64::from(beads)) + 0.4, 0.0, 0.0)).collect();
    let builder = placed(builder, &space, &places);
    (1..beads).fold(builder, |builder, k| builder.bond([k - 1, k], "link")).build().unwrap()
}

#[test]
fn chain_across_a_corner_passes_its_audit_in_boxes_of_any_size() {
    for dimensions in 1..=3 {
        for length in [2.5, 10.0, 1e3, 1e6] {
            for lower in [0.0, -0.5 * length, 1e6, -1e8] {
                let beads = if length < 8.0 { 2 } else { 6 };
                let finished = finished(chain(periodic(dimensions, lower, length), beads, 4_000));
                assert_eq!(finished.audit.faults(), [], "{dimensions} dimensions, {length} from {lower}");
                assert_eq!(finished.simulation.event_counts().physical(), 4_000);
            }
        }
    }
}

#[test]
fn rods_on_a_long_ring_pass_their_audit() {
    for (rods, length, potential) in [
        (600, 1e3, Potential::hard_sphere(1.0).unwrap()),
        (120, 2e5, Potential::hard_sphere(1e3).unwrap()),
        (600, 1e3, Potential::square_well(1.0, 1.3, 1.0).unwrap()),
    ] {
        let space = periodic(1, 0.0, length);
        let diameter = potential.core().unwrap();
        let builder = SceneBuilder::new("rods")
            .space(space.clone())
            .species(SpeciesDraft::new("A").mass(1.0).diameter(diameter))
            .interaction(InteractionDraft::new(potential).between("A", "A"))
            .run(RunPlan { limit: Until::events(100_000), ..RunPlan::default() });
        let places: Vec<Vector> =
            (0..rods).map(|k| Vector::new((f64::from(k) + 0.5) * length / f64::from(rods), 0.0, 0.0)).collect();
        let finished = finished(placed(builder, &space, &places).build().unwrap());
        assert_eq!(finished.audit.faults(), [], "{rods} rods");
    }
}

/// By round-off, a fast inelastic contact leaves a small overlap. The audit must accept this overlap, although the pair
/// hardly moves.
#[test]
fn balls_that_fall_far_and_come_to_rest_pass_their_audit() {
    for height in [10.0, 1e3, 1e5] {
        let wall = carom::model::space::Face::Wall(ContactLaw::smooth(0.0));
        let mut space = periodic(2, 0.0, 3.0);
        space.boundary[1] = Boundary::Bounded { lower: wall, upper: carom::model::space::Face::Open };
        space.size.y = 2.0 * height;
        let scene = SceneBuilder::new("balls")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(0.0))
            .gravity(Vector::new(0.0, -1.0, 0.0))
            .contact_time(1e-3)
            .particle("A", Vector::new(0.7, height, 0.0), Vector::new(0.0, 0.1, 0.0))
            .particle("A", Vector::new(0.8, height + 3.0, 0.0), Vector::new(0.0, -0.1, 0.0))
            .run(RunPlan { limit: Until::events(3_000), ..RunPlan::default() })
            .build()
            .unwrap();
        assert_eq!(finished(scene).audit.faults(), [], "from {height}");
    }
}

/// A run can start from the final state of another run. A particle next to coordinate 0 may have crossed the periodic
/// side and overlap by one unit in the last place of the box length.
#[test]
fn what_a_run_in_a_long_box_leaves_is_a_valid_start() {
    let build = |length: f64, depth: f64| {
        let scene = SceneBuilder::new("again")
            .space(periodic(1, 0.0, length))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
        let at = |x: f64| Vector::new(x, 0.0, 0.0);
        scene.particle("A", at(0.5), Vector::zeros()).particle("A", at(1.5 - depth), Vector::zeros()).build()
    };
    assert!(build(1e6, 1e6 * f64::EPSILON).is_ok());
    assert!(build(10.0, 1e6 * f64::EPSILON).is_err());
    assert!(build(1e6, 1e-6).is_err());
    // The tolerances of bond lengths and of overlaps are equal.
    let bonded = |length: f64, excess: f64| {
        let at = |x: f64| Vector::new(x, 0.0, 0.0);
        SceneBuilder::new("bonded")
            .space(periodic(1, 0.0, length))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Potential::bond(0.9, 1.2).unwrap()).named("link"))
            .particle("A", at(0.5), Vector::zeros())
            .particle("A", at(1.7 + excess), Vector::zeros())
            .bond([0, 1], "link")
            .build()
    };
    assert!(bonded(1e6, 1e6 * f64::EPSILON).is_ok());
    assert!(bonded(10.0, 1e6 * f64::EPSILON).is_err());
    assert!(bonded(1e6, 1e-6).is_err());
}

/// Fast growth heats spheres, and the thermostat cools them. The audit must compare the momentum error with the momenta
/// of hot spheres. The start is random, because growth on a lattice would end before the first contact.
#[test]
fn growth_much_faster_than_the_thermal_speed_passes_its_audit() {
    for rate in [1.0, 1e6, 1e10] {
        let growth = Growth { rate, until: GrowthTarget::PackingFraction(0.4) };
        let thermostat = Some(Thermostat::Rescaling { temperature: 1.0, interval: 1.0 });
        let name = "grow".to_owned();
        let stage = StagePlan { name, thermostat, growth: Some(growth), ..StagePlan::default() };
        let plan = RunPlan { stages: vec![stage], limit: Until::events(1_000), ..RunPlan::default() };
        let scene = SceneBuilder::new("growth")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Arrangement::Random, "A").count(108).packing_fraction(0.05))
            .temperature(1.0)
            .run(plan);
        let finished = finished(scene.build().unwrap());
        assert_eq!(finished.audit.faults(), [], "rate {rate}");
        assert!(finished.audit.momentum_drift.is_some());
    }
}

/// Particles fly a million diameters through a long box. The number of transitions must stay small.
#[test]
fn few_particles_in_a_long_box_have_few_transitions() {
    for boundary in [Boundary::Periodic, Boundary::walls(1.0)] {
        let space = Space { boundary: [boundary; 3], ..Space::periodic_cube(1e9) };
        let at = |x: f64| Vector::new(x, 5e8, 5e8);
        let scene = SceneBuilder::new("long")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", at(3e8), Vector::new(1.0, 0.0, 0.0))
            .particle("A", at(3e8 + 1e6), Vector::new(-1.0, 0.0, 0.0))
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
        simulation.advance(Until::time(1e6)).unwrap();
        let counts = simulation.event_counts();
        assert_eq!((counts.core, counts.in_invalid_state), (1, 0));
        assert!(counts.deepest_overlap < 1e-6, "{}", counts.deepest_overlap);
        assert!(counts.transition < 30_000, "{}", counts.transition);
    }
}
