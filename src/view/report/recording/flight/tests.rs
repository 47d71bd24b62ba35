use super::super::{Recording, read};
use super::*;
use crate::engine::{Simulation, Until};
use crate::model::space::{Boundary, Space};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use crate::trajectory::extended_xyz::write_frame;

fn frames(scene: &Scene, times: &[f64]) -> Vec<Frame> {
    let mut simulation = Simulation::without_plan(scene.clone());
    let at = |time: &f64| {
        simulation.advance(Until::time(*time)).unwrap();
        let mut frame = Frame::start_of(scene);
        (frame.time, frame.displacement) = (*time, simulation.displacement());
        let noted: Result<(), ()> = simulation.for_each_now(|now| {
            let particle = &mut frame.particles[now.id.0 as usize];
            (particle.position, particle.velocity) = (now.position, now.velocity);
            Ok(())
        });
        assert_eq!(noted, Ok(()));
        frame
    };
    times.iter().map(at).collect()
}

fn recorded(frames: &[Frame], scene: &Scene) -> Recording {
    let mut text = Vec::new();
    frames.iter().for_each(|frame| write_frame(&mut text, frame).unwrap());
    read(text.as_slice(), Some(scene)).unwrap()
}

/// Returns whether each particle flies freely from each frame to the next.
fn flights(recording: &Recording) -> Vec<Vec<bool>> {
    let moving = recording.head.moving;
    let of = |bytes: &Vec<u8>| {
        let bits = &bytes[bytes.len() - moving.div_ceil(8)..];
        (0..moving).map(|k| bits[k / 8] >> (k % 8) & 1 == 1).collect()
    };
    let mut all: Vec<_> = recording.frames.iter().map(of).collect();
    assert_eq!(all.pop(), Some(vec![false; moving]), "nothing follows the last frame");
    all
}

fn balls(boundary: [Boundary; 3]) -> SceneBuilder {
    SceneBuilder::new("balls")
        .space(Space { lower: Vector::zeros(), size: Vector::repeat(10.0), boundary })
        .species(SpeciesDraft::new("ball").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "ball"))
}

const OPEN: [Boundary; 3] = [Boundary::OPEN; 3];
const PERIODIC: [Boundary; 3] = [Boundary::Periodic; 3];

#[test]
fn balls_that_collide_between_frames_do_not_fly_freely() {
    // The first two balls collide at t = 1.5.
    let scene = balls(OPEN)
        .particle("ball", Vector::new(2.0, 5.0, 5.0), Vector::x())
        .particle("ball", Vector::new(6.0, 5.0, 5.0), -Vector::x())
        .particle("ball", Vector::new(5.0, 1.0, 5.0), Vector::new(0.3, 0.7, -0.1))
        .build()
        .unwrap();
    let recording = recorded(&frames(&scene, &[0.0, 0.7, 1.4, 2.1, 2.8]), &scene);
    let collided = vec![false, false, true];
    assert_eq!(flights(&recording), [vec![true; 3], vec![true; 3], collided, vec![true; 3]]);
}

#[test]
fn free_flight_must_match_position_and_velocity() {
    let scene = balls(OPEN).particle("ball", Vector::repeat(5.0), Vector::new(0.7, -0.3, 0.1)).build().unwrap();
    let mut both = frames(&scene, &[0.0, 1.3]);
    assert_eq!(flights(&recorded(&both, &scene)), [[true]]);
    let flown = both[1].clone();
    both[1].particles[0].position.y += 1e-4;
    assert_eq!(flights(&recorded(&both, &scene)), [[false]], "as fast as before, and elsewhere");
    both[1] = flown;
    both[1].particles[0].velocity = Vector::new(0.7, 0.3, 0.1);
    assert_eq!(flights(&recorded(&both, &scene)), [[false]], "there, and with another velocity");
}

#[test]
fn collision_at_the_very_end_of_an_interval_is_detected() {
    for (time, expected) in [(1.5 - 1e-5, true), (1.5 + 1e-5, false)] {
        let scene = balls(OPEN)
            .particle("ball", Vector::new(2.0, 5.0, 5.0), Vector::x())
            .particle("ball", Vector::new(6.0, 5.0, 5.0), -Vector::x())
            .build()
            .unwrap();
        assert_eq!(flights(&recorded(&frames(&scene, &[0.0, time]), &scene)), [[expected; 2]], "{time}");
    }
}

#[test]
fn parabolas_are_free_flights_until_the_floor() {
    let scene = balls([Boundary::OPEN, Boundary::OPEN, Boundary::walls(0.5)])
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .particle("ball", Vector::new(2.0, 5.0, 2.5), Vector::new(0.5, 0.0, 0.0))
        .particle("ball", Vector::new(6.0, 5.0, 8.5), Vector::zeros())
        .build()
        .unwrap();
    // The first ball reaches the floor at t = 2.
    let frames = frames(&scene, &[0.0, 0.9, 1.9, 2.9]);
    let recording = recorded(&frames, &scene);
    assert_eq!(recording.head.falls, [[[0.0, 0.0, -1.0]]]);
    assert_eq!(flights(&recording), [[true, true], [true, true], [false, true]]);
    let without = balls(OPEN).particle("ball", Vector::repeat(5.0), Vector::zeros()).build().unwrap();
    assert_eq!(flights(&recorded(&frames, &without)), [[false; 2]; 3], "without gravity nothing falls");
}

