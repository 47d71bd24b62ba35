use super::*;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

fn scene(dimensions: usize, potential: Potential, restitution: f64) -> Scene {
    let mut space = Space::periodic_cube(10.0);
    for axis in dimensions..3 {
        (space.boundary[axis], space.size[axis]) = (Boundary::Flat, 0.0);
    }
    SceneBuilder::new("two")
        .space(space)
        .species(SpeciesDraft::new("unused").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("A").mass(3.0).diameter(2.0))
        .interaction(InteractionDraft::new(potential).between("A", "A").restitution(restitution))
        .particle("A", Vector::new(1.5, 0.0, 0.0), Vector::zeros())
        .particle("A", Vector::new(6.5, 0.0, 0.0), Vector::zeros())
        .build()
        .unwrap()
}

fn hard() -> Potential {
    Potential::hard_sphere(2.0).unwrap()
}

fn value(values: &[PublishedValue], quantity: &str) -> f64 {
    values.iter().find(|value| value.quantity == quantity).unwrap().value
}

#[test]
fn published_values_use_the_units_of_the_scene() {
    let temperature = 5.0;
    let spheres = of_system(&scene(3, hard(), 1.0), None, &[0, 2], 1.0, Some(temperature));
    let phi = 2.0 * std::f64::consts::PI / 6.0 * 8.0 / 1000.0;
    assert_eq!(value(&spheres, "compressibility_factor"), hard_spheres(phi));
    assert!((value(&spheres, "pressure") - hard_spheres(phi) * 2.0 / 1000.0 * temperature).abs() < 1e-15);
    // Collision rate of a dilute gas: sqrt(16 pi T / m) rho sigma^2.
    let thin = (16.0 * std::f64::consts::PI * temperature / 3.0).sqrt() * 2.0 / 1000.0 * 4.0;
    assert!((value(&spheres, "collision_rate") / thin - 1.0).abs() < 0.03);
    let disks = of_system(&scene(2, hard(), 1.0), None, &[0, 2], 1.5, Some(temperature));
    assert_eq!(value(&disks, "compressibility_factor"), hard_disks(2.0 * std::f64::consts::PI / 4.0 * 9.0 / 100.0));
    let rods = of_system(&scene(1, hard(), 1.0), None, &[0, 2], 1.0, None);
    assert_eq!(value(&rods, "compressibility_factor"), 1.0 / 0.6);
    assert!(rods.iter().all(|value| value.quantity == "compressibility_factor"));
}

