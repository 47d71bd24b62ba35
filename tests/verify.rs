//! The proof of runs: what is right is proven, and what is wrong is found.

use std::ops::ControlFlow;

use carom::scene::Scene;
use carom::verify::{Certificate, End, Stretch, verify};

fn prove(scene: Scene, from: u64, events: u64) -> Certificate {
    verify(scene, Stretch { from, events }, &mut |_| ControlFlow::Continue(()))
}

fn config(name: &str) -> Scene {
    Scene::from_file(format!("configs/{name}.toml")).unwrap()
}

#[test]
fn every_scene_of_configs_is_proven() {
    for (name, events) in [
        ("bouncing_ball", 500),
        ("elastic_spheres_1d", 1000),
        ("granular_cooling", 1000),
        ("hard_sphere_fluid", 1000),
        ("hopper", 600),
        ("pendulum", 1000),
        ("polymer", 1000),
        ("square_well_fluid", 1000),
        ("stepped_lennard_jones", 1000),
    ] {
        let started = std::time::Instant::now();
        let certificate = prove(config(name), 0, events);
        println!("{name}: {:?} {certificate:?}", started.elapsed());
        assert!(certificate.is_proven(), "{name}: {certificate:?}");
        assert!(certificate.counts.events() == events || certificate.end == End::RunEnded, "{name}");
    }
}
