//! Compares each event of the engine with the rules and the response of the reference, starting from the state before
//! the event. Errors do not carry over to the next event, so all events of a run must agree within round-off.

use super::response::{Encounter, TcModel};
use super::rules::{Discontinuity, seen};
use super::*;
use crate::engine::event as engine;
use crate::engine::{Simulation, Until};
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::RefCell;

const SCENES: u32 = 60;
const EVENTS: u64 = 300;
/// Minimum number of compared events of each kind. A few hundred are expected.
const FEWEST: u32 = 50;

/// Relative round-off of a velocity after an event in both implementations. The engine also adds a small speed to make
/// a reflection effective.
const ROUNDINGS: f64 = 32.0 * f64::EPSILON;

/// If the time since the last contact equals the contact time within this relative difference, round-off decides
/// whether the contact is elastic. The test accepts both results.
const TIE: f64 = 1e-9;

#[derive(Debug, Clone)]
struct Recipe {
    seed: u64,
    masses: [f64; 2],
    energies: [f64; 3],
    restitution: f64,
    gravity: f64,
    contact_time: Option<f64>,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let mass = || (-2.0..2.0_f64).prop_map(f64::exp);
    (
        (any::<u64>(), [mass(), mass()], prop::array::uniform3(-1.5..1.5_f64)),
        (
            prop_oneof![Just(1.0), 0.5..1.0_f64],
            prop_oneof![Just(0.0), 0.1..1.0_f64],
            prop::option::of((-7.0..-1.0_f64).prop_map(f64::exp)),
        ),
    )
        .prop_map(|((seed, masses, energies), (restitution, gravity, contact_time))| Recipe {
            seed,
            masses,
            energies,
            restitution,
            gravity,
            contact_time,
        })
}

impl Recipe {
    /// Builds a scene with steps up and down around hard and penetrable cores, with bonds, static spheres and walls.
    fn scene(&self) -> Scene {
        let [u, v, w] = self.energies;
        let steps = |last| Potential::new(vec![1.6, 1.3, 1.0], vec![0.0, u, v, last]).unwrap();
        let walls = Boundary::walls(self.restitution);
        let mut builder = SceneBuilder::new("random")
            .seed(self.seed)
            .space(crate::model::space::Space {
                boundary: [walls; 3],
                ..crate::model::space::Space::periodic_cube(8.0)
            })
            .gravity(Vector::new(0.0, 0.3 * self.gravity, -self.gravity))
            .species(SpeciesDraft::new("A").mass(self.masses[0]).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(self.masses[1]).diameter(0.9))
            .species(SpeciesDraft::new("S").diameter(1.0).fixed())
            .interaction(InteractionDraft::new(steps(f64::INFINITY)).between("A", "A").restitution(self.restitution))
            .interaction(InteractionDraft::new(steps(w)).between("A", "B").restitution(self.restitution))
            .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B").restitution(self.restitution))
            .interaction(
                InteractionDraft::new(Potential::square_well(1.0, 1.5, v).unwrap())
                    .between("A", "S")
                    .restitution(self.restitution),
            )
            .interaction(InteractionDraft::new(Model::HardSphere).between("B", "S").restitution(self.restitution))
            .interaction(
                InteractionDraft::new(Potential::bond(0.7, 1.9).unwrap()).named("link").restitution(self.restitution),
            );
        if let Some(time) = self.contact_time {
            builder = builder.contact_time(time);
        }
        for k in 0..3_u32 {
            let x = 1.5 + 2.5 * f64::from(k);
            builder = builder
                .particle("S", Vector::new(x, 1.0, 1.0), Vector::zeros())
                .particle("A", Vector::new(x, 3.0, 1.0), Vector::new(0.3 * x, -1.1, 0.9))
                .particle("B", Vector::new(x, 4.5, 1.0), Vector::new(-0.7, 0.4 * x, 0.8))
                .bond([3 * k + 1, 3 * k + 2], "link");
        }
        let mut fill = Fill::new(Lattice::SimpleCubic, "A").count(24);
        fill.composition = vec![("A".into(), 0.5), ("B".into(), 0.5)];
        fill.temperature = Some(1.0);
        let fill = fill.region(Vector::new(0.1, 0.1, 2.6), Vector::new(7.9, 7.9, 7.9));
        builder.fill(fill).build().unwrap()
    }
}

