mod damaged;

use super::*;
use crate::Vector;
use crate::mesh::write_stl::write_stl;

/// Returns a sheet of squares with coordinates that are exact in every format.
fn sheet(side: u32) -> TriangleMesh {
    let corner = |x: u32, y: u32| Vector::new(f64::from(x) - 1.0, f64::from(y), 0.5 * f64::from((x * y) % 3));
    let square = |k: u32| {
        let (x, y) = (k % side, k / side);
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    TriangleMesh::welded((0..side * side).flat_map(square))
}

fn binary(mesh: &TriangleMesh) -> Vec<u8> {
    let mut content = Vec::new();
    write_stl(mesh, &mut content).unwrap();
    content
}

fn text(mesh: &TriangleMesh) -> Vec<u8> {
    let mut text = String::from("solid of a test\n");
    for corners in mesh.all_corners() {
        text += "  facet normal nan 0 -1e0\n    outer loop\n";
        corners.iter().for_each(|c| text += &format!("      vertex {:e} {} {}\n", c.x, c.y, c.z));
        text += "    endloop\n  endfacet\n";
    }
    (text + "endsolid of a test\n").into_bytes()
}

fn obj(mesh: &TriangleMesh) -> Vec<u8> {
    let mut text = String::from("# a test\nmtllib x.mtl\no test\n");
    mesh.vertices.iter().for_each(|c| text += &format!("v {} {} {}\n", c.x, c.y, c.z));
    text += "vn 0 0 1\ns off\n";
    mesh.triangles.iter().for_each(|t| text += &format!("f {}//1 {}//1 {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    text.into_bytes()
}

fn refused(extension: &str, content: impl AsRef<[u8]>) -> String {
    let error = read_mesh("part", extension, content.as_ref()).unwrap_err();
    let message = error.to_string();
    message.strip_prefix("part: ").unwrap_or_else(|| panic!("{message}")).to_owned()
}

fn facet(vertices: &str) -> String {
    format!("facet normal 0 0 1\nouter loop\n{vertices}\nendloop\nendfacet\n")
}

const CORNERS: &str = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0";

#[test]
fn each_format_reads_back() {
    let mesh = sheet(5);
    assert_eq!(read_mesh("a", "stl", &binary(&mesh)).unwrap(), mesh);
    assert_eq!(read_mesh("a", ".STL", &text(&mesh)).unwrap(), mesh);
    assert_eq!(read_mesh("a", "Obj", &obj(&mesh)).unwrap(), mesh);
}

#[test]
fn text_keeps_all_digits_of_a_number() {
    let x = 0.1 + 0.2;
    let text = facet(&format!("vertex {x} 0 0\nvertex 1 0 0\nvertex 0 1 0"));
    let mesh = read_mesh("a", "stl", format!("solid\n{text}endsolid").as_bytes()).unwrap();
    assert_eq!(mesh.vertices[0].x, x);
    let mesh = read_mesh("a", "obj", format!("v {x} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").as_bytes()).unwrap();
    assert_eq!(mesh.vertices[0].x, x);
}

#[test]
fn binary_stl_may_begin_with_solid_and_truncation_is_reported() {
    let mesh = sheet(3);
    for header in [&b"solid part"[..], b"SOLID\n", b"solid facet normal 0 0 1 outer loop vertex"] {
        let mut content = binary(&mesh);
        content[..80].fill(b' ');
        content[..header.len()].copy_from_slice(header);
        assert_eq!(read_mesh("a", "stl", &content).unwrap(), mesh);
        content.truncate(700);
        assert_eq!(
            refused("stl", &content),
            "the header announces 18 triangles: expected 984 bytes, found 700, enough for 12; the file is damaged or cut off, \
            copy or export it again"
        );
    }
}

#[test]
fn triangle_count_in_header_is_checked_against_file_length() {
    let mut content = binary(&sheet(1));
    for count in [200_000_000, u32::MAX, 1, 3] {
        content[80..84].copy_from_slice(&u32::to_le_bytes(count));
        let expected = 84 + 50 * u64::from(count);
        assert!(refused("stl", &content).contains(&format!("expected {expected} bytes, found 184, enough for 2;")));
    }
    content[80..84].fill(0);
    content.truncate(84);
    assert!(refused("stl", &content).starts_with("the file has no triangle: expected at least one triangle after"));
    content.truncate(83);
    assert!(refused("stl", &content).contains("found 83 other bytes"));
}

#[test]
fn binary_coordinates_must_be_finite() {
    for (bytes, shown) in [(f32::NAN, "NaN"), (f32::NEG_INFINITY, "-inf")] {
        let mut content = binary(&sheet(2));
        // A coordinate of the second corner of triangle 3.
        content[84 + 3 * 50 + 24..][..4].copy_from_slice(&bytes.to_le_bytes());
        let message = refused("stl", &content);
        assert!(message.starts_with(&format!("triangle 3 (from 0): coordinate is `{shown}`, expected a finite")));
    }
    let mut content = binary(&sheet(2));
    content[84..96].fill(0xff);
    assert!(read_mesh("a", "stl", &content).is_ok());
}

#[test]
fn empty_and_unknown_files_are_refused() {
    for extension in ["stl", "obj"] {
        for content in [&b""[..], b" \r\n\t\n"] {
            assert_eq!(refused(extension, content), "the file is empty: expected a mesh; export it again");
        }
        assert!(refused(extension, b"\xff\xfes\0o\0").contains("UTF-16"));
    }
    assert!(refused("ply", b"ply").starts_with("`ply` is not a supported mesh format: expected `stl` or `obj`"));
    assert!(refused("stl", "facet ".repeat(100)).contains("expected text that begins with `solid`"));
}

#[test]
fn text_stl_is_read_with_any_name_case_and_layout() {
    let body = facet(CORNERS);
    let bytes = |parts: &[&[u8]]| parts.concat();
    for content in [
        bytes(&[b"solid K\xf6rper \xff solid\n", body.as_bytes(), b"endsolid K\xf6rper\n"]),
        bytes(&[b"\xef\xbb\xbfSolid\r\n", body.to_uppercase().replace('\n', "\r\n").as_bytes(), b"EndSolid"]),
        bytes(&[b"solid\n", body.replace('\n', " ").as_bytes(), b"endsolid\n\n \n"]),
        bytes(&[b"\n solid a\nendsolid a\nsolid b\n", body.as_bytes(), b"endsolid b\n"]),
        bytes(&[
            b"solid a\n",
            body.replace("endloop", "end loop").replace("endf", "End F").as_bytes(),
            b"end solid a\n",
        ]),
        bytes(&[b"solid a b\r", body.replace('\n', "\r").as_bytes(), b"endsolid a b\r"]),
        bytes(&[b"solid a b ", body.replace('\n', " ").as_bytes(), b"endsolid a b"]),
        bytes(&[b"solid endsolid ", body.replace('\n', " ").as_bytes(), b"endsolid"]),
    ] {
        assert_eq!(read_mesh("a", "stl", &content).unwrap().triangles, [[0, 1, 2]]);
    }
}

#[test]
fn solids_on_one_line_are_all_read() {
    let other = facet("vertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1");
    let content = format!("solid a {} endsolid a solid b {} endsolid b", facet(CORNERS), other).replace('\n', " ");
    assert_eq!(read_mesh("a", "stl", content.as_bytes()).unwrap().triangles, [[0, 1, 2], [0, 1, 3]]);
    // LF, CR LF and CR each end a line.
    let message = refused("stl", "solid a\rfacet normal 0 0 1\r\nouter loop\nvertex 0 x 0\r");
    assert!(message.starts_with("line 4: found `x`"), "{message}");
}

#[test]
fn trailing_bytes_of_binary_stl_are_ignored_and_counted() {
    let mesh = sheet(2);
    let mut content = binary(&mesh);
    assert_eq!(unread_bytes("stl", &content), 0);
    content.extend_from_slice(b"made by a scanner");
    assert_eq!(read_mesh("a", "STL", &content).unwrap(), mesh);
    assert_eq!(unread_bytes("STL", &content), 17);
    // The appended bytes fill another triangle, so the number of triangles in the header is too small.
    content.extend_from_slice(&[7; 33]);
    assert!(refused("stl", &content).starts_with("the header announces 8 triangles: expected 484 bytes, found 534"));
    assert_eq!(unread_bytes("obj", b"f"), 0);
}

#[test]
fn text_stl_errors_name_the_line() {
    let solid = |body: &str| refused("stl", format!("solid a\n{body}"));
    let whole = facet(CORNERS);
    for (body, expected) in [
        (facet("vertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0"), "line 4: coordinate is `nan`, expected a finite"),
        (facet("vertex 0 0 0\nvertex 1 -inf 0\nvertex 0 1 0"), "line 5: coordinate is `-inf`"),
        (facet("vertex 0 0 0\nvertex 1 0 0\nvertex 0 1e999 0"), "line 6: coordinate is `1e999`"),
        (facet("vertex 0 0,5 0"), "line 4: found `0,5`, expected a coordinate, such as -1.5e-3;"),
        (facet("vertex 0 0\nvertex 1 0 0\nvertex 0 1 0"), "line 5: found `vertex`, expected a coordinate"),
        (
            facet("vertex 0 0 0\nvertex 1 0 0"),
            "line 6: found `endloop`, expected `vertex`, because a facet has three vertices;",
        ),
        (facet(&format!("{CORNERS}\nvertex 1 1 0")), "line 7: found `vertex`, expected `endloop` after three"),
        (facet(&format!("{CORNERS} 7")), "line 6: found `7`, expected `endloop` after three"),
        (whole.replace("1\nouter", "\nouter"), "line 3: found `loop`, expected `outer` after the three components"),
        (format!("{whole}vertex\n"), "line 9: found `vertex`, expected `facet` or `endsolid`;"),
        (whole.clone(), "line 9: the file ends, expected `facet` or `endsolid`; it is cut off"),
        (whole[..whole.len() - 9].to_owned(), "line 8: the file ends, expected `endfacet`;"),
        (format!("{whole}endsolid\n{whole}"), "line 10: found `facet`, expected `solid` or the end"),
        ("endsolid a\n".to_owned(), "the file has no triangle: expected at least one `facet`;"),
        (facet("vertex 0 0 \u{e9}\u{1}"), "line 4: found `\u{e9}\u{fffd}`, expected a coordinate"),
    ] {
        let message = solid(&body);
        assert!(message.starts_with(expected), "{message}");
    }
    let long = solid(&facet(&format!("vertex {}", "9x".repeat(5_000_000))));
    assert!(long.len() < 200 && long.contains("..."), "{long}");
    // A truncated file is always rejected, because it lacks `endsolid`.
    let content = format!("solid a\n{whole}endsolid");
    for end in 0..content.len() {
        assert!(read_mesh("a", "stl", &content.as_bytes()[..end]).is_err());
    }
}

#[test]
fn obj_faces_are_read_in_all_notations() {
    let square = "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n";
    for faces in
        ["f 1 2 3 4", "f 1/5 2/6 3/7 4/", "f 1//9 2//9 3//9 4//9", "f -4/1/1 -3/1/1 -2/1/1 -1/1/1", "f 1 2 \\\r\n3 4"]
    {
        let mesh = read_mesh("a", "obj", format!("{square}{faces}\n").as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{faces}");
        assert_eq!(mesh.area(), 1.0);
    }
    // Faces may precede their vertices, names need not be UTF-8, and vertices may be repeated or unused.
    let mesh =
        read_mesh("a", "obj", b"o \xff\xfe\n# c:\\\nf 2 3 4\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nf 2 4 5")
            .unwrap();
    assert_eq!((mesh.vertices.len(), mesh.triangles), (3, vec![[0, 1, 2], [0, 2, 1]]));
    // Negative vertex numbers count backwards from the last vertex before the face.
    let mesh = read_mesh("a", "obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -3 -1").unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
    assert_eq!(read_mesh("a", "obj", b"v 0 0 0\nv 1 0 0\nf 1 1 2").unwrap().triangles, [[0, 0, 1]]);
}

#[test]
fn concave_obj_face_is_not_filled_outside_its_outline() {
    let outline = "v 10 0 0\nv 10 4 0\nv 4 4 0\nv 4 10 0\nv 0 10 0\nv 0 0 0\n";
    for face in ["f 1 2 3 4 5 6", "f 3 4 5 6 1 2", "f 6 5 4 3 2 1"] {
        let mesh = read_mesh("a", "obj", format!("{outline}{face}\n").as_bytes()).unwrap();
        assert!((mesh.area() - 64.0).abs() < 1e-12, "{face}: {}", mesh.area());
        let is_within = |[a, b, c]: [Vector; 3]| {
            let point = Vector::new(5.5, 5.5, 0.0);
            let side = |from: Vector, to: Vector| (to - from).cross(&(point - from)).z;
            let sides = [side(a, b), side(b, c), side(c, a)];
            sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
        };
        assert!(!mesh.all_corners().any(is_within), "{face}");
    }
}

#[test]
fn obj_errors_name_the_line() {
    let three = |rest: &str| refused("obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{rest}"));
    for (rest, expected) in [
        ("f 1 2 4\n\n", "line 4: the face refers to vertex 4, expected 1 to 3, or -3 to -1;"),
        ("f 1 2 0", "line 4: the face refers to vertex 0,"),
        ("f 1 2 -4", "line 4: the face refers to vertex -4,"),
        ("f 1 2 -9223372036854775808", "line 4: the face refers to vertex -9223372036854775808,"),
        ("f 1 2 9223372036854775807", "line 4: the face refers to vertex 9223372036854775807,"),
        ("f 1 2 99999999999999999999", "line 4: found `99999999999999999999`, expected the number of a vertex"),
        ("f 1 2 3.0", "line 4: found `3.0`, expected the number of a vertex, such as 7, -1 or 7/2/3;"),
        ("f /1 2 3", "line 4: found `/1`, expected"),
        ("\nf 1 2\n", "line 5: the face has 2 corners, expected 3 or more;"),
        ("f\n", "line 4: the face has 0 corners"),
        ("f 1 2 \\\n", "line 4: the face has 2 corners"),
        ("v 1 2\n", "line 4: found `end of line`, expected a coordinate"),
        ("v 1 2 NaN\n", "line 4: coordinate is `NaN`"),
        ("v 1 2 1e61\n", "line 4: coordinate is `1e61`"),
        (
            "v 1 1 0\nv 1 -1 0\nf 3 2 1 4 5\n",
            "line 6: the face of 5 corners has an outline that crosses itself, expected a simple polygon; export the mesh in triangles",
        ),
        ("v 1 1 3\nf 1 2 4 3\n", "line 5: the face of 4 corners is not flat: a corner is "),
        ("l 1 2\n", "the file has no triangle: expected at least one face `f`;"),
    ] {
        let message = three(rest);
        assert!(message.starts_with(expected), "{message}");
    }
    let error = read_mesh("a", "obj", b"v 0 0 x").unwrap_err();
    assert_eq!(error.place(), Some(Place::Line(1)));
}

#[test]
fn stl_writer_rejects_coordinates_beyond_single_precision() {
    use crate::mesh::write_stl::WriteStlError;
    let mut mesh = sheet(1);
    mesh.vertices[3].x = 1e39;
    let mut content = Vec::new();
    assert!(matches!(write_stl(&mesh, &mut content), Err(WriteStlError::Triangle(1))));
    assert!(content.is_empty());
    assert!(binary(&sheet(1)).starts_with(b"carom\0"));
}
