use std::fs;
use std::path::Path;

use super::*;
use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::model::{ParticleId, SpeciesId};
use crate::trajectory::extended_xyz::WriteError;
use crate::trajectory::frame::{FrameParticle, FrameSpecies};

/// Four bonded particles along x. A bond crosses a periodic boundary.
pub(in crate::io) fn chain() -> Frame {
    let bead = |id: u32, species, radius| FrameParticle {
        id: ParticleId(id),
        species: SpeciesId(species),
        position: Vector::new(f64::from(id) - 1.5, 0.1, 2.0),
        velocity: if id == 0 { Vector::new(1.0, 0.1 + 0.2, -2e-9) } else { Vector::zeros() },
        radius,
    };
    Frame {
        time: 0.25,
        lower: Vector::new(-2.0, -1.0, 0.0),
        size: Vector::new(4.0, 6.0, 10.0),
        periodic: [true, false, true],
        displacement: 0.0,
        species: vec![
            FrameSpecies { name: "bead".into(), is_static: false, mass: Some(2.5) },
            FrameSpecies { name: "bob".into(), is_static: true, mass: Some(f64::INFINITY) },
        ],
        particles: vec![bead(0, 0, 0.5), bead(1, 1, 0.75), bead(2, 0, 0.5), bead(3, 0, 0.5)],
        bonds: [[0, 1], [2, 1], [2, 3], [3, 0]].map(|ends| ends.map(ParticleId)).to_vec(),
        ..Frame::default()
    }
}

pub(in crate::io) fn trajectory(path: &Path, frames: &[Frame]) {
    let mut text = Vec::new();
    for frame in frames {
        write_frame(&mut text, frame).unwrap();
    }
    fs::write(path, text).unwrap();
}

pub(crate) fn converted(frames: &[Frame], format: Format) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("source.xyz"), folder.path().join("target"));
    trajectory(&source, frames);
    convert(&source, format, &target, &Options::default()).unwrap();
    fs::read(target).unwrap()
}

fn at(times: &[f64]) -> Vec<Frame> {
    times.iter().map(|&time| Frame { time, ..chain() }).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn selected_frames_are_converted() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("b.xyz"));
    trajectory(&source, &at(&[0.0, 1.0, 2.0, 3.0]));
    for (first, last, times) in [
        (0, None, &[0.0, 1.0, 2.0, 3.0][..]),
        (1, Some(2), &[1.0, 2.0]),
        (3, Some(3), &[3.0]),
        (2, Some(u64::MAX), &[2.0, 3.0]),
    ] {
        let done = convert(&source, Format::Xyz, &target, &Options { first, last, replace: true }).unwrap();
        assert_eq!(done, Converted { frames: times.len() as u64, is_truncated: false });
        let frames: Result<Vec<Frame>, _> = FrameReader::new(&fs::read(&target).unwrap()[..]).collect();
        assert_eq!(frames.unwrap(), at(times));
    }
    // The table numbers the frames as in the source.
    let table = folder.path().join("b.csv");
    convert(&source, Format::Csv, &table, &Options { first: 2, ..Options::default() }).unwrap();
    assert!(fs::read_to_string(table).unwrap().lines().nth(1).unwrap().starts_with("2,2,0,bead,"));
}

#[test]
fn unreadable_source_is_reported_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("b"));
    let good = "1\n\nA 0 0 0\n";
    for format in Format::ALL {
        for (text, first, expected) in [
            (String::new(), 0, "the file holds no frame"),
            ("\n \n".to_owned(), 5, "the file holds no frame"),
            (format!("{good}1\n\nA 0 zero 0\n"), 0, "line 6: position is `zero`, expected a finite number"),
            (format!("{good}1\n\nA 0 zero 0\n"), 1, "line 6: position is `zero`, expected a finite number"),
            ("2\n\nA 0 0 0\n".to_owned(), 0, "cut off"),
            (good.to_owned(), 1, "frame 1 of"),
        ] {
            fs::write(&source, text).unwrap();
            let error = convert(&source, format, &target, &Options { first, ..Options::default() }).unwrap_err();
            let message = format!("{error}: {:?}", std::error::Error::source(&error).map(ToString::to_string));
            assert!(message.contains(expected) && message.contains("a.xyz"), "{format:?}: {message}");
            assert_eq!(names(folder.path()), ["a.xyz"], "{format:?}");
        }
    }
    let missing = convert(&folder.path().join("none.xyz"), Format::Csv, &target, &Options::default());
    assert!(matches!(missing, Err(ConvertError::Read { source: ReadError::Open { .. }, .. })));
}

