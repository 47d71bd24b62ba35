//! Every scene of `configs/` is valid, and is what its comments say.

use carom::scene::Scene;

#[test]
fn every_scene_of_configs_loads() {
    let mut count = 0;
    for entry in std::fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        let scene = Scene::from_file(&path).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
        assert_eq!(Some(scene.name.as_str()), path.file_stem().and_then(|stem| stem.to_str()));
        assert_eq!(scene.leaks(), [], "{}", scene.name);
        println!("{}: {} particles", scene.name, scene.particles.len());
        count += 1;
    }
    assert_eq!(count, 9);
}

#[test]
fn the_hopper_is_the_one_of_the_paper_and_holds() {
    let scene = Scene::from_file("configs/hopper.toml").unwrap();
    let mesh: usize = scene.meshes.iter().map(|mesh| mesh.particles.len()).sum();
    println!("{mesh} mesh spheres, {} grains", scene.particles.len() - mesh);
    assert!((1600..1800).contains(&mesh), "{mesh} mesh spheres");
    assert_eq!(scene.gaps(), []);
    // Every grain starts inside of the bin: its centre keeps the contact distance 2 to the wall of radius 17.
    for particle in scene.particles.iter().filter(|particle| particle.species.0 == 0) {
        assert!(particle.position.xy().norm() < 15.0);
    }
}

#[test]
fn the_pendulum_is_straight_and_its_links_are_of_the_same_slack() {
    let scene = Scene::from_file("configs/pendulum.toml").unwrap();
    assert_eq!(scene.bonds.len(), 10);
    for bond in &scene.bonds {
        let [a, b] = bond.pair.map(|id| &scene.particles[id.0 as usize]);
        let interaction = &scene.interactions[bond.interaction.0 as usize];
        let core = interaction.potential.core().unwrap();
        assert!((interaction.potential.range() / core - 1.06).abs() < 1e-15);
        assert!(((b.position - a.position).norm() / core - 1.05).abs() < 1e-12);
        assert_eq!(interaction.restitution, 0.9);
    }
    // Links of beads share one interaction; that of the bob has its own diameter.
    assert_eq!(scene.bonds[0].interaction, scene.bonds[8].interaction);
    assert_eq!(scene.interactions[scene.bonds[9].interaction.0 as usize].potential.core(), Some(1.5));
}
