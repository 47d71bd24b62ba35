//! Grains that fall asleep and wake up, beside the reference engine.

use carom::check::reference::{self, Reference};
use carom::engine::event::{Event, EventKind, Outcome};
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

use super::pair;

/// Simulated time that is compared. No search happens at this time.
const TIME: f64 = 4.9;

/// Round-off grows at each contact of two round grains, but not at contacts with the floor. A comparison ends when the times
/// of an event differ by more than this.
const COMPARABLE: f64 = 1e-9;

/// At one event, round-off grows from [`COMPARABLE`] to at most this size.
const TOLERANCE: f64 = 1e-5;

/// A box with a floor. A part of the floor may be a belt.
const BOX: &str = "
[space]
size = [7.0, 7.0, 40.0]
x = 'walls'
y = 'walls'
z = 'open'
[run]
until_time = 5.0
[dynamics]
gravity = [0.0, 0.0, -1.0]
contact_time = 0.01
sleep = { interval = 0.25, distance = DISTANCE, wake_speed = WAKE_SPEED }
[[species]]
name = 'grain'
mass = 1.3
diameter = 1.0
INDIVIDUAL
material = 'stone'
[[species]]
name = 'large'
mass = 2.9
diameter = 1.4
INDIVIDUAL
material = 'stone'
[[material]]
between = ['stone', 'stone']
restitution = 0.6
ROUGH
[[interaction]]
species = ['grain', 'grain']
potential = 'hard-sphere'
[[interaction]]
species = ['grain', 'large']
potential = 'hard-sphere'
[[interaction]]
species = ['large', 'large']
potential = 'hard-sphere'
[[surface]]
shape = 'parallelogram'
corner = [0.0, 0.0, 1.0]
edge_1 = [4.0, 0.0, 0.0]
edge_2 = [0.0, 7.0, 0.0]
restitution = 0.4
ROUGH
BELT
[[surface]]
shape = 'parallelogram'
corner = [4.0, 0.0, 1.0]
edge_1 = [3.0, 0.0, 0.0]
edge_2 = [0.0, 7.0, 0.0]
restitution = 0.4
ROUGH
";

/// Grains lie near the floor, apart from each other. Later, others fall onto them.
#[derive(Debug, Clone)]
struct Recipe {
    /// Displacements of the resting grains from the points of a lattice, and their heights above the floor.
    lying: Vec<[f64; 3]>,
    falling: Vec<[f64; 3]>,
    /// Relative spread of the diameters of a species; `None` if they are equal.
    spread: Option<f64>,
    friction: Option<f64>,
    distance: f64,
    wake_speed: f64,
    belt: f64,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let lying = prop::collection::vec([-0.2..0.2_f64, -0.2..0.2_f64, 0.001..0.03_f64], 4..9);
    let falling = prop::collection::vec([0.5..5.5_f64, 0.5..5.5_f64, 1.0..9.0_f64], 0..3);
    let spread = prop::option::of(0.05..0.3_f64);
    let rough = prop::option::of(0.1..0.8_f64);
    let belt = prop_oneof![Just(0.0), 0.001..0.1_f64];
    (lying, falling, spread, rough, 1e-3..0.02_f64, 0.03..1.0_f64, belt).prop_map(
        |(lying, falling, spread, friction, distance, wake_speed, belt)| Recipe {
            lying,
            falling,
            spread,
            friction,
            distance,
            wake_speed,
            belt,
        },
    )
}

impl Recipe {
    fn scene(&self) -> Option<Scene> {
        let own = |diameter: f64, k: u8| diameter * (1.0 - self.spread.unwrap_or(0.0) * f64::from(k * 5 % 8) / 7.0);
        let lying = self.lying.iter().zip(0_u8..).map(|([x, y, z], k)| {
            let (column, row, diameter) = (f64::from(k % 3), f64::from(k / 3), own(1.0, k));
            ([1.0 + 2.0 * column + x, 1.0 + 2.0 * row + y, 1.0 + 0.5 * diameter + z], "grain", diameter)
        });
        let falling = self.falling.iter().zip(0_u8..);
        let falling = falling.map(|([x, y, z], k)| ([*x, *y, 4.0 + 9.0 * f64::from(k) + z], "large", own(1.4, k + 1)));
        let particles: String = lying
            .chain(falling)
            .map(|(position, species, diameter)| {
                let diameter = self.spread.map_or_else(String::new, |_| format!("diameter = {diameter}\n"));
                format!(
                    "[[particle]]\nspecies = '{species}'\nposition = {position:?}\nvelocity = [0.0, 0.0, 0.0]\n{diameter}"
                )
            })
            .collect();
        let rough = self.friction.map_or_else(String::new, |friction| format!("friction = {friction}\n"));
        let belt = if self.belt > 0.0 && self.friction.is_some() {
            format!("surface_velocity = [{}, 0.0, 0.0]\n", self.belt)
        } else {
            String::new()
        };
        let toml = BOX
            .replace("INDIVIDUAL", self.spread.map_or("", |_| "diameters = 'individual'"))
            .replace("DISTANCE", &self.distance.to_string())
            .replace("WAKE_SPEED", &self.wake_speed.to_string())
            .replace("ROUGH", &rough)
            .replace("BELT", &belt)
            + &particles;
        Scene::from_toml(&toml, "sleep.toml").ok()
    }
}

