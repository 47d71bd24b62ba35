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
