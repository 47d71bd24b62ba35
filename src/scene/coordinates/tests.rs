use super::*;
use crate::Vector;
use crate::analysis::instruments::Scalar;
use crate::engine::{Simulation, Until};
use crate::model::Scene;
use crate::model::potential::Potential;
use crate::model::space::Space;
use crate::scene::{Chain, Fill, InteractionDraft, Lattice, Model, SpeciesDraft};
use crate::trajectory::extended_xyz::write_frame;

#[test]
fn columns_are_found_by_name() {
    let text = "2\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=id:I:1:species:S:1:velo:R:3:pos:R:3 Time=0\n\
                0 A 1 2 3 4 5 6\n1 B 0 0 0 7 8 9\n";
    let Start { frame, has_box, comment, .. } = parse(text.as_bytes(), 0).unwrap();
    assert_eq!(frame.species[0].name, "A");
    assert_eq!(frame.particles[0].position, Vector::new(4.0, 5.0, 6.0));
    assert_eq!(frame.particles[0].velocity, Vector::new(1.0, 2.0, 3.0));
    assert_eq!(frame.particles[1].position, Vector::new(7.0, 8.0, 9.0));
    assert!(has_box && comment == 2);
}

#[test]
fn plain_xyz_needs_only_species_and_coordinates() {
    let text = b"1\n\nA 1 2 3\n1\n\nA 4 5 6\n";
    let Start { frame, has_box, comment, .. } = parse(text, 1).unwrap();
    assert_eq!(frame.particles[0].position, Vector::new(4.0, 5.0, 6.0));
    assert!(!has_box && comment == 5);
    assert_eq!(parse(text, 2).unwrap_err(), (6, "the file ends after 2 frames, expected frame 2".to_owned()));
    assert_eq!(parse(text, 3).unwrap_err(), (6, "the file ends after 2 frames, expected frame 3".to_owned()));
}

#[test]
fn file_errors_name_the_line() {
    assert_eq!(parse(b"", 0).unwrap_err().0, 1);
    let error = parse(b"x\n\n", 0).unwrap_err();
    assert_eq!(error, (1, "expected the number of particles of a frame, 0 to 4294967295, found `x`".to_owned()));
    assert!(parse(b"2\n\nA 1 2 3\n", 0).unwrap_err().1.contains("expected 2 particles, the file ends after 1"));
    assert_eq!(parse(b"1\n\nA 1 2\n", 0).unwrap_err(), (3, "expected 4 columns, found 3".to_owned()));
    assert_eq!(parse(b"1\n\nA 1 nan 3\n", 0).unwrap_err().1, "position is `nan`, expected a finite number");
    assert!(parse(b"1\nProperties=pos:R:3\n1 2 3\n", 0).unwrap_err().1.contains("type:S:1"));
    assert!(parse(b"99999999999999999\n\nA 1 2 3\n", 0).is_err(), "the announced number is not allocated");
}

fn started(frame: &Frame, scene: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    write_frame(std::fs::File::create(folder.path().join("start.xyz")).unwrap(), frame).unwrap();
    let text = format!("{scene}\n[run]\nuntil_events = 10\n");
    Scene::from_toml(text, folder.path().join("scene.toml"))
}

const BEADS: &str = r#"
[[species]]
name = "bead"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["bead", "bead"]
potential = "hard-sphere"
[[interaction]]
name = "slack"
potential = "bond"
shortest = 0.5
longest = 1.5
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.5
longest = 0.9
"#;

