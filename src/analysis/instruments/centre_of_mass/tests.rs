use super::*;
use crate::analysis::instruments::test_system::{Recorded, instrument, mean, measure, number, report, start};
use crate::model::space::Space;
use crate::model::{MassRule, ParticleId, Scene, SpeciesId};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

const WALLS: fn() -> Boundary = || Boundary::walls(1.0);

/// Two moving species, a static one, and a species without particles.
fn scene(boundary: [Boundary; 3], gravity: Vector) -> Scene {
    let scene = SceneBuilder::new("centre")
        .space(Space { boundary, ..Space::periodic_cube(20.0) })
        .gravity(gravity)
        .species(SpeciesDraft::new("small").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("post").diameter(1.0).fixed())
        .species(SpeciesDraft::new("large").mass(3.1).diameter(1.0))
        .species(SpeciesDraft::new("absent").mass(1.3).diameter(1.0))
        .particle("small", Vector::new(3.0, 4.0, 5.0), Vector::new(0.3, -0.2, 0.1))
        .particle("post", Vector::new(15.0, 15.0, 15.0), Vector::zeros())
        .particle("large", Vector::new(8.0, 9.0, 11.0), Vector::new(-0.1, 0.2, 0.3))
        .particle("small", Vector::new(6.0, 2.0, 7.0), Vector::zeros());
    without_interactions(scene, &["small", "large", "post"]).build().unwrap()
}

fn without_interactions(scene: SceneBuilder, names: &[&str]) -> SceneBuilder {
    let pairs = names.iter().enumerate().flat_map(|(k, one)| names[..=k].iter().map(move |other| (one, other)));
    // Static particles never meet.
    let pairs = pairs.filter(|pair| *pair != (&"post", &"post"));
    pairs.fold(scene, |scene, (one, other)| scene.interaction(InteractionDraft::new(Model::None).between(one, other)))
}

fn plan(axis_point: Option<[f64; 3]>) -> Plan {
    Plan { axis_point, interval: Some(0.5) }
}

fn measured(scene: Scene, plan: &Plan, duration: f64) -> Measured {
    let (system, mut simulation) = start(scene);
    let mut centre = instrument(&simulation, &system, duration, |setup| Recorded::new(CentreOfMass::new(plan, setup)));
    measure(&mut simulation, &system, &mut centre, duration);
    report(&centre, &system)
}

#[test]
fn centres_of_mass_of_free_particles_are_exact() {
    let measured = measured(scene([WALLS(), Boundary::Periodic, WALLS()], Vector::zeros()), &plan(None), 4.0);
    // Without collisions, the mean over the times 0.5, 1, ..., 4 is the position at 2.25.
    let (first, large, second) =
        ((3.0 + 2.25 * 0.3, 5.0 + 2.25 * 0.1), (8.0 - 2.25 * 0.1, 11.0 + 2.25 * 0.3), (6.0, 7.0));
    let all = |a: f64, b: f64, c: f64| (0.7 * (a + c) + 3.1 * b) / 4.5;
    let expected = [
        ("x", "Centre of mass along x", all(first.0, large.0, second.0)),
        ("z", "Centre of mass along z", all(first.1, large.1, second.1)),
        ("x_small", "Centre of mass of small along x", 0.5 * (first.0 + second.0)),
        ("z_small", "Centre of mass of small along z", 0.5 * (first.1 + second.1)),
        ("x_large", "Centre of mass of large along x", large.0),
        ("z_large", "Centre of mass of large along z", large.1),
    ];
    assert_eq!(measured.numbers.len(), expected.len());
    for (number, (key, title, exact)) in measured.numbers.iter().zip(expected) {
        assert_eq!((number.name.as_str(), number.title.as_str()), (format!("centre_of_mass_{key}").as_str(), title));
        assert!((number.mean.unwrap() - exact).abs() < 1e-13, "{key} {:?} {exact}", number.mean);
    }
    let [curve] = &measured.curves[..] else { panic!() };
    let times: Vec<f64> = (0..=8).map(|k| 0.5 * f64::from(k)).collect();
    assert_eq!(curve.variables[0].values, times);
    let names: Vec<&str> = curve.series.iter().map(|series| series.name.as_str()).collect();
    assert_eq!(names, ["x", "z", "x of small", "z of small", "x of large", "z of large"]);
    for (k, time) in times.iter().enumerate() {
        assert!((curve.series[3].values[k].unwrap() - (6.0 + 0.05 * time)).abs() < 1e-13);
        assert!((curve.series[4].values[k].unwrap() - (8.0 - 0.1 * time)).abs() < 1e-13);
    }
}

