use super::*;
use crate::Vector;
use crate::analysis::instruments::test_system::{
    Recorded, estimate, hard_spheres, instrument, mean, measure, number, report, start,
};
use crate::engine::{Simulation, Until};
use crate::model::space::{Boundary, Space};
use crate::model::{Scene, SpeciesId};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

const STATIC: u32 = 1;

fn event(kind: EventKind, particle: u32, other: Other, time: f64) -> Event {
    Event {
        time,
        kind,
        particle: ParticleId(particle),
        other,
        normal: Vector::x(),
        impulse: Vector::x(),
        torques: [Vector::zeros(); 2],
        distance: 1.0,
        energy_step: 0.0,
        dissipated: 0.0,
        positions: [Vector::zeros(); 2],
        before: [Vector::zeros(); 2],
        after: [Vector::zeros(); 2],
    }
}

fn pair(a: u32, b: u32, time: f64) -> Event {
    event(EventKind::Pair(Outcome::Core), a, Other::Particle(ParticleId(b)), time)
}

fn surface(particle: u32, surface: u32, time: f64) -> Event {
    event(EventKind::Surface, particle, Other::Surface { surface, feature: 0 }, time)
}

/// A plane with particles of the given ids and species. Species 1 is static.
fn plane(particles: &[(u32, u32)]) -> (SystemDescription, Vec<ParticleId>, Vec<SpeciesId>) {
    let space = Space { boundary: [Boundary::OPEN, Boundary::OPEN, Boundary::Flat], ..Space::periodic_cube(10.0) };
    let mut system = SystemDescription::of_points(space, 1);
    system.species_masses = vec![1.0, f64::INFINITY];
    (
        system,
        particles.iter().map(|(id, _)| ParticleId(*id)).collect(),
        particles.iter().map(|(_, species)| SpeciesId(*species)).collect(),
    )
}

/// Windows of length 1 whose ends are 2 apart: from 1 to 2, from 3 to 4, and so on.
fn contacts(system: &SystemDescription) -> Recorded<Contacts> {
    let setup = Setup { system, sample: Sample::default(), duration: 100.0 };
    Recorded::new(Contacts::new(&Plan { duration: Some(1.0), interval: Some(2.0) }, &setup))
}

fn fractions(measured: &Measured) -> Vec<f64> {
    measured.curves[0].series[0].values.iter().map(|value| value.unwrap()).collect()
}

#[test]
fn contacts_of_a_window_are_counted_by_hand() {
    let particles: Vec<(u32, u32)> = [3, 5, 8, 9].into_iter().map(|id| (id, 0)).chain([(11, STATIC)]).collect();
    let (mut system, ids, species) = plane(&particles);
    system.surfaces = vec![];
    let mut contacts = contacts(&system);
    assert_eq!(contacts.next_sample(), 2.0);
    let twice = |contacts: &mut Recorded<Contacts>, of: &dyn Fn(f64) -> Event| {
        [1.25, 1.75].into_iter().for_each(|time| contacts.event(&of(time), &system));
    };
    // Contacts: 3-5 from both sides, 5-8, 8 with the static particle 11, 8 with two surfaces.
    contacts.event(&pair(3, 5, 1.1), &system);
    contacts.event(&pair(5, 3, 1.9), &system);
    twice(&mut contacts, &|time| pair(8, 5, time));
    twice(&mut contacts, &|time| pair(11, 8, time));
    twice(&mut contacts, &|time| surface(8, 0, time));
    twice(&mut contacts, &|time| surface(8, 6, time));
    // No contacts: a single collision, a collision before the window, steps of a potential, and the end of a bond. The
    // static particle has a surface, and particle 7 leaves.
    contacts.event(&pair(3, 9, 1.5), &system);
    contacts.event(&pair(3, 9, 0.9), &system);
    for outcome in [Outcome::Capture, Outcome::Release, Outcome::Bounce] {
        twice(&mut contacts, &|time| event(EventKind::Pair(outcome), 8, Other::Particle(ParticleId(9)), time));
    }
    twice(&mut contacts, &|time| event(EventKind::Exit, 9, Other::Surface { surface: 6, feature: 0 }, time));
    twice(&mut contacts, &|time| event(EventKind::Thermostat, 9, Other::Bath, time));
    twice(&mut contacts, &|time| pair(7, 5, time));
    twice(&mut contacts, &|time| surface(7, 0, time));
    twice(&mut contacts, &|time| surface(11, 0, time));
    let sample = Sample { time: 2.0, ids: &ids, species: &species, ..Sample::default() };
    contacts.sample(&sample, &system);
    let measured = report(&contacts, &system);
    // The coordination numbers are 1, 2, 4 and 0.
    assert_eq!(mean(&measured, "coordination_number"), 7.0 / 4.0);
    assert_eq!(fractions(&measured)[..6], [0.25, 0.25, 0.25, 0.0, 0.25, 0.0]);
    assert!(measured.number("surface_coordination").is_none(), "the system has no surfaces");
    system.surfaces = crate::analysis::instruments::SystemDescription::of(&column()).surfaces;
    assert_eq!(mean(&report(&contacts, &system), "surface_coordination"), 0.5);
    // Only particle 8 has the three contacts of a plane. Without its rattling neighbour 5 it still has three.
    assert_eq!(mean(&measured, "coordination_number_without_rattlers"), 3.0);
    assert_eq!(mean(&measured, "rattler_fraction"), 0.75);
}

