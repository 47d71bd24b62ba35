//! Tests of moving surfaces. Contacts are compared with exact bounces, and with contacts in the frame of the surface.
//! No particle may leave a closed surface.

use super::meshes::{contacts, gas, mesh};
use crate::Vector;
use crate::engine::{Simulation, Until};
use crate::model::space::{Boundary, Space};
use crate::model::{MotionKind, Scene, SurfaceMotion, SurfaceShape, TriangleMesh};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use std::f64::consts::{PI, TAU};

const ALWAYS: (f64, f64) = (0.0, f64::INFINITY);

fn moving((from, until): (f64, f64), kind: MotionKind) -> SurfaceMotion {
    SurfaceMotion { from, until, kind }
}

fn along_z(speed: f64, acceleration: f64) -> MotionKind {
    MotionKind::Translation { velocity: Vector::z() * speed, acceleration: Vector::z() * acceleration }
}

fn floor(restitution: f64) -> SurfaceDraft {
    let plane = SurfaceShape::Plane { point: Vector::zeros(), normal: Vector::z() };
    SurfaceDraft::new("floor", plane).restitution(restitution)
}

/// A ball above a floor at z = 0. `height` is the initial gap.
fn ball(gravity: f64, height: f64, speed: f64, floor: SurfaceDraft) -> Scene {
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    SceneBuilder::new("ball")
        .space(space)
        .gravity(Vector::z() * -gravity)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .surface(floor)
        .particle("A", Vector::new(10.0, 10.0, height + 0.25), Vector::new(0.1, 0.0, speed))
        .build()
        .unwrap()
}

#[test]
fn surface_that_starts_moving_late_is_still_hit() {
    // The floor starts to move very late. Before this time, the engine tries to prove that no further event happens.
    let floor = floor(1.0).motion(moving((1e6, 1e6 + 20.0), along_z(0.1, 0.0)));
    let mut simulation = Simulation::without_plan(ball(0.0, 1.0, 0.0, floor));
    assert_eq!(simulation.advance(Until::events(1)), Ok(crate::engine::Reason::Events));
    assert!((simulation.time() - 1_000_010.0).abs() < 1e-6, "{}", simulation.time());
    assert!(simulation.event_counts().transition > 40_000);
}

fn oscillation(amplitude: f64, rate: f64, phase: f64) -> MotionKind {
    MotionKind::Oscillation { amplitude: Vector::z() * amplitude, frequency: rate / TAU, phase }
}

#[test]
fn ball_thrown_by_a_moving_floor_has_exact_time_and_speed() {
    // The floor rises by 0.5 (t - 2) from t = 2 to 4, then by 0.3 (t - 4)^2 until t = 5. The initial gap is 0.6.
    let floor = floor(0.8).motion(moving((2.0, 4.0), along_z(0.5, 0.0))).motion(moving((4.0, 5.0), along_z(0.0, 0.6)));
    let found = contacts(ball(0.0, 0.6, 0.0, floor), 1);
    let event = &found[0];
    assert!((event.time - 3.2).abs() < 1e-14);
    // After a contact with a floor of speed `w`, the speed is `v' = -e v + (1 + e) w` with the restitution `e`. The
    // floor does the work `J w` with the impulse `J`.
    assert!((event.after[0].z - 0.9).abs() < 1e-14);
    let (work, lost) = (0.7 * 0.9 * 0.5, 0.5 * 0.7 * (1.0 - 0.64) * 0.25);
    assert!((event.energy_step - work).abs() < 1e-14 && (event.dissipated - lost).abs() < 1e-14, "{event:?}");
    // This floor rises by 1.2 (t - 4)^2 from t = 4 to 5. It reaches a ball at a gap of 1.1, but not at a gap of 1.3.
    let late = ball(0.0, 1.1, 0.0, self::floor(1.0).motion(moving((4.0, 5.0), along_z(0.0, 2.4))));
    let found = contacts(late, 1);
    assert!((found[0].time - (4.0 + (1.1_f64 / 1.2).sqrt())).abs() < 1e-14, "{}", found[0].time);
    let mut simulation =
        Simulation::without_plan(ball(0.0, 1.3, 0.0, self::floor(1.0).motion(moving((4.0, 5.0), along_z(0.0, 2.4)))));
    let _ = simulation.advance(Until::time(100.0));
    assert_eq!(simulation.event_counts().wall, 0, "it stops 0.1 below the ball");
}

