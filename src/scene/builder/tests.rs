use super::*;
use crate::model::{Potential, Restitution};
use crate::scene::{Lattice, Model};

fn begun() -> (SceneBuilder, SpeciesId) {
    let mut scene = SceneBuilder::new("dimers")
        .space(Space::periodic_cube(12.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bead", "bead").restitution(0.9))
        .interaction(InteractionDraft::new(Potential::bond(1.0, 1.4).unwrap()).named("rope"));
    let bead = scene.insert_species(SpeciesDraft::new("bead").mass(1.3).diameter(1.0));
    (scene, bead)
}

#[test]
fn inserted_items_get_the_ids_of_the_built_scene() {
    let (mut scene, bead) = begun();
    let wall = scene.insert_species(SpeciesDraft::new("wall").diameter(1.0).fixed());
    let at = |x: f64| Vector::new(x, 1.0, 1.0);
    let chain = Chain {
        species: "bead".to_owned(),
        length: 4,
        count: 1,
        bond: "rope".to_owned(),
        spacing: Some(1.2),
        straight: Some((Vector::new(1.0, 6.0, 6.0), Vector::x())),
        temperature: None,
        speed: None,
    };
    let first = scene.insert_particle("bead", at(1.0), Vector::zeros());
    let beads = scene.insert_chain(chain);
    let last = scene.insert_particle("bead", at(2.2), Vector::zeros());
    let sphere = scene.insert_particle("wall", at(9.0), Vector::zeros());
    let hard = InteractionDraft::new(Model::HardSphere).between("bead", "wall");
    let scene = scene.interaction(hard).bond([first, last], "rope").build().unwrap();
    assert_eq!([first, beads, last, sphere].map(|id| id.0), [0, 1, 5, 6]);
    assert_eq!((scene.species_of(last).mass, scene.species_of(sphere).is_static()), (1.3, true));
    assert_eq!((scene.species()[bead.0 as usize].name.as_str(), scene.particles()[6].species), ("bead", wall));
    assert!(scene.bonds().iter().any(|bond| bond.pair == [first, last]));
    assert_eq!(scene.interactions()[0].law.restitution, Restitution::Constant(0.9));
}

#[test]
fn unknown_ids_and_species_without_mass_are_rejected() {
    let fill = || Fill::new(Lattice::SimpleCubic, "bead");
    let insert = |fill: Fill| {
        let (scene, _) = begun();
        let mut scene = scene.fill(fill.region(Vector::repeat(4.0), Vector::repeat(11.0)));
        let id = scene.insert_particle("bead", Vector::repeat(1.0), Vector::zeros());
        scene.build().map(|_| id.0)
    };
    assert_eq!(insert(fill().count(27)).unwrap(), 27);
    let error = insert(fill().number_density(0.05)).unwrap_err().to_string();
    assert!(error.starts_with("particle[0] is given after a fill"), "{error}");
    // A particle may be added after a fill of unknown count if the id of the particle is not requested.
    let (scene, _) = begun();
    let scene = scene.fill(fill().number_density(0.05).region(Vector::repeat(4.0), Vector::repeat(11.0)));
    assert!(scene.clone().particle("bead", Vector::repeat(1.0), Vector::zeros()).build().is_ok());
    let error = scene.species(SpeciesDraft::new("dust").diameter(0.1)).build().unwrap_err().to_string();
    assert!(error.starts_with("species[1]: `mass` is missing"), "{error}");
}

#[test]
fn temperature_and_speed_apply_to_all_fills_and_chains_without_their_own() {
    let lower = |x: f64| (Vector::new(x, 4.0, 4.0), Vector::new(x + 4.0, 11.0, 11.0));
    let fill = |x| Fill::new(Lattice::SimpleCubic, "bead").count(27).region(lower(x).0, lower(x).1);
    let chain = || Chain {
        species: "bead".to_owned(),
        length: 4,
        count: 1,
        bond: "rope".to_owned(),
        spacing: Some(1.2),
        straight: Some((Vector::new(1.0, 2.0, 2.0), Vector::x())),
        temperature: None,
        speed: None,
    };
    let own = || Fill { temperature: Some(0.5), ..fill(7.0) };
    for set in [|scene: SceneBuilder| scene.temperature(1.5), |scene: SceneBuilder| scene.speed(1.5)] {
        let before = set(begun().0).fill(fill(1.0)).chain(chain()).fill(own()).build().unwrap();
        let between = set(begun().0.fill(fill(1.0))).chain(chain()).fill(own()).build().unwrap();
        let after = set(begun().0.fill(fill(1.0)).chain(chain()).fill(own())).build().unwrap();
        assert!(before == after && between == after);
        let energy = |ids: std::ops::Range<usize>| {
            after.particles()[ids].iter().map(|particle| particle.velocity.norm_squared()).sum::<f64>()
        };
        assert!(energy(0..27) > 0.0 && energy(27..31) > 0.0);
        // The momentum is zero, so 27 particles have `3 * 26` degrees of freedom.
        assert!((1.3 * energy(31..58) / (3.0 * 26.0) - 0.5).abs() < 1e-12);
    }
    let both = begun().0.fill(fill(1.0)).temperature(1.0).speed(1.0).build().unwrap_err().to_string();
    assert!(both.starts_with("fill[0].speed"), "{both}");
}
