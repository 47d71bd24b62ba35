use super::*;
use crate::engine::{Simulation, Until};
use crate::io::convert::tests::converted;
use crate::model::Format;
use crate::model::space::Space;
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use crate::trajectory::extended_xyz::{FrameReader, write_frame};

/// Simulates a dilute gas in a periodic box. Returns its frames, and unwrapped positions as sums of displacements
/// between frames. A displacement is much shorter than the box, so its nearest image is the true displacement.
fn flown(shear_rate: Option<f64>) -> (Vec<Frame>, Vec<Vec<Vector>>) {
    let space = Space { size: Vector::new(5.0, 4.5, 4.0), ..Space::periodic_cube(1.0) };
    let gas = SceneBuilder::new("gas")
        .species(SpeciesDraft::new("ball").mass(0.7).diameter(0.5))
        // Shear heats the gas. Inelastic contacts remove the heat.
        .interaction(
            InteractionDraft::new(Model::HardSphere).between("ball", "ball").restitution(if shear_rate.is_some() {
                0.6
            } else {
                1.0
            }),
        )
        .space(Space { lower: Vector::new(-1.0, 2.0, 0.0), ..space })
        .fill(Fill::new(Lattice::SimpleCubic, "ball").count(27))
        .temperature(1.0);
    let gas = if let Some(rate) = shear_rate { gas.shear(rate) } else { gas };
    let scene = gas.build().unwrap();
    let mut frame = Frame::start_of(&scene);
    let mut simulation = Simulation::without_plan(scene);
    let (mut frames, mut followed) = (Vec::new(), Vec::new());
    for step in 0..600 {
        simulation.advance(Until::time(0.1 * f64::from(step))).unwrap();
        let snapshot = simulation.snapshot();
        let before = frame.clone();
        (frame.time, frame.displacement) = (snapshot.time, snapshot.displacement);
        frame.images = snapshot.images;
        for (particle, position) in frame.particles.iter_mut().zip(snapshot.positions) {
            particle.position = position;
        }
        let last: Option<&Vec<Vector>> = followed.last();
        let now: Vec<Vector> = match last {
            None => frame.particles.iter().map(|particle| particle.position).collect(),
            Some(last) => (0..27)
                .map(|k| {
                    let (from, to) = (before.particles[k].position, frame.particles[k].position);
                    // The particle is `boxes_up` boxes above the central box. Images at this height slide along x.
                    let boxes_up = ((last[k].y - from.y) / frame.size.y).round();
                    let slid = boxes_up * shear_rate.unwrap_or(0.0) * frame.size.y * (frame.time - before.time);
                    last[k] + frame.nearest_image(to - from) + Vector::new(slid, 0.0, 0.0)
                })
                .collect(),
        };
        followed.push(now);
        frames.push(frame.clone());
    }
    (frames, followed)
}

/// Mean squared displacement along each axis.
fn squares(positions: &[Vec<Vector>]) -> Vec<Vector> {
    let mean = |now: &Vec<Vector>| {
        let all = now.iter().zip(&positions[0]).map(|(now, then)| (now - then).component_mul(&(now - then)));
        all.sum::<Vector>() / now.len() as f64
    };
    positions.iter().map(mean).collect()
}

fn unwrapped(frames: &[Frame]) -> Vec<Vec<Vector>> {
    frames.iter().map(|frame| (0..frame.particles.len()).map(|place| frame.unwrapped(place)).collect()).collect()
}

fn columns(table: &str, first: usize) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split(',').skip(first).map(|word| word.parse().unwrap()).collect();
    table.lines().skip(1).map(row).collect()
}

#[test]
fn unwrapped_positions_match_the_followed_trajectories() {
    // At a shear rate of 0.5, the images slide by 27 periods in the simulated time.
    for rate in [None, Some(0.5), Some(-0.3)] {
        let (frames, followed) = flown(rate);
        let most = [0, 1, 2].map(|axis| frames[599].images.iter().map(|image| image[axis].abs()).max());
        assert!(most.iter().all(|most| *most > Some(1)), "{rate:?}: they fly round the box, {most:?}");
        let mut text = Vec::new();
        frames.iter().for_each(|frame| write_frame(&mut text, frame).unwrap());
        let read: Vec<Frame> = FrameReader::new(text.as_slice()).map(Result::unwrap).collect();
        assert_eq!(read, frames);
        let table = String::from_utf8(converted(&frames, Format::Csv)).unwrap();
        let table: Vec<Vec<Vector>> = columns(&table, 4)
            .chunks(27)
            .zip(&frames)
            .map(|(rows, frame)| {
                let edges =
                    [[frame.size.x, 0.0, 0.0], [frame.displacement, frame.size.y, 0.0], [0.0, 0.0, frame.size.z]];
                let place = |row: &Vec<f64>| {
                    let travelled = edges.iter().zip(&row[7..]).map(|(edge, image)| Vector::from(*edge) * *image);
                    Vector::new(row[0], row[1], row[2]) + travelled.sum::<Vector>()
                };
                rows.iter().map(place).collect()
            })
            .collect();
        for (name, positions) in [("extended XYZ", unwrapped(&read)), ("CSV", table)] {
            for (k, (found, expected)) in squares(&positions).iter().zip(squares(&followed)).enumerate() {
                // The expected positions are sums of about 600 rounded steps.
                let allowed = 1e-11 * expected.amax().max(1.0);
                assert!((found - expected).amax() <= allowed, "{name}, {rate:?}, frame {k}: {found} {expected}");
            }
        }
    }
}

#[test]
fn position_below_the_box_within_round_off_wraps_into_it() {
    let (frames, _) = flown(None);
    let frame = &frames[0];
    for below in [-1e-20, -1e-300, 0.0, -f64::MIN_POSITIVE] {
        let position = frame.wrapped(&(frame.lower + Vector::new(0.0, 0.0, below)));
        assert_eq!(position.z, frame.lower.z, "{below}");
    }
    let upper = frame.wrapped(&(frame.lower + frame.size));
    assert_eq!(upper, frame.lower);
}
