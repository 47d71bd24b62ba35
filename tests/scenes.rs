//! Every scene in `configs/` is valid and agrees with its comments.

use carom::model::{Restitution, Scene};

#[test]
fn every_scene_of_configs_loads() {
    let mut count = 0;
    for entry in std::fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let scene = Scene::from_file(&path).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
        assert_eq!(Some(scene.name()), path.file_stem().and_then(|stem| stem.to_str()));
        assert_eq!(scene.leaks(), [], "{}", scene.name());
        assert_eq!(carom::run::burdens(&scene), [], "{}", scene.name());
        println!("{}: {} particles", scene.name(), scene.particles().len());
        count += 1;
    }
    assert_eq!(count, 36);
}

#[test]
fn hopper_matches_the_paper_and_has_no_gaps() {
    let scene = Scene::from_file("configs/hopper.toml").unwrap();
    let surface: usize = scene.static_surfaces().iter().map(|surface| surface.particles.len()).sum();
    println!("{surface} surface spheres, {} grains", scene.particles().len() - surface);
    assert!((1600..1800).contains(&surface), "{surface} surface spheres");
    assert_eq!(scene.gaps(), []);
    // The centre of each grain keeps the contact distance of 2 from the wall of radius 17.
    for particle in scene.particles().iter().filter(|particle| particle.species.0 == 0) {
        assert!(particle.position.xy().norm() < 15.0);
    }
}

#[test]
fn pendulum_is_straight_and_its_links_have_equal_slack() {
    let scene = Scene::from_file("configs/pendulum.toml").unwrap();
    assert_eq!(scene.bonds().len(), 10);
    for bond in scene.bonds() {
        let [a, b] = bond.pair.map(|id| &scene.particles()[id.0 as usize]);
        let interaction = &scene.interactions()[bond.interaction.0 as usize];
        let core = interaction.potential.core().unwrap();
        assert!((interaction.potential.range() / core - 1.06).abs() < 1e-15);
        assert!(((b.position - a.position).norm() / core - 1.05).abs() < 1e-12);
        assert_eq!(interaction.law.restitution, Restitution::Constant(0.9));
    }
    assert_eq!(scene.bonds()[0].interaction, scene.bonds()[8].interaction);
    assert_eq!(scene.interactions()[scene.bonds()[9].interaction.0 as usize].potential.core(), Some(1.5));
}

#[test]
fn the_disks_of_maxwell_start_with_one_speed_and_no_momentum() {
    let scene = Scene::from_file("configs/maxwell.toml").unwrap();
    let velocities = || scene.particles().iter().map(|particle| particle.velocity);
    assert!(velocities().all(|velocity| (velocity.norm() - 1.0).abs() < 4.0 * f64::EPSILON && velocity.z == 0.0));
    assert!(velocities().sum::<carom::Vector>().norm() < 1e-12);
}

#[test]
fn cradle_balls_nearly_touch_and_the_first_is_raised() {
    let scene = Scene::from_file("configs/cradle.toml").unwrap();
    let position = |id: usize| scene.particles()[id].position;
    for id in 1..4 {
        let gap = (position(id + 1) - position(id)).norm() - 1.0;
        assert!(gap > 0.0 && gap < 0.01, "{gap}");
    }
    assert!(position(0).z > position(1).z + 1.0);
    for bond in scene.bonds() {
        let [ball, pivot] = bond.pair.map(|id| position(id.0 as usize));
        assert!((1.0 - (ball - pivot).norm() / 6.0).abs() < 1e-4);
    }
}

const FLUID: &str = r#"
[space]
size = [12.0, 12.0, 12.0]
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[species]]
name = "B"
mass = 2.0
diameter = 0.5
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[interaction]]
name = "link"
potential = "bond"
lambda = 1.2
[[particle]]
species = "A"
position = [-1.0, 13.0, 5.0]
[[chain]]
species = "A"
length = 10
count = 12
bond = "link"
temperature = 1.0
[[fill]]
composition = { A = 0.25, B = 0.75 }
arrangement = "random"
count = 400
temperature = 2.0
[run]
until_time = 1.0
"#;

fn separation(scene: &Scene, a: usize, b: usize) -> f64 {
    let difference = scene.particles()[a].position - scene.particles()[b].position;
    carom::model::space::minimum_image(difference, &scene.space().periods()).norm()
}

