//! Audits random valid scenes whose coordinates have lost most digits to rounding. No audit may fail. `cargo bench
//! --bench audits` audits any number of scenes.

#[path = "../../benches/audits/judge.rs"]
mod judge;
#[allow(dead_code, reason = "the benchmark has more uses for a scene")]
#[path = "../../benches/audits/scenes.rs"]
mod scenes;

use judge::{Verdict, judge};

#[test]
fn audits_of_valid_scenes_pass() {
    let mut events = 0;
    for seed in 1..=90 {
        let scene = scenes::scene(seed);
        match judge(&scene.text) {
            Verdict::Sound(some) => events += some,
            verdict => panic!("seed {seed}: {verdict:?}\n{}", scene.text),
        }
    }
    assert!(events > 50_000, "{events}");
}

#[test]
fn a_scene_that_is_not_valid_is_refused() {
    let scene = scenes::scene(1).text.replace("diameter = 1.0", "diameter = -1.0");
    assert!(matches!(judge(&scene), Verdict::Refused(_)));
}