#[test]
fn a_killed_run_gives_its_complete_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("trajectory.xyz.partial"), folder.path().join("b.csv"));
    trajectory(&source, &at(&[0.0, 1.0]));
    let text = fs::read(&source).unwrap();
    fs::write(&source, &text[..text.len() - 8]).unwrap();
    let done = convert(&source, Format::Csv, &target, &Options::default()).unwrap();
    assert_eq!(done, Converted { frames: 1, is_truncated: true });
    let error = convert(&source, Format::Csv, &target, &Options { first: 1, ..Options::default() }).unwrap_err();
    assert!(matches!(error, ConvertError::NoSuchFrame { first: 1, count: 1, .. }));
}

#[test]
fn the_source_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let forced = Options { replace: true, ..Options::default() };
    for name in ["trajectory.xyz", "trajectory.xyz.partial"] {
        let source = folder.path().join(name);
        trajectory(&source, &at(&[0.0]));
        let before = fs::read(&source).unwrap();
        for format in Format::ALL {
            let error = convert(&source, format, &folder.path().join("trajectory.xyz"), &forced).unwrap_err();
            assert!(matches!(error, ConvertError::Source(_)), "{format:?}: {error}");
        }
        assert_eq!(fs::read(&source).unwrap(), before);
        fs::remove_file(source).unwrap();
    }
}

#[test]
fn only_a_former_conversion_is_replaced_and_only_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("target"));
    trajectory(&source, &at(&[0.0, 1.0]));
    let forced = Options { replace: true, ..Options::default() };
    for format in Format::ALL {
        convert(&source, format, &target, &Options::default()).unwrap();
        let again = convert(&source, format, &target, &Options::default()).unwrap_err();
        assert!(matches!(again, ConvertError::Exists(_)), "{format:?}: {again}");
        convert(&source, format, &target, &forced).unwrap();
        assert_eq!(names(folder.path()), ["a.xyz", "target"], "{format:?}");
        let is_folder = target.is_dir();
        if is_folder {
            fs::write(target.join("chapter.tex"), "years of work").unwrap();
            let foreign = convert(&source, format, &target, &forced).unwrap_err();
            assert!(matches!(foreign, ConvertError::Foreign(_)), "{format:?}: {foreign}");
            assert_eq!(fs::read_to_string(target.join("chapter.tex")).unwrap(), "years of work");
            fs::remove_dir_all(&target).unwrap();
            fs::write(&target, "a file").unwrap();
        } else {
            fs::remove_file(&target).unwrap();
            fs::create_dir(&target).unwrap();
        }
        assert!(matches!(convert(&source, format, &target, &forced), Err(ConvertError::Foreign(_))), "{format:?}");
        if is_folder { fs::remove_file(&target).unwrap() } else { fs::remove_dir(&target).unwrap() }
    }
}

#[test]
fn unfinished_file_of_another_run_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("trajectory.xyz"));
    let unfinished = folder.path().join("trajectory.xyz.partial");
    trajectory(&source, &at(&[0.0]));
    fs::write(&unfinished, "still going on").unwrap();
    for format in Format::ALL {
        let error = convert(&source, format, &target, &Options::default()).unwrap_err();
        assert!(matches!(&error, ConvertError::Exists(path) if *path == unfinished), "{format:?}: {error}");
        assert_eq!(fs::read_to_string(&unfinished).unwrap(), "still going on");
    }
    convert(&source, Format::Csv, &target, &Options { replace: true, ..Options::default() }).unwrap();
    assert_eq!(names(folder.path()), ["a.xyz", "trajectory.xyz"]);
}