#[test]
fn spins_of_a_file_are_the_spins_of_its_particles() {
    let text = format!(
        "{BEADS}[[particle]]\nspecies = \"bead\"\nposition = [1.0, 1.0, 1.0]\n[[file]]\npath = \"start.xyz\"\n"
    );
    let rough = text.replace("\"hard-sphere\"", "\"hard-sphere\"\nfriction = 0.5");
    let beads = SceneBuilder::new("beads")
        .space(Space::periodic_cube(9.0))
        .species(SpeciesDraft::new("bead").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bead", "bead"))
        .particle("bead", Vector::new(3.0, 4.0, 4.0), Vector::zeros())
        .particle("bead", Vector::new(6.0, 4.0, 4.0), Vector::zeros());
    let spins = [Vector::new(0.1, -2.5, 1e-3), Vector::new(0.0, 3.7, -0.2)];
    let component = |k: usize| Scalar::new(SPINS[k], spins.iter().map(|spin| spin[k]).collect());
    let frame = Frame { scalars: (0..3).map(component).collect(), ..Frame::start_of(&beads.build().unwrap()) };
    let scene = started(&frame, &rough).unwrap();
    let found: Vec<(f64, Vector)> =
        scene.particles().iter().map(|particle| (particle.position.x, particle.spin)).collect();
    assert_eq!(found, [(1.0, Vector::zeros()), (3.0, spins[0]), (6.0, spins[1])]);
    assert_eq!(scene.inputs[0].unused, [] as [&str; 0]);
    // Particles of a smooth scene do not spin.
    let smooth = started(&frame, &text).unwrap();
    assert!(smooth.particles().iter().all(|particle| particle.spin == Vector::zeros()));
    let lost = Frame { scalars: frame.scalars[1..].to_vec(), ..frame };
    let scene = started(&lost, &rough).unwrap();
    assert!(scene.particles().iter().all(|particle| particle.spin == Vector::zeros()));
    assert_eq!(scene.inputs[0].unused, ["omegay", "omegaz"]);
}

/// Bonded neighbours overlap. The frame lists the particles in reverse.
fn chains() -> Frame {
    let straight = |y, bond: &str| Chain {
        species: "bead".into(),
        length: 3,
        count: 1,
        bond: bond.into(),
        spacing: Some(0.8),
        straight: Some((Vector::new(1.0, y, 2.0), Vector::x())),
        temperature: None,
        speed: None,
    };
    let scene = SceneBuilder::new("chains")
        .species(SpeciesDraft::new("bead").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bead", "bead"))
        .interaction(InteractionDraft::new(Potential::bond(0.5, 1.5).unwrap()).named("slack"))
        .interaction(InteractionDraft::new(Potential::bond(0.5, 0.9).unwrap()).named("link"))
        .space(Space {
            lower: Vector::new(0.5, -1.0, 0.0),
            size: Vector::new(8.0, 9.0, 10.0),
            ..Space::periodic_cube(1.0)
        })
        .chain(straight(1.0, "link"))
        .chain(straight(4.0, "slack"))
        .build()
        .unwrap();
    let mut frame = Frame::start_of(&scene);
    frame.particles.reverse();
    frame.images.clear();
    frame
}

#[test]
fn bonds_and_box_of_a_frame_are_those_of_the_scene() {
    let scene = started(
        &chains(),
        &format!(
            "{BEADS}[[particle]]\nspecies = \"bead\"\nposition = [6.0, 6.0, 6.0]\n[[file]]\npath = \"start.xyz\"\n"
        ),
    )
    .unwrap();
    assert_eq!((scene.space.lower, scene.space.size), (Vector::new(0.5, -1.0, 0.0), Vector::new(8.0, 9.0, 10.0)));
    // The single particle has the id 0. Particle 5 of the frame comes first and gets the id 1.
    let bonds: Vec<_> = scene
        .bonds
        .iter()
        .map(|bond| {
            let name = scene.interactions[bond.interaction.0 as usize].name.as_deref().unwrap();
            (bond.pair.map(|id| id.0), name)
        })
        .collect();
    assert_eq!(bonds, [([5, 6], "link"), ([4, 5], "link"), ([2, 3], "slack"), ([1, 2], "slack")]);
    let all = started(&chains(), &format!("{BEADS}[[file]]\npath = \"start.xyz\"\nbond = \"slack\"\n")).unwrap();
    assert!(all.bonds.iter().all(|bond| bond.interaction == all.bonds[0].interaction));
    let sized =
        started(&chains(), &format!("{BEADS}[space]\nsize = [20.0, 20.0, 20.0]\n[[file]]\npath = \"start.xyz\"\n"));
    assert_eq!(sized.unwrap().space.size, Vector::repeat(20.0));
}

#[test]
fn unresolvable_bonds_are_reported_with_file_and_line() {
    let file = "[[file]]\npath = \"start.xyz\"\n";
    let without_link = BEADS[..BEADS.rfind("[[interaction]]").unwrap()].to_owned();
    let error = |frame: &Frame, scene: String| started(frame, &scene).unwrap_err().to_string();
    let found = error(&chains(), format!("{without_link}{file}"));
    assert!(found.contains("start.xyz, line 2: bonds are held by `link`") && found.contains("slack"), "{found}");
    let nameless = Frame { bond_kinds: Vec::new(), bond_names: Vec::new(), ..chains() };
    let found = error(&nameless, format!("{BEADS}{file}"));
    assert!(found.contains("start.xyz, line 2: `bonds` do not name their interaction"), "{found}");
    let found = error(&nameless, format!("{BEADS}{file}bond = \"lnk\"\n"));
    assert!(found.contains("file[0].bond: unknown interaction `lnk`"), "{found}");
    let mut lost = chains();
    lost.bonds[1][1].0 = 77;
    let found = error(&lost, format!("{BEADS}{file}"));
    assert!(found.contains("line 2: bond 1-77 ends at a particle that is not in the frame"), "{found}");
}

#[test]
fn boundaries_missing_from_the_frame_must_be_given() {
    let mut frame = chains();
    frame.periodic[2] = false;
    let file = "[[file]]\npath = \"start.xyz\"\n";
    let found = started(&frame, &format!("{BEADS}{file}")).unwrap_err().to_string();
    assert!(found.contains("`z` is missing"), "{found}");
    let walls = started(&frame, &format!("{BEADS}[space]\nz = \"walls\"\n{file}")).unwrap();
    assert_eq!(walls.space.boundary, [Boundary::Periodic, Boundary::Periodic, Boundary::walls(1.0)]);
}

const BALLS: &str = r#"
[[species]]
name = "ball"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["ball", "ball"]
potential = "hard-sphere"
restitution = 0.7
[[file]]
path = "start.xyz"
"#;

#[test]
fn start_from_a_sheared_frame_keeps_its_image_displacement() {
    let sheared = SceneBuilder::new("sheared")
        .species(SpeciesDraft::new("ball").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "ball").restitution(0.7))
        .space(Space::periodic_cube(5.0))
        .fill(Fill::new(Lattice::SimpleCubic, "ball").count(64))
        .temperature(1.0)
        .shear(0.7)
        .build()
        .unwrap();
    let mut frame = Frame::start_of(&sheared);
    let mut simulation = Simulation::without_plan(sheared);
    simulation.advance(Until::time(3.1)).unwrap();
    let snapshot = simulation.snapshot();
    frame.displacement = snapshot.displacement;
    for (particle, (position, velocity)) in
        frame.particles.iter_mut().zip(snapshot.positions.iter().zip(&snapshot.velocities))
    {
        (particle.position, particle.velocity) = (*position, *velocity);
    }
    assert!(frame.displacement.abs() > 0.5, "{}", frame.displacement);
    let scene = started(&frame, &format!("{BALLS}[space]\nshear_rate = 0.7\n")).unwrap();
    assert_eq!(scene.displacement, frame.displacement);
    // The two trajectories differ only by round-off, which collisions amplify.
    let mut again = Simulation::without_plan(scene);
    assert!((again.snapshot().displacement - frame.displacement).abs() < 1e-12);
    simulation.advance(Until::time(3.3)).unwrap();
    again.advance(Until::time(0.2)).unwrap();
    let (one, other) = (simulation.snapshot(), again.snapshot());
    assert!(again.event_counts().physical() > 5, "{}", again.event_counts().physical());
    for (a, b) in one.positions.iter().zip(&other.positions) {
        assert!(frame_of(&one).nearest_image(a - b).norm() < 1e-9, "{a} {b}");
    }
    let elsewhere = Frame { displacement: 0.0, ..frame.clone() };
    let found = started(&elsewhere, &format!("{BALLS}[space]\nshear_rate = 0.7\n")).unwrap_err().to_string();
    assert!(found.contains("overlap at the start"), "{found}");
    let found = started(&frame, BALLS).unwrap_err().to_string();
    assert!(found.contains("`shear_rate` is missing: the periodic images are displaced"), "{found}");
}

/// Only the box of this frame is used.
fn frame_of(snapshot: &crate::engine::Snapshot) -> Frame {
    let mut frame = chains();
    (frame.lower, frame.size, frame.displacement) = (Vector::zeros(), Vector::repeat(5.0), snapshot.displacement);
    frame
}

#[test]
fn a_file_in_other_units_than_the_scene_is_refused() {
    let file = "[[file]]\npath = \"start.xyz\"\nbond = \"link\"\n";
    let units = |length: &str| format!("{BEADS}{file}[units]\nlength = \"{length}\"\nmass = \"g\"\ntime = \"ms\"\n");
    let in_millimetres = Frame { units: Units::new("mm", "g", "ms"), ..chains() };
    let error = started(&in_millimetres, &units("cm")).unwrap_err().to_string();
    let expected = "line 2: the units are mm, g and ms, expected cm, g and ms as in [units]: no number is converted";
    assert!(error.contains(expected), "{error}");
    for (frame, scene) in
        [(&in_millimetres, units("mm")), (&in_millimetres, format!("{BEADS}{file}")), (&chains(), units("cm"))]
    {
        started(frame, &scene).unwrap();
    }
}

#[test]
fn a_file_with_other_radii_or_masses_than_the_species_is_refused() {
    let file = "[[file]]\npath = \"start.xyz\"\n";
    let error = |frame: &Frame| started(frame, &format!("{BEADS}{file}")).unwrap_err().to_string();
    let mut grown = chains();
    grown.particles.iter_mut().for_each(|particle| particle.radius *= 1.1);
    let found = error(&grown);
    for expected in ["start.xyz, line 3: ", "has a radius of 0.55", "species `bead`", "has 0.5", "its diameter to 1.1"]
    {
        assert!(found.contains(expected), "{expected}: {found}");
    }
    let mut one = chains();
    one.particles[3].radius = 0.51;
    assert!(error(&one).contains("line 6: "), "{}", error(&one));
    let mut heavy = chains();
    heavy.species[0].mass = Some(2.0);
    let found = error(&heavy);
    assert!(
        found.contains("line 2: the species `bead` has a mass of 2, but 1 in the scene: set its mass to 2"),
        "{found}"
    );
    // The masses are not compared if the species is static in the file, or if the file has no mass.
    let mut frozen = chains();
    (frozen.species[0].mass, frozen.species[0].is_static) = (Some(f64::INFINITY), true);
    started(&frozen, &format!("{BEADS}{file}")).unwrap();
    let mut untold = chains();
    untold.species[0].mass = None;
    started(&untold, &format!("{BEADS}{file}")).unwrap();
}

fn of_text(text: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("start.xyz"), text).unwrap();
    let scene = "space = { size = [9.0, 9.0, 9.0] }\nspecies = [{ name = 'A', mass = 2.0, diameter = 1.0 }]\n\
        interaction = [{ species = ['A', 'A'], potential = 'hard-sphere' }]\nfile = [{ path = 'start.xyz' }]\nrun = { until_time = 1.0 }\n";
    Scene::from_toml(scene, folder.path().join("scene.toml"))
}

