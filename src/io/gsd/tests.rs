//! Tests of GSD files with an independent reader that follows the specification.

use std::collections::HashMap;

use crate::Vector;
use crate::base::numbers::index;
use crate::io::convert::tests::{chain, converted, trajectory};
use crate::io::convert::{ConvertError, FrameError, Options, convert};
use crate::model::Format;
use crate::model::{ParticleId, Units};
use crate::trajectory::Frame;

/// Contents of an array: type code, number of rows, number of columns, bytes.
type Chunk = (u8, u64, u32, Vec<u8>);

fn number<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes[at..at + N].try_into().unwrap()
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(number(bytes, at))
}

fn parse(bytes: &[u8]) -> HashMap<(u64, String), Chunk> {
    assert_eq!(u64_at(bytes, 0), 0x65DF65DF65DF65DF);
    let [index_at, index_length, names_at, names_pieces] = [8, 16, 24, 32].map(|at| index(u64_at(bytes, at)));
    assert_eq!(u32::from_le_bytes(number(bytes, 40)), 0x0001_0004, "schema 1.4");
    assert_eq!(u32::from_le_bytes(number(bytes, 44)), 0x0002_0000, "file layer 2.0");
    assert!(bytes[48..112].starts_with(b"carom ") && bytes[111] == 0);
    assert_eq!(&bytes[112..118], b"hoomd\0");
    assert!(bytes[118..256].iter().all(|&byte| byte == 0));
    assert_eq!(index_at + 32 * index_length, bytes.len());
    let list = &bytes[names_at..names_at + 64 * names_pieces];
    assert_eq!(list.last(), Some(&0));
    let names: Vec<String> = list
        .split(|&byte| byte == 0)
        .take_while(|name| !name.is_empty())
        .map(|name| String::from_utf8(name.to_vec()).unwrap())
        .collect();
    let mut last = (0, 0);
    let entries = bytes[index_at..].chunks(32).map(|entry| {
        let (frame, rows, location) = (u64_at(entry, 0), u64_at(entry, 8), index(u64_at(entry, 16)));
        let columns = u32::from_le_bytes(number(entry, 24));
        let name = u16::from_le_bytes(number(entry, 28));
        assert!((frame, name) >= last, "sorted by frame, then by name");
        last = (frame, name);
        assert_eq!(entry[31], 0);
        let size = match entry[30] {
            1 | 5 => 1,
            3 | 7 | 9 => 4,
            4 | 10 => 8,
            kind => panic!("type {kind}"),
        };
        let length = index(rows) * columns as usize * size;
        let data = bytes[location..location + length].to_vec();
        ((frame, names[name as usize].clone()), (entry[30], rows, columns, data))
    });
    entries.collect()
}

fn floats(chunk: &Chunk) -> Vec<f32> {
    assert_eq!(chunk.0, 9);
    chunk.3.chunks(4).map(|bytes| f32::from_le_bytes(number(bytes, 0))).collect()
}

fn doubles(chunk: &Chunk) -> Vec<f64> {
    assert_eq!(chunk.0, 10);
    chunk.3.chunks(8).map(|bytes| f64::from_le_bytes(number(bytes, 0))).collect()
}

fn whole(chunk: &Chunk) -> Vec<u32> {
    assert_eq!(chunk.0, 3);
    chunk.3.chunks(4).map(|bytes| u32::from_le_bytes(number(bytes, 0))).collect()
}

