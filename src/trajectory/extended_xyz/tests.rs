use proptest::prelude::*;

use super::*;
use crate::Vector;
use crate::model::{ParticleId, SpeciesId, Units};
use crate::trajectory::frame::{FrameParticle, FrameSpecies};

fn read(text: &[u8]) -> Vec<Result<Frame, ReadError>> {
    FrameReader::new(text).collect()
}

fn written(frame: &Frame) -> String {
    let mut text = Vec::new();
    write_frame(&mut text, frame).unwrap();
    String::from_utf8(text).unwrap()
}

fn two_discs() -> Frame {
    let disc = |id, x, v| FrameParticle {
        id: ParticleId(id),
        species: SpeciesId(0),
        position: Vector::new(x, 0.5, 0.0),
        velocity: Vector::new(v, 0.0, 0.0),
        radius: 0.5,
    };
    Frame {
        time: 0.5,
        lower: Vector::zeros(),
        size: Vector::new(5.0, 5.0, 0.0),
        periodic: [true, true, false],
        species: vec![FrameSpecies { name: "ball".into(), is_static: false, mass: Some(1.0) }],
        particles: vec![disc(0, 0.5, 1.0), disc(1, 2.5, -1.0)],
        images: vec![[0; 3], [-2, 0, 0]],
        ..Frame::default()
    }
}

#[test]
fn written_frame_matches_documentation() {
    let expected = "2\n\
        Lattice=\"5 0 0 0 5 0 0 0 1\" Origin=\"0 0 0\" Properties=type:S:1:pos:R:3:velo:R:3:radius:R:1:id:I:1:map_shift:I:3:masses:R:1 \
        Time=0.5 pbc=\"T T F\" flat=\"F F T\" species_table=\"ball\" static=\"F\" \
        species_mass=\"1\"\n\
        ball 0.5 0.5 0 1 0 0 0.5 0 0 0 0 1\n\
        ball 2.5 0.5 0 -1 0 0 0.5 1 -2 0 0 1\n";
    assert_eq!(written(&two_discs()), expected);
}

#[test]
fn units_are_written_and_read() {
    let frame = Frame { units: Units::new("mm", "g", "ms"), ..two_discs() };
    let text = written(&frame);
    assert!(text.contains(" units=\"mm g ms\"\n"), "{text}");
    assert_eq!(*read(text.as_bytes())[0].as_ref().unwrap(), frame);
    for other in ["metal", "\"mm g\"", "\"mm g ms K\"", "\"mm g 1\""] {
        let frames = read(text.replace("\"mm g ms\"", other).as_bytes());
        assert_eq!(*frames[0].as_ref().unwrap(), two_discs(), "{other}");
    }
    let frame = Frame { units: Units::new("mm", "a gram", "ms"), ..two_discs() };
    assert!(matches!(write_frame(Vec::new(), &frame), Err(WriteError::Units)));
}

#[test]
fn image_columns_are_read_under_every_known_name() {
    let text = |columns: &str, rest: &str| format!("1\nProperties=pos:R:3:{columns}\n1 2 3 {rest}\n");
    for name in ["map_shift", "images", "image"] {
        let frame = read(text(&format!("{name}:I:3"), "-4 0 5").as_bytes()).pop().unwrap().unwrap();
        assert_eq!(frame.images, [[-4, 0, 5]]);
    }
    let old = read(text("id:I:1", "7").as_bytes()).pop().unwrap().unwrap();
    assert!(old.images.is_empty() && !written(&old).contains("map_shift"));
    let error = read(text("map_shift:I:3", "1 2.5 3").as_bytes()).pop().unwrap().unwrap_err();
    assert_eq!(error.to_string(), "line 3: map_shift is `2.5`, expected a whole number of periods");
    let some = Frame { images: vec![[0; 3]], ..two_discs() };
    assert!(matches!(write_frame(Vec::new(), &some), Err(WriteError::Images)));
}

