//! On any number of threads or domains, random scenes have the events, state and counts of a single thread, bit for bit.
//!
//! A run is split at random. Between two pieces, it may change its number of threads, be written and read like a
//! checkpoint, or enter or leave a heat bath. Some systems start cold or rest for a long time.
//!
//! ```text
//! CAROM_FUZZ_SCENES=5000 cargo test --release --test random_scenes threads -- --nocapture
//! ```

use std::fmt::Write;
use std::ops::ControlFlow;

use carom::engine::event::Event;
use carom::engine::{Reason, Simulation, SingleThread};
use carom::model::Thermostat;
use carom::{Scene, Until, Vector};

use super::dice::Dice;
use super::{PATIENCE, generator, over_seeds, setting};

/// Numbers of threads, which are also numbers of domains.
const THREADS: [usize; 7] = [1, 2, 2, 3, 4, 8, 13];
const STRETCHES: usize = 6;
/// Number of steps between two checks of the elapsed time.
const STEPS: u64 = 20_000;

#[derive(Debug, Default)]
struct Count {
    refused: usize,
    given_up: usize,
    /// Sums over all pieces. The count `spread` is for pieces on several threads.
    compared: usize,
    spread: usize,
    /// In domains, and on threads that share the system.
    windows: [u64; 2],
    undone: [u64; 2],
    serial: [u64; 2],
    events: usize,
    baths: usize,
}

impl Count {
    /// Notes a piece of a run with some events.
    fn note(&mut self, simulation: &Simulation, events: usize) {
        self.compared += 1;
        self.events += events;
        self.spread += usize::from(simulation.single_thread().is_none());
        if let Some(work) = simulation.domain_work() {
            self.windows[0] += work.windows;
            self.undone[0] += work.differences + work.uncovered;
            self.serial[0] += work.serial;
        }
        if let Some(work) = simulation.thread_work() {
            self.windows[1] += work.windows;
            self.undone[1] += work.conflicts;
            self.serial[1] += work.alone;
        }
    }
}

/// The end of a piece: at a time, after a number of events, or when an observer has seen a number of events.
#[derive(Debug, Clone, Copy)]
enum Stretch {
    Time(f64),
    Events(u64),
    Shown(usize),
}

