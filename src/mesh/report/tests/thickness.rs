use super::*;

fn plate(height: f64, thickness: f64) -> TriangleMesh {
    cuboid(&Vector::new(0.0, 0.0, height), &Vector::new(3.0, 2.0, height + thickness)).unwrap()
}

#[test]
fn walls_and_gaps_of_closed_meshes_are_told_apart() {
    let mesh = both(&plate(0.0, 0.25), &plate(0.25 + 0.0625, 0.5));
    let report = assert_clean(&mesh);
    assert_eq!((report.wall.unwrap().distance, report.gap.unwrap().distance), (0.25, 0.0625));
    assert_eq!(report.thinnest, report.gap);
    let gap = report.gap.unwrap();
    assert!(gap.triangle < 12 && gap.other >= 12);
    // Turned inside out, the plates are gaps in a solid.
    let report = assert_clean(&inside_out(&mesh));
    assert_eq!((report.wall.unwrap().distance, report.gap.unwrap().distance), (0.25, 0.0625));
    let alone = assert_clean(&plate(0.0, 1.0));
    assert_eq!((alone.wall.unwrap().distance, alone.gap), (1.0, None));
}

#[test]
fn hollow_shell_reports_wall_thickness_and_cavity_width() {
    let shell =
        both(&icosphere(&Vector::zeros(), 2.0, 3).unwrap(), &inside_out(&icosphere(&Vector::zeros(), 1.5, 3).unwrap()));
    let report = assert_clean(&shell);
    assert!((report.wall.unwrap().distance - 0.5).abs() < 0.01, "{:?}", report.wall);
    assert!((report.gap.unwrap().distance - 3.0).abs() < 0.05, "{:?}", report.gap);
}

#[test]
fn open_sheets_have_one_distance_whichever_way_they_face() {
    let sheet = |z: f64| disc(&Vector::new(0.0, 0.0, z), &Vector::z(), 1.0, 0.1).unwrap();
    for upper in [sheet(0.125), inside_out(&sheet(0.125))] {
        let report = MeshReport::of(&both(&sheet(0.0), &upper));
        assert_eq!((report.thinnest.unwrap().distance, report.wall, report.gap), (0.125, None, None));
    }
    assert_eq!(MeshReport::of(&sheet(0.0)).thinnest, None);
    let inclined = |degrees: f64| {
        let upper = sheet(3.0).transformed(1.0, &Rotation3::new(Vector::x() * degrees.to_radians()), &Vector::zeros());
        let wide = sheet(0.0).transformed(50.0, &Rotation3::identity(), &Vector::zeros());
        MeshReport::of(&both(&upper, &wide)).thinnest
    };
    assert!(inclined(59.5).is_some());
    assert_eq!(inclined(60.5), None);
}

#[test]
fn tree_finds_the_same_thinnest_wall_as_brute_force() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for _ in 0..20 {
        let mut mesh = icosphere(&Vector::zeros(), 1.0, 2).unwrap();
        mesh.vertices.iter_mut().for_each(|vertex| *vertex *= 0.4 + uniform(&mut random));
        let report = assert_clean(&mesh);
        // The foot is the point where the line along the normal crosses the plane of the other triangle. It is inside
        // that triangle if the areas of the three triangles between foot and sides add up to the area of that triangle.
        let mut shortest = [f64::INFINITY; 2];
        for (i, corners) in mesh.all_corners().enumerate() {
            let normal = crate::model::triangle_mesh::twice_area(&corners).normalize();
            let middle = corners.iter().sum::<Vector>() / 3.0;
            for (j, other) in mesh.all_corners().enumerate() {
                let area = crate::model::triangle_mesh::twice_area(&other);
                let cosine = normal.dot(&area.normalize());
                if mesh.triangles[i].iter().any(|number| mesh.triangles[j].contains(number)) || cosine > -0.5 {
                    continue;
                }
                let distance = (other[0] - middle).dot(&area) / normal.dot(&area);
                let foot = middle + normal * distance;
                let [a, b, c] = other.map(|corner| corner - foot);
                let parts = a.cross(&b).norm() + b.cross(&c).norm() + c.cross(&a).norm();
                if parts < area.norm() * (1.0 + 1e-9) {
                    let shortest = &mut shortest[usize::from(distance < 0.0)];
                    *shortest = shortest.min(distance.abs());
                }
            }
        }
        let found = [report.gap, report.wall].map(|found| found.map_or(f64::INFINITY, |found| found.distance));
        assert!(found.iter().zip(shortest).all(|(a, b)| *a == b || (a - b).abs() < 1e-9), "{found:?} {shortest:?}");
    }
}