#[test]
fn masses_of_individual_diameters_are_proportional_to_the_volume() {
    let scene = SceneBuilder::new("centre")
        .space(Space { boundary: [WALLS(), WALLS(), WALLS()], ..Space::periodic_cube(20.0) })
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0).individual_diameters(MassRule::Volume))
        .sized_particle("A", 0.5, Vector::new(3.0, 4.0, 5.0), Vector::zeros())
        .sized_particle("A", 1.5, Vector::new(8.0, 9.0, 11.0), Vector::zeros());
    let measured = measured(without_interactions(scene, &["A"]).build().unwrap(), &plan(None), 1.0);
    for (name, [one, other]) in [("x", [3.0, 8.0]), ("y", [4.0, 9.0]), ("z", [5.0, 11.0])] {
        let exact = (one + 27.0 * other) / 28.0;
        assert!((mean(&measured, &format!("centre_of_mass_{name}")) - exact).abs() < 1e-13, "{name}");
    }
}

/// Angle of a single ball that moves for a tiny time.
fn angle(boundary: [Boundary; 3], gravity: [f64; 3], [position, point]: [[f64; 3]; 2]) -> f64 {
    let scene = SceneBuilder::new("ball")
        .space(Space { boundary, ..Space::periodic_cube(20.0) })
        .gravity(gravity.into())
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .particle("A", position.into(), Vector::zeros())
        .build()
        .unwrap();
    let plan = Plan { axis_point: Some(point), interval: Some(1e-9) };
    let measured = measured(scene, &plan, 1.0625e-8);
    let angles = &measured.curve("inclination").unwrap().series[0];
    let mean = mean(&measured, "inclination");
    assert!(angles.unit == "degree" && angles.values.iter().all(|angle| (angle.unwrap() - mean).abs() < 1e-6));
    assert_eq!(
        measured.numbers.len(),
        1 + 3 - boundary.iter().filter(|it| !matches!(it, Boundary::Bounded { .. })).count()
    );
    mean
}

#[test]
fn inclination_is_the_angle_from_gravity() {
    let sqrt_3 = 3.0_f64.sqrt();
    let drum = [Boundary::OPEN, Boundary::OPEN, Boundary::Periodic];
    let point = [9.0, 10.0, 3.0];
    let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-6, "{found} {exact}");
    let in_drum = |x: f64, y: f64| angle(drum, [0.0, -1.3, 0.0], [[9.0 + x, 10.0 + y, 7.0], point]);
    // From -y, a rotation from x to y turns towards +x.
    near(in_drum(0.0, -2.0), 0.0);
    near(in_drum(1.0, -sqrt_3), 30.0);
    near(in_drum(-1.0, -sqrt_3), -30.0);
    near(in_drum(sqrt_3, 1.0), 120.0);
    // Gravity along another direction. Its component along the periodic axis does not count.
    near(angle(drum, [0.6, 0.0, 0.5], [[9.0 + sqrt_3, 11.0, 7.0], point]), 30.0);
    // Other planes: from z to x is a rotation from the second axis to the first.
    let in_zx = [Boundary::OPEN, Boundary::Periodic, WALLS()];
    near(angle(in_zx, [0.0, 0.0, 1.0], [[11.0, 1.0, 3.0 + 2.0 * sqrt_3], point]), -30.0);
    // With three axes, the angle has no sign.
    let closed = [Boundary::OPEN, Boundary::OPEN, WALLS()];
    near(angle(closed, [0.0, -1.0, 0.0], [[8.0, 10.0 - sqrt_3, 3.0], point]), 30.0);
    near(angle(closed, [0.0, -1.0, 0.0], [[9.0, 10.0 - sqrt_3, 4.0], point]), 30.0);
}