#[test]
fn gsd_frame_has_all_particle_data_and_bonds() {
    let units = Units::new("mm", "g", "ms");
    let chunks = parse(&converted(&[Frame { units, ..chain() }], Format::Gsd));
    let get = |name: &str| &chunks[&(0, name.to_owned())];
    assert_eq!(get("configuration/step"), &(4, 1, 1, vec![0; 8]));
    assert_eq!(get("configuration/dimensions"), &(1, 1, 1, vec![3]));
    assert_eq!(floats(get("configuration/box")), [4.0, 6.0, 10.0, 0.0, 0.0, 0.0]);
    assert_eq!(doubles(get("log/carom/time")), [0.25]);
    assert_eq!(doubles(get("log/carom/centre")), [0.0, 2.0, 5.0]);
    assert_eq!(get("log/carom/periodic"), &(1, 3, 1, vec![1, 0, 1]));
    assert_eq!(get("log/carom/units"), &(5, 3, 3, b"mm\0g\0\0ms\0".to_vec()));
    assert_eq!(whole(get("particles/N")), [4]);
    assert_eq!(get("particles/types"), &(5, 2, 5, b"bead\0bob\0\0".to_vec()));
    assert_eq!(whole(get("particles/typeid")), [0, 1, 0, 0]);
    assert_eq!(floats(get("particles/diameter")), [1.0, 1.5, 1.0, 1.0]);
    assert_eq!(floats(get("particles/mass")), [2.5, 0.0, 2.5, 2.5]);
    let positions: Vec<f32> = (0..4).flat_map(|id| [id as f32 - 1.5, -1.9, -3.0]).collect();
    assert_eq!((get("particles/position").1, get("particles/position").2), (4, 3));
    assert_eq!(floats(get("particles/position")), positions);
    assert_eq!(floats(get("particles/velocity"))[..4], [1.0, 0.3, -2e-9, 0.0]);
    assert_eq!(whole(get("bonds/N")), [4]);
    assert_eq!(get("bonds/types"), &(5, 1, 5, b"bond\0".to_vec()));
    assert_eq!((get("bonds/group").1, get("bonds/group").2), (4, 2));
    assert_eq!(whole(get("bonds/group")), [0, 1, 2, 1, 2, 3, 3, 0]);
}

#[test]
fn a_sheared_box_is_tilted_and_holds_its_particles() {
    let mut frame = Frame { displacement: -1.5, ..chain() };
    frame.periodic[1] = true;
    // The centre of the box is at (0, 2, 5), and the height of the box along y is 6. At y = 4.9, the tilted box is
    // shifted along x by -1.5 * 2.9 / 6 = -0.725, and extends from -2.725 to 1.275.
    for (particle, x) in frame.particles.iter_mut().zip([-1.9, 1.2, 1.3, 1.9]) {
        particle.position = Vector::new(x, 4.9, 5.0);
    }
    frame.images = vec![[0, 1, 0], [3, 0, 0], [3, 0, 0], [-1, 0, 2]];
    let chunks = parse(&converted(&[frame], Format::Gsd));
    let get = |name: &str| floats(&chunks[&(0, name.to_owned())]);
    assert_eq!(get("configuration/box"), [4.0, 6.0, 10.0, -0.25, 0.0, 0.0]);
    let x: Vec<f32> = get("particles/position").into_iter().step_by(3).collect();
    assert_eq!(x, [-1.9, 1.2, -2.7, -2.1]);
    // A particle that is shifted back by one period has an image number larger by 1.
    let image = &chunks[&(0, "particles/image".to_owned())];
    let expected: Vec<u8> = [0, 1, 0, 3, 0, 0, 4, 0, 0, 0, 0, 2_i32].into_iter().flat_map(i32::to_le_bytes).collect();
    assert_eq!(image, &(7, 4, 3, expected));
}

#[test]
fn image_counts_beyond_32_bits_are_rejected() {
    let mut frame = Frame { displacement: -1.5, ..chain() };
    frame.periodic[1] = true;
    // At y = 4.9, the tilted box ends at x = 1.275, so one period is subtracted from x = 1.3.
    frame.particles[0].position = Vector::new(1.3, 4.9, 5.0);
    frame.images = vec![[i32::MAX - 1, 0, 0], [0; 3], [0; 3], [0; 3]];
    let chunks = parse(&converted(&[frame.clone()], Format::Gsd));
    let image = &chunks[&(0, "particles/image".to_owned())];
    assert_eq!(image.3[..4], i32::MAX.to_le_bytes());
    frame.images[0][0] = i32::MAX;
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("a.gsd"));
    trajectory(&source, &[frame]);
    let error = convert(&source, Format::Gsd, &target, &Options::default()).unwrap_err();
    let ConvertError::Frame { source: error, .. } = error else { panic!("{error}") };
    assert!(matches!(error, FrameError::BeyondPeriods(2147483648.0)), "{error}");
}

