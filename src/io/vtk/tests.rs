//! Reads VTK files back with an independent reader.

use std::fs;
use std::path::Path;

use crate::Vector;
use crate::base::numbers::index;
use crate::io::convert::convert;
use crate::io::convert::tests::{chain, trajectory};
use crate::model::{Format, Units};
use crate::trajectory::Frame;

fn attribute<'a>(text: &'a str, name: &str) -> &'a str {
    let start = text.find(&format!("{name}=\"")).unwrap() + name.len() + 2;
    &text[start..start + text[start..].find('"').unwrap()]
}

struct File {
    text: String,
    appended: Vec<u8>,
}

impl File {
    fn read(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap();
        let end = b"\n</AppendedData>\n</VTKFile>\n";
        assert!(bytes.ends_with(end));
        let appended = bytes[at + mark.len()..bytes.len() - end.len()].to_vec();
        Self { text: String::from_utf8(bytes[..at].to_vec()).unwrap(), appended }
    }

    fn section(&self, tag: &str) -> &str {
        let (open, close) = (format!("<{tag}>"), format!("</{tag}>"));
        &self.text[self.text.find(&open).unwrap()..self.text.find(&close).unwrap()]
    }

    fn bytes(&self, section: &str, name: &str, kind: &str) -> Vec<u8> {
        let element = section.split("/>").find(|element| element.contains(&format!("Name=\"{name}\""))).unwrap();
        let element = &element[element.rfind("<DataArray").unwrap()..];
        assert_eq!(attribute(element, "type"), kind);
        let offset: usize = attribute(element, "offset").parse().unwrap();
        let length = index(u64::from_le_bytes(self.appended[offset..offset + 8].try_into().unwrap()));
        self.appended[offset + 8..offset + 8 + length].to_vec()
    }

    fn floats(&self, tag: &str, name: &str) -> Vec<f64> {
        let bytes = self.bytes(self.section(tag), name, "Float64");
        bytes.chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect()
    }

    fn indices(&self, name: &str) -> Vec<u32> {
        let bytes = self.bytes(self.section("PointData"), name, "UInt32");
        bytes.chunks(4).map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap())).collect()
    }

    fn cells(&self, tag: &str, name: &str) -> Vec<i64> {
        let bytes = self.bytes(self.section(tag), name, "Int64");
        bytes.chunks(8).map(|bytes| i64::from_le_bytes(bytes.try_into().unwrap())).collect()
    }
}

fn in_folder(frames: &[Frame]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("a.xyz");
    trajectory(&source, frames);
    convert(&source, Format::Vtk, &folder.path().join("vtk"), &Default::default()).unwrap();
    folder
}

#[test]
fn vtk_frame_has_all_particle_data_and_bonds() {
    let folder = in_folder(&[Frame { units: Units::new("mm", "g", "ms"), ..chain() }]);
    let file = File::read(&folder.path().join("vtk/frame_000000.vtp"));
    for (name, count) in [("Points", "4"), ("Verts", "4"), ("Lines", "3")] {
        assert_eq!(attribute(&file.text, &format!("NumberOf{name}")), count);
    }
    assert_eq!(file.floats("FieldData", "TimeValue"), [0.25]);
    assert_eq!(file.floats("FieldData", "box"), [-2.0, -1.0, 0.0, 2.0, 5.0, 10.0]);
    assert_eq!(file.floats("FieldData", "displacement"), [0.0]);
    assert!(file.text.contains("NumberOfTuples=\"2\" format=\"ascii\">98 101 97 100 0 98 111 98 0</Array>"));
    let units = "Name=\"units\" NumberOfTuples=\"3\" format=\"ascii\">109 109 0 103 0 109 115 0</Array>";
    assert!(file.section("FieldData").contains(units));
    let positions: Vec<f64> = (0..4).flat_map(|id| [f64::from(id) - 1.5, 0.1, 2.0]).collect();
    assert_eq!(file.floats("Points", "Points"), positions);
    assert_eq!(file.floats("PointData", "radius"), [0.5, 0.75, 0.5, 0.5]);
    assert_eq!(file.floats("PointData", "velocity")[..4], [1.0, 0.1 + 0.2, -2e-9, 0.0]);
    assert_eq!((file.indices("species"), file.indices("id")), (vec![0, 1, 0, 0], vec![0, 1, 2, 3]));
    assert_eq!(file.bytes(file.section("PointData"), "static", "UInt8"), [0, 1, 0, 0]);
    assert_eq!(
        (file.cells("Verts", "connectivity"), file.cells("Verts", "offsets")),
        (vec![0, 1, 2, 3], vec![1, 2, 3, 4])
    );
    // The bond between particles 3 and 0 crosses a periodic side, so no line is drawn.
    assert_eq!(file.cells("Lines", "connectivity"), [0, 1, 2, 1, 2, 3]);
    assert_eq!(file.cells("Lines", "offsets"), [2, 4, 6]);
}

#[test]
fn displacement_of_a_sheared_box_is_written() {
    let mut frame = Frame { displacement: 2.0, ..chain() };
    frame.periodic[1] = true;
    let folder = in_folder(&[frame]);
    let file = File::read(&folder.path().join("vtk/frame_000000.vtp"));
    assert_eq!(file.floats("FieldData", "displacement"), [2.0]);
}

