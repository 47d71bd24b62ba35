use super::*;
use crate::analysis::instruments::test_system::{Recorded, estimate, instrument, measure, report, start};
use crate::mesh::revolution::revolution;
use crate::model::random::{Purpose, Random};
use crate::model::space::{Boundary, Space};
use crate::model::{ContactLaw, Scene, SurfaceShape};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};

fn plan(axis: Option<&str>) -> Plan {
    Plan { interval: None, axis: axis.map(str::to_owned), bins: Some(10) }
}

fn open(name: &str) -> SceneBuilder {
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    SceneBuilder::new(name).space(space)
}

#[test]
fn mean_force_of_bouncing_balls_is_their_weight() {
    // One ball bounces on a plane tilted by 1e-9, another on a wall.
    let slope = SurfaceShape::Plane { point: Vector::new(0.0, 0.0, 5.0), normal: Vector::new(0.0, 1e-9, 1.0) };
    let walls = Boundary::Bounded {
        lower: crate::model::space::Face::Wall(ContactLaw::smooth(1.0)),
        upper: crate::model::space::Face::Open,
    };
    let space = Space { boundary: [Boundary::OPEN, Boundary::OPEN, walls], ..Space::periodic_cube(20.0) };
    let scene = SceneBuilder::new("weight")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -2.0))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.1).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "B"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
        .surface(SurfaceDraft::new("slope", slope).only("A"))
        .particle("A", Vector::new(5.0, 5.0, 7.0), Vector::zeros())
        .particle("B", Vector::new(12.0, 5.0, 1.5), Vector::zeros())
        .build()
        .unwrap();
    let (system, mut simulation) = start(scene);
    let new = |setup: &Setup<'_>| Recorded::new(SurfaceForces::new(&plan(Some("z")), setup));
    let mut forces = instrument(&simulation, &system, 2_000.0, new);
    measure(&mut simulation, &system, &mut forces, 2_000.0);
    let measured = report(&forces, &system);
    for (name, weight) in [("slope", 1.4), ("wall_z_lower", 6.2)] {
        let mean = |key: &str| estimate(&measured, &format!("force_{name}_{key}")).0;
        // The run starts and ends between two bounces, so the mean force is only approximately the weight.
        assert!((mean("z") / -weight - 1.0).abs() < 5e-3, "{name} {}", mean("z"));
        assert!((mean("normal") / weight - 1.0).abs() < 5e-3);
        assert!(mean("x").abs() < 1e-12);
    }
    // The contacts are at heights of 5.5 and 0.5, in the bins of width 2 that start at 4 and 0.
    let curve = &measured.curves[0];
    let full = |series: usize| -> Vec<usize> {
        let values = curve.series[series].values.iter().enumerate();
        values.filter(|(_, value)| value.is_some_and(|value| value > 0.0)).map(|(bin, _)| bin).collect()
    };
    assert_eq!((full(0), full(1)), (vec![0], vec![2]));
}

fn filled(
    (count, seed): (u32, u64),
    is_inside: impl Fn(&Vector) -> bool,
    cavity: SurfaceShape,
    interacts: bool,
) -> Scene {
    let mut random = Random::new(seed, Purpose::Placement, 0);
    let mut scene = open("cavity")
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.3))
        .surface(SurfaceDraft::new("cavity", cavity));
    scene = match interacts {
        true => scene.interaction(InteractionDraft::new(Model::HardSphere).between("A", "A")),
        false => scene.interaction(InteractionDraft::new(Model::None).between("A", "A")),
    };
    let mut placed: Vec<Vector> = Vec::new();
    while placed.len() < count as usize {
        let place = Vector::from_fn(|_, _| 20.0 * random.uniform());
        let is_free = !interacts || placed.iter().all(|other| (place - other).norm() > 0.3);
        if is_inside(&place) && is_free {
            placed.push(place);
        }
    }
    for place in placed {
        let speed = 1.0 + random.uniform();
        let direction = random.direction(&Space::periodic_cube(1.0));
        scene = scene.particle("A", place, direction * speed);
    }
    scene.build().unwrap()
}

#[test]
fn the_pressure_in_a_sphere_is_that_of_the_virial() {
    // Virial theorem: `R F = 2 E + W`, apart from the change of `sum m r . v` over the run. `F` is the mean normal
    // force, `R` the distance of the centres from the middle at contact, `E` the kinetic energy, and `W` the virial of
    // the particles per time.
    let middle = Vector::repeat(10.0);
    for interacts in [false, true] {
        let sphere = SurfaceShape::Sphere { centre: middle, radius: 4.0, is_inside: true };
        let scene = filled((150, 7), |place| (place - middle).norm() < 3.85, sphere, interacts);
        let (system, mut simulation) = start(scene);
        let new = |setup: &Setup<'_>| SurfaceForces::new(&plan(None), setup);
        let mut forces = instrument(&simulation, &system, 400.0, new);
        let moment = |simulation: &crate::engine::Simulation| {
            let snapshot = simulation.snapshot();
            let all = snapshot.positions.iter().zip(&snapshot.velocities);
            all.map(|(r, v)| 0.7 * (r - middle).dot(v)).sum::<f64>()
        };
        let before = moment(&simulation);
        measure(&mut simulation, &system, &mut forces, 400.0);
        let ends = (moment(&simulation) - before) / 400.0;
        let virial = simulation.event_counts().virial.total() / 400.0;
        let expected = (2.0 * simulation.energy().kinetic + virial - ends) / 3.85;
        let (normal, _) = estimate(&report(&forces, &system), "force_cavity_normal");
        assert!((normal / expected - 1.0).abs() < 1e-10, "{normal} {expected}");
        assert!(virial > 1.0 || !interacts, "{virial}");
    }
}

