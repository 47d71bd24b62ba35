//! The pressure between walls, from the virial, from the impulses on the walls, and from the pressure tensor.

use carom::engine::event::EventKind;
use carom::model::MeasurementPlan;
use carom::model::measurement_plan as plan;
use carom::model::space::{Boundary, Space};
use carom::model::{RunPlan, Thermostat, Until};
use carom::run::Finished;
use carom::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft};
use carom::{Run, Simulation, Vector};

use super::measure::{finish, hard, number};

fn mixture(boundary: [Boundary; 3], size: Vector, counts: [u64; 2]) -> Finished {
    let scene = SceneBuilder::new("mixture")
        .seed(11)
        .space(Space { lower: Vector::zeros(), size, boundary })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.0).diameter(1.6))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(hard(1.3)).between("A", "B"))
        .interaction(InteractionDraft::new(hard(1.6)).between("B", "B"))
        .fill(Fill::new(Arrangement::Random, "B").count(counts[1]))
        .fill(Fill::new(Arrangement::Random, "A").count(counts[0]))
        .temperature(1.3)
        .measure(MeasurementPlan {
            pressure_tensor: Some(plan::PressureTensor::default()),
            ..MeasurementPlan::default()
        })
        .run(RunPlan { equilibration: Until::events(20_000), limit: Until::events(150_000), ..RunPlan::default() })
        .build()
        .unwrap();
    finish(scene)
}

#[test]
fn virial_wall_and_tensor_pressures_agree() {
    let (periodic, walls, flat) = (Boundary::Periodic, Boundary::walls(1.0), Boundary::Flat);
    let (plane, space) = (Vector::new(11.0, 9.0, 0.0), Vector::new(7.0, 6.0, 5.5));
    for (what, boundary, size, counts) in [
        ("slit, 2-D", [walls, periodic, flat], plane, [16, 12]),
        ("box, 2-D", [walls, walls, flat], plane, [16, 12]),
        ("slit, 3-D", [periodic, periodic, walls], space, [30, 20]),
        ("box, 3-D", [walls; 3], space, [30, 20]),
    ] {
        let finished = mixture(boundary, size, counts);
        let virial = finished.observable("pressure").unwrap();
        let virial_error = virial.standard_error.unwrap();
        println!("{what}: virial {virial:?}");
        // The centres of particles cannot enter the outer layer of the box, a fifth of the volume or more. The standard
        // error must be far smaller than the effect of this layer.
        assert!(virial_error < 0.01 * virial.mean, "{what}: {virial:?}");
        let (mean, error) = number(&finished.measured, "pressure");
        println!("{what}: tensor {mean} +- {error}");
        assert!((mean - virial.mean).abs() < 4.0 * error.max(virial_error), "{what}: {mean} +- {error}, {virial:?}");
        let (mut sum, mut number) = (0.0, 0.0);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            for side in ["lower", "upper"] {
                let on_wall = finished.observable(&format!("pressure_on_{side}_{name}_wall"));
                assert_eq!(on_wall.is_some(), boundary[axis] == walls, "{what}: {side} {name}");
                let Some(on_wall) = on_wall else { continue };
                let error = libm::hypot(virial_error, on_wall.standard_error.unwrap());
                let difference = on_wall.mean - virial.mean;
                (sum, number) = (sum + on_wall.mean, number + 1.0);
                println!("{what}: {side} {name} {on_wall:?}, {:+.2} sigma", difference / error);
                assert!(error < 0.02 * virial.mean && difference.abs() < 4.0 * error, "{what}: {on_wall:?} {virial:?}");
            }
        }
        // Oscillations of energy between the axes cancel in the mean over all walls.
        let mean = sum / number;
        assert!((mean - virial.mean).abs() < 2.0 * virial_error, "{what}: {mean}, {virial:?}");
    }
}