struct Judge<'a> {
    reference: &'a mut Reference,
    /// TC models with the nominal contact time, and with slightly shorter and longer contact times.
    tc_models: Vec<TcModel>,
    counts: &'a RefCell<BTreeMap<String, u32>>,
}

impl Judge<'_> {
    fn pair(&mut self, event: &engine::Event, j: ParticleId, found: engine::Outcome) -> Result<(), TestCaseError> {
        let i = event.particle;
        let known = self.reference.pairs.get_mut(&(i.0.min(j.0), i.0.max(j.0)));
        let (interaction, state) = known.ok_or_else(|| TestCaseError::fail(format!("no interaction: {event:?}")))?;
        let Interaction { potential, law, .. } = &self.reference.scene.interactions[interaction.0 as usize];
        let sides = [Side::Positive, Side::Negative].map(|side| (side, seen(potential, *state, side)));
        let at = sides
            .into_iter()
            .find_map(|(side, seen)| seen.filter(|seen| seen.distance == event.distance).map(|seen| (side, seen)));
        let (side, seen) = at.ok_or_else(|| TestCaseError::fail(format!("not in state {state}: {event:?}")))?;
        let species = [i, j].map(|particle| self.reference.scene.species_of(particle));
        let weights = species.map(Species::inverse_mass);
        let apart = event.positions[0] - event.positions[1];
        let encounter = Encounter {
            sliding: None,
            seen,
            side,
            normal: apart.normalize(),
            velocity: event.before[0] - event.before[1],
            acceleration: species[0].acceleration - species[1].acceleration,
            curvature: 1.0 / apart.norm(),
            reduced_mass: 1.0 / (weights[0] + weights[1]),
            law: *law,
        };
        let moving: Vec<u32> = [i, j].into_iter().zip(weights).filter(|(_, w)| *w > 0.0).map(|(p, _)| p.0).collect();
        let outcome = match found {
            engine::Outcome::Core => Outcome::Core,
            engine::Outcome::Capture => Outcome::Capture,
            engine::Outcome::Release => Outcome::Release,
            engine::Outcome::Bounce => Outcome::Bounce,
        };
        match outcome {
            Outcome::Capture => *state += 1,
            Outcome::Release => *state -= 1,
            Outcome::Core | Outcome::Bounce => {}
        }
        let partner = if moving.len() == 1 { ", static" } else { "" };
        let barrier = if seen.energy_step == f64::INFINITY { ", barrier" } else { "" };
        self.compare(event, &encounter, weights, &moving, (outcome, &format!("{outcome:?}{barrier}{partner}")))
    }

    fn wall(&mut self, event: &engine::Event, axis: u8) -> Result<(), TestCaseError> {
        let species = self.reference.species(event.particle.0);
        let Boundary::Bounded { lower: Face::Wall(law), .. } = self.reference.scene.space.boundary[usize::from(axis)]
        else {
            return Err(TestCaseError::fail("no wall"));
        };
        let weights = [species.inverse_mass(), 0.0];
        let encounter = Encounter {
            sliding: None,
            seen: Discontinuity { distance: event.distance, energy_step: f64::INFINITY },
            side: Side::Positive,
            normal: event.normal,
            velocity: event.before[0],
            acceleration: species.acceleration,
            curvature: 0.0,
            reduced_mass: species.mass,
            law,
        };
        self.compare(event, &encounter, weights, &[event.particle.0], (Outcome::Core, "Wall"))
    }

    /// Checks an event of the engine. At least one of the TC models must agree.
    fn compare(
        &mut self,
        event: &engine::Event,
        encounter: &Encounter,
        weights: [f64; 2],
        moving: &[u32],
        (outcome, kind): (Outcome, &str),
    ) -> Result<(), TestCaseError> {
        let without = [encounter.leave(None, moving, event.time)];
        let with = self.tc_models.iter_mut().map(|model| encounter.leave(Some(model), moving, event.time));
        let mut possible: Vec<_> = with.collect();
        if possible.is_empty() {
            possible.extend(without);
        }
        let mut least = f64::INFINITY;
        for (expected, after, _) in possible {
            prop_assert_eq!(expected, outcome, "{:?}", event);
            least = least.min(self.excess(event, encounter, weights, &after));
        }
        prop_assert!(least <= 1.0, "{kind} is {least} times as far off as rounding: {event:?}");
        *self.counts.borrow_mut().entry(kind.to_owned()).or_default() += 1;
        Ok(())
    }

    /// Returns the largest difference between an event and its expectation, divided by its round-off bound.
    fn excess(&self, event: &engine::Event, encounter: &Encounter, weights: [f64; 2], after: &Vector) -> f64 {
        let &Encounter { seen, velocity, reduced_mass: mu, normal, .. } = encounter;
        let is_crossed =
            matches!(event.kind, engine::EventKind::Pair(engine::Outcome::Capture | engine::Outcome::Release));
        let step = if is_crossed { 2.0 * seen.energy_step.abs() / mu } else { 0.0 };
        let fastest = event.before[0].norm() + event.before[1].norm() + step.sqrt();
        // After a pair crosses a step, its normal velocity is the root of a rounded number. A small root is inaccurate.
        let rounding = ROUNDINGS * fastest * fastest;
        let root = if is_crossed { rounding / after.dot(&normal).abs().max(rounding.sqrt()) } else { 0.0 };
        let bound = ROUNDINGS * fastest + root + if self.tc_models.is_empty() { 0.0 } else { TIE * after.norm() };
        let impulse = (after - velocity) * mu;
        let mut largest = (event.normal_impulse() - impulse.dot(&normal)).abs() / (mu * bound);
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            let expected = event.before[k] + impulse * (sign * weights[k]);
            let bound = bound * (weights[k] * mu).max(f64::EPSILON) + ROUNDINGS * event.before[k].norm();
            largest = largest.max((event.after[k] - expected).norm() / bound.max(f64::MIN_POSITIVE));
        }
        let energy_step = if is_crossed { seen.energy_step } else { 0.0 };
        let lost = 0.5 * mu * (velocity.norm_squared() - after.norm_squared());
        let dissipated = if is_crossed { 0.0 } else { lost };
        let bound = 2.0 * mu * fastest * bound;
        largest.max((event.energy_step - energy_step).abs() / bound).max((event.dissipated - dissipated).abs() / bound)
    }
}