#[test]
fn gravity_of_a_stage_bends_flights() {
    let mut parts = balls(OPEN)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .particle("ball", Vector::repeat(5.0), Vector::zeros())
        .build()
        .unwrap()
        .into_parts();
    parts.run.gravity = Some(Vector::new(0.0, 0.5, 0.0));
    let scene = Scene::of_parts(parts);
    let mut frames = vec![Frame::start_of(&scene); 3];
    for (frame, (time, y, z, v)) in frames.iter_mut().zip([
        (0.0, 5.0, 5.0, [0.0, 0.0]),
        (1.0, 5.0, 4.5, [0.0, -1.0]),
        (2.0, 5.25, 3.5, [0.5, -1.0]),
    ]) {
        frame.time = time;
        frame.particles[0].position = Vector::new(5.0, y, z);
        frame.particles[0].velocity = Vector::new(0.0, v[0], v[1]);
    }
    let recording = recorded(&frames, &scene);
    assert_eq!(flights(&recording), [[true]; 2]);
    assert_eq!(recording.head.falls, [[[0.0, 0.0, -1.0]], [[0.0, 0.5, 0.0]]]);
    assert_eq!(recording.head.frames.iter().map(|frame| frame.fall).collect::<Vec<_>>(), [0, 1, 0]);
}

#[test]
fn flights_cross_periodic_sides_up_to_half_a_period() {
    let scene = balls(PERIODIC)
        .particle("ball", Vector::new(9.0, 1.0, 5.0), Vector::new(2.0, -1.0, 0.25))
        .particle("ball", Vector::new(5.0, 5.0, 1.0), Vector::new(4.9, 0.0, 0.0))
        .build()
        .unwrap();
    let recording = recorded(&frames(&scene, &[0.0, 0.9, 1.9]), &scene);
    assert_eq!(
        flights(&recording),
        [[true, true], [true, false]],
        "0.9 * 4.9 are less than half of 10, 4.9 are nearly that"
    );
}

#[test]
fn flights_through_sliding_sides_are_straight_in_the_laboratory() {
    let scene = balls(PERIODIC)
        .shear(0.2)
        .particle("ball", Vector::new(5.0, 9.5, 5.0), Vector::new(0.1, 1.0, 0.3))
        .particle("ball", Vector::new(2.0, 0.5, 2.0), Vector::new(0.1, -1.0, 0.0))
        .particle("ball", Vector::new(2.0, 5.0, 8.0), Vector::new(0.1, 0.2, 0.0))
        .build()
        .unwrap();
    let frames = frames(&scene, &[0.0, 0.3, 1.3, 2.1]);
    assert!((frames[1].particles[0].velocity.x - frames[2].particles[0].velocity.x - 2.0).abs() < 1e-12);
    let recording = recorded(&frames, &scene);
    assert_eq!(recording.head.slide, 2.0);
    assert_eq!(flights(&recording), [[true; 3]; 3]);
}

#[test]
fn flights_are_joined_where_frames_are_left_out() {
    let flights = |fall, ways: &[u8]| Flights { fall, ways: ways.to_vec() };
    let first = flights(0, &[1, 0, 3, 200, 5]);
    assert_eq!(first.clone().then(&flights(0, &[2, 4, 0, 41, 6])), flights(0, &[3, 0, 0, 0, 11]));
    assert_eq!(first.then(&flights(1, &[1; 5])).count(), 0, "two accelerations are no parabola");
    assert_eq!(flights(0, &[1, 0, 3, 0, 0, 0, 0, 0, 9]).bits().collect::<Vec<_>>(), [0b101, 1]);
}

#[test]
fn collision_in_a_skipped_frame_is_remembered() {
    let scene = balls(OPEN).particle("ball", Vector::repeat(5.0), Vector::x()).build().unwrap();
    // The particle turns back between frames 1500 and 1501. The recording contains only one of them.
    let frames = (0..4_323).map(|index| {
        let mut frame = Frame::start_of(&scene);
        frame.time = f64::from(index);
        let turned = index > 1_500;
        let particle = &mut frame.particles[0];
        particle.velocity = if turned { -Vector::x() } else { Vector::x() };
        particle.position.x = if turned { 1_500.0 - (f64::from(index) - 1_501.0) } else { f64::from(index) };
        frame
    });
    let recording = recorded(&frames.collect::<Vec<_>>(), &scene);
    let flights = flights(&recording);
    let wrong: Vec<f64> = recording
        .head
        .frames
        .iter()
        .zip(&flights)
        .filter(|(_, flight)| !flight[0])
        .map(|(head, _)| head.time)
        .collect();
    assert_eq!(wrong, [1_500.0], "from 1500 to 1504 it is unknown");
}
