//! The verifier accepts the end of a run only if no event can follow.

use carom::check::verify::{Contact, Fault};
use carom::model::Scene;

use crate::{end_of, scene};

/// Spheres of diameter 1 with these positions and velocities. The text of the scene begins with `head`.
fn spheres(head: &str, potential: &str, particles: &[([f64; 3], [f64; 3])]) -> Scene {
    let mut text = format!(
        "{head}\n[[species]]\nname = \"A\"\nmass = 1.0\ndiameter = 1.0\n[[interaction]]\nspecies = [\"A\", \"A\"]\n{potential}\n"
    );
    for (position, velocity) in particles {
        text += &format!("[[particle]]\nspecies = \"A\"\nposition = {position:?}\nvelocity = {velocity:?}\n");
    }
    scene(&(text + "[run]\nuntil_events = 100\n"))
}

const HARD: &str = "potential = \"hard-sphere\"";

const OPEN: &str = "[space]\nsize = [10.0, 10.0, 10.0]\nx = \"open\"\ny = \"open\"\nz = \"open\"";

#[test]
fn end_is_not_proven_if_round_off_decides_about_a_collision() {
    // A sphere approaches a resting sphere from a distance of 10^8 diameters, and touches or narrowly misses it.
    let pair =
        |miss: f64| spheres(OPEN, HARD, &[([1e8, miss, 0.0], [-1.0, 0.0, 0.0]), ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&pair(1.01)), Ok(()));
    assert!(matches!(end_of(&pair(1.0 + 1e-9)), Err(Fault::EndNotShown { .. } | Fault::EndedEarly { .. })));
    assert!(matches!(end_of(&pair(1.0)), Err(Fault::EndNotShown { .. } | Fault::EndedEarly { .. })));
}

#[test]
fn separating_pair_has_ended_and_approaching_pair_has_not() {
    let pair = |v: f64| spheres(OPEN, HARD, &[([2.0, 5.0, 5.0], [v, 0.0, 0.0]), ([6.0, 5.0, 5.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&pair(-1.0)), Ok(()));
    assert_eq!(end_of(&pair(0.0)), Ok(()));
    let Err(Fault::EndedEarly { contact: Contact::Pair(_), due }) = end_of(&pair(1e-9)) else { panic!() };
    assert!((due / 3e9 - 1.0).abs() < 1e-14, "{due}");
}

#[test]
fn pair_that_meets_in_another_periodic_image_has_not_ended() {
    let head = "[space]\nsize = [100.0, 100.0, 100.0]";
    let meeting = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.0, 0.0]), ([20.0, 50.2, 50.0], [0.0, 0.0, 0.0])]);
    assert!(matches!(end_of(&meeting), Err(Fault::EndedEarly { due, .. }) if (88.0..90.0).contains(&due)));
    let passing = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.0, 0.0]), ([20.0, 51.2, 50.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&passing), Ok(()), "the same again after every period");
    // In this oblique direction, the path hardly repeats. The sphere may hit an image of the other sphere.
    let dense = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.37, 0.11]), ([20.0, 51.2, 50.0], [0.0, 0.0, 0.0])]);
    assert!(end_of(&dense).is_err());
    let alike =
        spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.37, 0.11]), ([20.0, 51.2, 50.0], [-1.0, 0.37, 0.11])]);
    assert_eq!(end_of(&alike), Ok(()), "no relative motion");
    let alone = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.37, 0.11])]);
    assert_eq!(end_of(&alone), Ok(()));
}

#[test]
fn end_is_not_proven_if_the_next_contact_cannot_be_found() {
    let head = "[space]\nsize = [1e9, 1e9, 1e9]";
    let lost = spheres(head, HARD, &[([0.0, 0.0, 0.0], [-1.0, 0.37, 0.11]), ([20.0, 51.2, 50.0], [0.0, 0.0, 0.0])]);
    assert!(matches!(end_of(&lost), Err(Fault::EndNotShown { .. })));
    // The sphere leaves along the open z-axis and can hit only the first few images.
    let slit = "[space]\nsize = [10.0, 10.0, 1e3]\nz = \"open\"";
    let out = |y| spheres(slit, HARD, &[([0.0, y, 0.0], [-1.0, 0.0, 0.1]), ([5.0, 5.0, 0.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&out(0.0)), Ok(()));
    assert!(matches!(end_of(&out(5.0)), Err(Fault::EndedEarly { .. })));
}

#[test]
fn scenes_with_wall_or_well_events_ahead_have_not_ended() {
    let walls = "[space]\nsize = [10.0, 10.0, 10.0]\nx = \"walls\"\ny = \"open\"\nz = \"open\"";
    let ball = |v| spheres(walls, HARD, &[([5.0, 5.0, 5.0], v)]);
    assert!(matches!(end_of(&ball([1e-30, 0.0, 0.0])), Err(Fault::EndedEarly { contact: Contact::Wall { .. }, .. })));
    assert_eq!(end_of(&ball([0.0, 1.0, 0.0])), Ok(()));
    let well = "potential = \"square-well\"\nlambda = 1.5\nwell_depth = 1.0";
    let inside = spheres(OPEN, well, &[([2.0, 5.0, 5.0], [0.0, 0.0, 0.0]), ([3.2, 5.0, 5.0], [0.1, 0.0, 0.0])]);
    assert!(matches!(end_of(&inside), Err(Fault::EndedEarly { .. })));
}

#[test]
fn ball_falling_beside_a_post_has_ended_and_above_it_has_not() {
    let head = format!(
        "{OPEN}\n[dynamics]\ngravity = [0.0, 0.0, -1.0]\n[[species]]\nname = \"post\"\nstatic = true\ndiameter = 1.0\n\
        [[interaction]]\nspecies = [\"A\", \"post\"]\npotential = \"hard-sphere\"\n[[particle]]\nspecies = \"post\"\n\
        position = [5.0, 5.0, 1.0]"
    );
    let ball = |x| spheres(&head, HARD, &[([x, 5.0, 5.0], [0.0, 0.0, 2.0])]);
    assert_eq!(end_of(&ball(6.5)), Ok(()));
    assert!(matches!(end_of(&ball(5.5)), Err(Fault::EndedEarly { .. })));
}