#[test]
fn sheared_box_displacement_is_read_modulo_the_period() {
    let frame = Frame { displacement: -1.75, ..two_discs() };
    assert!(written(&frame).contains("Lattice=\"5 0 0 -1.75 5 0 0 0 1\""), "{}", written(&frame));
    for (entry, expected) in [("-1.75", -1.75), ("8.25", -1.75), ("-2.5", 2.5), ("5", 0.0), ("-0", 0.0)] {
        let text = written(&frame).replace("-1.75", entry);
        let frames = read(text.as_bytes());
        assert_eq!(frames[0].as_ref().unwrap().displacement, expected, "{entry}");
    }
    for lattice in ["5 0 0 1 5 0 0 1 1", "5 0 0 1 5 0.5 0 0 1", "5 0 0 1 0 0 0 0 1", "0 0 0 1 5 0 0 0 1"] {
        let error = read(format!("0\nLattice=\"{lattice}\"\n").as_bytes()).pop().unwrap().unwrap_err();
        assert!(error.problem().starts_with("Lattice is `"), "{lattice}: {error}");
    }
}

#[test]
fn reordered_and_unknown_columns_are_accepted() {
    let text = b"1\r\nProperties=id:I:1:junk:R:2:vel:R:3:pos:R:3 note='a b' Time = 3\r\n7 nan x 1 2 3 4 5 6\r\n\n";
    let frames = read(text);
    let frame = frames[0].as_ref().unwrap();
    let particle = frame.particles[0];
    assert_eq!((particle.id, particle.radius), (ParticleId(7), 0.5));
    assert_eq!((particle.velocity, particle.position), (Vector::new(1., 2., 3.), Vector::new(4., 5., 6.)));
    assert_eq!(
        (frame.periodic, frame.lower, frame.size),
        ([false; 3], Vector::new(3.5, 4.5, 5.5), Vector::repeat(1.0))
    );
    assert_eq!(frames.len(), 1);
}

#[test]
fn plain_xyz_file_is_read() {
    let mut reader = FrameReader::new(&b"2\nwater, by hand\nO 0 0 0\nH 1 0 0"[..]);
    let frame = reader.next().unwrap().unwrap();
    let names: Vec<_> = frame.species.iter().map(|species| species.name.as_str()).collect();
    assert_eq!(names, ["O", "H"]);
    assert_eq!((frame.particles[1].id, frame.particles[1].species), (ParticleId(1), SpeciesId(1)));
    assert!(!reader.has_velocities() && reader.next().is_none());
}

#[test]
fn comment_line_variants_of_ase_are_read() {
    let plain = "1\nLattice=\"3 0 0 0 4 0 0 0 5\" Properties=species:S:1:pos:R:3 Time=2 pbc=\"T T T\"\nA 1 2 3\n";
    let expected = read(plain.as_bytes()).pop().unwrap().unwrap();
    for comment in [
        "Lattice = \"3 0 0 0 4 0 0 0 5\" Properties =species:S:1:pos:R:3 Time= 2 pbc = \"T T T\"",
        "Lattice={3 0 0 0 4 0 0 0 5} Properties=species:S:1:pos:R:3 Time=2 pbc={T T T}",
        "Lattice=[[3, 0, 0], [0, 4, 0], [0, 0, 5]] flag Properties=species:S:1:pos:R:3 Time=2 pbc=[T, T, T]",
        "Lattice=\"3 1e-16 0 -2e-16 4 0 0 3e-16 5\" Properties=species:S:1:pos:R:3 Time=2 pbc=T",
    ] {
        let text = format!("\u{feff}1\n{comment}\nA 1 2 3\n");
        assert_eq!(read(text.as_bytes()).pop().unwrap().unwrap(), expected, "{comment}");
    }
    let mut reader = FrameReader::new(plain.replace("Time=2", "time=12.5ps").into_bytes().leak() as &[u8]);
    assert_eq!(reader.next().unwrap().unwrap().time, 0.0);
    assert_eq!(reader.beside().unused, ["Time"]);
    let periodic = |flags: &str| read(plain.replace("\"T T T\"", flags).as_bytes()).pop().unwrap().unwrap().periodic;
    assert_eq!([periodic("F"), periodic("\"T F T\"")], [[false; 3], [true, false, true]]);
}

