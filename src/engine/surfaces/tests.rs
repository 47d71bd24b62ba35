use super::plane::Plane;
use super::{Placed, Surface};
use crate::Vector;
use crate::engine::event::{Event, EventKind, Other};
use crate::engine::parts::Engine;
use crate::engine::{Reason, Until};
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{ContactLaw, Scene, SurfaceLaw, SurfaceShape};
use crate::physics::detection::never::Doubt;
use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft, SurfaceDraft};
use std::ops::ControlFlow;

mod meshes;
mod moving;
mod periodic;

fn grains(gravity: f64, count: u32, surfaces: Vec<SurfaceDraft>) -> Scene {
    let hard = |diameter| Potential::hard_sphere(diameter).unwrap();
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let mut scene = SceneBuilder::new("grains")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -gravity))
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.1).diameter(1.5))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A").restitution(0.9))
        .interaction(InteractionDraft::new(hard(1.25)).between("A", "B").restitution(0.9))
        .interaction(InteractionDraft::new(hard(1.5)).between("B", "B").restitution(0.9));
    for k in 0..count {
        let at = |n: u32| 7.0 + 2.0 * f64::from(n % 4);
        let name = if k % 3 == 0 { "B" } else { "A" };
        let velocity = Vector::new(1.3 - f64::from(k % 5), 0.7 * f64::from(k % 3) - 0.6, 0.4 - f64::from(k % 4));
        scene = scene.particle(name, Vector::new(at(k), at(k / 4), at(k / 16)), velocity);
    }
    scene = surfaces.into_iter().fold(scene, SceneBuilder::surface);
    scene.build().unwrap()
}

/// Eight planes around the middle of the region, like the faces of a rotated octahedron.
fn cage(law: SurfaceLaw) -> Vec<SurfaceDraft> {
    let middle = Vector::repeat(10.0);
    let turned =
        |x: f64, y: f64, z: f64| Vector::new(0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, z) + Vector::repeat(0.1 * x);
    let directions = (0..8).map(|k| {
        let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
        turned(sign(0), 1.2 * sign(1), 0.9 * sign(2))
    });
    let plane = |direction: Vector| {
        let shape = SurfaceShape::Plane { point: middle - 6.5 * direction.normalize(), normal: direction };
        SurfaceDraft { law, ..SurfaceDraft::new("", shape) }
    };
    let name = |(k, draft): (usize, SurfaceDraft)| SurfaceDraft { name: format!("plane {k}"), ..draft };
    directions.map(plane).enumerate().map(name).collect()
}

fn run<const FALLING: bool>(
    engine: &mut Engine<FALLING, true>,
    events: u64,
    mut look: impl FnMut(&Event, &Placed),
) -> u64 {
    let surfaces = engine.sources.surfaces.clone();
    let named = |number, feature| move |placed: &&Placed| (placed.number, placed.feature) == (number, feature);
    let mut contacts = 0;
    let mut see = |event: &Event| {
        if let Other::Surface { surface, feature } = event.other {
            assert_eq!((event.kind, event.wall(), event.code()), (EventKind::Surface, None, 11));
            look(event, surfaces.all().iter().find(named(surface, feature)).unwrap());
            contacts += 1;
        }
        ControlFlow::Continue(())
    };
    assert_eq!(engine.advance(Until::events(events), &mut Some(&mut see)), Ok(Reason::Events));
    contacts
}

fn keeps_all<const FALLING: bool>(gravity: f64, restitution: f64, count: u32) {
    let scene = grains(gravity, count, cage(SurfaceLaw::Reflecting(ContactLaw::smooth(restitution))));
    let mut engine = Engine::<FALLING, true>::new(&scene);
    let start = engine.energy();
    let contacts = run(&mut engine, 4_000, |event, surface| {
        let [radius, mass] = if event.distance == 0.5 { [0.5, 0.7] } else { [0.75, 3.1] };
        assert_eq!(event.distance, radius);
        let normal = surface.shape.normal(&event.positions[0]);
        assert!(surface.shape.gap(&event.positions[0], radius).abs() < 1e-13);
        let [arriving, leaving] = [event.before[0], event.after[0]].map(|v| normal.dot(&v));
        assert!((leaving + restitution * arriving).abs() < 1e-14 * event.before[0].norm().max(1.0));
        assert!((event.impulse - (event.after[0] - event.before[0]) * mass).norm() < 1e-14 * event.impulse.norm());
        assert!((event.impulse - normal * event.normal_impulse()).norm() < 1e-13 * event.impulse.norm());
        assert!((event.dissipated - 0.5 * mass * (arriving * arriving - leaving * leaving)).abs() < 1e-12);
    });
    assert!(contacts > 300, "{contacts}");
    assert_eq!(engine.real_overlaps(), []);
    assert_eq!(engine.counts.totals.in_invalid_state, 0);
    let (end, counts) = (engine.energy(), engine.counts.totals);
    let change = end.kinetic + end.potential - start.kinetic - start.potential;
    assert!((change + counts.dissipated.total()).abs() < 1e-10 * start.kinetic, "{change}");
}