/// Returns the times of the first bounces on a vibrating floor. Small steps bracket each bounce for a bisection.
fn bounces(
    gravity: f64,
    (height, leaving): (f64, f64),
    restitution: f64,
    (amplitude, rate, phase): (f64, f64, f64),
    count: usize,
) -> Vec<f64> {
    let first = amplitude * libm::sin(TAU * phase);
    let surface = |t: f64| amplitude * libm::sin(rate * t + TAU * phase) - first;
    let (mut since, mut from, mut speed) = (0.0, height, leaving);
    let mut times = Vec::new();
    while times.len() < count {
        let above = |t: f64| from + (speed - 0.5 * gravity * (t - since)) * (t - since) - surface(t);
        let step = 1e-3 / rate;
        let mut upper = since + step;
        while above(upper) > 0.0 {
            upper += step;
        }
        let mut lower = upper - step;
        for _ in 0..80 {
            let middle = 0.5 * (lower + upper);
            if above(middle) > 0.0 { lower = middle } else { upper = middle }
        }
        let own = amplitude * rate * libm::cos(rate * upper + TAU * phase);
        let arriving = speed - gravity * (upper - since);
        (since, from) = (upper, surface(upper));
        speed = -restitution * arriving + (1.0 + restitution) * own;
        times.push(upper);
    }
    times
}

#[test]
fn bounce_times_on_vibrating_floor_match_the_bouncing_ball_map() {
    // Rounding errors decay near a stable orbit. Otherwise, they grow.
    for (restitution, gamma, count) in [(0.5, 1.3, 400), (0.8, 0.9, 400), (1.0, 2.0, 6)] {
        let (gravity, rate) = (9.81, 31.0);
        let amplitude = gamma * gravity / (rate * rate);
        let phase = libm::acos(PI * (1.0 - restitution) / (gamma * (1.0 + restitution))) / TAU;
        let leaving = 1.02 * PI * gravity / rate;
        let floor = floor(restitution).motion(moving(ALWAYS, oscillation(amplitude, rate, phase)));
        let found = contacts(ball(gravity, 1e-3, leaving, floor), count as u64);
        let expected = bounces(gravity, (1e-3, leaving), restitution, (amplitude, rate, phase), count);
        for (event, time) in found.iter().zip(&expected) {
            assert!((event.time - time).abs() * rate < 1e-9, "{restitution} {gamma}: {} {time}", event.time);
        }
        assert_eq!(found.len(), expected.len());
    }
}

#[test]
fn bounce_times_on_vibrating_floor_match_40_digit_reference() {
    // Times of bounces 1, 50, 100 and 200, computed by bisection with 40 digits.
    let cases = [
        (
            0.5,
            0.01327,
            0.1009,
            [0.206_500_245_409_480_6, 10.134_182_438_316_404, 20.268_358_935_134_273, 40.536_711_928_770_01],
        ),
        (
            0.8,
            0.009_19,
            0.1866,
            [0.207_275_212_608_111_3, 10.134_182_315_471_11, 20.268_358_732_863_6, 40.536_711_726_498_12],
        ),
    ];
    for (restitution, amplitude, phase, expected) in cases {
        let kind = MotionKind::Oscillation { amplitude: Vector::z() * amplitude, frequency: 4.9338, phase };
        let floor = floor(restitution).motion(moving(ALWAYS, kind));
        let found = contacts(ball(9.81, 1.0 / 1024.0, 1.014, floor), 200);
        for (bounce, time) in [1, 50, 100, 200].into_iter().zip(expected) {
            let off = TAU * 4.9338 * (found[bounce - 1].time - time).abs();
            assert!(off < 1e-9, "bounce {bounce}: the phase is off by {off:e}");
        }
    }
}

#[test]
fn vibrating_floor_is_accurate_at_late_times() {
    let amplitude = 4.0 * 9.81 / (31.0 * 31.0);
    let floor = floor(0.9).motion(moving(ALWAYS, oscillation(amplitude, 31.0, 0.0)));
    let mut parts = ball(9.81, 0.5, 0.0, floor).into_parts();
    parts.start_time = 1e7;
    let mut simulation = Simulation::without_plan(Scene::new(parts).unwrap());
    simulation.advance(Until::events(500)).unwrap();
    assert_eq!((simulation.event_counts().in_invalid_state, simulation.real_overlaps()), (0, vec![]));
    // Times near 1e7 are multiples of 1.9e-9. At a speed of 5, two multiples cause an overlap of 2e-8.
    assert!(simulation.event_counts().deepest_overlap < 1e-7, "{}", simulation.event_counts().deepest_overlap);
}

