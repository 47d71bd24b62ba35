//! The verifier proves the events of many kinds of scenes.

use carom::check::verify::{Certificate, End, Verifier};
use carom::model::Scene;

use crate::FLUID;
use crate::Recording;
use crate::WELL;
use crate::config;
use crate::extremes::deep;
use crate::prove;
use crate::scene;

pub fn assert_proven(name: &str, certificate: &Certificate, events: u64) {
    assert!(certificate.is_proven(), "{name}: {certificate:?}");
    let counts = certificate.counts;
    assert!(counts.events() == events || certificate.end == End::RunEnded, "{name}: {certificate:?}");
    let margins = certificate.margins;
    let worst = margins.distance.max(margins.overlap).max(margins.outcome).max(margins.flight);
    // The error bounds assume that all roundings add up, but roundings partly cancel.
    assert!(worst < 0.5, "{name}: {margins:?}");
}

#[test]
fn every_scene_of_configs_is_proven() {
    for (name, events) in [
        ("bouncing_ball", 500),
        ("brownian", 1000),
        ("cradle", 1000),
        ("elastic_spheres_1d", 1000),
        ("equation_of_state", 1000),
        ("granular_cooling", 1000),
        ("hard_sphere_fluid", 1000),
        ("hopper", 1000),
        ("maxwell", 1000),
        ("pendulum", 1000),
        ("polymer", 1000),
        ("rough_cooling", 1000),
        ("square_well_fluid", 1000),
        ("stepped_lennard_jones", 1000),
    ] {
        assert_proven(name, &prove(config(name), 0, events), events);
    }
}

#[test]
fn proof_may_start_within_a_run() {
    for (name, text) in [("fluid", FLUID), ("well", WELL)] {
        let certificate = prove(scene(text), 20_000, 2000);
        assert_eq!(certificate.first_event, 20_001);
        assert_proven(name, &certificate, 2000);
    }
    assert_proven("hopper", &prove(config("hopper"), 50_000, 500), 500);
}

#[test]
fn the_end_of_the_run_ends_the_proof() {
    let fluid = scene(FLUID).with_limit(carom::model::Until::time(0.5)).unwrap();
    let certificate = prove(fluid, 0, 1_000_000);
    assert_eq!(certificate.end, End::RunEnded);
    assert!((certificate.duration - 0.5).abs() < 1e-12, "{certificate:?}");
}

#[test]
fn proof_covers_all_stages_of_the_run() {
    let stages = "[[stage]]\nname = \"a\"\nuntil_time = 0.25\n\
        [[stage]]\nname = \"b\"\nmeasure = true\nequilibration_time = 0.125\nuntil_time = 0.5\n";
    let fluid = scene(&format!("{FLUID}{stages}")).with_limit(carom::model::Until::time(0.5)).unwrap();
    let certificate = prove(fluid, 0, 1_000_000);
    assert_eq!(certificate.end, End::RunEnded);
    assert!((certificate.duration - 1.375).abs() < 1e-12, "{certificate:?}");
}

#[test]
fn late_start_time_does_not_change_a_proof() {
    let early = prove(scene(WELL), 0, 2000);
    let late = prove(scene(&format!("start_time = 1e12\n{WELL}")), 0, 2000);
    assert_proven("late", &late, 2000);
    assert_eq!(late.start, 1e12);
    assert_eq!((late.duration, late.counts, late.margins), (early.duration, early.counts, early.margins));
}

#[test]
fn invalid_starts_are_proven_to_improve() {
    let text = FLUID.replace("fcc", "overlapping").replace("256", "200").replace("0.35", "0.2");
    let mut particles = String::from("allow_invalid_start = true\n[space]\nsize = [8.0, 8.0, 8.0]\n");
    particles.push_str(&text[..text.find("[[fill]]").unwrap()]);
    // Positions from a Weyl sequence. Some particles overlap.
    for k in 0..200 {
        let place = |step: f64| (f64::from(k) * step).fract();
        let (x, y, z) = (8.0 * place(0.819_172_5), 8.0 * place(0.671_043_6), 8.0 * place(0.549_700_4));
        let [u, v, w] = [0.754_877, 0.569_840, 0.430_159].map(|step| 2.0 * place(step) - 1.0);
        particles.push_str(&format!(
            "[[particle]]\nspecies = \"A\"\nposition = [{x}, {y}, {z}]\nvelocity = [{u}, {v}, {w}]\n"
        ));
    }
    particles.push_str("[run]\nuntil_events = 100000\n");
    let certificate = prove(scene(&particles), 0, 3000);
    assert!(certificate.counts.in_invalid_state > 0, "{certificate:?}");
    assert_proven("invalid", &certificate, 3000);
}

#[test]
fn planes_lines_and_small_boxes_are_proven() {
    let disks = FLUID.replace("fcc", "hexagonal").replace("256", "144").replace("0.35", "0.5");
    let disks = format!("[space]\nz = \"flat\"\n{disks}");
    assert_proven("disks", &prove(scene(&disks), 0, 3000), 3000);
    let mut rods = String::from("[space]\nsize = [9.0, 0.0, 0.0]\ny = \"flat\"\nz = \"flat\"\n");
    rods.push_str(&FLUID[..FLUID.find("[[fill]]").unwrap()]);
    for k in 0..6 {
        let (x, v) = (1.5 * f64::from(k) + 0.2, [1.0, -0.5, 0.25, 2.0, -1.5, 0.125][k as usize]);
        rods.push_str(&format!(
            "[[particle]]\nspecies = \"A\"\nposition = [{x}, 0.0, 0.0]\nvelocity = [{v}, 0.0, 0.0]\n"
        ));
    }
    rods.push_str("[run]\nuntil_events = 100000\n");
    assert_proven("rods", &prove(scene(&rods), 0, 3000), 3000);
    // In a box of about two diameters, two particles meet in several images.
    let small = FLUID.replace("256", "4").replace("0.35", "0.2");
    assert_proven("small box", &prove(scene(&small), 0, 3000), 3000);
    let thin = FLUID.replace("256", "4").replace("0.35", "0.000001");
    assert_proven("thin gas", &prove(scene(&thin), 0, 20), 20);
}