#[test]
fn every_window_starts_without_collisions() {
    let (system, ids, species) = plane(&[(0, 0), (1, 0)]);
    let mut contacts = contacts(&system);
    let sample = |time| Sample { time, ids: &ids, species: &species, ..Sample::default() };
    // A collision in each of two windows, then two in a window, then two between windows.
    for (collisions, end) in [(vec![1.5], 2.0), (vec![3.5], 4.0), (vec![5.5, 5.6], 6.0), (vec![6.5, 6.6], 8.0)] {
        collisions.into_iter().for_each(|time| contacts.event(&pair(0, 1, time), &system));
        assert_eq!(contacts.next_sample(), end);
        contacts.sample(&sample(end), &system);
        assert!(contacts.instrument.collisions.0.is_empty());
    }
    let measured = report(&contacts, &system);
    assert_eq!(mean(&measured, "coordination_number"), 0.25);
    assert_eq!(fractions(&measured)[..2], [0.75, 0.25]);
    assert_eq!(number(&measured, "coordination_number_without_rattlers").mean, None);
    assert_eq!(mean(&measured, "rattler_fraction"), 1.0);
}

#[test]
fn rattlers_are_removed_until_none_is_left() {
    // In a plane, a particle needs three contacts. Particles 0 to 3 are all in contact. Particle 4 touches 0 and 5 and a
    // wall, and 5 touches 4 and a wall. So 5 is a rattler, and without it, 4 is one, too.
    let (system, ids, species) = plane(&[(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)]);
    let mut contacts = contacts(&system);
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3), (0, 4), (4, 5)];
    for time in [1.2, 1.3, 1.4] {
        pairs.iter().for_each(|&(a, b)| contacts.event(&pair(a, b, time), &system));
        [4, 5].into_iter().for_each(|particle| contacts.event(&surface(particle, 1, time), &system));
    }
    contacts.sample(&Sample { time: 2.0, ids: &ids, species: &species, ..Sample::default() }, &system);
    let measured = report(&contacts, &system);
    assert_eq!(mean(&measured, "coordination_number"), 3.0);
    assert_eq!(fractions(&measured)[2..5], [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]);
    assert_eq!(mean(&measured, "coordination_number_without_rattlers"), 3.0);
    assert_eq!(mean(&measured, "rattler_fraction"), 2.0 / 6.0);
}

#[test]
fn last_bin_includes_all_larger_numbers() {
    let all: Vec<(u32, u32)> = (0..30).map(|id| (id, 0)).collect();
    let (system, ids, species) = plane(&all);
    let mut contacts = contacts(&system);
    for time in [1.2, 1.3] {
        (1..30).for_each(|other| contacts.event(&pair(0, other, time), &system));
    }
    contacts.sample(&Sample { time: 2.0, ids: &ids, species: &species, ..Sample::default() }, &system);
    let measured = report(&contacts, &system);
    let fractions = fractions(&measured);
    assert_eq!((fractions[1], fractions[20]), (29.0 / 30.0, 1.0 / 30.0));
    assert!((mean(&measured, "coordination_number") - 58.0 / 30.0).abs() < 1e-15);
}

