//! Surfaces that move and gravity that turns, in words.

use super::place::{Place, code, errors, words};

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
fn a_check_and_a_run_tell_what_moves_and_what_was_measured() {
    let place = Place::with(SHAKER);
    let output = place.carom(&["check", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let text = words(&output);
    for told in [
        "moves with velocity (0, 0, 0) and acceleration (0, 0, 0.1) from t = 0 to 1",
        "oscillates by (0, 0, 0.1) with frequency 2 from t = 1",
        "in tilted and measurement only",
        "tilted: gravity (0.1, 0, -1)",
    ] {
        assert!(text.contains(told), "no `{told}` in {text}");
    }
    let output = place.carom(&["run", "scene.toml"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let text = words(&output);
    assert!(text.contains("results of instruments\nParticles that passed top"), "{text}");
    assert!(text.contains("energy supplied") && text.contains("sound"), "{text}");
    let proof = place.carom(&["verify", "runs/scene"]);
    assert_eq!(code(&proof), 0, "{}", words(&proof));
    assert!(words(&proof).contains("\nPROVEN"), "{}", words(&proof));
}
