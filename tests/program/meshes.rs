//! Meshes from damaged files or with damaged geometry.

use super::place::{Place, code, errors, line, words};

const SCENE: &str = r#"
[space]
size = [10.0, 10.0, 10.0]
x = "open"
y = "open"
z = "open"

[[species]]
name = "grain"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["grain", "grain"]
potential = "hard-sphere"

[[surface]]
name = "bin"
shape = "mesh"
path = "bin.stl"

[[particle]]
species = "grain"
position = [5.0, 5.0, 5.0]
velocity = [0.1, 0.0, 0.0]

[run]
until_time = 1.0
"#;

const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

const BOX: [[usize; 3]; 12] = [
    [0, 2, 1],
    [0, 3, 2],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
];

type Triangle = [[f64; 3]; 3];

fn text(triangles: &[Triangle]) -> String {
    let mut text = "solid bin\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid bin\n"
}

fn box_at(corner: [f64; 3], edge: f64) -> Vec<Triangle> {
    let place = |k: usize| std::array::from_fn(|axis| corner[axis] + edge * CORNERS[k][axis]);
    BOX.iter().map(|triangle| triangle.map(place)).collect()
}

fn binary(announced: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(announced.to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        triangle.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn invalid_mesh_files_are_rejected_with_place_and_help() {
    let good = text(&box_at([1.0; 3], 8.0));
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, f32::NAN]];
    let cases: [(&str, Vec<u8>, &[&str]); 7] = [
        ("empty", Vec::new(), &["empty", "export it again"]),
        ("no triangles", b"solid bin\nendsolid bin\n".to_vec(), &["no triangle", "export a surface"]),
        ("cut off", good.as_bytes()[..good.len() / 2].to_vec(), &["line ", "expected"]),
        ("not a number", good.replacen("vertex 9", "vertex NaN", 1).into_bytes(), &["NaN", "expected"]),
        ("a word", good.replacen("outer loop", "outer lop", 1).into_bytes(), &["line 3", "expected"]),
        ("10 GB", binary(200_000_000, &[]), &["200000000 triangles", "expected 10000000084 bytes"]),
        ("NaN in binary", binary(1, &[triangle]), &["NaN", "finite"]),
    ];
    for (name, content, told) in cases {
        let place = Place::with(SCENE);
        std::fs::write(place.path().join("bin.stl"), content).unwrap();
        for command in [&["check", "scene.toml"][..], &["run", "scene.toml", "--quiet"]] {
            let output = place.carom(command);
            let text = line(&output);
            assert_eq!(code(&output), 2, "{name}: {text}");
            assert!(text.contains("bin.stl"), "{name}: {text}");
            told.iter().for_each(|told| assert!(text.contains(told), "{name}: no `{told}` in {text}"));
        }
        assert!(!place.path().join("runs").exists(), "{name}: nothing is left behind");
    }
}

#[test]
fn bad_mesh_geometry_is_reported_with_triangles_and_help() {
    let good = box_at([1.0; 3], 8.0);
    let open = good[1..].to_vec();
    let inverted: Vec<_> = good.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let one_inverted: Vec<_> = inverted[..1].iter().chain(&good[1..]).copied().collect();
    let crossing: Vec<_> = good.iter().chain(&box_at([7.0, 7.2, 7.4], 6.0)).copied().collect();
    let twice: Vec<_> = good.iter().chain(&good[3..4]).copied().collect();
    let tiny = box_at([0.001; 3], 0.008);
    let cases: [(&str, Vec<Triangle>, &[&str]); 6] = [
        ("open", open, &["open", "rim"]),
        ("inverted", inverted, &["normals point inwards"]),
        ("one inverted", one_inverted, &["normals", "recalculate"]),
        ("crossing", crossing, &["intersect or overlap", "boolean"]),
        ("twice", twice, &["delete one of the faces"]),
        ("millimetres", tiny, &["scale"]),
    ];
    for (name, triangles, told) in cases {
        let place = Place::with(SCENE);
        place.write("bin.stl", &text(&triangles));
        let output = place.carom(&["check", "scene.toml"]);
        let text = format!("{}{}", words(&output), errors(&output));
        let text = text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(code(&output), 0, "{name}: {text}");
        told.iter().for_each(|told| assert!(text.contains(told), "{name}: no `{told}` in {text}"));
        place.write("scene.toml", &SCENE.replace("path =", "closed = true\npath ="));
        let output = place.carom(&["run", "scene.toml", "--quiet"]);
        let text = errors(&output);
        if name == "millimetres" {
            assert_eq!(code(&output), 0, "{text}");
        } else {
            assert_eq!(code(&output), 2, "{name}: {text}");
            assert!(text.contains("bin.stl") && text.contains("because of `closed`"), "{name}: {text}");
        }
    }
}

#[test]
fn particles_are_counted_inside_of_a_closed_mesh() {
    let place = Place::with("");
    place.write("bin.stl", &text(&box_at([0.0; 3], 1.0)));
    // Two counting regions cover the same cube. One region is a mesh that is turned by a right angle about z.
    let more = r#"
[[fill]]
species = "grain"
arrangement = "sc"
count = 27
temperature = 1.0
region = { lower = [0.6, 0.6, 0.6], upper = [9.4, 9.4, 9.4] }

[output]
thermo_interval = 0.25

[[output.count]]
name = "mesh"
path = "bin.stl"
scale = 4.0
rotation = { axis = [0.0, 0.0, 1.0], angle = 90.0 }
translation = [7.0, 2.0, 3.0]

[[output.count]]
name = "box"
lower = [3.0, 2.0, 3.0]
upper = [7.0, 6.0, 7.0]

[run]
until_time = 5.0
"#;
    let (head, _) = SCENE.split_once("[[surface]]").unwrap();
    place.write("scene.toml", &format!("{head}{more}").replace("\"open\"", "\"walls\""));
    place.done(&["run", "scene.toml", "--quiet"]);
    let rows = place.thermo("runs/scene");
    assert!(rows.len() > 15 && rows.iter().all(|row| row["in_mesh"] == row["in_box"]), "{rows:?}");
    assert!(rows.iter().any(|row| row["in_box"] != rows[0]["in_box"]), "{rows:?}");
    let record = place.read("runs/scene/scene.toml");
    assert!(record.contains("checksum = \"crc32:"), "{record}");
    place.write("bin.stl", &text(&box_at([0.0; 3], 2.0)));
    place.refused(&["check", "runs/scene/scene.toml"], &["checksum"]);
    place.write("bin.stl", &text(&box_at([0.0; 3], 1.0)[1..]));
    let output = place.carom(&["check", "scene.toml"]);
    let told = line(&output);
    assert!(code(&output) == 2 && told.contains("output.count[0].path") && told.contains("rim"), "{told}");
}
