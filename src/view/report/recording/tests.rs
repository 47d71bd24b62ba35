use super::*;
use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::base::numbers::trunc_to_u8;
use crate::model::potential::Potential;
use crate::model::space::Space;
use crate::model::{ParticleId, SpeciesId};
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use crate::trajectory::extended_xyz::write_frame;
use crate::trajectory::frame::{FrameSpecies, SPINS};

/// Returns a frame with `count` moving grains and a static pivot. The first grain is bonded to the pivot.
pub(super) fn frame(time: f64, count: u32) -> Frame {
    let place = |k: u32, factor: f64| (f64::from(k) * factor + time).rem_euclid(1.0);
    let grain = |k: u32| FrameParticle {
        id: ParticleId(k),
        species: SpeciesId(0),
        // Every second grain is shifted by one period, which does not change its position in the box.
        position: Vector::new(
            10.0 * place(k, 0.618) + 10.0 * f64::from(k % 2),
            4.0 * place(k, 0.414),
            -2.0 * place(k, 0.732),
        ),
        velocity: Vector::new(f64::from(k), 0.0, 0.0),
        radius: 0.5,
    };
    let pivot = FrameParticle {
        id: ParticleId(count),
        species: SpeciesId(1),
        position: Vector::new(1.0, 2.0, -1.0),
        velocity: Vector::zeros(),
        radius: 0.25,
    };
    let species = |name: &str, is_static| FrameSpecies { name: name.to_owned(), is_static, mass: None };
    Frame {
        time,
        lower: Vector::new(0.0, 0.0, -2.0),
        size: Vector::new(10.0, 4.0, 2.0),
        periodic: [true, false, false],
        species: vec![species("grain", false), species("pivot", true)],
        particles: (0..count).map(grain).chain([pivot]).collect(),
        bonds: vec![[ParticleId(0), ParticleId(count)]],
        ..Frame::default()
    }
}

fn text(frames: &[Frame]) -> Vec<u8> {
    let mut text = Vec::new();
    frames.iter().for_each(|frame| write_frame(&mut text, frame).unwrap());
    text
}

/// Decodes the position of a particle as the player does.
fn decoded(recording: &Recording, frame: usize, particle: usize) -> [f64; 3] {
    let bytes = &recording.frames[frame];
    let [lower, size] = recording.head.frames[frame].field;
    [0, 1, 2].map(|k| {
        let at = 6 * particle + 2 * k;
        lower[k] + f64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]])) / 65_534.0 * size[k]
    })
}

#[test]
fn positions_and_speeds_are_recorded_within_quantisation_step() {
    let frames: Vec<Frame> = (0..4).map(|k| frame(0.1 * f64::from(k), 51)).collect();
    let recording = read(text(&frames).as_slice(), None).unwrap();
    let head = &recording.head;
    assert_eq!((head.moving, head.fixed, head.bonds, head.frames_in_file), (51, 1, 1, 4));
    assert_eq!(recording.notes, [""; 0]);
    for (index, frame) in frames.iter().enumerate() {
        assert_eq!(head.frames[index].time, frame.time);
        for (particle, expected) in frame.particles.iter().take(51).enumerate() {
            let found = decoded(&recording, index, particle);
            for (k, found) in found.into_iter().enumerate() {
                let expected = if k == 0 { expected.position.x % 10.0 } else { expected.position[k] };
                let bound = head.frames[index].field[1][k] / 131_068.0 * (1.0 + 1e-9);
                assert!((found - expected).abs() <= bound, "{k}: {found} but {expected}");
                assert!((frame.lower[k]..=frame.lower[k] + frame.size[k]).contains(&found));
            }
            // The coordinates take 3 * 2 * 51 = 306 bytes, and are padded to 308 bytes.
            let [low, high] = head.frames[index].ranges[0];
            let speed = low + f64::from(recording.frames[index][308 + particle]) / 255.0 * (high - low);
            assert!((speed - expected.velocity.norm()).abs() <= 0.5 * 50.0 / 255.0 + 1e-9);
        }
        assert_eq!(recording.frames[index].len(), 308 + 51 + 7);
    }
    // The constants are 52 radii, the position of the pivot, the two ends and the radius of the bond, and 52 species.
    assert_eq!(recording.constants.len(), 4 * 52 + 12 + 8 + 4 + 52);
    let float = |at: usize| f32::from_le_bytes(recording.constants[at..at + 4].try_into().unwrap());
    assert_eq!([0, 204, 208, 212, 216].map(float), [0.5, 0.25, 1.0, 2.0, -1.0]);
    assert_eq!(recording.constants[220..228], [0, 0, 0, 0, 51, 0, 0, 0]);
    assert_eq!(float(228), 0.09, "0.36 of the smaller radius");
    assert_eq!(recording.constants[232 + 50..], [0, 1]);
}

