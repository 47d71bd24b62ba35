//! Builds the engine of a scene.

use super::array::Array;
use super::clock::Clock;
use super::distances::Distances;
use super::images::ImagePolicy;
use super::images::travelled::Travelled;
use super::parts::{Counts, Engine, Hardware};
use super::prediction::{Prediction, Schedule};
use super::sources::Sources;
use super::state::State;
use crate::Vector;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::ranges::Ranges;
use crate::engine::neighbours::{Neighbours, Search};
use crate::engine::pairs::Pairs;
use crate::engine::schedule::EventQueue;
use crate::model::potential::Potential;
use crate::model::{InteractionId, Scene};
use crate::physics::detection::lanes::Simd;
use crate::physics::motion::RelativeState;
use std::borrow::Cow;
use std::ops::Range;

/// Number of due times from which the median is estimated.
const MANY: usize = 32_768;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub fn new(scene: &Scene) -> Self {
        let mut engine = Self::placed(scene);
        let search = Search::of(scene, &engine.pairs.rules.rows, &engine.ranges);
        engine.begin(scene, search);
        engine
    }

    /// Creates an engine with all particles in place, but without predictions.
    pub(super) fn placed(scene: &Scene) -> Self {
        let count = scene.particles().len();
        let pairs = Pairs::of(scene, TABLE);
        let rows = &pairs.rules.rows;
        let state = State::of(scene, rows, TABLE);
        let mut engine = Self {
            clock: Clock::new(scene.start_time(), count),
            schedule: Schedule::new(Array::new(), EventQueue::new(0, 0, 1.0)),
            neighbours: Neighbours::none(scene.space()),
            ranges: Ranges::of(scene, rows),
            images: ImagePolicy::of(scene),
            distances: Distances::default(),
            sources: Sources::of(scene, rows, &state),
            state,
            counts: Box::new(Counts::new(if TABLE { rows.species().len() } else { 0 })),
            hardware: Hardware { width: Simd::most(), looks_ahead: false },
            broken: None,
            domains: None,
            slabs: None,
            scratch: None,
            pairs,
        };
        engine.schedule_global();
        engine
    }

    pub(super) fn begin(&mut self, scene: &Scene, search: Search) {
        let count = self.state.bodies.len();
        self.schedule.predictions = vec![Prediction::NONE; count].into();
        self.schedule.queue = EventQueue::new(count, count, 1.0);
        if let Some(last) = scene.last_state() {
            let bodies = &self.state.bodies;
            self.state
                .images
                .set(|particle| last.images.get(bodies[particle as usize].id as usize).copied().unwrap_or_default());
        }
        self.sort_in(search);
        if TABLE {
            self.set_pair_states(scene);
        }
        self.predict_all();
        let moving = self.schedule.predictions.iter().filter(|prediction| prediction.due_time().is_finite()).count();
        if moving > 0 {
            let finite = self.schedule.predictions.iter().map(Prediction::due_time).filter(|time| time.is_finite());
            let mut times: Vec<f64> = finite.step_by(moving.div_ceil(MANY)).collect();
            let middle = times.len() / 2;
            let median = *times.select_nth_unstable_by(middle, f64::total_cmp).1;
            self.schedule.queue = EventQueue::new(self.state.moving, moving, median);
        } else if let Some(inlets) = &self.sources.inlets
            && let Some(interval) = inlets.shortest_interval()
        {
            self.schedule.queue = EventQueue::new(1, 1, interval);
        }
        for particle in self.particles() {
            self.enqueue(particle);
        }
    }

    /// Fills the lists of all particles, and predicts the events of all particles, at the beginning of an epoch.
    pub(super) fn predict_all(&mut self) {
        self.fill_lists();
        self.enlarge();
        for particle in self.particles() {
            if !self.is_static(particle) {
                self.predict_anew(particle, 0.0);
            }
        }
    }

    /// Frees the largest arrays before another engine replaces this engine.
    pub(super) fn let_go(&mut self) {
        (self.state.bodies, self.state.images) = (Array::new(), Travelled::new(0));
        self.schedule = Schedule::new(Array::new(), EventQueue::new(0, 0, 1.0));
        self.neighbours = Neighbours::none(&self.state.space);
    }

    pub(super) fn set_pair_states(&mut self, scene: &Scene) {
        for bond in &scene.bonds {
            let [a, b] = bond.pair.map(|id| self.number(id));
            self.remember(scene, a, b, bond.interaction.narrow(), true);
        }
        self.set_states_of(scene, self.particles());
        // Because of rounding, a pair that was captured in the previous run may be just beyond the search range.
        for ([a, b], _) in scene.last_state().iter().flat_map(|last| &last.captured) {
            self.remember_if_unknown(scene, self.number(*a), self.number(*b));
        }
    }

    /// Sets the states of those pairs of the given particles that have no state yet. The particles are the last in memory.
    pub(super) fn set_states_of(&mut self, scene: &Scene, particles: Range<u32>) {
        let has_states = |id: InteractionId| scene.interactions[id.0 as usize].potential.accessible_states() != (0..=0);
        if !scene.table.iter().any(|(_, id)| has_states(id)) {
            return;
        }
        let holds_all_pairs = scene.table.iter().any(|(_, id)| scene.interactions[id.0 as usize].potential.is_bond());
        let mut near = Candidates::default();
        for a in particles.clone() {
            self.neighbours.find_candidates(a, self.row(a), &mut near);
            let all = if holds_all_pairs { self.particles() } else { 0..0 };
            let found = if holds_all_pairs { &[] } else { near.found() };
            let mut across = Vec::new();
            self.for_each_across(a, |b| across.push(b));
            for b in all.chain(found.iter().copied()).chain(across) {
                // A pair is found twice if both particles are in `particles`.
                let is_found_twice = b < a && particles.contains(&b) && !self.is_static(b);
                if b == a || is_found_twice || self.is_static(a) && (self.is_static(b) || particles.contains(&b)) {
                    continue;
                }
                self.remember_if_unknown(scene, a, b);
            }
        }
    }

    /// Sets the state of a pair that interacts and has no state yet.
    fn remember_if_unknown(&mut self, scene: &Scene, a: u32, b: u32) {
        let (holder, partner) = if self.is_static(a) { (b, a) } else { (a, b) };
        let meeting = *self.pairs.rules.meeting(self.row(a), self.row(b));
        if meeting.exists && self.pairs.states.get(holder, partner).is_none() {
            self.remember(scene, a, b, meeting.interaction, false);
        }
    }

    /// Sets the state of one pair. A bonded pair is stored even in state 0, because it has its own interaction.
    fn remember(&mut self, scene: &Scene, a: u32, b: u32, interaction: u16, is_bond: bool) {
        let ids = [a, b].map(|particle| self.id(particle));
        let of_run = scene.last_state().and_then(|last| last.state_of(ids, InteractionId(u32::from(interaction))));
        let state = of_run.unwrap_or_else(|| self.state_by_distance(scene, a, b, interaction));
        if state > 0 || is_bond {
            self.set_pair_state(a, b, state, interaction);
        }
    }

    fn state_by_distance(&self, scene: &Scene, a: u32, b: u32, interaction: u16) -> u16 {
        let [(one, v), (other, u)] = [a, b].map(|particle| self.state_at(particle, self.clock.now));
        let apart = self.nearest(one - other, v - u, self.clock.now).0;
        let rounding = rounding_of_distances(one.amax().max(other.amax()), &self.state.periods);
        let potential = &scene.interactions[usize::from(interaction)].potential;
        let potential = if self.has_sizes() {
            let pair = [a, b].map(|particle| (self.species_of(particle), self.radius(particle)));
            if !potential.is_bond() && apart.position.norm() > scene.range_with(pair[0], pair[1]) + rounding {
                return 0;
            }
            scene.potential_between(InteractionId(u32::from(interaction)), pair)
        } else {
            Cow::Borrowed(potential)
        };
        let state = state_at_start(&potential, &apart, rounding);
        // A potential has at most a few thousand steps, so the state fits into 16 bits.
        u16::try_from(state).unwrap_or(u16::MAX)
    }
}