#[test]
fn every_engine_event_matches_the_reference() {
    let counts = RefCell::new(BTreeMap::new());
    let run = |recipe: Recipe| {
        let scene = recipe.scene();
        let mut reference = Reference::new(&scene).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let count = scene.particles.len();
        let times = scene.contact_time.into_iter().flat_map(|time| [time, time * (1.0 - TIE), time * (1.0 + TIE)]);
        let tc_models = times.map(|time| TcModel::new(time, count)).collect();
        let mut judge = Judge { reference: &mut reference, tc_models, counts: &counts };
        let mut simulation = Simulation::without_plan(scene);
        let mut verdict = Ok(());
        // The result is ignored, because a scene may collapse or run out of events.
        let _ = simulation.advance_with(Until::time(1e3).or_events(EVENTS), |event| {
            if verdict.is_ok() {
                verdict = match (event.kind, event.partner()) {
                    (engine::EventKind::Pair(outcome), Some(partner)) => judge.pair(event, partner, outcome),
                    (engine::EventKind::Surface, _) => judge.wall(event, event.wall().unwrap().0),
                    _ => Err(TestCaseError::fail(format!("not an event of this scene: {event:?}"))),
                };
            }
        });
        verdict
    };
    TestRunner::new(ProptestConfig { cases: SCENES, ..ProptestConfig::default() }).run(&recipe(), run).unwrap();
    let counts = counts.into_inner();
    assert!(counts.values().all(|&count| count >= FEWEST), "{counts:?}");
    assert!(counts.len() >= 9, "{counts:?}");
    assert!(counts.values().sum::<u32>() > SCENES * u32::try_from(EVENTS).unwrap() / 2, "{counts:?}");
}
