//! Randomly damaged mesh files yield an error or a mesh, never a panic. `CAROM_MUTATIONS` sets the number of files.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::*;
use crate::mesh::report::{Inside, MeshReport};

const USUAL: usize = 2_000;

fn below(random: &mut ChaCha8Rng, end: usize) -> usize {
    random.next_u32() as usize % end.max(1)
}

const PIECES: [&[u8]; 16] = [
    b"nan",
    b"-inf",
    b"1e400",
    b"\n",
    b"\0\0\0",
    b"\xff\xff\xff\x7f",
    b"solid ",
    b"endsolid",
    b"facet",
    b"f -1 -2 -3\n",
    b" -99999999999 ",
    b"/",
    b"\\\n",
    b"\r",
    b"4294967296",
    b"v ",
];

fn damage(content: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let length = content.len();
    let place = below(random, length);
    let end = (place + 1 + below(random, 80)).min(length);
    match random.next_u32() % 9 {
        0 | 1 if place < length => content[place] = random.next_u32().to_le_bytes()[0],
        2 if place < length => content[place] ^= 1 << (random.next_u32() % 8),
        3 => content.truncate(place),
        4 => {
            let bytes: Vec<u8> = (0..1 + below(random, 20)).map(|_| random.next_u32().to_le_bytes()[0]).collect();
            content.splice(place..place, bytes);
        }
        5 if place < end => drop(content.drain(place..end)),
        6 if place < end => {
            let doubled = content[place..end].to_vec();
            content.splice(place..place, doubled);
        }
        7 => {
            let piece = PIECES[below(random, PIECES.len())];
            content.splice(place..place, piece.iter().copied());
        }
        _ => {
            // Overwrites 32 bits. In binary STL, the number of triangles begins at byte 80.
            let place = if random.next_u32().is_multiple_of(2) { 80 } else { place };
            if let Some(bytes) = content.get_mut(place..place + 4) {
                bytes.copy_from_slice(&(random.next_u32() >> (random.next_u32() % 32)).to_le_bytes());
            }
        }
    }
}

#[test]
fn damaged_files_are_refused_or_read_and_never_panic() {
    let wanted = std::env::var("CAROM_MUTATIONS").ok().map_or(USUAL, |count| count.parse().expect("a number"));
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut counts = [[0_usize; 2]; 3];
    for _ in 0..wanted {
        let mesh = sheet(1 + random.next_u32() % 6);
        let kind = below(&mut random, 3);
        let (extension, mut content) =
            [("stl", binary(&mesh)), ("stl", text(&mesh)), ("obj", obj(&mesh))].into_iter().nth(kind).unwrap();
        for _ in 0..1 + below(&mut random, 4) {
            damage(&mut content, &mut random);
        }
        match read_mesh("part", extension, &content) {
            Ok(mesh) => {
                counts[kind][0] += 1;
                assert_eq!(mesh.first_unusable(), None);
                assert!(!mesh.triangles.is_empty() && mesh.vertices.len() <= 3 * mesh.triangles.len());
                assert!(mesh.triangles.len() <= content.len());
                let report = MeshReport::of(&mesh);
                assert_eq!(report.volume.is_some(), report.is_closed() && report.is_oriented());
                assert!(report.area.is_finite() && report.volume.is_none_or(f64::is_finite));
                let _ = Inside::of(&mesh).winding_number(&mesh.vertices[0]);
            }
            Err(error) => {
                counts[kind][1] += 1;
                let message = error.to_string();
                assert!(message.starts_with("part: ") && message.len() < 400, "{message}");
                assert!(message.contains("expected") && message.contains(';'), "{message}");
            }
        }
    }
    println!("read and refused: binary STL {:?}, text STL {:?}, OBJ {:?}", counts[0], counts[1], counts[2]);
    assert!(counts.iter().flatten().all(|count| 200 * count > wanted / 3), "{counts:?}");
}