/// Three balls on top of each other on the floor of a pipe, and the TC model.
fn column() -> Scene {
    let floor = Boundary::Bounded {
        lower: crate::model::space::Face::Wall(crate::model::ContactLaw::smooth(0.5)),
        upper: crate::model::space::Face::Open,
    };
    let space = Space { boundary: [Boundary::Periodic, Boundary::Periodic, floor], ..Space::periodic_cube(9.0) };
    let ball = |scene: SceneBuilder, height: f64| scene.particle("A", Vector::new(4.0, 4.0, height), Vector::zeros());
    let scene = SceneBuilder::new("column")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .contact_time(0.01)
        .species(SpeciesDraft::new("A").mass(1.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(0.5));
    [0.5, 1.5, 2.5].into_iter().fold(scene, ball).build().unwrap()
}

fn measured(simulation: &mut Simulation, system: &SystemDescription, plan: &Plan, duration: f64) -> Measured {
    let mut contacts = instrument(simulation, system, duration, |setup| Recorded::new(Contacts::new(plan, setup)));
    measure(simulation, system, &mut contacts, duration);
    report(&contacts, system)
}

#[test]
fn balls_in_a_column_touch_their_neighbours_and_the_floor() {
    let (system, mut simulation) = start(column());
    simulation.advance(Until::time(1.0)).unwrap();
    let measured = measured(&mut simulation, &system, &Plan::default(), 20.0);
    // Windows have a length of 100 contact times, and fill the time.
    assert_eq!(measured.curves[0].series[0].normalisation.as_ref().unwrap().divisors[0].values, [20.0]);
    // The two contacts of pairs count twice, and the contact with the floor once.
    assert!((mean(&measured, "coordination_number") - 5.0 / 3.0).abs() < 1e-14);
    assert!((mean(&measured, "surface_coordination") - 1.0 / 3.0).abs() < 1e-14);
    let fractions = fractions(&measured);
    assert!((fractions[1] - 1.0 / 3.0).abs() < 1e-14 && (fractions[2] - 2.0 / 3.0).abs() < 1e-14);
    assert_eq!(mean(&measured, "rattler_fraction"), 1.0);
}

#[test]
fn particles_of_a_dilute_gas_have_no_contacts() {
    let (system, mut simulation) = hard_spheres(108, 0.01);
    // In a mean free time of about 12, a particle hardly meets the same partner twice.
    let plan = Plan { duration: Some(1.0), interval: None };
    let measured = measured(&mut simulation, &system, &plan, 50.0);
    assert!(simulation.event_counts().core > 100);
    assert!(mean(&measured, "coordination_number") < 1e-3);
    assert_eq!(mean(&measured, "rattler_fraction"), 1.0);
}

#[test]
fn long_run_with_short_windows_leaves_gaps_between_them() {
    let (system, simulation) = hard_spheres(4, 0.01);
    let ends = |interval: Option<f64>, duration: f64| {
        let plan = Plan { duration: Some(0.5), interval };
        instrument(&simulation, &system, duration, |setup| Contacts::new(&plan, setup)).next_sample()
    };
    assert_eq!((ends(None, 10.0), ends(None, 500.0), ends(None, 5000.0)), (0.5, 0.5, 5.0));
    assert_eq!((ends(Some(0.75), 1e6), ends(Some(0.5), 1e6)), (0.75, 0.5));
}

/// Smooth grains of three sizes that have settled on a floor, in a box with periodic sides.
fn packing() -> Scene {
    let sizes = [("small", 0.7, 0.9), ("middle", 1.0, 1.0), ("large", 1.7, 1.2)];
    let species =
        sizes.map(|(name, mass, diameter)| format!("{{ name = '{name}', mass = {mass:?}, diameter = {diameter:?} }}"));
    let pairs = sizes.iter().enumerate().flat_map(|(k, one)| sizes[..=k].iter().map(move |other| (one.0, other.0)));
    let interactions: Vec<String> = pairs
        .map(|(a, b)| format!("{{ species = ['{a}', '{b}'], potential = 'hard-sphere', restitution = 0.5 }}"))
        .collect();
    let text = format!(
        "seed = 1\n\
         space = {{ size = [6.0, 6.0, 26.0], z = {{ lower = 'wall', upper = 'open', restitution = 0.5 }} }}\n\
         dynamics = {{ gravity = [0.0, 0.0, -1.0], contact_time = 0.004 }}\n\
         species = [{}]\n\
         interaction = [{}]\n\
         fill = [{{ composition = {{ small = 0.35, middle = 0.35, large = 0.3 }}, arrangement = 'random', \
         count = 300, region = {{ lower = [0.0, 0.0, 0.0], upper = [6.0, 6.0, 25.0] }} }}]\n\
         run = {{ until_time = 99.0 }}",
        species.join(", "),
        interactions.join(", ")
    );
    Scene::from_toml(text, "packing.toml").unwrap()
}

#[test]
fn packing_of_smooth_grains_is_isostatic() {
    let (system, mut simulation) = start(packing());
    simulation.advance(Until::time(30.0)).unwrap();
    // Windows of 100 contact times. Windows of 10 contact times miss the weakest contacts, 6 % of all.
    let plan = Plan { duration: Some(0.4), interval: None };
    let measured = measured(&mut simulation, &system, &plan, 6.4);
    let all = ["coordination_number", "surface_coordination"].map(|name| mean(&measured, name));
    let (without_rattlers, rattlers) =
        (mean(&measured, "coordination_number_without_rattlers"), mean(&measured, "rattler_fraction"));
    let (_, error) = estimate(&measured, "coordination_number");
    println!("{all:?} +- {error}, {without_rattlers}, {rattlers}");
    // Every grain rests on others, so there are `3 N` contacts, without the two that would hold the packing along the
    // periodic axes. A pair counts for two grains, and a contact with the floor for one: `Z = 2 (3 N - 2) / N - F / N`.
    // One contact more or less changes the sum by 2 / N. Grains at rest still rattle, so the contacts with the smallest
    // forces and the pairs with the smallest gaps are uncertain: three contacts of 900.
    let exact = 6.0 - 4.0 / 300.0;
    assert!((all[0] + all[1] - exact).abs() < 4.0 * error + 6.0 / 300.0 && error < 0.005, "{all:?} +- {error}");
    // A rattler that rests on three grains is removed with its three contacts, so the other grains are isostatic, too.
    // Contacts with the floor count only once, which lowers the sum by 2 %.
    assert!((without_rattlers / 6.0 - 1.0).abs() < 0.03, "{without_rattlers}");
    assert!((0.01..0.3).contains(&rattlers), "{rattlers}");
}