fn kind(event: &Event) -> reference::EventKind {
    match event.kind {
        EventKind::Pair(Outcome::Core) => reference::EventKind::Pair(reference::Outcome::Core),
        EventKind::Rest => reference::EventKind::Rest,
        EventKind::Wake => reference::EventKind::Wake,
        _ => reference::EventKind::Surface { number: 0 },
    }
}

fn is_surface(kind: reference::EventKind) -> bool {
    matches!(kind, reference::EventKind::Surface { .. } | reference::EventKind::Wall { .. })
}

/// Returns how many events were compared, and the numbers of grains that fell asleep and woke up.
fn compare(scene: &Scene) -> Result<[usize; 3], TestCaseError> {
    let mut reference = Reference::new(scene).map_err(|error| TestCaseError::fail(error.to_string()))?;
    let mut simulation = Simulation::without_plan(scene.clone());
    let mut compared = [0; 3];
    let mut fast = Vec::new();
    let _ = simulation.advance_with(Until::time(TIME), |event| fast.push(*event));
    for (k, ours) in fast.iter().enumerate() {
        let Some(theirs) = reference.step_before(TIME) else {
            return Err(TestCaseError::fail(format!("event {k}: {ours:?}")));
        };
        let same = kind(ours) == theirs.kind || is_surface(kind(ours)) && is_surface(theirs.kind);
        // Round-off may change the order of simultaneous events, except for those of a search.
        let next = fast.get(k + 1).map_or(f64::INFINITY, |next| next.time);
        let is_search = matches!(ours.kind, EventKind::Rest | EventKind::Wake);
        if !is_search && (next - ours.time).abs() < COMPARABLE {
            break;
        }
        prop_assert!(same, "event {}: {:?} {:?}", k, ours, theirs);
        let between = (theirs.particle.0, theirs.partner.map(|partner| partner.0));
        prop_assert_eq!(pair(ours), between, "event {}: {:?} {:?}", k, ours, theirs);
        prop_assert!((ours.time - theirs.time).abs() < TOLERANCE, "event {k}: {ours:?} {theirs:?}");
        if (ours.time - theirs.time).abs() > COMPARABLE {
            break;
        }
        prop_assert!((ours.dissipated - theirs.dissipated).abs() < 1e3 * COMPARABLE, "event {k}: {ours:?} {theirs:?}");
        let torques =
            if ours.particle == theirs.particle { theirs.torques } else { [theirs.torques[1], theirs.torques[0]] };
        for (one, other) in ours.torques.iter().zip(&torques) {
            prop_assert!((one - other).norm() < 1e3 * COMPARABLE, "event {k}: {ours:?} {theirs:?}");
        }
        compared[0] += 1;
        compared[1] += usize::from(ours.kind == EventKind::Rest);
        compared[2] += usize::from(ours.kind == EventKind::Wake);
    }
    Ok(compared)
}

const CASES: u32 = 60;

#[test]
fn grains_fall_asleep_and_wake_up_as_in_the_reference() {
    let mut runner = TestRunner::new(ProptestConfig { cases: CASES, ..ProptestConfig::default() });
    let all = Cell::new([0; 3]);
    let result = runner.run(&recipe(), |recipe| {
        let Some(scene) = recipe.scene() else { return Err(TestCaseError::reject("no such scene")) };
        let compared = compare(&scene)?;
        all.set(std::array::from_fn(|k| all.get()[k] + compared[k]));
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    println!("{:?} events, grains that fell asleep, and that woke up", all.get());
    assert!(all.get()[0] > 10_000 && all.get()[1] > 100 && all.get()[2] > 10, "{:?}", all.get());
}