const EVERYTHING: &str = r#"
[space]
size = [12.0, 12.0, 14.0]
x = "periodic"
y = "periodic"
z = { lower = "wall", upper = "wall", restitution = 0.9 }
[dynamics]
gravity = [0.0, 0.0, -1.0]
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[species]]
name = "B"
mass = 3.0
diameter = 0.75
acceleration = [0.0, 0.5, -0.5]
[[species]]
name = "post"
static = true
diameter = 2.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.4
well_depth = 0.5
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
restitution = 0.95
[[interaction]]
species = ["B", "B"]
potential = "penetrable"
height = 0.75
[[interaction]]
species = ["A", "post"]
potential = "square-well"
lambda = 1.25
well_depth = 0.25
[[interaction]]
species = ["B", "post"]
potential = "hard-sphere"
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.9
longest = 1.2
[[particle]]
species = "post"
position = [6.0, 6.0, 2.0]
[[particle]]
species = "post"
position = [1.0, 3.0, 7.0]
[[chain]]
species = "A"
length = 6
bond = "link"
start = [2.0, 6.0, 11.0]
direction = [1.0, 0.0, 0.0]
temperature = 1.0
[[fill]]
species = "B"
arrangement = "random"
count = 40
temperature = 1.0
region = { lower = [0.5, 0.5, 9.0], upper = [11.5, 5.0, 13.5] }
[[fill]]
species = "A"
arrangement = "random"
count = 30
temperature = 1.0
region = { lower = [0.5, 7.5, 4.0], upper = [11.5, 11.5, 13.0] }
[run]
until_events = 100000
"#;

#[test]
fn scene_with_all_features_is_proven() {
    let certificate = prove(scene(EVERYTHING), 0, 4000);
    assert_proven("everything", &certificate, 4000);
    let counts = certificate.counts;
    for (kind, count) in [
        ("core", counts.core),
        ("capture", counts.capture),
        ("release", counts.release),
        ("bounce", counts.bounce),
        ("wall", counts.wall),
    ] {
        assert!(count > 50, "{kind}: {counts:?}");
    }
    let with_tc = EVERYTHING.replace("[dynamics]", "[dynamics]\ncontact_time = 0.01");
    assert_proven("with the TC model", &prove(scene(&with_tc), 0, 4000), 4000);
}

#[test]
fn pair_states_of_verifier_and_engine_agree() {
    let recording = Recording::of(scene(WELL), 3000);
    let mut simulation = carom::engine::Simulation::without_plan(recording.scene.clone());
    simulation.advance(carom::engine::Until::events(3000)).unwrap();
    let mut verifier = Verifier::new(&recording.scene, &recording.start).unwrap();
    assert_eq!(recording.fault_for(&mut verifier), None);
    assert_eq!(verifier.compare_pairs(&simulation.captured_pairs()), Ok(()));
}

#[test]
fn arrest_ends_the_proof_and_keeps_its_counts() {
    let ball = config("bouncing_ball");
    let mut parts = ball.clone().into_parts();
    parts.contact_time = None;
    let certificate = prove(Scene::new(parts).unwrap(), 0, 100_000);
    assert!(matches!(certificate.end, End::Arrested(_)), "{certificate:?}");
    assert!(!certificate.is_proven());
    assert!(certificate.counts.wall > 10);
}

#[test]
fn caller_can_end_the_proof_between_two_events() {
    let mut asked = 0;
    let certificate = carom::check::verify::verify(
        deep("1e12"),
        carom::check::verify::EventRange { from: 0, events: 1000 },
        &mut |_| {
            asked += 1;
            if asked > 3 { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
        },
    );
    assert_eq!(certificate.end, End::Interrupted);
}

#[test]
fn caller_can_interrupt_a_proof_before_a_distant_event() {
    let pipe = "
        [space]
        size = [1e15, 3.0, 3.0]
        [[species]]
        name = \"A\"
        mass = 1.0
        diameter = 1.0
        [[interaction]]
        species = [\"A\", \"A\"]
        potential = \"hard-sphere\"
        [[particle]]
        species = \"A\"
        position = [0.5, 0.5, 0.5]
        velocity = [1.0, 0.3, 0.2]
        [[particle]]
        species = \"A\"
        position = [1e10, 1.5, 1.5]
        velocity = [-1.0, 0.1, 0.3]
        [run]
        until_time = 1e14
    ";
    for from in [0, 10] {
        let mut asked = 0;
        let certificate = carom::check::verify::verify(
            scene(pipe),
            carom::check::verify::EventRange { from, events: 10 },
            &mut |_| {
                asked += 1;
                if asked > 5 { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
            },
        );
        assert_eq!(certificate.end, End::Interrupted);
    }
}
