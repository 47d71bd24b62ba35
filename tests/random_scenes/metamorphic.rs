//! Changes that leave the physics of a scene unchanged, such as a mirror image or a shift. The events must agree.

use carom::engine::event::Event;
use carom::engine::{Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::Boundary;
use carom::model::{Particle, ParticleId, Scene, SceneParts};

use crate::dice::Dice;
use crate::generator;

const SCENES: usize = 60;
/// Number of compared events if rounding may differ. Differences grow tenfold with each event of a particle.
const FEW: u64 = 20;
/// A difference of 1e-15 can grow to this value. Times between events are far longer.
const TOLERANCE: f64 = 1e-7;

fn scenes() -> impl Iterator<Item = (u64, String, Scene)> {
    let built = |seed| {
        let text = generator::usual(seed);
        Scene::from_toml(text.clone(), "random.toml").ok().map(|scene| (seed, text, scene))
    };
    (1000..).filter_map(built).take(SCENES)
}

/// Returns the first events, up to a collapse or the time limit of the scene.
fn events(scene: &Scene, most: u64) -> Vec<Event> {
    let mut events = Vec::new();
    let time = scene.run().limit.time.unwrap_or(f64::INFINITY);
    let _ = Simulation::without_plan(scene.clone())
        .advance_with(Until::time(time).or_events(most), |event| events.push(*event));
    events
}

fn who(event: &Event, number: &impl Fn(ParticleId) -> u32) -> (u32, Option<u32>) {
    match event.partner() {
        Some(partner) => {
            let (a, b) = (number(event.particle), number(partner));
            (a.min(b), Some(a.max(b)))
        }
        None => (number(event.particle), None),
    }
}

/// Counts equal events. Stops before two events if round-off may decide their order.
fn agreeing(seed: u64, ours: &Scene, theirs: &Scene, number: impl Fn(ParticleId) -> u32, is_mirror: bool) -> usize {
    let (ours, theirs) = (events(ours, FEW), events(theirs, FEW));
    for (k, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        if ours.get(k + 1).is_some_and(|next| next.time - a.time < TOLERANCE) {
            return k;
        }
        let wall = b.wall().map(|(axis, is_upper)| (axis, is_upper != (is_mirror && axis == 0)));
        let same = a.kind == b.kind && a.wall() == wall && who(a, &|id| id.0) == who(b, &number);
        assert!(same, "seed {seed}, event {k}: {a:?} {b:?}");
        assert!((a.time - b.time).abs() < TOLERANCE, "seed {seed}, event {k}: {a:?} {b:?}");
        let scale = 1.0 + a.impulse.norm();
        assert!(
            (a.impulse.norm() - b.impulse.norm()).abs() < 1e3 * TOLERANCE * scale,
            "seed {seed}, event {k}: {a:?} {b:?}"
        );
    }
    assert_eq!(ours.len(), theirs.len(), "seed {seed}");
    ours.len()
}

fn compare(change: impl Fn(&mut SceneParts, &mut Dice) -> Vec<u32>, is_mirror: bool) {
    let mut all = 0;
    for (seed, _, scene) in scenes() {
        let mut parts = scene.clone().into_parts();
        let numbers = change(&mut parts, &mut Dice::new(seed));
        let changed = Scene::new(parts).unwrap();
        let number = |id: ParticleId| numbers.get(id.0 as usize).copied().unwrap_or(id.0);
        all += agreeing(seed, &scene, &changed, number, is_mirror);
    }
    assert!(all > 4 * SCENES, "{all} events compared");
}

#[test]
fn a_mirrored_scene_has_mirrored_events() {
    let mirror = |scene: &mut SceneParts, _: &mut Dice| {
        scene.space.lower.x = -scene.space.upper().x;
        if let Boundary::Bounded { lower, upper } = &mut scene.space.boundary[0] {
            std::mem::swap(lower, upper);
        }
        scene.species.iter_mut().for_each(|species| species.acceleration.x *= -1.0);
        for particle in &mut scene.particles {
            particle.position.x *= -1.0;
            particle.velocity.x *= -1.0;
            // A spin is an axial vector.
            (particle.spin.y, particle.spin.z) = (-particle.spin.y, -particle.spin.z);
        }
        Vec::new()
    };
    compare(mirror, true);
}

#[test]
fn a_shifted_scene_has_the_same_events() {
    let shift = |scene: &mut SceneParts, dice: &mut Dice| {
        let by = carom::Vector::from_fn(|_, _| dice.between(-3.0, 3.0));
        scene.space.lower += by;
        for Particle { position, .. } in &mut scene.particles {
            *position += by;
        }
        for k in (0..3).filter(|&k| scene.space.boundary[k] == Boundary::Flat) {
            let plane = scene.space.lower[k];
            scene.particles.iter_mut().for_each(|particle| particle.position[k] = plane);
        }
        Vec::new()
    };
    compare(shift, false);
}

#[test]
fn a_renumbered_scene_has_the_same_events() {
    let renumber = |scene: &mut SceneParts, dice: &mut Dice| {
        let count = scene.particles.len();
        let mut old: Vec<u32> = (0..).take(count).collect();
        for k in (1..count).rev() {
            old.swap(k, dice.below(k + 1));
        }
        let mut new = vec![0; count];
        for (number, &id) in (0..).zip(&old) {
            new[id as usize] = number;
        }
        scene.particles = old.iter().map(|&id| scene.particles[id as usize]).collect();
        for bond in &mut scene.bonds {
            let [a, b] = bond.pair.map(|id| new[id.0 as usize]);
            bond.pair = [ParticleId(a.min(b)), ParticleId(a.max(b))];
        }
        scene.bonds.sort_by_key(|bond| bond.pair);
        old
    };
    compare(renumber, false);
}

#[test]
fn spheres_far_away_change_no_event() {
    let mut all = 0;
    let mut changed_scenes = 0;
    for (seed, text, scene) in scenes() {
        let Some(axis) = (0..3).find(|&k| matches!(scene.space().boundary[k], Boundary::Bounded { .. })) else {
            continue;
        };
        let mut text = text + "[[species]]\nname = \"far\"\nstatic = true\ndiameter = 1.0\n";
        for species in scene.species().iter().filter(|species| !species.is_static()) {
            text +=
                &format!("[[interaction]]\nspecies = [\"{}\", \"far\"]\npotential = \"hard-sphere\"\n", species.name);
        }
        let is_closed = |face| matches!(face, carom::model::space::Face::Wall(_));
        let Boundary::Bounded { upper, .. } = scene.space().boundary[axis] else { continue };
        // The added sphere is beyond a wall or far away, so no particle reaches it.
        let beyond = if is_closed(upper) { 1.5 } else { 1e3 };
        let mut place = carom::Vector::zeros();
        place[axis] = scene.space().size[axis] + beyond;
        text += &format!("[[particle]]\nspecies = \"far\"\nposition = {:?}\n", <[f64; 3]>::from(place));
        let far = Scene::from_toml(text, "random.toml").unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        all += agreeing(seed, &scene, &far, |id| id.0, false);
        changed_scenes += 1;
    }
    assert!(all > 4 * changed_scenes && changed_scenes > 10, "{all} events of {changed_scenes} scenes compared");
}

fn scaled(scene: &Scene, [length, time, mass]: [f64; 3]) -> Scene {
    let (speed, energy) = (length / time, mass * length * length / (time * time));
    let mut scaled = scene.clone().into_parts();
    scaled.space.lower *= length;
    scaled.space.size *= length;
    for species in &mut scaled.species {
        species.mass *= mass;
        species.diameter *= length;
        species.acceleration *= length / (time * time);
        species.moment_of_inertia = species.moment_of_inertia.map(|moment| moment * mass * length * length);
    }
    for interaction in &mut scaled.interactions {
        let of = |values: &[f64], unit: f64| values.iter().map(|value| value * unit).collect();
        let potential = &interaction.potential;
        interaction.potential =
            Potential::new(of(potential.radii(), length), of(potential.energies(), energy)).unwrap();
    }
    for particle in &mut scaled.particles {
        particle.position *= length;
        particle.velocity *= speed;
        particle.spin /= time;
        particle.diameter = particle.diameter.map(|diameter| diameter * length);
    }
    scaled.contact_time = scaled.contact_time.map(|t| t * time);
    scaled.run.limit.time = scaled.run.limit.time.map(|t| t * time);
    Scene::new(scaled).unwrap()
}

#[test]
fn units_of_powers_of_two_change_no_bit() {
    // The powers of the speed in the law of viscoelastic spheres are rounded differently in other units.
    let plain = |(_, text, _): &(u64, String, Scene)| !text.contains("viscous_time") && !text.contains("speeds = ");
    for (seed, _, scene) in scenes().filter(plain) {
        let units = [0.125, 2.0, 32.0];
        let [length, time, mass] = units;
        let (ours, theirs) = (events(&scene, 200), events(&scaled(&scene, units), 200));
        assert_eq!(ours.len(), theirs.len(), "seed {seed}");
        for (k, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            let same = a.kind == b.kind
                && (a.particle, a.other) == (b.particle, b.other)
                && a.time * time == b.time
                && a.impulse * (mass * length / time) == b.impulse
                && a.positions.map(|r| r * length) == b.positions
                && a.after.map(|v| v * (length / time)) == b.after;
            assert!(same, "seed {seed}, event {k}: {a:?} {b:?}");
        }
    }
}

fn events_of(scene: &Scene, stretches: impl IntoIterator<Item = Until>) -> Vec<Event> {
    let mut simulation = Simulation::without_plan(scene.clone());
    let mut events = Vec::new();
    for until in stretches {
        if simulation.advance_with(until, |event| events.push(*event)).is_err() {
            break;
        }
        let _ = (simulation.snapshot(), simulation.energy(), simulation.deepest_overlap());
    }
    events
}

#[test]
fn splitting_a_run_by_time_or_by_events_changes_no_bit() {
    for (seed, _, scene) in scenes() {
        let limit = scene.run().limit.time.unwrap_or(f64::INFINITY);
        let by_events = events_of(&scene, [Until::time(limit).or_events(100)]);
        let (Some(last), 100) = (by_events.last(), by_events.len()) else { continue };
        // The reported time may be rounded down, so the limit is the next floating-point number.
        let time = last.time.next_up();
        let cut = |mut events: Vec<Event>| {
            events.truncate(100);
            events
        };
        assert_eq!(cut(events_of(&scene, [Until::time(time)])), by_events, "seed {seed}");
        let looks = (1..=37).map(|k| Until::time(time * f64::from(k) / 37.5));
        let stretches = (1..=50).map(|k| Until::time(time).or_events(2 * k));
        let many = looks.chain(stretches).chain([Until::time(time)]);
        assert_eq!(cut(events_of(&scene, many)), by_events, "seed {seed}");
    }
}