#[test]
fn a_start_has_what_was_asked_for_and_nothing_overlaps() {
    let scene = Scene::from_toml(FLUID, "fluid.toml").unwrap();
    assert_eq!(scene.particles().len(), 1 + 120 + 400);
    let fill = &scene.particles()[121..];
    assert_eq!(fill.iter().filter(|particle| particle.species.0 == 0).count(), 100);
    assert_eq!(scene.particles()[0].position, carom::Vector::new(11.0, 1.0, 5.0), "wrapped into the box");
    assert_eq!(scene.bonds().len(), 12 * 9);
    let bonded: Vec<[u32; 2]> = scene.bonds().iter().map(|bond| bond.pair.map(|id| id.0)).collect();
    for a in 0..scene.particles().len() {
        for b in 0..a {
            let contact: f64 = 0.5
                * [a, b].map(|k| scene.species()[scene.particles()[k].species.0 as usize].diameter).iter().sum::<f64>();
            let distance = separation(&scene, a, b);
            assert!(distance >= contact - 1e-12, "{a} and {b} are {distance} apart");
            if bonded.contains(&[b, a].map(|id| u32::try_from(id).unwrap())) {
                assert!((distance - 1.1).abs() < 1e-12, "bonds start in the middle");
            }
        }
    }
}

#[test]
fn a_scene_is_a_function_of_its_text() {
    let scene = |seed| Scene::from_toml_with(FLUID, "fluid.toml", &[("seed", seed)]).unwrap();
    assert_eq!(scene("1"), scene("1"));
    assert_ne!(scene("1").particles(), scene("2").particles());
    let cold = Scene::from_toml_with(FLUID, "fluid.toml", &[("chain.0.temperature", "0.0")]).unwrap();
    assert!(scene("1").particles().iter().zip(cold.particles()).all(|(a, b)| a.position == b.position));
}

#[test]
fn coordinates_come_from_a_file_beside_the_scene() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("start.xyz"), "2\n\nA 1 1 1\nB 3 3 3\n").unwrap();
    let (header, rest) = FLUID.split_once("[[particle]]").unwrap();
    let run = &rest[rest.find("[run]").unwrap()..];
    let path = directory.path().join("my scene.toml");
    std::fs::write(&path, format!("{header}[[file]]\npath = \"start.xyz\"\n{run}")).unwrap();
    let scene = Scene::from_file(&path).unwrap();
    assert_eq!(scene.name(), "my_scene");
    assert_eq!(scene.particles()[1].position, carom::Vector::repeat(3.0));
    assert_eq!(scene.particles()[1].species.0, 1);
}

#[test]
fn the_box_follows_from_count_and_density() {
    let scene = Scene::from_file("configs/hard_sphere_fluid.toml").unwrap();
    let sphere = std::f64::consts::PI / 6.0;
    assert!((4000.0 * sphere / scene.space().volume() - 0.4).abs() < 1e-12);
    assert_eq!(scene.particles().len(), 4000);
}

#[test]
fn builder_and_scene_file_pass_the_same_checks() {
    use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    let builder = |restitution| {
        SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(restitution))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.4))
            .temperature(1.0)
            .seed(1)
    };
    assert_eq!(builder(0.9).build().unwrap().particles().len(), 108);
    let error = builder(1.1).build().unwrap_err();
    assert_eq!(error.to_string(), "interaction[0].restitution is 1.1, expected a number from 0 to 1");
}

const POLYDISPERSE: &str = r#"
[[species]]
name = "A"
mass = 2.0
diameter = { distribution = "lognormal", mean = 1.2, deviation = 0.12, classes = 20 }
[[species]]
name = "B"
mass = 1.0
diameter = 1.0
[[interaction]]
name = "contact"
species = ["A", "A"]
potential = "hard-sphere"
restitution = 0.9
[[interaction]]
species = ["B", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[fill]]
composition = { A = 3.0, B = 1.0 }
arrangement = "random"
count = 410
packing_fraction = 0.55
temperature = 1.0
[run]
until_time = 0.5
"#;