#[test]
fn the_mean_chord_of_a_cavity_is_four_volumes_by_its_surface() {
    // Particles without interactions meet the wall at the rate `v S / 4 V` each, for any shape of the cavity (Cauchy).
    // `v` is the speed, `S` the surface and `V` the volume that centres can reach. By the virial theorem, the normal
    // force is `m v^2 S / 3 V` per particle.

    /// Largest initial distance of a particle from the centre line. The cavity has a radius of 2, and a particle has a
    /// radius of 0.15. The triangles of the ring reach up to 0.0024 into the cavity.
    const START: f64 = 1.8475;
    let middle = Vector::repeat(10.0);
    let ring = |place: &Vector| (place.x - 10.0).hypot(place.y - 10.0) - 5.0;
    let torus = {
        let sides = 160;
        let point = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k % sides) / f64::from(sides);
            [5.0 + 2.0 * libm::cos(angle), 2.0 * libm::sin(angle)]
        };
        let profile: Vec<[f64; 2]> = (0..=sides).map(point).collect();
        SurfaceShape::Mesh(revolution(&middle, &Vector::z(), &profile, 2e-3).unwrap())
    };
    let pipe = SurfaceShape::Cylinder { point: middle, axis: Vector::x(), radius: 2.0, is_inside: true };
    let around = |place: &Vector| (place.y - 10.0).hypot(place.z - 10.0);
    let in_ring = |place: &Vector| ring(place).hypot(place.z - 10.0) < START;
    let in_pipe = |place: &Vector| around(place) < START;
    for shape in [torus, pipe] {
        let is_ring = matches!(shape, SurfaceShape::Mesh(_));
        let (mut rates, mut pressures) = (Vec::new(), Vec::new());
        for seed in 1..=8 {
            let is_inside = |place: &Vector| if is_ring { in_ring(place) } else { in_pipe(place) };
            let scene = filled((1_000, seed), is_inside, shape.clone(), false);
            let sum =
                |of: fn(&Vector) -> f64| scene.particles.iter().map(|particle| of(&particle.velocity)).sum::<f64>();
            let (speed, square) = (sum(Vector::norm), sum(Vector::norm_squared));
            let (system, mut simulation) = start(scene);
            let mut forces = instrument(&simulation, &system, 12.0, |setup| SurfaceForces::new(&plan(None), setup));
            measure(&mut simulation, &system, &mut forces, 12.0);
            let measured = report(&forces, &system);
            let mean = |key: &str| estimate(&measured, &format!("force_cavity_{key}")).0;
            // For a ring and for a pipe, `V / S` is half of the radius that centres can reach.
            rates.push(mean("rate") * 2.0 * 1.85 / speed);
            pressures.push(mean("normal") * 1.5 * 1.85 / (0.7 * square));
        }
        for ratios in [rates, pressures] {
            let mean = ratios.iter().sum::<f64>() / 8.0;
            let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / 7.0;
            let error = (variance / 8.0).sqrt();
            assert!((mean - 1.0).abs() < 3.5 * error && error < 0.01, "{mean} +- {error}: {ratios:?}");
            println!("{mean} +- {error}");
        }
    }
}

#[test]
fn the_pressure_in_a_pipe_is_that_of_the_virial_across_it() {
    // Virial theorem for the motion perpendicular to the pipe. Without contacts between particles, the kinetic energy
    // of this motion is constant.
    let middle = Vector::repeat(10.0);
    let pipe = SurfaceShape::Cylinder { point: middle, axis: Vector::x(), radius: 4.0, is_inside: true };
    let across = |vector: &Vector| Vector::new(0.0, vector.y, vector.z);
    let scene = filled((150, 7), |place| across(&(place - middle)).norm() < 3.85, pipe, false);
    let (system, mut simulation) = start(scene);
    let mut forces = instrument(&simulation, &system, 400.0, |setup| SurfaceForces::new(&plan(None), setup));
    let sums = |simulation: &crate::engine::Simulation| {
        let snapshot = simulation.snapshot();
        let all = snapshot.positions.iter().zip(&snapshot.velocities);
        let both = all.map(|(r, v)| [(r - middle).dot(&across(v)), across(v).norm_squared()].map(|x| 0.7 * x));
        both.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
    };
    let [before, _] = sums(&simulation);
    measure(&mut simulation, &system, &mut forces, 400.0);
    let [after, twice_energy] = sums(&simulation);
    let expected = (twice_energy - (after - before) / 400.0) / 3.85;
    let (normal, _) = estimate(&report(&forces, &system), "force_cavity_normal");
    assert!((normal / expected - 1.0).abs() < 1e-10, "{normal} {expected}");
}