/// Returns the events and the reason for the end, or `None` if the run takes too long.
fn advance(simulation: &mut Simulation, stretch: Stretch) -> Option<(Vec<Event>, Result<Reason, String>)> {
    let mut events = Vec::new();
    let (until, most) = match stretch {
        Stretch::Time(time) => (Until::time(time), usize::MAX),
        Stretch::Events(events) => (Until::events(events), usize::MAX),
        Stretch::Shown(most) => (Until::time(f64::INFINITY), most),
    };
    for _ in 0..PATIENCE {
        let mut see = |event: &Event| {
            events.push(*event);
            if events.len() == most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        match simulation.advance_for_with(STEPS, until, &mut see) {
            Ok(None) => {}
            Ok(Some(reason)) => return Some((events, Ok(reason))),
            Err(error) => return Some((events, Err(error.to_string()))),
        }
    }
    None
}

/// Chooses the next piece of a run. A system at rest may have no events, so the piece ends at a given time.
fn stretch(simulation: &Simulation, dice: &mut Dice) -> Stretch {
    if simulation.snapshot().velocities.iter().all(|velocity| *velocity == Vector::zeros()) {
        return Stretch::Time(simulation.time() + dice.power(-2.0, 4.0));
    }
    let events = 1 + dice.below(3_000);
    let few = if events.is_multiple_of(2) { events as u64 } else { 1 };
    match dice.below(3) {
        0 => Stretch::Time(simulation.time() + dice.power(-2.0, 1.0)),
        1 => Stretch::Events(simulation.event_counts().physical() + few),
        _ => Stretch::Shown(events),
    }
}

fn compare(text: &str, dice: &mut Dice, count: &mut Count) -> Option<String> {
    let Ok(scene) = Scene::from_toml(text, "random.toml") else {
        count.refused += 1;
        return None;
    };
    let begin = |scene: Scene| Simulation::new(scene.clone()).unwrap_or_else(|_| Simulation::without_plan(scene));
    let why = SingleThread::of(&scene);
    let (mut one, mut other) = (begin(scene.clone()), begin(scene));
    if dice.chance(0.3) {
        for simulation in [&mut one, &mut other] {
            simulation.set_thermostat(None, 0).unwrap();
        }
    }
    assert_eq!(other.single_thread(), why, "the scene and the engine agree why there is one thread");
    for at in 0..STRETCHES {
        let threads = if dice.chance(0.02) { 64 } else { dice.pick(&THREADS) };
        if dice.chance(0.5) {
            other.set_domains(threads, 1);
        } else {
            // Narrow slabs are slow, but many of these boxes are short.
            other.set_slabs(threads, dice.pick(&[0.5, 1.0, 2.0, 4.0]));
        }
        let stretch = stretch(&one, dice);
        let Some((seen, end)) = advance(&mut one, stretch) else {
            count.given_up += 1;
            return None;
        };
        let what = format!("stretch {at}, {threads} threads, {stretch:?}");
        let Some((seen_there, end_there)) = advance(&mut other, stretch) else {
            return Some(format!("{what}: takes too long"));
        };
        if let Some(first) = (0..seen.len().max(seen_there.len())).find(|&at| seen.get(at) != seen_there.get(at)) {
            let both = [seen.get(first), seen_there.get(first)];
            return Some(format!("{what}: event {first}: {both:#?}, {}", work(&other)));
        }
        let all = |simulation: &Simulation| {
            let by_species = simulation.event_counts_by_species();
            (simulation.snapshot(), *simulation.event_counts(), format!("{by_species:?}"))
        };
        let (here, there) = (all(&one), all(&other));
        if end != end_there || here != there {
            let same = [here.0 == there.0, here.1 == there.1, here.2 == there.2];
            return Some(format!(
                "{what}: {end:?}, {end_there:?}, same state and counts {same:?} at {}, {}, {}",
                one.time(),
                other.time(),
                work(&other)
            ));
        }
        count.note(&other, seen.len());
        if end.is_err() || end == Ok(Reason::Idle) {
            return None;
        }
        change(&mut one, &mut other, dice, count);
    }
    None
}

fn work(simulation: &Simulation) -> String {
    format!("{:?}, {:?}", simulation.domain_work(), simulation.thread_work())
}

fn change(one: &mut Simulation, other: &mut Simulation, dice: &mut Dice, count: &mut Count) {
    if dice.chance(0.3) {
        let bytes = postcard::to_stdvec(&*other).unwrap();
        *other = postcard::from_bytes(&bytes).unwrap();
    }
    if dice.chance(0.2) {
        let velocities: Vec<_> = one.snapshot().velocities.iter().map(|velocity| velocity * 1.1).collect();
        let [first, second] = [&mut *one, &mut *other].map(|simulation| simulation.set_velocities(&velocities));
        assert_eq!(format!("{first:?}"), format!("{second:?}"));
    }
    if dice.chance(0.2) {
        let bath = bath(dice);
        let [first, second] =
            [&mut *one, &mut *other].map(|simulation| simulation.set_thermostat(bath.as_ref(), count.compared));
        assert_eq!(format!("{first:?}"), format!("{second:?}"));
        count.baths += usize::from(first.is_ok());
    }
}

fn bath(dice: &mut Dice) -> Option<Thermostat> {
    let (temperature, rate) = (dice.pick(&[1.2, 0.1]), dice.power(-3.0, 0.5));
    let axes = dice.pick(&[[true; 3], [true, true, false]]);
    dice.chance(0.7).then_some(Thermostat::Andersen { temperature, rate, axes })
}

fn space(text: &mut String, dice: &mut Dice, count: usize, is_flat: bool) {
    let fraction = dice.between(0.02, if is_flat { 0.4 } else { 0.3 });
    let long = dice.pick(&[1.0, 2.5, 8.0]);
    let edge = if is_flat {
        (count as f64 * 0.8 / fraction / long).sqrt()
    } else {
        (count as f64 * 0.55 / fraction / long).cbrt()
    };
    let edge = edge.max(5.0);
    let mut size = [edge, edge, if is_flat { 0.0 } else { edge }];
    let along = dice.below(if is_flat { 2 } else { 3 });
    size[along] *= long;
    let _ = writeln!(text, "[space]\nsize = {size:?}");
    for (axis, edge) in ["x", "y", "z"].into_iter().zip(size) {
        let hot = "{ lower = { temperature = 1.5 }, upper = { temperature = 0.8 } }";
        let sides = match dice.below(6) {
            _ if edge == 0.0 => "\"flat\"",
            0 => "\"walls\"",
            1 => hot,
            2 if dice.chance(0.3) => "{ lower = \"wall\", upper = \"open\", restitution = 0.9 }",
            _ => "\"periodic\"",
        };
        let _ = writeln!(text, "{axis} = {sides}");
    }
}

fn surface(text: &mut String, dice: &mut Dice) {
    if dice.chance(0.25) {
        let heat = dice.pick(&["temperature = 1.4", "restitution = 1.0"]);
        let motion = "motion = [{ kind = \"oscillation\", amplitude = [0.3, 0.2, 0.0], frequency = 0.5 }]";
        let motion = if dice.chance(0.4) && heat.starts_with('r') { motion } else { "" };
        let _ = write!(
            text,
            "[[surface]]\nshape = \"capsule\"\nstart = [1.0, 1.0, 0.0]\nend = [2.0, 3.0, 0.0]\nradius = 0.4\n{heat}\n{motion}\n"
        );
    }
}

/// A large scene with any combination of features.
fn large(seed: u64) -> String {
    let mut dice = Dice::new(seed ^ 0x5eed);
    let dice = &mut dice;
    let count = if dice.chance(0.1) { 4_000 + dice.below(3_000) } else { 80 + dice.below(1_200) };
    let mut text = format!("name = \"large\"\nseed = {seed}\n");
    let is_flat = dice.chance(0.3);
    space(&mut text, dice, count, is_flat);
    let restitution = if dice.chance(0.3) { dice.pick(&[0.9, 0.6]) } else { 1.0 };
    let _ = writeln!(text, "[dynamics]");
    if restitution < 1.0 {
        let _ = writeln!(text, "contact_time = {:?}", dice.power(-4.0, -1.0));
    }
    if dice.chance(0.4) {
        let down = if is_flat { [0.0, -0.3, 0.0] } else { [0.0, 0.1, -0.3] };
        let _ = writeln!(text, "gravity = {down:?}");
    }
    let masses = [0.7, dice.pick(&[0.7, 3.1, 40.0])];
    let diameters = [1.0, dice.pick(&[1.0, 0.45, 0.15])];
    for k in 0..2 {
        let _ = write!(text, "[[species]]\nname = \"S{k}\"\nmass = {:?}\ndiameter = {:?}\n", masses[k], diameters[k]);
    }
    let kind = dice.below(4);
    for (a, b) in [(0, 0), (0, 1), (1, 1)] {
        let potential = match kind {
            0 => format!("\"square-well\"\nlambda = 1.6\nwell_depth = {:?}", dice.pick(&[1.0, 0.3])),
            1 => "\"square-shoulder\"\nlambda = 1.3\nheight = 0.7".to_owned(),
            _ => "\"hard-sphere\"".to_owned(),
        };
        let _ = write!(
            text,
            "[[interaction]]\nspecies = [\"S{a}\", \"S{b}\"]\npotential = {potential}\nrestitution = {restitution}\n"
        );
    }
    let [links, first, second] = match dice.below(5) {
        0 => [0.0; 3],
        1 => [0.0, 0.0, 1.1],
        _ => [1.1; 3],
    };
    let chains = if dice.chance(0.3) { count / 20 } else { 0 };
    if chains > 0 {
        let longest = dice.pick(&[1.3, 2.6]);
        let _ = write!(
            text,
            "[[interaction]]\nname = \"link\"\npotential = \"bond\"\nshortest = 0.9\nlongest = {longest}\n\
             [[chain]]\nspecies = \"S0\"\nlength = 5\ncount = {chains}\nbond = \"link\"\ntemperature = {links}\n"
        );
    }
    let rest = count - 5 * chains;
    for (species, share, temperature) in [(0, rest / 2, first), (1, rest - rest / 2, second)] {
        let _ = write!(
            text,
            "[[fill]]\nspecies = \"S{species}\"\narrangement = \"random\"\ncount = {share}\ntemperature = {temperature}\n"
        );
    }
    surface(&mut text, dice);
    text += "[run]\nuntil_events = 1\n";
    if dice.chance(0.25) {
        let rate = dice.power(-2.0, 0.5);
        let _ = writeln!(text, "thermostat = {{ kind = \"andersen\", temperature = 1.2, rate = {rate:?} }}");
    }
    text
}

#[test]
fn random_scenes_have_the_same_bits_on_any_number_of_threads() {
    let scenes = setting("CAROM_FUZZ_SCENES", 44);
    let text = |seed: u64| if seed.is_multiple_of(2) { generator::scene(seed) } else { large(seed) };
    let mut count = Count::default();
    let different = over_seeds(scenes, |seed| compare(&text(seed), &mut Dice::new(!seed), &mut count));
    println!("{count:?}");
    if let Some(&seed) = different.first() {
        panic!("{} of {scenes} scenes; the first is {seed}:\n{}", different.len(), text(seed));
    }
    // With few scenes, some cases may not occur.
    let many = count.windows.iter().all(|windows| *windows > 10 * scenes) && !count.undone.contains(&0);
    assert!(scenes < 40 || count.spread as u64 > scenes && many, "{count:?}");
}