/// Returns the largest difference between two successive flight times, in periods of the floor. The ball starts near
/// the orbit with one bounce per period. Only the last 40 bounces are used.
fn unevenness(restitution: f64, gamma: f64, bounces: u64) -> f64 {
    let (gravity, rate) = (9.81, 31.0);
    let amplitude = gamma * gravity / (rate * rate);
    // On the orbit, the ball bounces at the phase with `cos(phase) = pi (1 - e) / (gamma (1 + e))`. Here `e` is the
    // restitution, and `gamma` is the largest acceleration of the floor divided by gravity.
    let phase = libm::acos(PI * (1.0 - restitution) / (gamma * (1.0 + restitution)));
    let leaving = PI * gravity / rate;
    let floor = floor(restitution).motion(moving(ALWAYS, oscillation(amplitude, rate, phase / TAU)));
    let found = contacts(ball(gravity, 1e-12, leaving * (1.0 + 1e-4), floor), bounces);
    let last = &found[found.len() - 40..];
    let intervals: Vec<f64> = last.windows(2).map(|two| (two[1].time - two[0].time) * rate / TAU).collect();
    intervals.windows(2).map(|two| (two[1] - two[0]).abs()).fold(0.0, f64::max)
}

#[test]
fn bouncing_ball_period_doubles_at_the_known_threshold() {
    // The orbit becomes unstable if the acceleration of the floor, divided by gravity, exceeds the threshold.
    for (restitution, threshold) in [(0.5, 1.52682), (0.8, 1.07084)] {
        let below = unevenness(restitution, threshold - 1e-3, 20_000);
        let above = unevenness(restitution, threshold + 1e-3, 20_000);
        assert!(below < 1e-9, "{restitution}: {below}");
        assert!(above > 1e-3, "{restitution}: {above}");
    }
}

#[test]
fn contacts_are_the_same_in_the_frame_of_a_moving_surface() {
    // A gas in a closed box that is at rest, moves at a constant velocity, or falls together with the gas.
    let (lower, upper) = (Vector::new(6.1, 6.3, 6.7), Vector::new(13.9, 14.2, 14.8));
    let draft = || mesh("box", TriangleMesh::cuboid(&lower, &upper)).restitution(0.9);
    let scene = |drift: Vector, gravity: f64, draft: SurfaceDraft| {
        let scene = gas(6, 5.0, gravity).surface(draft).build().unwrap();
        let mut parts = scene.into_parts();
        parts.particles.iter_mut().for_each(|particle| particle.velocity += drift);
        Scene::new(parts).unwrap()
    };
    let expected = contacts(scene(Vector::zeros(), 0.0, draft()), 60);
    let (drift, fall) = (Vector::new(0.3, -0.2, 0.5), Vector::new(0.1, -0.2, -1.0) * 0.4);
    let drifts = MotionKind::Translation { velocity: drift, acceleration: Vector::zeros() };
    let falls = MotionKind::Translation { velocity: drift, acceleration: fall };
    for (gravity, kind) in [(0.0, drifts), (0.4, falls)] {
        let found = contacts(scene(drift, gravity, draft().motion(moving(ALWAYS, kind))), 60);
        assert_eq!(expected.len(), found.len());
        assert!(found.len() > 20);
        for (one, other) in expected.iter().zip(&found) {
            assert_eq!(one.particle, other.particle);
            assert!((one.time - other.time).abs() < 1e-9, "{} {}", one.time, other.time);
            assert!((one.impulse - other.impulse).norm() < 1e-9);
        }
    }
}

#[test]
fn a_blade_that_turns_strikes_along_its_own_normal() {
    // The blade turns about the z axis through the middle of the box. It starts along x, and its angle is `2 pi f t`.
    // The ball is at rest at (3, 2) relative to the middle.
    let blade = TriangleMesh::cuboid(&Vector::new(10.0, 9.9, 9.0), &Vector::new(14.0, 10.0, 11.0));
    let kind = MotionKind::Rotation { point: Vector::repeat(10.0), axis: Vector::z(), frequency: 0.1 };
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let scene = SceneBuilder::new("blade")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .surface(mesh("blade", blade).motion(moving(ALWAYS, kind)))
        .particle("A", Vector::new(13.0, 12.0, 10.0), Vector::zeros());
    let found = contacts(scene.build().unwrap(), 1);
    // At the contact, the angle of the blade is the angle of the ball minus the angle that the ball's radius subtends.
    let angle = libm::atan2(2.0, 3.0) - libm::asin(0.25 / 13.0_f64.sqrt());
    let rate = TAU * 0.1;
    assert!((found[0].time - angle / rate).abs() < 1e-13, "{} {}", found[0].time, angle / rate);
    let normal = Vector::new(-libm::sin(angle), libm::cos(angle), 0.0);
    assert!((found[0].normal - normal).norm() < 1e-13, "{}", found[0].normal);
    // The contact is `sqrt(13 - 1/16)` away from the axis. The ball leaves at twice the speed of the blade there.
    let speed = 2.0 * rate * (13.0_f64 - 0.0625).sqrt();
    assert!((found[0].after[0] - normal * speed).norm() < 1e-13, "{}", found[0].after[0]);
}