#[test]
fn driven_granular_slit_has_equal_wall_and_virial_pressures() {
    // The bath drives particles only along the slit. An isotropic gas would have a pressure a third higher.
    let slit = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Flat];
    let scene = SceneBuilder::new("driven")
        .seed(1)
        .space(Space { lower: Vector::zeros(), size: Vector::new(20.0, 20.0, 0.0), boundary: slit })
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A").restitution(0.5))
        .fill(Fill::new(Arrangement::Random, "A").count(120))
        .temperature(1.0)
        .measure(MeasurementPlan {
            pressure_tensor: Some(plan::PressureTensor::default()),
            ..MeasurementPlan::default()
        })
        .run(RunPlan {
            equilibration: Until::events(20_000),
            limit: Until::events(100_000),
            thermostat: Some(Thermostat::Andersen { temperature: 1.0, rate: 0.5, axes: [false, true, false] }),
            ..RunPlan::default()
        })
        .build()
        .unwrap();
    let finished = Run::new(scene).finish().unwrap();
    let virial = finished.observable("pressure").unwrap();
    let tensor = finished.measured.number("pressure_xx").unwrap();
    println!("{virial:?} {:?}", tensor.mean);
    assert!((tensor.mean.unwrap() / virial.mean - 1.0).abs() < 1e-9, "{virial:?} {:?}", tensor.mean);
    for side in ["lower", "upper"] {
        let on_wall = finished.observable(&format!("pressure_on_{side}_x_wall")).unwrap();
        let error = libm::hypot(virial.standard_error.unwrap(), on_wall.standard_error.unwrap());
        println!("{on_wall:?}");
        assert!(error < 0.02 * virial.mean, "{virial:?} {on_wall:?}");
        assert!((on_wall.mean - virial.mean).abs() < 4.0 * error, "{virial:?} {on_wall:?}");
    }
}

#[test]
fn the_walls_of_a_falling_gas_carry_its_weight() {
    let mut boundary = [Boundary::Periodic, Boundary::walls(1.0), Boundary::Flat];
    let scene = |boundary| {
        SceneBuilder::new("weight")
            .seed(2)
            .space(Space { lower: Vector::zeros(), size: Vector::new(10.0, 12.0, 0.0), boundary })
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
            .gravity(Vector::new(0.0, -0.3, 0.0))
            .fill(Fill::new(Arrangement::Random, "A").count(20))
            .temperature(1.0)
            .run(RunPlan { equilibration: Until::events(5_000), limit: Until::events(100_000), ..RunPlan::default() })
            .build()
            .unwrap()
    };
    let finished = Run::new(scene(boundary)).finish().unwrap();
    assert!(finished.observable("pressure").is_none(), "it is not the same at all heights");
    let on = |side: &str| finished.observable(&format!("pressure_on_{side}_y_wall")).unwrap().mean;
    // The pressures on floor and ceiling differ by the weight of 20 particles of mass 0.7, divided by the length of the
    // floor, 10. The total momentum changes by about sqrt(20 0.7), which adds a small deviation.
    let (weight, left) = (20.0 * 0.7 * 0.3 / 10.0, 4.0 * 14.0_f64.sqrt() / (10.0 * finished.measurement.duration));
    assert!((on("lower") - on("upper") - weight).abs() < left, "{} {} {weight} {left}", on("lower"), on("upper"));
    assert!(left < 0.01 * weight);
    boundary[0] = Boundary::OPEN;
    let open = Run::new(scene(boundary)).finish().unwrap();
    assert!(open.observable("pressure_on_lower_y_wall").is_none(), "its area has no end");
}

#[test]
fn thermal_wall_velocities_do_not_depend_on_the_order_of_contacts() {
    // Returns the velocities of the first particle after its contacts with hot walls. The particles are too small to
    // meet. The argument `others` decides when the other two particles reach the walls.
    let velocities = |others: f64| {
        let slit = Space {
            boundary: [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic],
            ..Space::periodic_cube(10.0)
        };
        let mut scene = SceneBuilder::new("three")
            .seed(3)
            .space(slit)
            .wall_temperature(0, 1.3)
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1e-3));
        scene = scene.interaction(InteractionDraft::new(hard(1e-3)).between("A", "A"));
        for (k, speed) in [1.1, others, 3.0 * others].into_iter().enumerate() {
            scene = scene.particle("A", Vector::new(3.0, 2.0 + k as f64, 5.0), Vector::new(speed, 0.3, 0.0));
        }
        let mut simulation = Simulation::new(scene.build().unwrap()).unwrap();
        let mut given = Vec::new();
        let mut see = |event: &carom::Event| {
            if event.particle.0 == 0 && event.kind == EventKind::Surface {
                given.push(event.after[0].map(f64::to_bits));
            }
        };
        simulation.advance_with(Until::events(400), &mut see).unwrap();
        given.truncate(50);
        given
    };
    let first = velocities(0.5);
    assert_eq!(first.len(), 50);
    assert_eq!(first, velocities(7.3));
    let mut distinct = first.iter().map(|given| given.x).collect::<Vec<_>>();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), 50, "each contact has its own");
}