/// Number of roundings in the distance of a pair at its event. Each of the six coordinates is streamed in three
/// operations, wrapped, and subtracted.
const ROUNDINGS: f64 = 32.0;

/// Returns the rounding error of the distance of a pair at its discontinuity `[length]`.
pub(super) fn rounding_of_distances(largest: f64, periods: &Vector) -> f64 {
    let wrapped = periods.iter().filter(|period| period.is_finite()).fold(0.0, |most: f64, period| most.max(*period));
    ROUNDINGS * f64::EPSILON * largest.max(wrapped)
}

/// Returns the state of a pair at the start from its distance. Within round-off of a discontinuity, for example after a
/// run that ended at an event, the pair is on the side towards which it moves.
fn state_at_start(potential: &Potential, apart: &RelativeState, rounding: f64) -> usize {
    let distance = apart.position.norm();
    let receding = apart.position.dot(&apart.velocity);
    match potential.radii().iter().find(|radius| (distance - **radius).abs() <= rounding) {
        Some(radius) if receding > 0.0 => potential.state_at(*radius),
        Some(radius) if receding < 0.0 => potential.state_at(radius.next_down()),
        _ => potential.state_at(distance),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::reference::Reference;
    use crate::check::verify::{EventRange, verify};
    use crate::engine::{Reason, Simulation, Until};
    use crate::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};
    use std::ops::ControlFlow;

    fn wells() -> SceneBuilder {
        let well = Potential::square_well(1.0, 1.5, 1.0).unwrap();
        SceneBuilder::new("wells")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(well).between("A", "A"))
    }

    #[test]
    fn pair_at_an_event_restarts_in_its_last_state() {
        for seed in 1..=20 {
            let fluid =
                wells().seed(seed).fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2));
            let scene = fluid.temperature(1.5).build().unwrap();
            let space = scene.space.clone();
            let mut simulation = Simulation::without_plan(scene);
            assert_eq!(simulation.advance(Until::events(1_500)), Ok(Reason::Events));
            let snapshot = simulation.snapshot();
            let mut next = wells().space(space);
            for (position, velocity) in snapshot.positions.iter().zip(&snapshot.velocities) {
                next = next.particle("A", *position, *velocity);
            }
            let next = next.build().unwrap();
            let mut again = Simulation::without_plan(next.clone());
            assert_eq!(again.energy().potential, simulation.energy().potential, "seed {seed}");
            assert_eq!(again.captured_pairs(), simulation.captured_pairs(), "seed {seed}");
            let proven = verify(next.clone(), EventRange { from: 0, events: 5 }, &mut |_| ControlFlow::Continue(()));
            assert!(proven.is_proven(), "seed {seed}: {:?}", proven.end);
            if seed <= 5 {
                let mut reference = Reference::new(&next).unwrap();
                for _ in 0..3 {
                    let one = again.events(Until::time(1e3)).next().unwrap().unwrap();
                    let other = reference.step_before(1e3).unwrap();
                    // The two engines may list the particles of an event in a different order.
                    let (i, j) = (one.particle, one.partner().unwrap());
                    assert_eq!((i.min(j), Some(i.max(j))), (other.particle, other.partner));
                    assert_eq!(one.energy_step, other.energy_step, "both engines capture, or both release");
                    assert!((one.time - other.time).abs() < 1e-9, "seed {seed}");
                }
            }
        }
    }

    #[test]
    fn velocity_decides_pair_state_only_at_a_discontinuity() {
        let potential = Potential::square_well(1.0, 1.5, 1.0).unwrap();
        let state = |distance: f64, radial: f64| {
            let apart =
                RelativeState { position: Vector::new(distance, 0.0, 0.0), velocity: Vector::new(radial, 1.0, 0.0) };
            state_at_start(&potential, &apart, rounding_of_distances(3.0, &Vector::repeat(f64::INFINITY)))
        };
        let (inside, outside) = (1.5_f64.next_down(), 1.5_f64.next_up());
        for at in [inside, 1.5, outside] {
            assert_eq!((state(at, -1.0), state(at, 1.0)), (1, 0), "{at}");
        }
        assert_eq!(
            [inside, 1.5, outside].map(|at| state(at, 0.0)),
            [1, 0, 0],
            "without a velocity the distance decides"
        );
        for radial in [-1.0, 1.0] {
            assert_eq!([1.5 - 1e-12, 1.5 + 1e-12].map(|at| state(at, radial)), [1, 0], "beyond rounding");
            assert_eq!(state(1.0, radial), 1, "no pair is captured through a hard core");
        }
    }
}
