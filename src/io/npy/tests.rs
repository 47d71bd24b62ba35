//! Reads NumPy files back with an independent reader.

use std::fs;
use std::path::Path;

use crate::io::convert::convert;
use crate::io::convert::tests::{chain, trajectory};
use crate::model::{Format, Units};
use crate::trajectory::Frame;

/// Returns the type, the shape and the data of an array.
fn read(path: &Path) -> (String, String, Vec<u8>) {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(end % 64, 0);
    let header = std::str::from_utf8(&bytes[10..end]).unwrap();
    assert!(header.ends_with('\n') && header.contains("'fortran_order': False"));
    let between = |from: &str, to: &str| {
        let start = header.find(from).unwrap() + from.len();
        header[start..start + header[start..].find(to).unwrap()].to_owned()
    };
    (between("'descr': '", "'"), between("'shape': (", ")"), bytes[end..].to_vec())
}

fn floats(path: &Path) -> (String, Vec<f64>) {
    let (kind, shape, bytes) = read(path);
    assert_eq!(kind, "<f8");
    (shape, bytes.chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect())
}

#[test]
fn arrays_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("npy"));
    let mut second = Frame { time: 0.75, displacement: 1.25, ..chain() };
    second.periodic[1] = true;
    second.particles[3].position.z = 9.0;
    let mut first = chain();
    first.periodic[1] = true;
    (first.units, second.units) = (Units::new("mm", "g", "ms"), Units::new("mm", "g", "ms"));
    trajectory(&source, &[first, second]);
    convert(&source, Format::Npy, &target, &Default::default()).unwrap();
    let file = |name: &str| target.join(name);
    assert_eq!(floats(&file("times.npy")), ("2,".to_owned(), vec![0.25, 0.75]));
    let (shape, positions) = floats(&file("positions.npy"));
    assert_eq!((shape.as_str(), positions.len()), ("2, 4, 3,", 24));
    assert_eq!((&positions[..3], positions[11], positions[23]), (&[-1.5, 0.1, 2.0][..], 2.0, 9.0));
    let (shape, velocities) = floats(&file("velocities.npy"));
    assert_eq!((shape.as_str(), &velocities[12..16]), ("2, 4, 3,", &[1.0, 0.1 + 0.2, -2e-9, 0.0][..]));
    let (shape, edges) = floats(&file("box.npy"));
    assert_eq!((shape.as_str(), &edges[6..]), ("2, 2, 3,", &[-2.0, -1.0, 0.0, 4.0, 6.0, 10.0][..]));
    assert_eq!(floats(&file("displacements.npy")), ("2,".to_owned(), vec![0.0, 1.25]));
    assert_eq!(floats(&file("radius.npy")), ("4,".to_owned(), vec![0.5, 0.75, 0.5, 0.5]));
    assert_eq!(floats(&file("species_mass.npy")), ("2,".to_owned(), vec![2.5, f64::INFINITY]));
    let bytes = |numbers: &[u32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let whole = |numbers: &[u32], shape: &str| ("<u4".to_owned(), shape.to_owned(), bytes(numbers));
    assert_eq!(read(&file("ids.npy")), whole(&[0, 1, 2, 3], "4,"));
    assert_eq!(read(&file("species.npy")), whole(&[0, 1, 0, 0], "4,"));
    assert_eq!(read(&file("bonds.npy")), whole(&[0, 1, 2, 1, 2, 3, 3, 0], "4, 2,"));
    assert_eq!(read(&file("periodic.npy")), ("|b1".to_owned(), "3,".to_owned(), vec![1, 1, 1]));
    assert_eq!(read(&file("species_static.npy")), ("|b1".to_owned(), "2,".to_owned(), vec![0, 1]));
    let codes: Vec<u32> = "beadbob\0".chars().map(u32::from).collect();
    assert_eq!(read(&file("species_names.npy")), ("<U4".to_owned(), "2,".to_owned(), bytes(&codes)));
    let codes: Vec<u32> = "mmg\0ms".chars().map(u32::from).collect();
    assert_eq!(read(&file("units.npy")), ("<U2".to_owned(), "3,".to_owned(), bytes(&codes)));
}

#[test]
fn unknown_quantities_have_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("npy"));
    fs::write(&source, "1\n\n\u{e9} 1 2 3\n").unwrap();
    convert(&source, Format::Npy, &target, &Default::default()).unwrap();
    for absent in ["velocities.npy", "bonds.npy", "species_mass.npy", "units.npy"] {
        assert!(!target.join(absent).exists());
    }
    let (kind, _, bytes) = read(&target.join("species_names.npy"));
    assert_eq!((kind.as_str(), &bytes[..]), ("<U1", &[0xe9, 0, 0, 0][..]));
    // After a frame without velocities, a frame with velocities is an error.
    fs::write(&source, "1\n\nO 1 2 3\n1\nProperties=pos:R:3:velo:R:3\n1 2 3 4 5 6\n").unwrap();
    fs::remove_dir_all(&target).unwrap();
    let error = convert(&source, Format::Npy, &target, &Default::default()).unwrap_err();
    assert!(error.to_string().contains("frame 1 of"), "{error}");
}