#[test]
fn a_frame_that_a_format_cannot_hold_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (source, target) = (folder.path().join("a.xyz"), folder.path().join("b"));
    let error_of = |format, change: &dyn Fn(&mut Frame)| {
        let mut frames = at(&[0.0, 1.0]);
        change(&mut frames[1]);
        trajectory(&source, &frames);
        let error = convert(&source, format, &target, &Options::default()).unwrap_err();
        assert!(!target.exists());
        match error {
            ConvertError::Frame { index: 1, source, .. } => source,
            other => panic!("{other}"),
        }
    };
    for format in [Format::Gsd, Format::Vtk] {
        let error = error_of(format, &|frame| frame.bonds[0][1] = ParticleId(9));
        assert!(matches!(error, FrameError::NoBondEnd(ParticleId(9))), "{error}");
        let error = error_of(format, &|frame| frame.particles[3].id = ParticleId(2));
        assert!(matches!(error, FrameError::RepeatedId(ParticleId(2))), "{error}");
    }
    let error = error_of(Format::Gsd, &|frame| frame.particles[0].position.x = 1e39);
    assert!(matches!(error, FrameError::BeyondSingle(_)), "{error}");
    type Change = fn(&mut Frame);
    let changes: [(&str, Change); 7] = [
        ("particles", |frame| frame.particles.truncate(3)),
        ("ids", |frame| frame.particles.swap(0, 2)),
        ("species", |frame| frame.particles[0].species = SpeciesId(1)),
        ("species", |frame| frame.species[0].is_static = true),
        ("radii", |frame| frame.particles[0].radius = 1.0),
        ("bonds", |frame| frame.bonds.truncate(1)),
        ("periodic axes", |frame| frame.periodic[1] = true),
    ];
    for (what, change) in changes {
        match error_of(Format::Npy, &change) {
            FrameError::OtherParticles(found) => assert_eq!(found, what),
            other => panic!("{what}: {other}"),
        }
    }
}

#[test]
fn conversions_go_beside_their_source() {
    let beside = |format: Format| format.target_beside(Path::new("runs/a/trajectory.xyz"));
    let names = Format::ALL.map(|format| beside(format).to_string_lossy().into_owned());
    let expected = ["trajectory.lammpstrj", "trajectory.gsd", "trajectory-vtk", "trajectory-npy", "trajectory.csv"];
    for (name, expected) in names.iter().zip(expected.iter().chain(&["trajectory-piece.xyz"])) {
        assert_eq!(name, &format!("runs/a/{expected}"));
    }
}

#[test]
fn scalars_of_particles_are_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("a.xyz");
    let mut frame = chain();
    // The particles are in reverse order. GSD sorts them by id. All other formats keep their order.
    frame.particles.reverse();
    let values = vec![0.5, 0.1 + 0.2, 0.0, -2.5];
    frame.scalars = vec![Scalar { name: "q6".into(), values: values.clone() }];
    trajectory(&source, &[frame.clone()]);
    let target = |format: Format| {
        convert(&source, format, &format.target_beside(&source), &Options::default()).unwrap();
        format.target_beside(&source)
    };
    let text = |format| fs::read_to_string(target(format)).unwrap();
    let columns = ["0.5", "0.30000000000000004", "0", "-2.5"];
    for (format, head, separator) in [
        (Format::Xyz, "id:I:1:masses:R:1:q6:R:1 ", ' '),
        (Format::Lammps, "radius q6\n", ' '),
        (Format::Csv, "radius,q6\n", ','),
    ] {
        let text = text(format);
        assert!(text.contains(head), "{text}");
        let last: Vec<&str> = text.lines().rev().take(4).map(|line| line.rsplit(separator).next().unwrap()).collect();
        assert_eq!(last.into_iter().rev().collect::<Vec<_>>(), columns);
    }
    let bytes = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let has = |file: &Path, values: &[f64]| fs::read(file).unwrap().windows(32).any(|window| window == bytes(values));
    assert!(has(&target(Format::Npy).join("q6.npy"), &values));
    let frame_file = target(Format::Vtk).join("frame_000000.vtp");
    assert!(
        has(&frame_file, &values) && String::from_utf8_lossy(&fs::read(frame_file).unwrap()).contains("Name=\"q6\"")
    );
    assert!(has(&target(Format::Gsd), &values.iter().rev().copied().collect::<Vec<_>>()));
    // Extended XYZ can be read back. If the name of a scalar conflicts with a column of a format, it is rejected.
    let back =
        FrameReader::new(fs::read(Format::Xyz.target_beside(&source)).unwrap().as_slice()).next().unwrap().unwrap();
    assert_eq!(back, frame);
    for name in ["radius", "x", "", "a b", "../q6", "Box"] {
        frame.scalars[0].name = name.into();
        assert!(matches!(write_frame(Vec::new(), &frame), Err(WriteError::Scalar(_))), "{name}");
    }
    frame.scalars[0] = Scalar { name: "q6".into(), values: vec![0.5; 3] };
    assert!(matches!(write_frame(Vec::new(), &frame), Err(WriteError::Scalar(_))));
}