#[test]
fn momenta_are_velocities_times_masses() {
    let file = |columns: &str, more: &str| {
        format!("2\nProperties=species:S:1:pos:R:3:{columns}\nA 1 1 1 {more} 3 0 -5\nA 4 4 4 {more} 0 1 0\n")
    };
    let velocities = |scene: Scene| scene.particles().iter().map(|it| it.velocity).collect::<Vec<_>>();
    let expected = vec![Vector::new(1.5, 0.0, -2.5), Vector::new(0.0, 0.5, 0.0)];
    assert_eq!(velocities(of_text(&file("momenta:R:3", "")).unwrap()), expected);
    assert_eq!(velocities(of_text(&file("masses:R:1:momenta:R:3", "2.0")).unwrap()), expected);
    let both = file("velo:R:3:momenta:R:3", "7 8 9");
    assert_eq!(velocities(of_text(&both).unwrap()), [Vector::new(7.0, 8.0, 9.0); 2]);
    let error = of_text(&file("masses:R:1:momenta:R:3", "1.0")).unwrap_err().to_string();
    assert!(
        error.contains("start.xyz, line 3: the particle has a mass of 1, but the species `A` of the scene has 2"),
        "{error}"
    );
    let error = of_text(&file("masses:R:1:momenta:R:3", "-1.0")).unwrap_err().to_string();
    assert!(error.contains("line 3: mass is `-1.0`, expected a finite mass"), "{error}");
}

#[test]
fn malformed_velocity_columns_are_rejected_and_unused_columns_listed() {
    let error = of_text("1\nProperties=species:S:1:pos:R:3:velo:R:2\nA 1 1 1 3 0\n").unwrap_err().to_string();
    assert!(error.contains("line 2: ") && error.contains("`velo:R:3`"), "{error}");
    let text = "1\nProperties=species:S:1:pos:R:3:forces:R:3:initial_charges:R:1:id:I:1\nA 1 1 1 0 0 0 0.5 0\n";
    let scene = of_text(text).unwrap();
    assert_eq!(scene.inputs()[0].unused, ["forces", "initial_charges"]);
    #[cfg(feature = "view")]
    {
        let warnings = crate::view::description::warnings(&scene);
        assert!(warnings.iter().any(|it| it.contains("start.xyz: `forces`, `initial_charges`")), "{warnings:?}");
    }
    assert!(
        of_text("1\nProperties=species:S:1:pos:R:3:velo:R:3\nA 1 1 1 3 0 0\n").unwrap().inputs()[0].unused.is_empty()
    );
}