#[test]
fn species_column_is_the_one_matching_the_species_table() {
    let text = "2\nProperties=species:S:1:pos:R:3:type:S:1 species_table=\"ball Fe\" static=\"_JSON [true, false]\"\n\
        X 1 1 1 Fe\nX 2 2 2 ball\n";
    let frame = read(text.as_bytes()).pop().unwrap().unwrap();
    assert_eq!(frame.particles.iter().map(|particle| particle.species.0).collect::<Vec<_>>(), [1, 0]);
    assert_eq!(frame.species.iter().map(|species| species.is_static).collect::<Vec<_>>(), [true, false]);
    // Without a species table, the first species column is used.
    let text = text.replace("species_table=\"ball Fe\" static=\"_JSON [true, false]\"", "");
    assert_eq!(read(text.as_bytes()).pop().unwrap().unwrap().species[0].name, "X");
}

#[test]
fn malformed_input_names_line_and_value() {
    let cases = [
        ("x\n", "line 1: expected the number of particles of a frame, 0 to 4294967295, found `x`"),
        ("4294967296\n", "line 1: expected the number of particles of a frame, 0 to 4294967295, found `4294967296`"),
        ("-1\n\n", "line 1: expected the number of particles of a frame, 0 to 4294967295, found `-1`"),
        ("1\n\nA 0 0\n", "line 3: expected 4 columns, found 3"),
        ("1\n\nA 0 0 0 0 0 0\n", "line 3: expected 4 columns, found 5"),
        ("2\n\nA 0 0 0\nA 0 zero 0\n", "line 4: position is `zero`, expected a finite number"),
        ("1\n\nA 0 inf 0\n", "line 3: position is `inf`, expected a finite number"),
        ("1\nProperties=pos:R:3:id:I:1\n0 0 0 -4\n", "line 3: id is `-4`, expected a whole number, 0 to 4294967295"),
        (
            "1\nProperties=pos:R:3:radius:R:1\n0 0 0 -4\n",
            "line 3: radius is `-4`, expected a finite length, not negative",
        ),
        ("1\nProperties=pos:R:2\n0 0\n", "line 2: Properties is `pos:R:2`, expected positions, `pos:R:3`"),
        (
            "1\nProperties=pos:R\n0 0\n",
            "line 2: Properties is `pos:R`, expected `name:type:number` for each group of columns, such as `species:S:1:pos:R:3`",
        ),
        (
            "1\nLattice=\"1 1 0 0 1 0 0 0 1\"\n",
            "line 2: Lattice is `1 1 0 0 1 0 0 0 1`, expected a box aligned with the axes, `Lx 0 0 0 Ly 0 0 0 Lz`, or one whose \
             images along y slide along x, `Lx 0 0 d Ly 0 0 0 Lz`, where both are periodic",
        ),
        (
            "1\nLattice=\"1 0 0 0.2 1 0 0 0 1\" pbc=\"T F T\"\n",
            "line 2: Lattice is `1 0 0 0.2 1 0 0 0 1`, expected a box aligned with the axes, `Lx 0 0 0 Ly 0 0 0 Lz`, or one whose \
             images along y slide along x, `Lx 0 0 d Ly 0 0 0 Lz`, where both are periodic",
        ),
        ("1\nLattice=\"1 0 0\"\n", "line 2: Lattice is `1 0 0`, expected nine finite numbers"),
        ("1\npbc=\"T F\"\n", "line 2: pbc is `T F`, expected three of `T` and `F`"),
        ("1\nbonds=1-x\n", "line 2: bonds is `1-x`, expected pairs of ids such as `0-1 1-2`"),
        (
            "1\nspecies_table=\"a b\" species_mass=\"1 0\"\n",
            "line 2: species_mass is `1 0`, expected a positive number, or `inf`, for each species",
        ),
        ("1\nspecies_table=\"a b\" static=T\n", "line 2: static is `T`, expected a `T` or `F` for each species"),
        ("3", "the frame that begins on line 1 is cut off: expected 3 particles, the file ends after 0"),
        ("3\nTime=", "the frame that begins on line 1 is cut off: expected 3 particles, the file ends after 0"),
        (
            "0\n\n3\n\nA 0 0 0\nA 0 0",
            "the frame that begins on line 3 is cut off: expected 3 particles, the file ends after 1",
        ),
    ];
    for (text, expected) in cases {
        let error = read(text.as_bytes()).pop().unwrap().unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
    assert!(matches!(read(b"1\n\xff\n")[..], [Err(ReadError::NotText { line: 2 })]));
    assert!(read(b"").is_empty() && read(b" \n\n").is_empty());
}

#[test]
fn refuses_to_write_what_could_not_be_read_back() {
    let refusal = |change: &dyn Fn(&mut Frame)| {
        let mut frame = two_discs();
        change(&mut frame);
        write_frame(std::io::sink(), &frame).unwrap_err()
    };
    for name in ["", "a b", "a\"b", "a\\b", "\u{7f}"] {
        assert!(
            matches!(refusal(&|frame| frame.species[0].name = name.into()), WriteError::SpeciesName(n) if n == name)
        );
    }
    assert!(matches!(refusal(&|frame| frame.species.push(frame.species[0].clone())), WriteError::SpeciesName(_)));
    assert!(matches!(refusal(&|frame| frame.species.clear()), WriteError::NoSpecies(ParticleId(0))));
    for mass in [0.0, -1.0, f64::NAN] {
        assert!(
            matches!(refusal(&|frame| frame.species[0].mass = Some(mass)), WriteError::Mass(name) if name == "ball")
        );
    }
    assert!(matches!(refusal(&|frame| frame.time = f64::NAN), WriteError::Frame));
    assert!(matches!(refusal(&|frame| frame.size.x = -1.0), WriteError::Frame));
    for displacement in [f64::NAN, 2.6, -2.5] {
        assert!(matches!(refusal(&|frame| frame.displacement = displacement), WriteError::Frame));
    }
    assert!(matches!(refusal(&|f| (f.displacement, f.periodic[1]) = (1.0, false)), WriteError::Frame));
    assert!(matches!(refusal(&|f| f.particles[1].velocity.x = f64::INFINITY), WriteError::Particle(ParticleId(1))));
}

#[test]
fn frame_nearest_to_a_time_is_found_even_in_truncated_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trajectory.xyz");
    let at = |time| written(&Frame { time, ..two_discs() });
    let text = [at(0.0), at(1.0), at(2.0)].concat();
    std::fs::write(&path, &text).unwrap();
    for (asked, found) in [(None, 2.0), (Some(-5.0), 0.0), (Some(0.6), 1.0), (Some(1.5), 1.0), (Some(f64::NAN), 0.0)] {
        let pick = pick_frame(&path, asked).unwrap();
        assert_eq!((pick.frame.time, pick.is_truncated), (found, false));
    }
    std::fs::write(&path, &text[..text.len() - 8]).unwrap();
    let pick = pick_frame(&path, None).unwrap();
    assert_eq!((pick.frame.time, pick.is_truncated), (1.0, true));
    std::fs::write(&path, &text[..40]).unwrap();
    assert!(matches!(pick_frame(&path, None), Err(ReadError::Truncated { .. })));
    std::fs::write(&path, "").unwrap();
    assert!(matches!(pick_frame(&path, None), Err(ReadError::NoFrame)));
    assert!(matches!(pick_frame(folder.path().join("none").as_path(), None), Err(ReadError::Open { .. })));
}