#[test]
fn bond_longer_than_half_a_period_is_not_drawn() {
    let lines = |separation: Vector| {
        let mut frame = chain();
        frame.bonds.truncate(1);
        frame.particles[1].position = frame.particles[0].position + separation;
        let folder = in_folder(&[frame]);
        let file = File::read(&folder.path().join("vtk/frame_000000.vtp"));
        attribute(&file.text, "NumberOfLines").to_owned()
    };
    assert_eq!(lines(Vector::new(2.0, 0.0, 0.0)), "1");
    assert_eq!(lines(Vector::new(2.0_f64.next_up(), 0.0, 0.0)), "0");
    assert_eq!(lines(Vector::new(0.0, 0.0, -5.5)), "0");
    assert_eq!(lines(Vector::new(0.0, 5.5, 0.0)), "1");
}

#[test]
fn frame_list_has_all_times_and_box_has_twelve_edges() {
    let frames = [0.0, 1e-9, 2.5].map(|time| Frame { time, ..chain() });
    let folder = in_folder(&frames);
    let list = fs::read_to_string(folder.path().join("vtk/trajectory.pvd")).unwrap();
    let found: Vec<(&str, &str)> = list
        .lines()
        .filter(|line| line.starts_with("<DataSet"))
        .map(|line| (attribute(line, "timestep"), attribute(line, "file")))
        .collect();
    assert_eq!(found, [("0", "frame_000000.vtp"), ("1e-9", "frame_000001.vtp"), ("2.5", "frame_000002.vtp")]);
    assert!(list.ends_with("</Collection>\n</VTKFile>\n"));
    let edges = File::read(&folder.path().join("vtk/box.vtp"));
    let corners = edges.floats("Points", "Points");
    let ends = edges.cells("Lines", "connectivity");
    assert_eq!((corners.len(), ends.len()), (24, 24));
    let corner = |index: i64| Vector::from_column_slice(&corners[3 * usize::try_from(index).unwrap()..][..3]);
    let total: f64 = ends.chunks(2).map(|ends| (corner(ends[0]) - corner(ends[1])).norm()).sum();
    assert_eq!(total, 4.0 * (4.0 + 6.0 + 10.0));
}

#[test]
fn velocities_that_are_not_known_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("a.xyz");
    fs::write(&source, "1\n\nO 1 2 3\n").unwrap();
    convert(&source, Format::Vtk, &folder.path().join("vtk"), &Default::default()).unwrap();
    let file = File::read(&folder.path().join("vtk/frame_000000.vtp"));
    assert!(!file.text.contains("velocity") && file.floats("Points", "Points") == [1.0, 2.0, 3.0]);
}

#[test]
fn surfaces_are_written_at_the_time_of_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let surfaces = folder.path().join("surfaces");
    fs::create_dir(&surfaces).unwrap();
    let cube = crate::model::TriangleMesh::cuboid(&Vector::zeros(), &Vector::repeat(1.0));
    for name in ["gate.stl", "piston.stl"] {
        crate::mesh::write_stl(&cube, &mut fs::File::create(surfaces.join(name)).unwrap()).unwrap();
    }
    let list = r#"[{"file": "piston.stl", "motions": [{"from": 1.0, "until": null,
        "kind": {"Translation": {"velocity": [0.5, 0.0, 0.0], "acceleration": [0.0, 0.0, 0.0]}}}]},
        {"file": "gate.stl", "motions": []}]"#;
    fs::write(surfaces.join("surfaces.json"), list).unwrap();
    let frames: Vec<Frame> = [(0.0, [true, true]), (3.0, [true, false])]
        .map(|(time, surfaces)| Frame { time, surfaces: surfaces.to_vec(), ..chain() })
        .into();
    let source = folder.path().join("a.xyz");
    trajectory(&source, &frames);
    let target = folder.path().join("vtk");
    convert(&source, Format::Vtk, &target, &Default::default()).unwrap();
    let listed = fs::read_to_string(target.join("surfaces.pvd")).unwrap();
    let files: Vec<[&str; 2]> = listed
        .lines()
        .filter(|line| line.starts_with("<DataSet"))
        .map(|line| [attribute(line, "timestep"), attribute(line, "file")])
        .collect();
    let expected =
        [["0", "surface_0_gate.vtp"], ["0", "surface_1_piston_000000.vtp"], ["3", "surface_1_piston_000001.vtp"]];
    assert_eq!(files, expected);
    let ends = |name: &str| {
        let file = File::read(&target.join(name));
        assert_eq!((attribute(&file.text, "NumberOfPolys"), file.cells("Polys", "offsets")[11]), ("12", 36));
        let points = file.floats("Points", "Points");
        let xs = || points.iter().step_by(3).copied();
        (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max))
    };
    let ends: Vec<(f64, f64)> = files.iter().map(|[_, file]| ends(file)).collect();
    assert_eq!(ends, [(0.0, 1.0), (0.0, 1.0), (1.0, 2.0)]);
    fs::write(surfaces.join("gate.stl"), "solid\nfacet").unwrap();
    let error = convert(&source, Format::Vtk, &folder.path().join("other"), &Default::default()).unwrap_err();
    assert!(error.to_string().contains("gate.stl") && !folder.path().join("other").exists(), "{error}");
}