#[test]
fn particles_far_outside_are_omitted_and_counted() {
    let mut open = frame(0.0, 4);
    open.particles[1].position.y = 15.9;
    open.particles[2].position.y = 1e9;
    let recording = read(text(&[open]).as_slice(), None).unwrap();
    let head = &recording.head.frames[0];
    assert_eq!(head.beyond, 1);
    assert!((head.field[0][1] + head.field[1][1] - 15.9).abs() < 1e-12, "less than three edges beyond");
    assert_eq!(recording.frames[0][12..18], [255; 6]);
    assert!((decoded(&recording, 0, 1)[1] - 15.9).abs() < 1e-3);
}

#[test]
fn long_trajectories_are_thinned_evenly_and_end_with_the_last_frame() {
    let frames: Vec<Frame> = (0..4_323).map(|k| frame(f64::from(k), 1)).collect();
    let recording = read(text(&frames).as_slice(), None).unwrap();
    let times: Vec<f64> = recording.head.frames.iter().map(|frame| frame.time).collect();
    assert_eq!(recording.head.frames_in_file, 4_323);
    assert!(times.len() <= MOST_FRAMES && times.len() > MOST_FRAMES / 3, "{}", times.len());
    assert_eq!((times[0], times[times.len() - 1]), (0.0, 4_322.0));
    assert!(times[..times.len() - 1].windows(2).all(|two| two[1] - two[0] == 4.0));
}

#[test]
fn damaged_trajectory_is_reported_and_earlier_frames_kept() {
    let whole = text(&[frame(0.0, 3), frame(1.0, 3)]);
    assert!(read(&b""[..], None).unwrap_err().contains("no frame"));
    assert!(read(&b"three\n"[..], None).unwrap_err().contains("line 1"));
    assert!(read(&b"0\n\n"[..], None).unwrap_err().contains("no particles"));
    let recording = read(&whole[..whole.len() - 9], None).unwrap();
    assert_eq!(recording.frames.len(), 1);
    assert!(recording.notes[0].contains("cut off"), "{:?}", recording.notes);
    let other = read(text(&[frame(0.0, 3), frame(1.0, 4)]).as_slice(), None).unwrap();
    assert_eq!(other.frames.len(), 1);
    assert!(other.notes[0].contains("frame 2"), "{:?}", other.notes);
}

#[test]
fn channels_depend_on_potential_and_gravity() {
    let names = |recording: &Recording| -> Vec<String> {
        recording.head.channels.iter().map(|channel| channel.name.clone()).collect()
    };
    let scene = |potential, gravity| {
        SceneBuilder::new("s")
            .space(Space::periodic_cube(8.0))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(potential).between("A", "A"))
            .gravity(Vector::new(0.0, gravity, 0.0))
            .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
            .build()
            .unwrap()
    };
    for (potential, gravity, expected) in [
        (Potential::hard_sphere(1.0), 0.0, &["speed"][..]),
        (Potential::hard_sphere(1.0), 2.0, &["speed", "height"]),
        (Potential::square_well(1.0, 1.5, 1.0), 0.0, &["speed", "neighbours within a well"]),
    ] {
        let scene = scene(potential.unwrap(), gravity);
        let recording = read(text(&[Frame::start_of(&scene)]).as_slice(), Some(&scene)).unwrap();
        assert_eq!(names(&recording), expected);
        let up = if gravity > 0.0 { (1, true) } else { (2, false) };
        assert_eq!((recording.head.up, recording.head.is_upside_down), up, "gravity along +y points down");
    }
}

#[test]
fn particle_scalars_become_colour_channels() {
    let mut frames = [frame(0.0, 3), frame(1.0, 3)];
    for (frame, shift) in frames.iter_mut().zip([0.0, 0.25]) {
        // The pivot is static, so its value is not recorded.
        let values = vec![0.125 + shift, 0.25 + shift, 0.375 + shift, 9.0];
        frame.scalars = vec![Scalar { name: "q6".into(), values }];
    }
    let recording = read(text(&frames).as_slice(), None).unwrap();
    let head = &recording.head.channels[1];
    assert_eq!((head.name.as_str(), head.low, head.high, head.is_exceeded), ("q6", 0.125, 0.625, false));
    assert_eq!(recording.head.frames[1].ranges[1], [0.375, 0.625]);
    assert_eq!(recording.frames[1][20 + 3..20 + 6], [0, 128, 255]);
}