#[test]
fn a_distribution_of_diameters_becomes_classes() {
    let scene = Scene::from_toml(POLYDISPERSE, "polydisperse").unwrap();
    let names: Vec<&str> = scene.species().iter().map(|species| species.name.as_str()).collect();
    assert_eq!((names.len(), names[0], names[19], names[20]), (21, "A-1", "A-20", "B"));
    let mut counts = [0; 21];
    scene.particles().iter().for_each(|particle| counts[particle.species.0 as usize] += 1);
    // Three quarters of the 410 particles are in 20 classes, with 15.375 particles on average. The other 102.5
    // particles are of species B.
    assert!(counts[..20].iter().all(|count| (15..=16).contains(count)), "{counts:?}");
    assert!((102..=103).contains(&counts[20]) && counts.iter().sum::<i32>() == 410);
    // Classes with 16 instead of 15 particles are spread over all diameters, so the mean is nearly exact.
    let diameters = (0..20).map(|class| scene.species()[class].diameter * f64::from(counts[class]));
    let mean = diameters.sum::<f64>() / f64::from(410 - counts[20]);
    assert!((mean / 1.2 - 1.0).abs() < 1e-3, "{mean}");
    let packing_fraction = scene.packing_fraction();
    assert!((packing_fraction / 0.55 - 1.0).abs() < 1e-12, "{packing_fraction}");
    for species in &scene.species()[..20] {
        assert!((species.mass / (2.0 * (species.diameter / 1.2).powi(3)) - 1.0).abs() < 1e-12);
    }
    for (a, b, range) in [(2, 7, 1.0), (20, 3, 1.5), (20, 20, 1.0)] {
        let id = scene.table().get(a, b).unwrap();
        let interaction = &scene.interactions()[id.0 as usize];
        let contact = 0.5 * (scene.species()[a].diameter + scene.species()[b].diameter);
        assert_eq!(interaction.potential.core(), Some(contact));
        assert_eq!(interaction.potential.range(), range * contact);
        assert_eq!(interaction.law.restitution, Restitution::Constant(if a == 2 { 0.9 } else { 1.0 }));
    }
    assert_eq!(scene, Scene::from_toml(POLYDISPERSE, "polydisperse").unwrap());
}

#[test]
fn a_polydisperse_fluid_runs_with_a_sound_audit() {
    let scene = Scene::from_toml(POLYDISPERSE, "polydisperse").unwrap();
    let finished = carom::run::run(scene, &mut (), &mut |_| std::ops::ControlFlow::Continue(())).unwrap();
    assert_eq!(finished.audit.faults(), []);
    assert!(finished.measurement.event_counts.core > 1000);
}

#[test]
fn listed_diameters_keep_shares_and_disks_have_mass_by_area() {
    let overrides = [
        ("species.A.diameter", "{ distribution = \"list\", diameters = [1.0, 2.0], shares = [3, 1] }"),
        ("fill.0.composition", "{ A = 1.0 }"),
        ("fill.0.count", "400"),
        ("space.z", "flat"),
    ];
    let scene = Scene::from_toml_with(POLYDISPERSE, "list", &overrides).unwrap();
    let count = |class| scene.particles().iter().filter(|particle| particle.species.0 == class).count();
    assert_eq!((count(0), count(1), scene.species().len()), (300, 100, 3));
    for species in &scene.species()[..2] {
        assert!((species.mass - 2.0 * (species.diameter / 1.25).powi(2)).abs() < 1e-14);
    }
    assert!((scene.packing_fraction() / 0.55 - 1.0).abs() < 1e-12);
}

#[test]
fn species_that_have_no_particles_take_no_memory() {
    use std::fmt::Write;

    // Square tables for this number of species would need about 50 GB.
    const SPECIES: usize = 30_000;
    let mut text = "[space]\nsize = [10.0, 10.0, 10.0]\n".to_owned();
    for id in 0..SPECIES {
        writeln!(text, "[[species]]\nname = \"S{id}\"\nmass = 1.0\ndiameter = 1.0").unwrap();
    }
    for (a, b) in [(0, 0), (0, 20_000), (20_000, 20_000), (7, 29_999)] {
        writeln!(text, "[[interaction]]\nspecies = [\"S{a}\", \"S{b}\"]\npotential = \"hard-sphere\"").unwrap();
    }
    for (kind, x) in [(0, 1.0), (20_000, 4.0), (20_000, 7.0)] {
        let velocity = if kind == 0 { 1.0 } else { 0.0 };
        writeln!(
            text,
            "[[particle]]\nspecies = \"S{kind}\"\nposition = [{x:?}, 5.0, 5.0]\nvelocity = [{velocity:?}, 0.0, 0.0]"
        )
        .unwrap();
    }
    text.push_str("[run]\nuntil_events = 3\n");
    let scene = Scene::from_toml(text, "many").unwrap();
    let mut simulation = carom::engine::Simulation::without_plan(scene);
    let mut pairs = Vec::new();
    let until = carom::engine::Until::events(3);
    simulation.advance_with(until, |event| pairs.push([event.particle.0, event.partner().unwrap().0])).unwrap();
    pairs.iter_mut().for_each(|pair| pair.sort_unstable());
    // The impulse passes from sphere to sphere and through a periodic side.
    assert_eq!(pairs, [[0, 1], [1, 2], [0, 2]]);
}

