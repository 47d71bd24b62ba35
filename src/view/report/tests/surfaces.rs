use super::*;
use crate::Vector;
use crate::mesh::write_stl;
use crate::model::TriangleMesh;

const OBSTACLE: &str =
    "[[surface]]\nname = \"a box\"\nshape = \"box\"\nlower = [1.3, 1.3, 1.3]\nupper = [1.6, 1.7, 1.5]\n[run]";

fn head(html: &str) -> serde_json::Value {
    let start = html.find("id=\"player-head\">").unwrap() + "id=\"player-head\">".len();
    serde_json::from_str(&html[start..start + html[start..].find("</script>").unwrap()]).unwrap()
}

#[test]
fn the_player_has_the_surfaces_of_the_run() {
    let without = page(run_folder().path()).unwrap().html;
    assert!(head(&without).get("surfaces").is_none() && !without.contains("id=\"player-surface-data\""));
    let hard =
        SCENE.replace("[run]", OBSTACLE).replace("square-well\"\nlambda = 1.5\nwell_depth = 1.0", "hard-sphere\"");
    let place = folder_of(&hard.replace("diameter = 1.0", "diameter = 0.5"));
    let with = page(place.path()).unwrap();
    assert_eq!(with.notes, [""; 0]);
    let surfaces = head(&with.html)["surfaces"].clone();
    assert_eq!(
        (&surfaces["triangles"], &surfaces["edges"], &surfaces["vertices"]),
        (&12.into(), &12.into(), &24.into())
    );
    // Base64 of 12 bytes per triangle and per edge, and 9 bytes per vertex.
    let start = with.html.find("id=\"player-surface-data\">").unwrap() + "id=\"player-surface-data\">".len();
    let length = with.html[start..].find("</script>").unwrap();
    assert_eq!(length, (12 * 12 + 12 * 12 + 24 * 9) / 3 * 4);
    assert!(with.html.contains("Surfaces are read from the folder"));
}

#[test]
fn surfaces_that_are_too_large_or_damaged_are_left_out_with_a_note() {
    let run = run_folder();
    let folder = run.path().join("surfaces");
    fs::create_dir(&folder).unwrap();
    let tile = |k: u32| {
        let at = |a: u32, b: f64| Vector::new(f64::from(a) * 1e-4, b, 0.0);
        [at(k, 0.0), at(k + 1, 0.0), at(k, 1.0)]
    };
    let write = |name: &str, count: u32| {
        let mesh = TriangleMesh::welded((0..count).map(tile));
        write_stl(&mesh, &mut fs::File::create(folder.join(name)).unwrap()).unwrap();
    };
    write("a.stl", 49_000);
    write("b.stl", 2_000);
    write("c.stl", 1_000);
    fs::write(folder.join("d<b>.stl"), "solid\nfacet").unwrap();
    let page = page(run.path()).unwrap();
    assert_eq!(page.notes.len(), 2);
    assert!(
        page.notes[0].starts_with("surfaces/b.stl: the player does not show it: it has 2000 triangles"),
        "{:?}",
        page.notes
    );
    assert!(page.notes[1].starts_with("surfaces/d<b>.stl: ") && !page.html.contains("d<b>.stl"), "{:?}", page.notes);
    assert_eq!(head(&page.html)["surfaces"]["triangles"], 50_000);
    assert!(page.html.len() < 4_000_000, "{}", page.html.len());
}

#[test]
fn a_large_surface_does_not_make_the_particles_small() {
    let run = run_folder();
    let folder = run.path().join("surfaces");
    fs::create_dir(&folder).unwrap();
    let view = |size: f64| {
        let mesh = TriangleMesh::cuboid(&Vector::zeros(), &Vector::repeat(size));
        write_stl(&mesh, &mut fs::File::create(folder.join("it.stl")).unwrap()).unwrap();
        head(&page(run.path()).unwrap().html)["view"].clone()
    };
    let numbers = |upper: f64| serde_json::json!([[0.0, 0.0, 0.0], [upper, upper, upper]]);
    assert_eq!([view(5.0), view(8.0), view(1e3)], [numbers(6.0), numbers(8.0), numbers(6.0)]);
}

#[test]
fn player_moves_surfaces_with_each_frame() {
    let gate = OBSTACLE.replace("[run]", "stages = [\"first\"]\n[[surface]]\nname = \"rod\"\nshape = \"capsule\"\nstart = [4.3, 4.4, 4.5]\nend = [4.3, 4.5, 4.5]\nradius = 0.1\n[[surface.motion]]\nkind = \"translation\"\nvelocity = [0.25, 0.0, 0.0]\n[[stage]]\nname = \"first\"\nmeasure = true\nuntil_time = 1.0\n[run]");
    let hard = SCENE.replace("[run]", &gate).replace("square-well\"\nlambda = 1.5\nwell_depth = 1.0", "hard-sphere\"");
    let hard = hard.replace("6.0, 6.0]\n[[species", "6.0, 6.0]\nx = \"walls\"\n[[species");
    let place = folder_of(&hard.replace("diameter = 1.0", "diameter = 0.5"));
    let head = head(&page(place.path()).unwrap().html);
    assert_eq!(head["surfaces"]["parts"].as_array().unwrap().len(), 2);
    let mut seen = [0; 2];
    for frame in head["frames"].as_array().unwrap() {
        let (time, poses) = (frame["time"].as_f64().unwrap(), &frame["poses"]);
        // The gate is removed at t = 1. A frame at this time may show the gate.
        assert!(if time < 1.0 { !poses[0].is_null() } else { poses[0].is_null() || time == 1.0 }, "{time} {poses}");
        assert!((poses[1][9].as_f64().unwrap() - 0.25 * time).abs() < 1e-12 && poses[1][0] == 1.0, "{time} {poses}");
        seen[usize::from(poses[0].is_null())] += 1;
    }
    assert!(seen.iter().all(|count| *count > 5), "{seen:?}");
}
