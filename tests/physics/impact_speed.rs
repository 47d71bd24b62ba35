//! Coefficients of restitution that depend on the speed of impact.

use crate::measure::Mean;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

const VISCOELASTIC: &str = "{ viscous_time = 0.07, stiffness = 2.3 }";
const TABLE: &str = "{ speeds = [0.5, 1.0, 3.0], values = [0.9, 0.7, 0.4] }";

/// Coefficient of restitution of viscoelastic spheres (Müller and Pöschel, Phys. Rev. E 84, 021302, 2011).
fn viscoelastic(speed: f64, mass: f64) -> f64 {
    let squared = 1.5 * 0.07 * (2.3 / mass).powf(0.4) * speed.powf(0.2);
    let x = squared.sqrt();
    let (a, b) = (0.501086, 1.15345);
    (1.0 + a * x) / (1.0 + a * x + b * squared + 0.577977 * x * squared + 0.532178 * squared * squared)
}

fn tabulated(speed: f64, _mass: f64) -> f64 {
    if speed < 0.5 {
        0.9
    } else if speed < 1.0 {
        0.9 - 0.4 * (speed - 0.5)
    } else if speed < 3.0 {
        0.7 - 0.15 * (speed - 1.0)
    } else {
        0.4
    }
}

/// A coefficient of restitution as a function of the speed and the reduced mass.
type Law = fn(f64, f64) -> f64;

const LAWS: [(&str, Law); 2] = [(VISCOELASTIC, viscoelastic), (TABLE, tabulated)];

fn assert_close(found: f64, exact: f64, what: &str) {
    assert!((found - exact).abs() < 1e-12 * exact.abs().max(1.0), "{what}: {found} {exact}");
}

#[test]
fn bouncing_balls_follow_the_law_of_the_floor() {
    for (law, restitution) in LAWS {
        let wall = format!("z = {{ lower = 'wall', upper = 'open', restitution = {law} }}");
        let plane = format!(
            "z = 'open'\n[[surface]]\nname = 'floor'\nshape = 'plane'\npoint = [0.0, 0.0, 0.0]\n\
             normal = [0.0, 0.0, 1.0]\nrestitution = {law}"
        );
        for floor in [wall, plane] {
            let text = format!(
                "dynamics = {{ gravity = [0.0, 0.0, -1.0] }}\nspecies = [{{ name = 'ball', mass = 1.3, diameter = 1.0 }}]\n\
                 interaction = [{{ species = ['ball', 'ball'], potential = 'hard-sphere' }}]\n\
                 particle = [{{ species = 'ball', position = [3.0, 3.0, 10.5] }}]\nrun = {{ until_time = 1e3 }}\n\
                 [space]\nsize = [6.0, 6.0, 20.0]\n{floor}\n"
            );
            let scene = Scene::from_toml(text, "ball.toml").unwrap();
            let mut simulation = Simulation::new(scene).unwrap();
            let (mut speed, mut bounces) = (20.0_f64.sqrt(), 0);
            let check = |event: &carom::engine::event::Event| {
                let e = restitution(speed, 1.3);
                assert_close(event.dissipated, 0.65 * speed * speed * (1.0 - e * e), law);
                speed *= e;
                bounces += 1;
            };
            simulation.advance_with(Until::events(30), check).unwrap();
            assert_eq!(bounces, 30);
        }
    }
}

#[test]
fn unlike_balls_collide_with_their_reduced_mass() {
    for (law, restitution) in LAWS {
        for speed in [0.2, 0.7, 2.0, 5.0] {
            let text = format!(
                "space = {{ size = [9.0, 0.0, 0.0], x = 'open', y = 'flat', z = 'flat' }}\n\
                 species = [{{ name = 'a', mass = 1.3, diameter = 1.0 }}, {{ name = 'b', mass = 2.9, diameter = 1.0 }}]\n\
                 interaction = [{{ species = ['a', 'b'], potential = 'hard-sphere', restitution = {law} }}]\n\
                 particle = [{{ species = 'a', position = [3.0, 0.0, 0.0], velocity = [{speed:?}, 0.0, 0.0] }},\n\
                 {{ species = 'b', position = [5.0, 0.0, 0.0] }}]\nrun = {{ until_time = 9.0 }}"
            );
            let scene = Scene::from_toml(text, "two.toml").unwrap();
            let mut simulation = Simulation::new(scene).unwrap();
            simulation.advance(Until::time(9.0)).unwrap();
            let velocities = simulation.snapshot().velocities;
            let mass = 1.3 * 2.9 / 4.2;
            assert_close(velocities[1].x - velocities[0].x, restitution(speed, mass) * speed, law);
            assert_close(1.3 * velocities[0].x + 2.9 * velocities[1].x, 1.3 * speed, "momentum");
        }
    }
}

#[test]
fn gas_of_viscoelastic_spheres_cools_as_its_law_demands() {
    // In a gas with Maxwell's distribution, the normal speed v of a contact has a density proportional to
    // v exp(-m v^2 / (4 T)). The mean energy lost in a contact follows from this density.
    let mass = 1.3;
    let loss = |temperature: f64| {
        let (mut sum, mut norm) = (0.0, 0.0);
        for k in 0..4_000 {
            let v = (f64::from(k) + 0.5) * 2.5e-3 * (temperature / mass).sqrt();
            let weight = v * (-mass * v * v / (4.0 * temperature)).exp();
            let e = viscoelastic(v, 0.5 * mass);
            sum += weight * 0.25 * mass * v * v * (1.0 - e * e);
            norm += weight;
        }
        sum / norm
    };
    for temperature in [1.0, 1e-3] {
        let law = carom::model::Restitution::Viscoelastic { viscous_time: 0.07, stiffness: 2.3 };
        let scene = SceneBuilder::new("gas")
            .species(SpeciesDraft::new("A").mass(mass).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(law))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(1372).packing_fraction(0.05))
            .temperature(temperature);
        let mut simulation = Simulation::without_plan(scene.build().unwrap());
        let per_block = 686;
        // The first contacts dissolve the lattice.
        simulation.advance(Until::events(5 * per_block)).unwrap();
        let mut last = simulation.energy().kinetic;
        let ratios: Vec<f64> = (1..=15)
            .map(|block| {
                simulation.advance(Until::events((5 + block) * per_block)).unwrap();
                let kinetic = simulation.energy().kinetic;
                let mean = 0.5 * (kinetic + last) / 1.5 / 1372.0;
                let ratio = (last - kinetic) / (per_block as f64 * loss(mean));
                last = kinetic;
                ratio
            })
            .collect();
        let error = Mean::of(ratios);
        error.assert_is(1.0, 0.02, &format!("loss per contact at the temperature {temperature}"));
    }
}
