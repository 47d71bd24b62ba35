//! Ends of runs: an end is proven if nothing follows, and not if something does.

use carom::check::verify::{Contact, Fault, Verifier};
use carom::engine::{Simulation, States};
use carom::model::Scene;

use crate::scene;

/// The spheres of diameter 1 of a scene, at given positions and velocities.
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

/// Verdict of the verifier on a run that ends at its start.
fn end_of(scene: &Scene) -> Result<(), Fault> {
    let mut states = States::default();
    Simulation::without_plan(scene.clone()).states(&mut states);
    Verifier::new(scene, &states).unwrap().witness_end()
}

const OPEN: &str = "[space]\nsize = [10.0, 10.0, 10.0]\nx = \"open\"\ny = \"open\"\nz = \"open\"";

#[test]
fn an_end_is_not_shown_where_rounding_decides_between_a_miss_and_a_collision() {
    // 10^8 diameters away, passing at a distance of 1 and about 10^-9.
    let pair =
        |miss: f64| spheres(OPEN, HARD, &[([1e8, miss, 0.0], [-1.0, 0.0, 0.0]), ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&pair(1.01)), Ok(()));
    assert!(matches!(end_of(&pair(1.0 + 1e-9)), Err(Fault::EndNotShown { .. } | Fault::EndedEarly { .. })));
    assert!(matches!(end_of(&pair(1.0)), Err(Fault::EndNotShown { .. } | Fault::EndedEarly { .. })));
}

#[test]
fn two_that_part_in_open_space_have_ended_and_two_that_approach_have_not() {
    let pair = |v: f64| spheres(OPEN, HARD, &[([2.0, 5.0, 5.0], [v, 0.0, 0.0]), ([6.0, 5.0, 5.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&pair(-1.0)), Ok(()));
    assert_eq!(end_of(&pair(0.0)), Ok(()));
    let Err(Fault::EndedEarly { contact: Contact::Pair(_), due }) = end_of(&pair(1e-9)) else { panic!() };
    assert!((due / 3e9 - 1.0).abs() < 1e-14, "{due}");
}

#[test]
fn the_two_of_a_periodic_box_that_meet_in_another_image_have_not_ended() {
    let head = "[space]\nsize = [100.0, 100.0, 100.0]";
    let meeting = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.0, 0.0]), ([20.0, 50.2, 50.0], [0.0, 0.0, 0.0])]);
    assert!(matches!(end_of(&meeting), Err(Fault::EndedEarly { due, .. }) if (88.0..90.0).contains(&due)));
    let passing = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.0, 0.0]), ([20.0, 51.2, 50.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&passing), Ok(()), "the same again after every period");
    // Through the box along a diagonal of small steps.
    let dense = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.37, 0.11]), ([20.0, 51.2, 50.0], [0.0, 0.0, 0.0])]);
    assert!(end_of(&dense).is_err());
    let alike =
        spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.37, 0.11]), ([20.0, 51.2, 50.0], [-1.0, 0.37, 0.11])]);
    assert_eq!(end_of(&alike), Ok(()), "no relative motion");
    let alone = spheres(head, HARD, &[([10.0, 50.0, 50.0], [-1.0, 0.37, 0.11])]);
    assert_eq!(end_of(&alone), Ok(()));
}

#[test]
fn what_cannot_be_found_is_not_shown_either() {
    let head = "[space]\nsize = [1e9, 1e9, 1e9]";
    let lost = spheres(head, HARD, &[([0.0, 0.0, 0.0], [-1.0, 0.37, 0.11]), ([20.0, 51.2, 50.0], [0.0, 0.0, 0.0])]);
    assert!(matches!(end_of(&lost), Err(Fault::EndNotShown { .. })));
    // Out of a slit, past some images and then past none.
    let slit = "[space]\nsize = [10.0, 10.0, 1e3]\nz = \"open\"";
    let out = |y| spheres(slit, HARD, &[([0.0, y, 0.0], [-1.0, 0.0, 0.1]), ([5.0, 5.0, 0.0], [0.0, 0.0, 0.0])]);
    assert_eq!(end_of(&out(0.0)), Ok(()));
    assert!(matches!(end_of(&out(5.0)), Err(Fault::EndedEarly { .. })));
}

#[test]
fn walls_and_wells_end_nothing() {
    let walls = "[space]\nsize = [10.0, 10.0, 10.0]\nx = \"walls\"\ny = \"open\"\nz = \"open\"";
    let ball = |v| spheres(walls, HARD, &[([5.0, 5.0, 5.0], v)]);
    assert!(matches!(end_of(&ball([1e-30, 0.0, 0.0])), Err(Fault::EndedEarly { contact: Contact::Wall { .. }, .. })));
    assert_eq!(end_of(&ball([0.0, 1.0, 0.0])), Ok(()));
    let well = "potential = \"square-well\"\nlambda = 1.5\nwell_depth = 1.0";
    let inside = spheres(OPEN, well, &[([2.0, 5.0, 5.0], [0.0, 0.0, 0.0]), ([3.2, 5.0, 5.0], [0.1, 0.0, 0.0])]);
    assert!(matches!(end_of(&inside), Err(Fault::EndedEarly { .. })));
}

#[test]
fn a_ball_that_falls_off_and_one_that_comes_down_again() {
    let head = format!(
        "{OPEN}\n[dynamics]\ngravity = [0.0, 0.0, -1.0]\n[[species]]\nname = \"post\"\nstatic = true\ndiameter = 1.0\n\
        [[interaction]]\nspecies = [\"A\", \"post\"]\npotential = \"hard-sphere\"\n[[particle]]\nspecies = \"post\"\n\
        position = [5.0, 5.0, 1.0]"
    );
    let ball = |x| spheres(&head, HARD, &[([x, 5.0, 5.0], [0.0, 0.0, 2.0])]);
    assert_eq!(end_of(&ball(6.5)), Ok(()));
    assert!(matches!(end_of(&ball(5.5)), Err(Fault::EndedEarly { .. })));
}
