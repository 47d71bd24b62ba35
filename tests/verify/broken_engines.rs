//! Imitates engines with one error. Events are recorded in one scene and verified in a slightly different scene.

use carom::check::verify::{Fault, Quantity};
use carom::model::{Scene, SceneParts, Until};

use crate::FLUID;
use crate::Recording;
use crate::WELL;
use crate::scene;

fn fault(wrong: &Scene, right: Scene) -> Fault {
    let recording = Recording { scene: right, ..Recording::of(wrong.clone(), 2000) };
    recording.fault().unwrap().1
}

fn changed(text: &str, from: &str, to: &str) -> Scene {
    assert!(text.contains(from), "{from}");
    let mut changed = scene(text).into_parts();
    let other = scene(&text.replace(from, to)).into_parts();
    (changed.species, changed.interactions, changed.table) = (other.species, other.interactions, other.table);
    (changed.space.boundary, changed.contact_time) = (other.space.boundary, other.contact_time);
    Scene::new(changed).unwrap()
}

fn with(scene: Scene, change: impl FnOnce(&mut SceneParts)) -> Scene {
    let mut parts = scene.into_parts();
    change(&mut parts);
    Scene::new(parts).unwrap()
}

#[test]
fn a_wrong_diameter_misses_contacts() {
    let small = changed(FLUID, "potential = \"hard-sphere\"", "potential = \"hard-sphere\"\ndiameter = 0.999999999");
    let found = fault(&small, scene(FLUID));
    assert!(matches!(found, Fault::Missed { .. } | Fault::Unknown { .. }), "{found:?}");
    assert!(matches!(fault(&scene(FLUID), small), Fault::Unknown { .. }));
}

#[test]
fn missing_interaction_misses_contacts() {
    let text = format!("{FLUID}\n").replace("count = 256", "composition = { A = 0.5, B = 0.5 }\ncount = 256");
    let text = text.replacen("species = \"A\"\narrangement", "arrangement", 1);
    let species = "[[species]]\nname = \"B\"\nmass = 1.0\ndiameter = 1.0\n[[interaction]]\nspecies = [\"B\", \"B\"]\n\
        potential = \"hard-sphere\"\n[[interaction]]\nspecies = [\"A\", \"B\"]\npotential = \"hard-sphere\"\n[[fill]]";
    let right = scene(&text.replace("[[fill]]", species));
    let mut table = carom::model::SpeciesPairs::new(2);
    right.table().iter().filter(|([a, b], _)| a == b).for_each(|([a, b], id)| table.set(a, b, id));
    let blind = with(right.clone(), |parts| parts.table = table);
    assert!(matches!(fault(&blind, right), Fault::Missed { .. }));
}

#[test]
fn wrong_restitution_gives_wrong_dissipation() {
    let lossy = changed(FLUID, "potential = \"hard-sphere\"", "potential = \"hard-sphere\"\nrestitution = 0.999999999");
    let found = fault(&lossy, scene(FLUID));
    assert!(matches!(found, Fault::WrongNumbers { quantity: Quantity::Dissipation, .. }), "{found:?}");
    assert!(matches!(fault(&scene(FLUID), lossy), Fault::WrongNumbers { quantity: Quantity::Dissipation, .. }));
}

#[test]
fn wrong_well_depth_gives_a_wrong_energy_step() {
    let deeper = changed(WELL, "well_depth = 1.0", "well_depth = 1.000000001");
    let found = fault(&deeper, scene(WELL));
    assert!(matches!(found, Fault::WrongNumbers { quantity: Quantity::EnergyStep, .. }), "{found:?}");
}

#[test]
fn a_wrong_mass_has_wrong_velocities() {
    let text = FLUID.replace("temperature = 1.0", "temperature = 1.0\n[dynamics]\ncontact_time = 1e-9");
    let heavy = changed(&text, "mass = 1.0", "mass = 1.000000001");
    let found = fault(&heavy, scene(FLUID));
    assert!(matches!(found, Fault::WrongNumbers { .. }), "{found:?}");
}

#[test]
fn spurious_gravity_gives_wrong_momentum() {
    let falling = changed(FLUID, "[run]", "[dynamics]\ngravity = [0.0, 0.0, -1e-9]\n[run]");
    let found = fault(&falling, scene(FLUID));
    let Fault::WrongNumbers { quantity, .. } = found else { panic!("{found:?}") };
    assert_eq!(quantity, Quantity::Momentum);
}

#[test]
fn wrong_box_size_misses_contacts_across_the_sides() {
    let small = with(scene(FLUID), |parts| parts.space.size *= 1.0 + 1e-9);
    let found = fault(&small, scene(FLUID));
    assert!(matches!(found, Fault::Missed { .. } | Fault::Early { .. }), "{found:?}");
}

#[test]
fn a_missing_wall_misses_contacts() {
    let text = FLUID.replace("[run]", "[space]\nx = \"walls\"\n[run]");
    let open = changed(&text, "\"walls\"", "\"open\"");
    let found = fault(&open, scene(&text));
    assert!(matches!(found, Fault::Missed { contact: carom::check::verify::Contact::Wall { .. }, .. }), "{found:?}");
    let short = scene(&text).with_limit(Until::events(10)).unwrap();
    assert!(matches!(fault(&short, open), Fault::Unknown { .. }));
}

#[test]
fn wrong_contact_time_gives_wrong_dissipation() {
    let with = |time: &str| {
        let text = FLUID.replace("potential = \"hard-sphere\"", "potential = \"hard-sphere\"\nrestitution = 0.5");
        text.replace("[run]", &format!("[dynamics]\ncontact_time = {time}\n[run]"))
    };
    let longer = changed(&with("0.01"), "contact_time = 0.01", "contact_time = 0.011");
    let found = fault(&longer, scene(&with("0.01")));
    assert!(matches!(found, Fault::WrongNumbers { quantity: Quantity::Dissipation, .. }), "{found:?}");
}