#[test]
fn finite_size_reduces_values_to_first_order() {
    let of = |scene: &Scene, bath: Option<&Thermostat>, count: usize, quantity: &str| {
        let values = of_system(scene, bath, &[0, count], 1.0, Some(5.0));
        values.into_iter().find(|value| value.quantity == quantity).unwrap()
    };
    // For rods the first order in `1 / N` is exact: `Z_N - 1 = (1 - 1 / N) (Z - 1)`.
    let rods = scene(1, hard(), 1.0);
    let z = of(&rods, None, 2, "compressibility_factor");
    assert!((z.value - 1.0 / 0.6).abs() < 1e-15 && (z.at_size() - 1.0 - 0.5 * (z.value - 1.0)).abs() < 1e-5, "{z:?}");
    // Two rods at constant energy have one degree of freedom. To first order, they collide more often by a quarter.
    let bath = Thermostat::Andersen { temperature: 5.0, rate: 1.0, axes: [true; 3] };
    for (bath, part) in [(None, 0.75), (Some(&bath), 0.5)] {
        let rate = of(&rods, bath, 2, "collision_rate");
        assert!((rate.at_size() / rate.value - part).abs() < 1e-5, "{rate:?}");
    }
    // In a dilute gas, each of `N` particles has `N - 1` instead of `N` partners. For `N = 2`, `Z - 1` is halved.
    let spheres = scene(3, hard(), 1.0);
    let z = of(&spheres, None, 2, "compressibility_factor");
    assert!((z.finite_size / (z.value - 1.0) + 0.5).abs() < 0.02, "{z:?}");
    let pressure = of(&spheres, None, 2, "pressure");
    assert!((pressure.finite_size / pressure.value - z.finite_size / z.value).abs() < 1e-12);
    // The finite-size correction is proportional to `1 / L`. At equal density, a cube of twice the edge has half of it.
    let slower = |edge: f64, count: usize| {
        let mut cube = scene(3, hard(), 1.0);
        cube.space.size = Vector::repeat(edge);
        let here = of(&cube, None, count, "diffusion_coefficient");
        of(&cube, None, count, "diffusion_coefficient_infinite").value - here.at_size()
    };
    let [small, large] = [slower(10.0, 64), slower(20.0, 512)];
    assert!(small > 0.0 && (small / large - 2.0).abs() < 1e-12, "{small} {large}");
    // The mean free path of 20 spheres of diameter 2 in a box of edge 10 is 2.5, longer than L / 2 pi.
    let dilute = scene(3, hard(), 1.0);
    assert_eq!(of(&dilute, None, 20, "diffusion_coefficient").finite_size, 0.0);
    let mut long = scene(3, hard(), 1.0);
    long.space.size.x = 20.0;
    assert_eq!(of(&long, None, 64, "diffusion_coefficient").finite_size, 0.0);
}

#[test]
fn nothing_is_published_about_other_systems() {
    let nothing = |scene: &Scene| assert_eq!(of_system(scene, None, &[0, 2], 1.0, Some(1.0)), []);
    nothing(&scene(3, Potential::square_well(2.0, 1.5, 1.0).unwrap(), 1.0));
    nothing(&scene(3, hard(), 0.9));
    // The contact distance differs from the diameter of the species.
    nothing(&scene(3, Potential::hard_sphere(1.0).unwrap(), 1.0));
    let mut walls = scene(3, hard(), 1.0);
    walls.space.boundary[0] = Boundary::walls(1.0);
    nothing(&walls);
    let mut falling = scene(3, hard(), 1.0);
    falling.species[1].acceleration.z = -1.0;
    nothing(&falling);
    assert_eq!(of_system(&scene(3, hard(), 1.0), None, &[1, 2], 1.0, Some(1.0)), []);
}

#[test]
fn nothing_is_published_about_transport_in_a_heat_bath() {
    let bath = Thermostat::Andersen { temperature: 5.0, rate: 1.0, axes: [true; 3] };
    let scaling = Thermostat::Rescaling { temperature: 5.0, interval: 1.0 };
    let of = |thermostat: Option<&Thermostat>| -> Vec<String> {
        let values = of_system(&scene(3, hard(), 1.0), thermostat, &[0, 2], 1.0, Some(5.0));
        values.into_iter().map(|value| value.quantity).collect()
    };
    assert_eq!(of(Some(&bath)), ["compressibility_factor", "pressure", "collision_rate", "core_rate"]);
    assert_eq!(of(Some(&scaling)), of(None));
    assert!(of(None).iter().any(|quantity| quantity == "diffusion_coefficient"));
}

#[test]
fn crystal_densities_use_the_crystal_equation_of_state() {
    let labels = |scale: f64| -> Vec<String> {
        let values = of_system(&scene(3, hard(), 1.0), None, &[0, 2], scale, None);
        values.into_iter().map(|value| value.label).collect()
    };
    let scale_of = |phi: f64| (phi / (2.0 * std::f64::consts::PI / 6.0 * 8.0 / 1000.0)).cbrt();
    assert_eq!(labels(scale_of(0.49)), ["mKLM"]);
    assert_eq!(labels(scale_of(0.525)), ["mKLM", "Speedy, crystal"]);
    assert_eq!(labels(scale_of(0.6)), ["Speedy, crystal"]);
}