#[test]
fn planes_in_any_direction_hold_grains_and_reflect_them() {
    // The engine uses lists for 20 particles and cells for 60 particles.
    for count in [20, 60] {
        keeps_all::<false>(0.0, 1.0, count);
        keeps_all::<false>(0.0, 0.95, count);
        keeps_all::<true>(0.3, 1.0, count);
    }
}

#[test]
fn thermal_planes_emit_particles_at_their_temperature() {
    let scene = grains(0.0, 40, cage(SurfaceLaw::Thermal { temperature: 1.7 }));
    let mut engine = Engine::<false, true>::new(&scene);
    let mut squares = [0.0; 2];
    let contacts = run(&mut engine, 30_000, |event, surface| {
        let mass = if event.distance == 0.5 { 0.7 } else { 3.1 };
        let normal = surface.shape.normal(&event.positions[0]);
        let along = normal.dot(&event.after[0]);
        assert!(along > 0.0);
        squares[0] += mass * along * along;
        squares[1] += mass * (event.after[0].norm_squared() - along * along);
    });
    // `m v_n^2 / 2 T` with the normal velocity `v_n` has an exponential distribution. `m v_t^2 / T` with the tangential
    // velocity `v_t` has mean 2 and variance 4. The tolerance is five standard errors.
    let [normal, across] = squares.map(|sum| sum / (1.7 * contacts as f64));
    let error = 2.0 / (contacts as f64).sqrt();
    assert!((normal - 2.0).abs() < 5.0 * error && (across - 2.0).abs() < 5.0 * error, "{normal} {across} {contacts}");
}

#[test]
fn a_ball_on_a_slope_bounces_at_the_exact_times() {
    // The ball starts at rest, at a gap `h` above a slope of 45 degrees. Its acceleration along the normal is `g /
    // sqrt(2)`.
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(1e3) };
    let start = Vector::new(0.0, 0.0, 900.0);
    let scene = SceneBuilder::new("slope")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -2.0))
        .species(SpeciesDraft::new("ball").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("other").mass(0.7).diameter(1.0))
        .particle("ball", start, Vector::zeros());
    let normal = Vector::new(1.0, 0.0, 1.0).normalize();
    let plane = SurfaceShape::Plane { point: start - normal * 2.5, normal };
    let scene = scene.surface(SurfaceDraft::new("slope", plane)).build().unwrap();
    let mut engine = Engine::<true, true>::new(&scene);
    let first = (2.0 * 2.0 / 2.0_f64.sqrt()).sqrt();
    let mut times = Vec::new();
    assert_eq!(run(&mut engine, 6, |event, _| times.push(event.time)), 6);
    for (k, time) in times.iter().enumerate() {
        let expected = first * (1.0 + 2.0 * k as f64);
        assert!((time - expected).abs() < 1e-11 * expected, "{k} {time} {expected}");
    }
}

#[test]
fn particle_receding_from_a_plane_is_known_never_to_meet_it() {
    let plane = Plane::through(&Vector::zeros(), &Vector::new(1.0, 2.0, -1.0)).unwrap();
    let (position, none) = (Vector::new(4.0, 4.0, 1.0), Vector::zeros());
    let never = |velocity: Vector| {
        let flight = super::Flight { position: &position, velocity: &velocity, acceleration: &none, radius: 0.5 };
        plane.is_never_met(&flight, Doubt::of(10.0, 10.0))
    };
    assert!(never(Vector::new(1.0, 0.5, 0.0)) && !never(Vector::new(0.0, -1.0, 0.0)));
    assert!(Plane::through(&Vector::zeros(), &Vector::zeros()).is_none());
}