#[test]
fn spins_give_a_colour_and_orientations() {
    let mut frames = [frame(0.0, 3), frame(1.0, 3)];
    for frame in &mut frames {
        let spins = [vec![3.0, 0.0, 0.0, 9.0], vec![4.0, 0.0, 0.0, 9.0], vec![0.0, 0.0, 1.25, 9.0]];
        frame.scalars = SPINS.iter().zip(spins).map(|(name, values)| Scalar::new(name, values)).collect();
        frame.scalars.push(Scalar::new("contact_pressure", vec![1.0, 2.0, 3.0, 0.0]));
    }
    let recording = read(text(&frames).as_slice(), None).unwrap();
    let names: Vec<&str> = recording.head.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["speed", "spin", "contact_pressure"]);
    assert!(recording.head.has_turns);
    let pressure = &recording.head.channels[2];
    assert_eq!((&*pressure.unit, pressure.low, pressure.high), ("energy / length^D", 0.0, 3.0));
    assert_eq!(recording.head.frames[1].ranges[1], [0.0, 5.0]);
    // 20 bytes of coordinates, then orientations. The third grain has turned by 1.25 about z.
    assert_eq!(recording.frames[0].len(), 20 + 12 + 9 + 1);
    let turned = [0.625_f64.sin(), 0.625_f64.cos()].map(|part| trunc_to_u8((127.0 * part).round()));
    assert_eq!(recording.frames[1][20 + 8..20 + 12], [0, 0, turned[0], turned[1]]);
    assert_eq!(recording.frames[1][32 + 3..32 + 6], [255, 0, 64]);
    let plain = read(text(&[frame(0.0, 3)]).as_slice(), None).unwrap();
    assert!(!plain.head.has_turns && plain.frames[0].len() == 20 + 3 + 1);
}

#[test]
fn well_neighbours_match_brute_force() {
    let slid = [(4.0, 108, 1.7), (6.0, 108, -2.9), (12.0, 500, 5.1)];
    for (edge, count, displacement) in [(4.0, 108, 0.0), (6.0, 108, 0.0), (12.0, 500, 0.0)].into_iter().chain(slid) {
        // Some pairs have wells, with two different ranges.
        let well = |factor| Potential::square_well(0.5, factor, 1.0).unwrap();
        let mut fill = Fill::new(Lattice::FaceCentredCubic, "A");
        fill.composition.push(("B".to_owned(), 1.0));
        let density = count as f64 / f64::powi(edge, 3);
        let scene = SceneBuilder::new("well")
            .seed(3)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
            .species(SpeciesDraft::new("B").mass(1.0).diameter(0.5))
            .interaction(InteractionDraft::new(well(3.0)).between("A", "A"))
            .interaction(InteractionDraft::new(well(2.4)).between("A", "B"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
            .fill(fill.count(count).number_density(density))
            .build()
            .unwrap();
        let mut frame = Frame::start_of(&scene);
        assert!((frame.size.x - edge).abs() < 1e-9);
        let edge = frame.size.x;
        // Moves the particles off the lattice, and some of them out of the box.
        for (index, particle) in (0_u32..).zip(&mut frame.particles) {
            let shift = |factor: f64| (f64::from(index) * factor).fract() * edge;
            particle.position += Vector::new(shift(0.618), shift(0.414), shift(0.732));
        }
        frame.displacement = displacement;
        let near = |a: &FrameParticle, b: &FrameParticle| {
            let range = [[1.5, 1.2], [1.2, 0.0]][a.species.0 as usize][b.species.0 as usize];
            let apart = a.position - b.position;
            let nearest = |x: f64| x.rem_euclid(edge).min(edge - x.rem_euclid(edge));
            // Tries all images along y, each displaced along x.
            let is_near = (-2..=2).map(f64::from).any(|up| {
                let (x, y) = (nearest(apart.x + up * displacement), apart.y + up * edge);
                x * x + y * y + nearest(apart.z).powi(2) < range * range
            });
            a.id != b.id && is_near
        };
        let all = &frame.particles;
        let mut expected: Vec<f64> = all.iter().map(|a| all.iter().filter(|b| near(a, b)).count() as f64).collect();
        assert!(expected.iter().sum::<f64>() > 100.0);
        // Bonded particles are not counted as neighbours.
        let one = expected.iter().position(|count| *count > 0.0).unwrap();
        let other = all.iter().position(|b| near(&all[one], b)).unwrap();
        frame.bonds = vec![[all[other].id, all[one].id]];
        (expected[one], expected[other]) = (expected[one] - 1.0, expected[other] - 1.0);
        let found = neighbours::WellNeighbours::of(&scene, &frame).unwrap().count(&frame);
        assert_eq!(found, expected);
    }
}

#[test]
fn the_view_of_an_unbounded_system_contains_the_particles_of_all_frames() {
    let at = |time: f64, x: f64| {
        let mut frame = frame(time, 1);
        (frame.lower, frame.size, frame.periodic) = (Vector::zeros(), Vector::zeros(), [false; 3]);
        frame.particles.truncate(1);
        frame.bonds.clear();
        frame.particles[0].position = Vector::new(x, 0.0, 0.0);
        frame
    };
    // The two fields do not overlap.
    let recording = read(text(&[at(0.0, -3.0), at(1.0, 50.0)]).as_slice(), None).unwrap();
    let [lower, upper] = recording.head.view;
    assert!(lower[0] <= -3.0 && upper[0] >= 50.0, "{lower:?} {upper:?}");
}