fn number() -> impl Strategy<Value = f64> {
    use prop::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO, -100.0..100.0, Just(0.1 + 0.2)]
}

fn vector() -> impl Strategy<Value = Vector> {
    [number(), number(), number()].prop_map(Vector::from)
}

fn frame() -> impl Strategy<Value = Frame> {
    let particle = (any::<u32>(), 0..3_u32, vector(), vector(), number(), any::<[i32; 3]>());
    let flags = any::<[bool; 6]>();
    (
        number(),
        vector(),
        vector(),
        (flags, any::<bool>(), any::<bool>()),
        prop::collection::vec(particle, 0..8),
        prop::collection::vec(any::<[u32; 2]>(), 0..4),
    )
        .prop_map(|(time, lower, size, (flags, has_masses, has_images), particles, bonds)| Frame {
            time,
            lower,
            size: size.map(f64::abs),
            periodic: [flags[0], flags[1], flags[2]],
            displacement: if flags[0] && flags[1] && size.x != 0.0 && size.y != 0.0 { 0.375 * size.x } else { 0.0 },
            species: ["ball", "Fe", "é=1'"]
                .iter()
                .zip(&flags[3..])
                .map(|(name, &is_static)| FrameSpecies {
                    name: (*name).into(),
                    is_static,
                    mass: has_masses.then_some(if is_static { f64::INFINITY } else { time.abs() + 0.1 }),
                })
                .collect(),
            images: particles.iter().filter(|_| has_images).map(|particle| particle.5).collect(),
            particles: particles
                .into_iter()
                .map(|(id, species, position, velocity, radius, _)| FrameParticle {
                    id: ParticleId(id),
                    species: SpeciesId(species),
                    position,
                    velocity,
                    radius: radius.abs(),
                })
                .collect(),
            bonds: bonds.into_iter().map(|ends| ends.map(ParticleId)).collect(),
            bond_names: Vec::new(),
            bond_kinds: Vec::new(),
            scalars: Vec::new(),
            surfaces: flags[..usize::from(has_masses) * 2].to_vec(),
            units: if flags[5] { Units::new("mm", "g", "\u{b5}s") } else { Units::default() },
        })
}

