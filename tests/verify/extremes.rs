//! Runs with extreme numbers: very deep wells, large mass ratios, long times without events.

use carom::model::Scene;

use crate::WELL;
use crate::prove;
use crate::scene;
use crate::scenes::assert_proven;

#[test]
fn a_capture_by_a_deep_well_is_proven_though_it_makes_the_pair_fast() {
    for depth in ["1e2", "1e5", "1e8"] {
        for masses in ["1.0", "0.3", "1e-3"] {
            let text = WELL.replace("mass = 1.0", &format!("mass = {masses}"));
            let text = text.replace("well_depth = 1.0", &format!("well_depth = {depth}")).replace("256", "32");
            assert_proven(depth, &prove(scene(&text), 0, 1000), 1000);
        }
    }
}

#[test]
fn collisions_between_very_unequal_masses_are_proven() {
    for (mass, velocity) in [("1e-12", 1.0), ("1e-6", 1.0), ("1e6", 1.0), ("1e12", 1.0), ("0.1", 1e9)] {
        let text = format!(
            "[space]\nsize = [5.0, 5.0, 5.0]\n[[species]]\nname = \"A\"\nmass = 0.7\ndiameter = 1.0\n[[species]]\nname = \"B\"\n\
             mass = {mass}\ndiameter = 1.0\n[[interaction]]\nspecies = [\"A\", \"A\"]\npotential = \"hard-sphere\"\n\
             [[interaction]]\nspecies = [\"A\", \"B\"]\npotential = \"square-well\"\nlambda = 1.3\nwell_depth = 3.0\n\
             [[interaction]]\nspecies = [\"B\", \"B\"]\npotential = \"hard-sphere\"\n[[particle]]\nspecies = \"A\"\n\
             position = [0.5, 0.5, 0.5]\nvelocity = [{velocity}, 0.3, 0.2]\n[[particle]]\nspecies = \"B\"\n\
             position = [2.0, 0.6, 0.4]\nvelocity = [0.0, 0.0, 0.0]\n[[particle]]\nspecies = \"A\"\n\
             position = [2.0, 2.6, 3.4]\nvelocity = [-0.3, 0.1, 0.7]\n[run]\nuntil_events = 10000\n"
        );
        assert_proven(mass, &prove(scene(&text), 0, 2000), 2000);
    }
}

pub fn deep(depth: &str) -> Scene {
    let text = WELL.replace("well_depth = 1.0", &format!("well_depth = {depth}"));
    scene(&text.replace("256", "8"))
}

#[test]
fn extremely_deep_wells_are_proven_or_fail_without_a_panic() {
    // In wells deeper than 1e16, particles are so fast that the verifier may fail. It must not panic.
    for depth in ["1e12", "1e16", "1e20", "1e30", "1e49"] {
        let certificate = prove(deep(depth), 0, 300);
        let is_proven = certificate.is_proven() && certificate.counts.events() == 300;
        assert!(is_proven || depth.parse::<f64>().unwrap() > 1e16, "{depth}: {certificate:?}");
    }
}

#[test]
fn long_wait_before_quick_events_does_not_prevent_a_proof() {
    // After a fall of 35 units of time, two particles cross the steps of their potential in a few thousandths of a
    // unit.
    let text = r#"
[space]
size = [1204.8385830017867, 0.0, 0.0]
x = { lower = "wall", upper = "wall", restitution = 0.37 }
y = "flat"
z = "flat"
[[species]]
name = "A"
mass = 0.1
diameter = 0.31
acceleration = [-1.212397207639981, 0.0, 0.0]
[[interaction]]
species = ["A", "A"]
potential = "stepped-lennard-jones"
well_depth = 2.7
cutoff = 0.403
steps = 2
core_energy = 27.0
[[particle]]
species = "A"
position = [706.4552867114097, 0.0, 0.0]
velocity = [1.8024179753845468, 0.0, 0.0]
[[particle]]
species = "A"
position = [753.1873053291364, 0.0, 0.0]
velocity = [0.6250263492416288, 0.0, 0.0]
[run]
until_events = 1000
"#;
    assert_proven("falling", &prove(scene(text), 0, 100), 100);
}

#[test]
fn free_flight_over_many_epochs_is_proven() {
    // A light particle bounces between a wall and a static post. It has a thousand times as many events as the heavy
    // particles, which drift out through the open side.
    let text = r#"
[space]
size = [400.0, 0.0, 0.0]
x = { lower = "wall", upper = "open", restitution = 1.0 }
y = "flat"
z = "flat"
[[species]]
name = "A"
mass = 3.0
diameter = 0.7
[[species]]
name = "B"
mass = 1e-8
diameter = 0.31
[[species]]
name = "post"
static = true
diameter = 1.0
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
species = ["A", "post"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "post"]
potential = "hard-sphere"
[[particle]]
species = "B"
position = [1.0, 0.0, 0.0]
velocity = [1000.0, 0.0, 0.0]
[[particle]]
species = "post"
position = [3.0, 0.0, 0.0]
[[particle]]
species = "A"
position = [300.0, 0.0, 0.0]
velocity = [1.1, 0.0, 0.0]
[[particle]]
species = "A"
position = [306.0, 0.0, 0.0]
velocity = [0.3, 0.0, 0.0]
[run]
until_events = 100000
"#;
    assert_proven("drifting", &prove(scene(text), 0, 8000), 8000);
}