#[test]
fn later_frames_store_only_changes() {
    let mut second = Frame { time: 1.5, ..chain() };
    second.particles[2].radius = 2.0;
    let chunks = parse(&converted(&[chain(), second, Frame { bonds: Vec::new(), ..chain() }], Format::Gsd));
    let names = |frame| {
        let mut names: Vec<&str> =
            chunks.keys().filter(|(at, _)| *at == frame).map(|(_, name)| name.as_str()).collect();
        names.sort_unstable();
        names
    };
    let always = ["configuration/step", "log/carom/time", "particles/position", "particles/velocity"];
    assert_eq!(names(1), [&always[..2], &["particles/diameter"], &always[2..]].concat());
    assert_eq!(names(2), [&["bonds/N"], &always[..]].concat());
    assert_eq!(whole(&chunks[&(2, "bonds/N".to_owned())]), [0]);
    assert_eq!(chunks[&(1, "configuration/step".to_owned())].3, 1_u64.to_le_bytes());
}

#[test]
fn particles_are_in_the_order_of_their_ids_and_bonds_follow() {
    let mut frame = chain();
    frame.particles.reverse();
    let reversed = converted(&[frame], Format::Gsd);
    assert_eq!(reversed, converted(&[chain()], Format::Gsd));
    // Bonds refer to particles by index, even if the ids have gaps.
    let mut frame = chain();
    for particle in &mut frame.particles {
        particle.id.0 = particle.id.0 * 10 + 5;
    }
    frame.bonds = vec![[ParticleId(35), ParticleId(15)]];
    let chunks = parse(&converted(&[frame], Format::Gsd));
    assert_eq!(whole(&chunks[&(0, "bonds/group".to_owned())]), [3, 1]);
}

#[test]
fn plane_is_two_dimensional_and_line_has_a_thickness() {
    let flat = |axes: &[usize]| {
        let mut frame = chain();
        for &axis in axes {
            frame.size[axis] = 0.0;
            frame.periodic[axis] = false;
        }
        let chunks = parse(&converted(&[frame], Format::Gsd));
        let dimensions = chunks[&(0, "configuration/dimensions".to_owned())].3[0];
        (dimensions, floats(&chunks[&(0, "configuration/box".to_owned())])[..3].to_vec())
    };
    assert_eq!(flat(&[2]), (2, vec![4.0, 6.0, 0.0]));
    assert_eq!(flat(&[1]), (3, vec![4.0, 1.5, 10.0]));
    assert_eq!(flat(&[1, 2]), (3, vec![4.0, 1.5, 1.5]));
}

#[test]
fn velocities_of_the_first_frame_are_not_taken_for_those_of_a_later_one() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("a.gsd"));
    let with = "1\nProperties=pos:R:3:velo:R:3\n0 0 0 1 2 3\n";
    let without = "1\nProperties=pos:R:3\n0 0 0\n";
    for (text, expected) in [
        (format!("{with}{without}"), [Some(vec![1.0, 2.0, 3.0]), Some(vec![0.0; 3])]),
        (format!("{without}{with}"), [None, Some(vec![1.0, 2.0, 3.0])]),
    ] {
        std::fs::write(&source, text).unwrap();
        let options = crate::io::convert::Options { replace: true, ..Default::default() };
        crate::io::convert::convert(&source, Format::Gsd, &target, &options).unwrap();
        let chunks = parse(&std::fs::read(&target).unwrap());
        for (frame, expected) in (0..).zip(expected) {
            assert_eq!(chunks.get(&(frame, "particles/velocity".to_owned())).map(floats), expected);
            assert!(!chunks.contains_key(&(frame, "particles/mass".to_owned())));
        }
    }
}

#[test]
fn frame_without_particles_is_written() {
    let empty = Frame { particles: Vec::new(), bonds: Vec::new(), lower: Vector::zeros(), ..chain() };
    let chunks = parse(&converted(&[empty], Format::Gsd));
    assert_eq!(whole(&chunks[&(0, "particles/N".to_owned())]), [0]);
    assert!(!chunks.contains_key(&(0, "particles/position".to_owned())));
}