/// Generates frames with changed bytes and a missing end.
fn nearly_a_frame() -> impl Strategy<Value = Vec<u8>> {
    (frame(), prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6), any::<prop::sample::Index>())
        .prop_map(|(frame, changes, end)| {
            let mut text = written(&frame).into_bytes();
            for (place, byte) in changes {
                let place = place.index(text.len());
                text[place] = byte;
            }
            text.truncate(end.index(text.len()) + 1);
            text
        })
}

proptest! {
    #[test]
    fn a_frame_survives_the_file_bit_for_bit(frames in prop::collection::vec(frame(), 1..3)) {
        let text: String = frames.iter().map(written).collect();
        let back: Vec<Frame> = read(text.as_bytes()).into_iter().map(Result::unwrap).collect();
        // Unlike `==`, the debug text distinguishes -0 from 0.
        prop_assert_eq!(format!("{frames:?}"), format!("{back:?}"));
    }

    #[test]
    fn arbitrary_bytes_do_not_panic(text in prop::collection::vec(any::<u8>(), 0..300)) {
        read(&text);
    }

    #[test]
    fn damaged_frames_do_not_panic(text in nearly_a_frame()) {
        read(&text);
    }
}

#[test]
fn skipping_frames_counts_as_many_as_reading_them() {
    let text = [written(&two_discs()), "0\nTime=3\n".to_owned(), written(&two_discs())].concat();
    for cut in 0..=text.len() {
        let read = read(&text.as_bytes()[..cut]);
        let mut reader = FrameReader::new(&text.as_bytes()[..cut]);
        let mut passed = Vec::new();
        let ended = loop {
            match reader.next_preamble() {
                Ok(Some(preamble)) => passed.push((preamble.count, preamble.time)),
                Ok(None) => break None,
                Err(error) => break Some(matches!(error, ReadError::Truncated { .. })),
            }
        };
        let frames: Vec<_> = read.iter().filter_map(|frame| frame.as_ref().ok()).collect();
        assert_eq!(passed, frames.iter().map(|frame| (frame.particles.len(), frame.time)).collect::<Vec<_>>(), "{cut}");
        let fault = read.last().and_then(|frame| frame.as_ref().err());
        let fault = fault.map(|error| matches!(error, ReadError::Truncated { .. }));
        assert_eq!(ended, fault, "{cut}");
    }
    let at: usize = text.split_inclusive('\n').take(4).map(str::len).sum();
    let rest = FrameReader::behind(&text.as_bytes()[at..], 4).collect::<Result<Vec<_>, _>>().unwrap();
    assert_eq!(rest, read(text.as_bytes()).into_iter().skip(1).map(Result::unwrap).collect::<Vec<_>>());
    let mut cut = FrameReader::behind(&text.as_bytes()[at..text.len() - 20], 4).skip(1);
    assert_eq!(cut.next().unwrap().unwrap_err().line(), Some(7));
}