#[test]
fn inclination_is_undefined_at_the_point_itself() {
    let (system, _) = start(scene([Boundary::OPEN; 3], Vector::new(0.0, 0.0, -1.0)));
    // The product of a mass and a power of two is not rounded.
    let plan = plan(Some([2.0, 4.0, 8.0]));
    let sample = Sample {
        time: 0.5,
        ids: &[ParticleId(0)],
        species: &[SpeciesId(0)],
        positions: &[Vector::new(2.0, 4.0, 8.0)],
        ..Sample::default()
    };
    let setup = Setup { system: &system, sample: Sample { time: 0.0, ..sample }, duration: 10.0 };
    let mut centre = CentreOfMass::new(&plan, &setup);
    centre.sample(&sample, &system);
    assert_eq!(number(&report(&centre, &system), "inclination").mean, None);
    let other = Sample { time: 1.0, positions: &[Vector::new(5.0, 4.0, 8.0)], ..sample };
    centre.sample(&other, &system);
    let measured = report(&centre, &system);
    assert!((mean(&measured, "inclination") - 90.0).abs() < 1e-12);
    assert!((mean(&measured, "centre_of_mass_x_small") - 3.5).abs() < 1e-12);
    assert_eq!(number(&measured, "centre_of_mass_x_large").mean, None, "no particle is large");
}

#[test]
fn direction_of_gravity_is_that_of_the_total_weight() {
    let (mut system, _) = start(scene([Boundary::OPEN; 3], Vector::zeros()));
    system.accelerations[0] = Vector::new(0.0, 0.0, -3.1);
    system.accelerations[2] = Vector::new(-0.7, 0.0, 0.0);
    let below = Vector::new(2.0, 4.0, 7.0);
    let sample = Sample {
        time: 0.5,
        ids: &[ParticleId(0), ParticleId(1)],
        species: &[SpeciesId(0), SpeciesId(2)],
        positions: &[below, below],
        ..Sample::default()
    };
    let setup = Setup { system: &system, sample: Sample { time: 0.0, ..sample }, duration: 10.0 };
    let mut centre = CentreOfMass::new(&plan(Some([2.0, 4.0, 8.0])), &setup);
    centre.sample(&sample, &system);
    assert!((mean(&report(&centre, &system), "inclination") - 45.0).abs() < 1e-12);
}

#[test]
fn more_than_eight_species_have_a_common_centre_only() {
    for count in [1, 2, 8, 9] {
        let names: Vec<String> = (0..count).map(|k| format!("s{k}")).collect();
        let mut builder =
            SceneBuilder::new("many").space(Space { boundary: [WALLS(); 3], ..Space::periodic_cube(20.0) });
        for name in &names {
            builder = builder.species(SpeciesDraft::new(name).mass(1.3).diameter(0.5));
        }
        builder = without_interactions(builder, &names.iter().map(String::as_str).collect::<Vec<_>>());
        for (k, name) in names.iter().enumerate() {
            builder = builder.particle(name, Vector::new(2.0 + 1.5 * k as f64, 3.0, 3.0), Vector::zeros());
        }
        let measured = measured(builder.build().unwrap(), &plan(None), 2.0);
        let classes = if (2..=8).contains(&count) { 1 + count } else { 1 };
        assert_eq!(measured.numbers.len(), 3 * classes, "{count}");
        assert!((mean(&measured, "centre_of_mass_x") - (2.0 + 0.75 * (count - 1) as f64)).abs() < 1e-13);
    }
}

#[test]
fn curve_has_bounded_length_and_even_spacing() {
    let (system, mut simulation) = start(scene([WALLS(); 3], Vector::zeros()));
    let plan = Plan { axis_point: None, interval: Some(1e-3) };
    let mut centre = instrument(&simulation, &system, 5.0, |setup| CentreOfMass::new(&plan, setup));
    measure(&mut simulation, &system, &mut centre, 5.0);
    let times: Vec<f64> = centre.rows.times();
    assert!((500..=1025).contains(&times.len()), "{}", times.len());
    assert_eq!(times[0], 0.0);
    assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 8e-3).abs() < 1e-9));
}