#[test]
fn image_counts_are_written_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("a.xyz");
    let mut frame = chain();
    frame.particles.reverse();
    frame.images = vec![[1, 0, -2], [0; 3], [3, 0, 0], [0, 0, 70_000]];
    trajectory(&source, &[frame.clone()]);
    let target = |format: Format| {
        convert(&source, format, &format.target_beside(&source), &Options::default()).unwrap();
        format.target_beside(&source)
    };
    let text = |format| fs::read_to_string(target(format)).unwrap();
    for (format, head, first) in [
        (Format::Xyz, "id:I:1:map_shift:I:3:masses:R:1 ", "0.5 3 1 0 -2 2.5\n"),
        (Format::Lammps, "vx vy vz ix iy iz radius\n", "0 0 0 1 0 -2 0.5\n"),
        (Format::Csv, "radius,ix,iy,iz\n", ",0.5,1,0,-2\n"),
    ] {
        let text = text(format);
        assert!(text.contains(head) && text.contains(first), "{text}");
    }
    let bytes = |images: &[[i32; 3]]| images.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let has = |file: &Path, images: &[[i32; 3]]| {
        let bytes = bytes(images);
        fs::read(file).unwrap().windows(bytes.len()).any(|window| window == bytes)
    };
    assert!(has(&target(Format::Npy).join("images.npy"), &frame.images));
    assert!(has(&target(Format::Vtk).join("frame_000000.vtp"), &frame.images));
    assert!(has(&target(Format::Gsd), &frame.images.iter().rev().copied().collect::<Vec<_>>()));
    // If a later frame has no images, the table has empty cells, and a conversion to NumPy arrays fails.
    trajectory(&source, &[frame.clone(), Frame { images: Vec::new(), ..frame }]);
    let table = folder.path().join("b.csv");
    convert(&source, Format::Csv, &table, &Options::default()).unwrap();
    assert!(fs::read_to_string(table).unwrap().ends_with(",0.5,,,\n"));
    let error = convert(&source, Format::Npy, &folder.path().join("b"), &Options::default()).unwrap_err();
    assert!(matches!(error, ConvertError::Frame { index: 1, .. }), "{error}");
}

#[test]
fn columns_of_other_programs_are_scalars_if_they_are_finite() {
    let text = "2\nProperties=pos:R:3:charge:R:1:force:R:3:spin:R:1:tag:I:1:time:R:1\n1 2 3 0.5 0 0 0 nan 7 1\n1 2 5 -1 0 0 0 2 7 1\n";
    let frame = FrameReader::new(text.as_bytes()).next().unwrap().unwrap();
    assert_eq!(frame.scalars, [Scalar { name: "charge".into(), values: vec![0.5, -1.0] }]);
}
