//! Two dimensions: static disks confine particles, and speeds have Maxwell's distribution.

use carom::Vector;
use carom::engine::Simulation;
use carom::model::space::{Boundary, Space};
use carom::model::{MeasurementPlan, RunPlan, Until, measurement_plan as plan};
use carom::scene::{
    Arrangement, BoxSide, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft, Surface, SurfaceFill,
};

use super::measure::{finish, hard};

fn plane() -> Space {
    let boundary = [Boundary::OPEN, Boundary::Flat, Boundary::OPEN];
    Space { lower: Vector::zeros(), size: Vector::new(20.0, 0.0, 20.0), boundary }
}

fn at(x: f64, z: f64) -> Vector {
    Vector::new(x, 0.0, z)
}

fn surface(shape: Surface, spacing: Option<f64>) -> SurfaceFill {
    SurfaceFill { name: None, species: "wall".to_owned(), shape, spacing }
}

fn held(surfaces: Vec<SurfaceFill>) -> SceneBuilder {
    let fill = |species| Fill::new(Arrangement::Random, species).region(at(7.5, 7.5), at(12.5, 12.5));
    let scene = SceneBuilder::new("held")
        .space(plane())
        .species(SpeciesDraft::new("small").mass(0.7).diameter(0.6))
        .species(SpeciesDraft::new("large").mass(3.0).diameter(1.1))
        .species(SpeciesDraft::new("wall").diameter(0.9).fixed())
        .interaction(InteractionDraft::new(hard(0.6)).between("small", "small"))
        .interaction(InteractionDraft::new(hard(0.85)).between("small", "large"))
        .interaction(InteractionDraft::new(hard(1.1)).between("large", "large"))
        .interaction(InteractionDraft::new(hard(0.75)).between("small", "wall"))
        .interaction(InteractionDraft::new(hard(1.0)).between("large", "wall"))
        .fill(fill("small").count(12))
        .fill(fill("large").count(6))
        .speed(1.3);
    surfaces.into_iter().fold(scene, SceneBuilder::static_surface)
}

fn stays(scene: &SceneBuilder, is_inside: impl Fn(&Vector) -> bool) -> bool {
    let scene = scene.build().unwrap();
    let moving: Vec<bool> =
        scene.particles().iter().map(|p| !scene.species()[p.species.0 as usize].is_static()).collect();
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::events(40_000)).unwrap();
    let snapshot = simulation.snapshot();
    snapshot.positions.iter().zip(moving).all(|(position, is_moving)| !is_moving || is_inside(position))
}

#[test]
fn rings_rectangles_and_lines_confine_particles() {
    let centre = at(10.0, 10.0);
    let ring = held(vec![surface(Surface::Ring { centre, radius: 5.0 }, None)]);
    assert_eq!(ring.build().unwrap().leaks(), []);
    assert!(stays(&ring, |position| (position - centre).norm() < 5.0));
    let (lower, upper) = (at(5.0, 6.0), at(15.0, 14.0));
    let is_inside = |p: &Vector| (5.0..15.0).contains(&p.x) && (6.0..14.0).contains(&p.z);
    let rectangle = Surface::Rectangle { lower, upper, open: Vec::new() };
    assert!(stays(&held(vec![surface(rectangle, None)]), is_inside));
    let top = BoxSide { axis: 2, is_upper: true };
    let cup = surface(Surface::Rectangle { lower, upper, open: vec![top] }, None);
    let lid = surface(Surface::Line { ends: [at(5.0, 14.0), at(15.0, 14.0)] }, None);
    let closed = held(vec![cup.clone(), lid]);
    assert_eq!(closed.build().unwrap().gaps(), []);
    assert!(stays(&closed, is_inside));
    assert!(!stays(&held(vec![cup]), is_inside));
}

#[test]
fn leaky_spacings_and_joints_are_reported_and_do_leak() {
    let centre = at(10.0, 10.0);
    // Halfway between two disks, both centres are 0.8 away. Small disks need 0.75, large disks need 1.
    let ring = |spacing| held(vec![surface(Surface::Ring { centre, radius: 5.0 }, Some(spacing))]);
    let leaks = ring(1.6).build().unwrap().leaks();
    assert_eq!(leaks.iter().map(|leak| leak.species.as_str()).collect::<Vec<_>>(), ["small"]);
    assert!(!stays(&ring(1.6), |position| (position - centre).norm() < 5.0));
    assert_eq!(ring(1.49).build().unwrap().leaks(), []);
    let gaps = |apart: f64| {
        let lines = [[at(2.0, 3.0), at(8.0, 3.0)], [at(8.0 + apart, 3.0), at(18.0, 3.0)]];
        held(lines.map(|ends| surface(Surface::Line { ends }, None)).to_vec()).build().unwrap().gaps()
    };
    assert_eq!(gaps(1.4), []);
    let wide = gaps(1.9);
    assert!(!wide.is_empty() && wide.iter().all(|gap| gap.species == "small"), "{wide:?}");
}

#[test]
fn equal_speeds_relax_to_maxwells_distribution_at_constant_energy() {
    let boundary = [Boundary::Periodic, Boundary::Flat, Boundary::Periodic];
    let measure = plan::Speeds { windows: Some(2), window: Some(20.0), bins: Some(60), ..plan::Speeds::default() };
    let scene = SceneBuilder::new("maxwell")
        .space(Space { boundary, ..plane() })
        .species(SpeciesDraft::new("disk").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("disk", "disk"))
        .fill(Fill::new(Arrangement::Random, "disk").count(151))
        .speed(1.3)
        .measure(MeasurementPlan { speeds: Some(measure), ..MeasurementPlan::default() })
        .run(RunPlan { limit: Until::time(300.0), ..RunPlan::default() })
        .build()
        .unwrap();
    let finished = finish(scene);
    let temperature = finished.observable("temperature").unwrap().mean;
    // The particles start with the same speed v, so the temperature is N m v^2 / (D (N - 1)).
    assert!((temperature / (151.0 * 0.7 * 1.69 / 300.0) - 1.0).abs() < 1e-12, "{temperature}");
    let curve = finished.measured.curve("speeds").unwrap();
    let (last, width) = (&curve.series[1], 2.0 * curve.variables[0].values[0]);
    assert_eq!(last.name, "p(v) from 20 to 300");
    let sum: f64 = last.values.iter().flatten().sum();
    assert!((sum * width - 1.0).abs() < 1e-12, "{sum}");
    let bins = last.values.iter().zip(&last.standard_errors).zip(&curve.published[0].y);
    let terms: Vec<f64> = bins
        .filter(|(_, expected)| **expected * width > 0.004)
        .map(|((value, error), expected)| ((value.unwrap() - expected) / error.unwrap()).powi(2))
        .collect();
    let chi = terms.iter().sum::<f64>() / terms.len() as f64;
    assert!(terms.len() > 15 && (0.4..2.0).contains(&chi), "{chi} of {}", terms.len());
}
