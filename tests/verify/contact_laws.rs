//! Contact laws of grains: the TC model with friction, restitution that depends on the speed, and belts.

use carom::check::verify::{EventRange, verify};
use carom::model::Scene;
use std::ops::ControlFlow;

use crate::Recording;

/// Rough grains of two sizes that fall on a belt between two walls.
const GRAINS: &str = "
    seed = 6
    space = { size = [9.0, 0.0, 30.0], x = 'open', y = 'flat', z = 'open' }
    dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 0.01 }
    species = [{ name = 'a', mass = 0.7, diameter = 0.9 }, { name = 'b', mass = 1.3, diameter = 1.1 }]
    interaction = [
        { species = ['a', 'a'], potential = 'hard-sphere', restitution = { speeds = [0.0, 0.7, 2.0], values = [0.95, 0.6, 0.5] }, friction = 0.5 },
        { species = ['a', 'b'], potential = 'hard-sphere', restitution = { viscous_time = 0.1, stiffness = 7.0 }, friction = 0.4 },
        { species = ['b', 'b'], potential = 'hard-sphere', restitution = 0.5, tangential_restitution = 0.3, friction = 0.6 },
    ]
    surface = [
        { name = 'belt', shape = 'plane', point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], restitution = 0.55,
          friction = 0.45, surface_velocity = [0.3, 0.0, 0.0] },
        { name = 'right', shape = 'plane', point = [9.0, 0.0, 0.0], normal = [-1.0, 0.0, 0.0], restitution = 0.5, friction = 0.5 },
        { name = 'left', shape = 'plane', point = [0.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0], restitution = 0.5, friction = 0.5 },
    ]
    fill = [{ composition = { a = 15, b = 15 }, arrangement = 'random', count = 30,
              region = { lower = [0.6, 0.0, 0.6], upper = [8.4, 0.0, 12.0] } }]
    run = { until_time = 30.0 }
";

fn scene(text: &str) -> Scene {
    Scene::from_toml(text, "grains.toml").unwrap()
}

#[test]
fn grains_at_rest_on_a_belt_are_proven_from_any_event_on() {
    for from in [0, 3_000, 12_000, 20_000, 30_000] {
        let proof = verify(scene(GRAINS), EventRange { from, events: 300 }, &mut |_| ControlFlow::Continue(()));
        assert!(proof.is_proven(), "{from}: {:?}", proof.end);
    }
}

#[test]
fn published_tc_model_is_proven_and_differs_from_the_default() {
    let published = GRAINS.replace("contact_time = 0.01", "contact_time = 0.01, tc_rule = 'luding-mcnamara'");
    let mut recording = Recording::of(scene(&published), 1_500);
    assert_eq!(recording.fault(), None);
    recording.scene = scene(GRAINS);
    assert!(recording.fault().is_some());
}

#[test]
fn slightly_different_laws_are_found() {
    let mut recording = Recording::of(scene(GRAINS), 1_500);
    assert_eq!(recording.fault(), None);
    for (true_number, wrong) in [
        ("surface_velocity = [0.3,", "surface_velocity = [0.3000001,"),
        ("friction = 0.45", "friction = 0.4500001"),
        ("restitution = 0.55", "restitution = 0.5500001"),
        ("tangential_restitution = 0.3", "tangential_restitution = 0.3000001"),
        ("values = [0.95, 0.6, 0.5]", "values = [0.9500001, 0.6, 0.5]"),
        ("viscous_time = 0.1", "viscous_time = 0.1000001"),
        ("stiffness = 7.0", "stiffness = 7.000001"),
        ("contact_time = 0.01", "contact_time = 0.02"),
    ] {
        assert_eq!(GRAINS.matches(true_number).count(), 1, "{true_number}");
        recording.scene = scene(&GRAINS.replace(true_number, wrong));
        assert!(recording.fault().is_some(), "{wrong}");
    }
}