fn filled(region: &str, arrangement: &str, amount: &str, is_flat: bool) -> Result<Scene, carom::scene::SceneError> {
    let space = if is_flat { "size = [20.0, 20.0, 0.0]\nz = \"flat\"" } else { "size = [20.0, 20.0, 20.0]" };
    let text = format!(
        "[space]\n{space}\n[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 0.8\n[[interaction]]\nspecies = [\"A\", \"A\"]\n\
         potential = \"hard-sphere\"\n[[fill]]\nspecies = \"A\"\narrangement = \"{arrangement}\"\n{amount}\nregion = {{ {region} }}\n\
         [run]\nuntil_time = 1.0\n"
    );
    Scene::from_toml(text, "scene.toml")
}

#[test]
fn fills_of_curved_regions_have_their_density_and_stay_inside() {
    use std::f64::consts::PI;

    let sphere = "shape = \"sphere\", centre = [10.0, 10.0, 10.0], radius = 6.0";
    let tube = "shape = \"cylinder\", base = [6.0, 7.0, 5.0], axis = [0.0, 3.0, 4.0], radius = 3.0, length = 10.0";
    let funnel =
        "shape = \"cone\", base = [10.0, 10.0, 2.0], axis = [0.0, 0.0, 2.0], radii = [2.0, 7.0], length = 12.0";
    let flat = |region: &str| region.replace("10.0], radius", "0.0], radius");
    let strip = "shape = \"cylinder\", base = [5.0, 5.0, 0.0], axis = [4.0, 3.0, 0.0], radius = 2.0, length = 10.0";
    let (in_space, in_plane) = (0.8_f64.powi(3) * PI / 6.0, 0.8_f64.powi(2) * PI / 4.0);
    for (region, is_flat, volume) in [
        (sphere, false, 4.0 / 3.0 * PI * 216.0),
        (tube, false, PI * 90.0),
        (funnel, false, PI * 4.0 * (4.0 + 14.0 + 49.0)),
        (&flat(sphere), true, PI * 36.0),
        (strip, true, 40.0),
    ] {
        let lattice = if is_flat { "hexagonal" } else { "fcc" };
        for arrangement in ["random", lattice] {
            let scene = filled(region, arrangement, "packing_fraction = 0.2", is_flat).unwrap();
            let expected = (0.2 * volume / if is_flat { in_plane } else { in_space }).round();
            assert_eq!(scene.particles().len() as f64, expected, "{region} {arrangement}");
            for particle in scene.particles() {
                let p = particle.position;
                let is_inside = if region == tube {
                    let axis = carom::Vector::new(0.0, 0.6, 0.8);
                    let from = p - carom::Vector::new(6.0, 7.0, 5.0);
                    let along = from.dot(&axis);
                    (0.4 - 1e-9..9.6 + 1e-9).contains(&along) && (from - axis * along).norm() < 2.6 + 1e-9
                } else if region == funnel {
                    (2.4 - 1e-9..13.6 + 1e-9).contains(&p.z)
                        && (p.xy().add_scalar(-10.0)).norm() < 2.0 + 5.0 * (p.z - 2.0) / 12.0
                } else if region == strip {
                    let across = -0.6 * (p.x - 5.0) + 0.8 * (p.y - 5.0);
                    across.abs() < 1.6 + 1e-9
                } else {
                    (p - carom::Vector::new(10.0, 10.0, if is_flat { 0.0 } else { 10.0 })).norm() < 5.6 + 1e-9
                };
                assert!(is_inside, "{region} {arrangement}: {p}");
            }
            assert_eq!(filled(region, arrangement, "count = 7", is_flat).unwrap().particles().len(), 7);
        }
    }
    assert!(filled(sphere, "fcc", "packing_fraction = 0.7", false).unwrap_err().to_string().contains("0.8"));
    assert!(
        filled(sphere, "random", "packing_fraction = 0.5", false).unwrap_err().to_string().contains("found no place")
    );
}
