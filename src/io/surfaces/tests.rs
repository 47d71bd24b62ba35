use std::ops::ControlFlow;

use super::*;
use crate::Vector;
use crate::io::{Completed, Existing, Folder};
use crate::mesh::read_mesh;
use crate::model::space::{Boundary, Space};
use crate::model::{MotionKind, RunPlan, SurfaceShape, TriangleMesh, Until};
use crate::run::Run;
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};

fn scene() -> Scene {
    let mesh = TriangleMesh::cuboid(&Vector::repeat(1.0), &Vector::repeat(2.0));
    let sphere = SurfaceShape::Sphere { centre: Vector::repeat(7.0), radius: 1.0, is_inside: false };
    let plane = SurfaceShape::Plane { point: Vector::repeat(-5.0), normal: Vector::x() };
    SceneBuilder::new("obstacles")
        .space(Space { boundary: [Boundary::walls(1.0); 3], ..Space::periodic_cube(10.0) })
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .surface(SurfaceDraft::new("a box", SurfaceShape::Mesh(mesh)))
        .surface(SurfaceDraft::new("sphere", sphere))
        .surface(SurfaceDraft::new("beyond", plane))
        .particle("A", Vector::new(5.0, 5.0, 5.0), Vector::new(1.0, 0.7, 0.3))
        .particle("A", Vector::new(3.0, 5.0, 5.0), Vector::new(-1.0, 0.2, 0.1))
        .run(RunPlan { limit: Until::time(50.0), ..RunPlan::default() })
        .build()
        .unwrap()
}

fn run(target: &Path, existing: Existing) -> Completed {
    let mut folder = Folder::create(target, &scene(), existing).unwrap();
    let finished = Run::new(scene()).execute(&mut folder, &mut |_| ControlFlow::Continue(())).unwrap();
    folder.complete(&finished, "").unwrap()
}

#[test]
fn a_run_has_the_surfaces_of_its_scene_as_files() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    let completed = run(&target, Existing::Keep);
    let files = ["a_box.stl", "sphere.stl"].map(|name| target.join("surfaces").join(name));
    assert_eq!(surface_files(&target), files);
    assert!(files.iter().all(|file| completed.files.contains(file)));
    assert!(files.iter().all(|file| Folder::files_of(&target).contains(file)));
    let read = read_mesh("", "stl", &fs::read(&files[0]).unwrap()).unwrap();
    assert_eq!((read.triangles.len(), read.enclosed_volume()), (12, 1.0));
    // A replacement of the run writes its own surface files, and keeps the user's files.
    let mine = target.join("surfaces/mine.txt");
    fs::write(&mine, "years").unwrap();
    fs::write(&files[0], "changed").unwrap();
    run(&target, Existing::Replace);
    assert_eq!(surface_files(&target), files);
    assert!(fs::read(&files[0]).unwrap().starts_with(b"carom") && mine.exists());
    assert!(!target.join("replacement").exists());
}

#[test]
fn foreign_surface_file_is_not_replaced() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    run(&target, Existing::Keep);
    let scene = scene();
    let listed = fs::read_to_string(target.join(".carom")).unwrap();
    fs::write(target.join(".carom"), listed.replace("+ surfaces/sphere.stl\n", "")).unwrap();
    let refused = Folder::create(&target, &scene, Existing::Replace).unwrap_err();
    assert!(matches!(refused, OutputError::Foreign(path) if path == target.join("surfaces/sphere.stl")));
}

#[test]
fn a_resumed_run_writes_only_the_files_that_are_missing() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    run(&target, Existing::Keep);
    let [first, second] = ["a_box.stl", "sphere.stl"].map(|name| target.join("surfaces").join(name));
    fs::write(&first, "as it was").unwrap();
    let before = fs::read(&second).unwrap();
    fs::remove_file(&second).unwrap();
    let (folder, _) = Folder::resume(&target, Some(Until::time(60.0))).unwrap();
    assert_eq!(fs::read(&first).unwrap(), b"as it was");
    assert!(fs::read(&second).unwrap() == before);
    drop(folder);
    // Older versions wrote no surface files.
    fs::remove_dir_all(target.join("surfaces")).unwrap();
    let (_folder, checkpoint) = Folder::resume(&target, None).unwrap();
    assert_eq!(checkpoint.simulation.scene().surfaces().len(), 3);
    assert_eq!(surface_files(&target), [first, second]);
}

#[test]
fn names_of_files_are_safe_and_unique() {
    let mut taken = BTreeSet::new();
    let names = [
        ("hopper", "hopper"),
        ("Hopper", "Hopper-2"),
        ("left wall", "left_wall"),
        ("left_wall", "left_wall-2"),
        ("left wall-2", "left_wall-2-2"),
        ("a.b(c)+d", "a.b(c)+d"),
        ("\u{e9}t\u{e9}", "_t_"),
        ("con", "_con"),
        ("AUX.old", "_AUX.old"),
        ("COM1", "_COM1"),
        ("../x", ".._x"),
        ("cone", "cone"),
    ];
    for (name, expected) in names {
        assert_eq!(file_name(name, &mut taken), expected);
    }
    let long = "\u{e9}".repeat(100);
    assert_eq!(file_name(&long, &mut taken), "_".repeat(80));
    assert_eq!(file_name(&long, &mut taken), format!("{}-2", "_".repeat(80)));
}

#[test]
fn surface_motions_are_written_beside_their_meshes() {
    let kind = MotionKind::Translation { velocity: Vector::z() * 0.1, acceleration: Vector::zeros() };
    let motions =
        [SurfaceMotion { from: 1.0, until: 2.0, kind }, SurfaceMotion { from: 2.0, until: f64::INFINITY, kind }];
    let mut parts = scene().into_parts();
    parts.surfaces[1].motions = motions.to_vec();
    let moving = Scene::new(parts).unwrap();
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    drop(Folder::create(&target, &moving, Existing::Keep).unwrap());
    let listed =
        |file: &str, motions: &[SurfaceMotion]| ListedSurface { file: file.to_owned(), motions: motions.to_vec() };
    let expected = [listed("a_box.stl", &[]), listed("sphere.stl", &motions), listed("beyond.stl", &[])];
    assert_eq!(listed_surfaces(&target).unwrap(), expected);
    let mut parts = scene().into_parts();
    parts.surfaces[1].stages = vec!["measurement".to_owned()];
    let going = place.path().join("going");
    drop(Folder::create(&going, &Scene::new(parts).unwrap(), Existing::Keep).unwrap());
    assert_eq!(listed_surfaces(&going).unwrap().len(), 3);
    let still = place.path().join("still");
    drop(Folder::create(&still, &scene(), Existing::Keep).unwrap());
    assert!(listed_surfaces(&still).unwrap().is_empty() && !still.join("surfaces/surfaces.json").exists());
    let file = target.join("surfaces/surfaces.json");
    fs::write(&file, "[").unwrap();
    assert_eq!(listed_surfaces(&target).unwrap_err().0, file);
}
