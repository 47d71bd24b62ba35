//! How `carom check` and `carom run` describe moving surfaces and changing gravity.

use super::place::{Place, code, line, words};

const SHAKER: &str = r#"
[space]
size = [10.0, 10.0, 30.0]
z = { lower = "open", upper = "open" }

[dynamics]
gravity = [0.0, 0.0, -1.0]

[[species]]
name = "grain"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["grain", "grain"]
potential = "hard-sphere"

[[surface]]
name = "floor"
shape = "plane"
point = [0.0, 0.0, 1.0]
normal = [0.0, 0.0, 1.0]
stages = ["tilted", "measurement"]
motion = [
    { kind = "translation", until = 1.0, acceleration = [0.0, 0.0, 0.1] },
    { kind = "oscillation", amplitude = [0.0, 0.0, 0.1], frequency = 2.0 },
]

[[particle]]
species = "grain"
position = [5.0, 5.0, 3.0]

[[stage]]
name = "tilted"
until_time = 2.0
gravity = [0.1, 0.0, -1.0]

[run]
until_time = 20.0

[[measure.flow]]
name = "top"
axis = "z"
at = 2.5
"#;

#[test]
fn check_describes_motions_and_run_reports_measurements() {
    let place = Place::with(SHAKER);
    let output = place.done(&["check", "scene.toml"]);
    let text = words(&output);
    for told in [
        "moves with velocity (0, 0, 0) and acceleration (0, 0, 0.1) from t = 0 to 1",
        "oscillates by (0, 0, 0.1) with frequency 2 from t = 1",
        "in tilted and measurement only",
        "tilted: gravity (0.1, 0, -1)",
    ] {
        assert!(text.contains(told), "no `{told}` in {text}");
    }
    let output = place.done(&["run", "scene.toml"]);
    let text = words(&output);
    assert!(text.contains("results of instruments\nParticles that passed top"), "{text}");
    assert!(text.contains("energy supplied") && text.contains("sound"), "{text}");
    let proof = place.carom(&["verify", "runs/scene"]);
    assert_eq!(code(&proof), 0, "{}", words(&proof));
    assert!(words(&proof).contains("\nPROVEN"), "{}", words(&proof));
}

#[test]
fn check_names_unreachable_surfaces_and_motions_without_effect() {
    let scene = |surface: &str| {
        format!(
            r#"
[space]
size = [6.0, 6.0, 6.0]
x = "walls"
y = "walls"
z = "open"

[[species]]
name = "ball"
mass = 1.0
diameter = 1.0

[[interaction]]
species = ["ball", "ball"]
potential = "hard-sphere"

[[particle]]
species = "ball"
position = [2.0, 2.0, 3.0]
velocity = [0.1, 0.2, 0.3]

[run]
until_time = 1.0

[[surface]]
name = "it"
{surface}
"#
        )
    };
    let plate = |z: f64, x: f64| {
        format!(
            "shape = \"parallelogram\"\ncorner = [{x}, 1.0, {z}]\nedge_1 = [2.0, 0.0, 0.0]\nedge_2 = [0.0, 2.0, 0.0]"
        )
    };
    let floor = "shape = \"plane\"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 2.0]";
    let moved = |shape: &str, motion: &str| format!("{shape}\nmotion = [{{ kind = {motion} }}]");
    let beyond = Some("surface `it` is beyond the walls of x: no particle meets it");
    let along = Some("surface `it` moves only along itself, which has no effect on smooth spheres");
    for (surface, expected) in [
        (plate(1.0, 7.0), beyond),
        (plate(1.0, -3.0), beyond),
        (plate(1.0, 5.0), None),
        // The box is open along z, so particles may reach this plate.
        (plate(9.0, 2.0), None),
        (moved(floor, "\"translation\", velocity = [1.0, 0.5, 0.0]"), along),
        (moved(floor, "\"translation\", velocity = [1.0, 0.5, 0.1]"), None),
        (moved(floor, "\"rotation\", point = [3.0, 3.0, 0.0], axis = [0.0, 0.0, 1.0], frequency = 1.0"), along),
        (moved(floor, "\"rotation\", point = [3.0, 3.0, 0.0], axis = [0.0, 0.1, 1.0], frequency = 1.0"), None),
        (moved(&plate(1.0, 2.0), "\"oscillation\", amplitude = [0.0, 0.0, 0.2], frequency = 1.0"), None),
        (moved(&plate(1.0, 2.0), "\"oscillation\", amplitude = [0.0, 0.0, 0.2], frequency = 0.0"), along),
        (format!("{}\ntemperature = 1.0", moved(floor, "\"translation\", velocity = [1.0, 0.5, 0.0]")), None),
    ] {
        let place = Place::with(&scene(&surface));
        let text = words(&place.carom(&["check", "scene.toml"]));
        let told =
            text.lines().find(|line| line.contains("surface `it`")).map(|line| line.trim_start_matches("warning: "));
        assert_eq!(told, expected, "{surface}: {text}");
    }
}

#[test]
fn piston_that_crushes_a_grain_is_named_in_the_error() {
    let scene = r#"
[space]
size = [4.0, 4.0, 6.0]
x = "walls"
y = "walls"
z = { lower = "wall", upper = "open" }

[[species]]
name = "grain"
mass = 1.3
diameter = 1.0

[[interaction]]
species = ["grain", "grain"]
potential = "hard-sphere"

[[particle]]
species = "grain"
position = [2.0, 2.0, 1.5]
velocity = [0.1, 0.2, 0.3]

[[surface]]
name = "piston"
shape = "plane"
point = [0.0, 0.0, 5.0]
normal = [0.0, 0.0, -1.0]
motion = [{ kind = "translation", from = 1.0, velocity = [0.0, 0.0, -0.5] }]

[run]
until_time = 20.0
"#;
    let place = Place::with(scene);
    let output = place.carom(&["run", "scene.toml", "-q"]);
    let told = line(&output);
    assert_eq!(code(&output), 1, "{told}");
    assert!(told.contains("dynamical arrest at time 8.9") || told.contains("dynamical arrest at time 9"), "{told}");
    assert!(told.contains("surface `piston`"), "{told}");
    assert!(told.contains("help: a moving surface leaves the particles no room"), "{told}");
    assert!(!told.contains("restitution"), "it is 1: {told}");
}