#[test]
fn turning_blade_does_not_hit_beyond_its_end() {
    // The ball is farther from the axis than the end of the blade. Only the planes of the faces pass through the ball.
    let blade = TriangleMesh::cuboid(&Vector::new(10.0, 9.9, 9.0), &Vector::new(12.0, 10.0, 11.0));
    let kind = MotionKind::Rotation { point: Vector::repeat(10.0), axis: Vector::z(), frequency: 0.1 };
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let scene = SceneBuilder::new("blade")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .surface(mesh("blade", blade).motion(moving((0.0, 100.0), kind)))
        .particle("A", Vector::new(12.0, 12.0, 10.0), Vector::zeros());
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    simulation.advance(Until::time(100.0)).unwrap();
    assert_eq!(simulation.event_counts().wall, 0);
}

/// Distance between a position and the nearest plane of the faces of a convex mesh. Negative outside the mesh.
fn depth(mesh: &TriangleMesh, place: &Vector) -> f64 {
    let height = |[a, b, c]: [Vector; 3]| (b - a).cross(&(c - a)).normalize().dot(&(a - place));
    mesh.all_corners().map(height).fold(f64::INFINITY, f64::min)
}

#[test]
fn nothing_leaves_a_closed_box_that_turns_or_shakes() {
    let cuboid = TriangleMesh::cuboid(&Vector::new(6.1, 6.3, 6.7), &Vector::new(13.9, 14.2, 14.8));
    let axis = Vector::new(1.0, 0.4, -0.3);
    let turns = MotionKind::Rotation { point: Vector::new(9.5, 10.2, 10.4), axis, frequency: 0.21 };
    let shakes = MotionKind::Oscillation { amplitude: Vector::new(0.2, -0.1, 0.3), frequency: 2.3, phase: 0.2 };
    let stops = [moving((0.5, 3.5), turns), moving((4.0, 9.0), shakes), moving((9.0, 11.0), turns)];
    for motions in [&[moving(ALWAYS, turns)][..], &[moving(ALWAYS, shakes)], &stops] {
        for (gravity, restitution) in [(0.0, 1.0), (0.7, 0.9), (0.7, 0.3)] {
            let mut draft = mesh("box", cuboid.clone()).restitution(restitution);
            draft = motions.iter().fold(draft, |draft, motion| draft.motion(*motion));
            let scene = gas(20, 4.0, gravity).contact_time(1e-3).surface(draft).build().unwrap();
            let timeline = crate::model::surface_motion::Timeline::of(motions);
            let mut simulation = Simulation::without_plan(scene);
            let before = simulation.energy();
            for step in 1..=24 {
                simulation.advance(Until::time(0.5 * f64::from(step))).unwrap();
                let pose = timeline.at(simulation.time()).pose;
                let snapshot = simulation.snapshot();
                for (k, place) in snapshot.positions.iter().enumerate() {
                    let radius = if k % 3 == 0 { 0.4 } else { 0.25 };
                    let room = depth(&cuboid, &pose.place_of_shape(place)) - radius;
                    assert!(room > -1e-12, "{motions:?} {gravity} {restitution}: particle {k} at {room}");
                }
                assert_eq!(simulation.real_overlaps(), []);
            }
            let (after, counts) = (simulation.energy(), simulation.event_counts());
            assert!(counts.wall > 200, "{}", counts.wall);
            assert_eq!(counts.in_invalid_state, 0);
            let change = after.kinetic + after.potential - before.kinetic - before.potential;
            let off = change + counts.dissipated.total() - counts.supplied.total();
            assert!(off.abs() < 1e-10 * (after.kinetic + before.kinetic), "{off}");
        }
    }
}
