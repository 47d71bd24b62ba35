//! Proof that no further event will ever happen.
//!
//! A long time without events is no proof: two spheres in a large periodic box may meet after thousands of crossings.
//! The proof shows that no particle meets a surface and that no pair meets. The particles of a pair must recede or miss
//! each other along the axes that are not periodic, by more than round-off.

use super::parts::Engine;
use super::predict::Streamed;
use crate::Vector;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::surfaces::{Flight, Placed, Surface};
use crate::physics::detection::never::{self, Doubt};
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;

/// Largest number of pairs for the full proof, which takes a few hundredths of a second. Larger systems are proven idle
/// only if no particle will leave its cell.
const MOST_PAIRS: usize = 4_000_000;

/// Largest number of pairs in adjacent cells. The proof then takes a few seconds.
const MOST_NEAR: usize = 400_000_000;

/// Number of cell transitions without an event before the first attempt at a proof. The attempt takes less time than
/// these transitions.
const FIRST_PROOF: u64 = 20_000;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Tries to prove, at the end of an epoch, that no further event will happen. The number of transitions without an
    /// event doubles from one attempt to the next.
    pub(super) fn is_shown_to_be_over(&mut self) -> bool {
        if !self.is_proof_due() {
            return false;
        }
        self.counts.transitions_at_proof = self.counts.totals.transition;
        self.is_over()
    }

    pub(super) fn is_proof_due(&self) -> bool {
        let done = self.counts.totals.transition;
        let quiet = done.wrapping_sub(self.counts.transitions_at_event);
        let since_proof = done.wrapping_sub(self.counts.transitions_at_proof);
        let pairs = (self.state.bodies.len() as u64).saturating_pow(2);
        quiet >= FIRST_PROOF.max(pairs / 16) && since_proof >= quiet / 2
    }

    /// Returns true if the current state proves that no further event will happen.
    pub(super) fn is_over(&self) -> bool {
        if self.acts_for_ever() || !self.sources.surfaces.rest_from(self.time()) {
            return false;
        }
        // A pair inside a step of its potential has a predicted contact, unless the pair has no relative motion.
        if self.schedule.predictions.iter().any(|prediction| prediction.contact_time < f64::INFINITY) {
            return false;
        }
        let moving: Vec<Streamed> = self
            .particles()
            .filter(|&particle| !self.is_static(particle))
            .map(|particle| self.streamed(particle, self.clock.now))
            .collect();
        let rests = |me: &Streamed| me.velocity == Vector::zeros() && me.acceleration == Vector::zeros();
        if !moving.iter().all(|me| rests(me) || !self.may_meet_surface(me)) {
            return false;
        }
        if moving.iter().all(rests) {
            return true;
        }
        let stays = |particle: u32| self.schedule.predictions[particle as usize].due_time() == f64::INFINITY;
        if matches!(self.neighbours, Neighbours::Cells(_)) && moving.iter().all(|me| stays(me.number)) {
            return self.neighbours_never_meet(&moving);
        }
        if moving.len().saturating_mul(self.state.bodies.len()) > MOST_PAIRS {
            return false;
        }
        moving.iter().all(|me| {
            self.particles()
                .filter(|&other| other != me.number && (other > me.number || self.is_static(other)))
                .all(|other| self.never_meet(me, other))
        })
    }

    /// Returns true if no captured pair and no pair in adjacent cells will ever meet.
    fn neighbours_never_meet(&self, moving: &[Streamed]) -> bool {
        let (mut near, mut left) = (Candidates::default(), MOST_NEAR);
        moving.iter().all(|me| {
            self.neighbours.find_candidates(me.number, self.row(me.number), &mut near);
            let Some(rest) = left.checked_sub(near.found().len()) else { return false };
            left = rest;
            let captured = if TABLE { self.pairs.states.of(me.number) } else { &[] };
            let captured = captured.iter().map(|captured| captured.partner);
            near.found().iter().copied().chain(captured).all(|other| other == me.number || self.never_meet(me, other))
        })
    }

    /// Bounds the rounding errors of positions and velocities.
    fn doubt(&self, particles: &[u32]) -> Doubt {
        let mut sums = [0.0; 2];
        for &particle in particles {
            let (position, velocity) = self.state_at(particle, self.clock.now);
            let body = &self.state.bodies[particle as usize];
            sums[0] += position.norm() + body.position.norm();
            sums[1] += velocity.norm() + body.velocity.norm();
        }
        Doubt::of(sums[0], sums[1])
    }

    fn may_meet_surface(&self, me: &Streamed) -> bool {
        let flight = self.flight(me);
        let mut doubt = self.doubt(&[me.number]);
        doubt.position += Doubt::of(flight.radius, 0.0).position;
        let mut may_meet = false;
        let mut look = |_: u32, surface: &Placed| may_meet |= !surface.shape.is_never_met(&flight, doubt);
        self.sources.surfaces.for_each_unlimited(self.row(me.number), &mut look);
        let is_periodic = self.state.periods.iter().any(|period| period.is_finite());
        if is_periodic && self.sources.surfaces.has_features() {
            // Features have infinitely many periodic images.
            return true;
        }
        self.sources.surfaces.for_each_feature(&flight.swept(f64::INFINITY), self.row(me.number), &mut look);
        self.sources.surfaces.for_each_moving(self.row(me.number), self.time(), |pose, surface| {
            let (position, velocity) = (pose.place_of_shape(&me.position), pose.direction_of_shape(&me.velocity));
            let acceleration = pose.direction_of_shape(&me.acceleration);
            let seen = Flight { position: &position, velocity: &velocity, acceleration: &acceleration, ..flight };
            may_meet |= !surface.shape.is_never_met(&seen, doubt);
        });
        may_meet
    }

    /// Returns true if a pair provably never meets. Its particles have no relative motion, or they recede or miss each
    /// other along the axes that are not periodic.
    pub(super) fn never_meet(&self, me: &Streamed, other: u32) -> bool {
        let Some(squared) = self.squared_range_from_outside(me.number, other) else { return true };
        let (position, velocity) = self.state_at(other, self.clock.now);
        let velocity = me.velocity - velocity;
        let acceleration = me.acceleration - self.acceleration(other);
        if velocity == Vector::zeros() && acceleration == Vector::zeros() {
            return true;
        }
        let open = |vector: Vector| {
            Vector::from_fn(|axis, _| if self.state.periods[axis] == f64::INFINITY { vector[axis] } else { 0.0 })
        };
        let is_anywhere_periodic = self.state.periods.iter().any(|period| period.is_finite());
        let state = RelativeState { position: open(me.position - position), velocity: open(velocity) };
        if is_anywhere_periodic && state.position.norm_squared() <= squared {
            return false;
        }
        let (acceleration, distance) = (open(acceleration), squared.sqrt());
        let doubt = self.doubt(&[me.number, other]);
        if acceleration == Vector::zeros() {
            never::inertial(&state, &doubt, distance)
        } else {
            never::accelerated(&state, &acceleration, &doubt, distance)
        }
    }

    /// Returns the squared distance at which a pair enters the range of its potential `[length^2]`. `None` for a pair
    /// within the range, and for a pair that never meets.
    fn squared_range_from_outside(&self, a: u32, b: u32) -> Option<f64> {
        if !TABLE {
            return Some(self.pairs.rules.meeting(0, 0).squared);
        }
        if let Some(captured) = self.pairs.states.get(a, b) {
            let steps = &self.pairs.rules.steps[usize::from(captured.interaction)];
            let seen = (captured.state == 0).then(|| steps.seen_from(0, Side::Positive)).flatten();
            return seen.map(|seen| self.squared_of_pair(seen.squared, [a, b]));
        }
        let meeting = self.pairs.rules.meeting(self.row(a), self.row(b));
        // A particle that passes within the sleep distance can wake a sleeping particle.
        let passing = self.sources.sleepers.as_ref().filter(|_| self.is_asleep(b)).map_or(0.0, |it| it.plan.distance);
        if passing > 0.0 {
            let range = self.distance_of_pair(meeting.squared.sqrt(), [a, b]) + passing;
            return meeting.exists.then_some(range * range);
        }
        meeting.exists.then(|| self.squared_of_pair(meeting.squared, [a, b]))
    }
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::engine::{Reason, Simulation, Until};
    use crate::model::ContactLaw;
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Face, Space};
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

    fn balls(boundary: [Boundary; 3], velocity: [f64; 3]) -> Simulation {
        let mut space = Space::periodic_cube(40.0);
        space.boundary = boundary;
        let scene = SceneBuilder::new("balls")
            .species(SpeciesDraft::new("ball").mass(0.3).diameter(1.0))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 0.1).unwrap()).between("ball", "ball"))
            .space(space)
            .particle("ball", Vector::new(20.0, 15.0, 20.0), Vector::zeros())
            .particle("ball", Vector::new(20.0, 25.0, 20.0), Vector::from(velocity))
            .build()
            .unwrap();
        Simulation::without_plan(scene)
    }

    const PERIODIC: Boundary = Boundary::Periodic;
    const OPEN: Boundary = Boundary::OPEN;

    #[test]
    fn run_is_over_only_if_nothing_can_collide_again() {
        let wall = Face::Wall(ContactLaw::smooth(1.0));
        let below = Boundary::Bounded { lower: wall, upper: Face::Open };
        for (boundary, velocity, expected) in [
            ([OPEN; 3], [0.0, 1.0, 0.0], true),
            ([OPEN; 3], [0.3, -1.0, 0.0], true),
            ([OPEN; 3], [0.01, -1.0, 0.0], false),
            ([PERIODIC; 3], [0.3, 1.0, 0.1], false),
            // The balls never meet. The proof fails in a box that is periodic along all axes.
            ([PERIODIC; 3], [1.0, 0.0, 0.0], false),
            ([PERIODIC; 3], [0.0, 0.0, 0.0], true),
            ([PERIODIC, OPEN, PERIODIC], [0.3, 1.0, 0.1], true),
            ([PERIODIC, OPEN, PERIODIC], [0.3, -1.0, 0.1], false),
            ([OPEN, PERIODIC, PERIODIC], [0.0, 1.0, 0.1], false),
            ([OPEN, below, OPEN], [0.3, 1.0, 0.0], true),
            ([OPEN, below, OPEN], [0.3, -1.0, 0.0], false),
        ] {
            assert_eq!(balls(boundary, velocity).is_over(), expected, "{boundary:?} {velocity:?}");
        }
    }

    #[test]
    fn possible_collision_hidden_by_rounding_does_not_end_the_run() {
        let hard = |gravity: f64| {
            let space = Space { boundary: [OPEN; 3], ..Space::periodic_cube(10.0) };
            let scene = SceneBuilder::new("far")
                .space(space)
                .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
                .species(SpeciesDraft::new("B").mass(1.0).diameter(1.0));
            let pairs = [["A", "A"], ["A", "B"], ["B", "B"]];
            let mut scene = pairs.into_iter().fold(scene, |scene, [a, b]| {
                scene.interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between(a, b))
            });
            scene.species[0].acceleration = (gravity > 0.0).then(|| Vector::new(0.0, 0.0, -gravity));
            scene
        };
        // The two spheres meet at t = 1.5e7. Without the collision, the smallest distance would be 0.985 diameters.
        let [position, velocity] = [
            [9_958_719.654_207_112, 11_205_396.372_943_148, 512_830.356_104_685_8],
            [-0.663_914_600_325_803_6, -0.747_026_464_671_845_6, -0.034_188_661_192_157_396],
        ];
        let far = hard(0.0).particle("A", Vector::zeros(), Vector::zeros()).particle(
            "A",
            Vector::from(position),
            Vector::from(velocity),
        );
        assert!(!Simulation::without_plan(far.build().unwrap()).is_over());
        // The thrown ball rises for a time of 10^9 and then falls onto the other ball.
        let thrown = hard(1e-9).particle("A", Vector::new(5.0, 5.0, 8.0), Vector::new(0.0, 0.0, 1.0)).particle(
            "B",
            Vector::new(5.0, 5.0, 2.0),
            Vector::zeros(),
        );
        let mut thrown = Simulation::without_plan(thrown.build().unwrap());
        thrown.advance(Until::time(20.0)).unwrap();
        assert!(!thrown.is_over());
    }

    #[test]
    fn receding_balls_in_open_space_end_the_run() {
        let mut simulation = balls([OPEN; 3], [0.01, -1.0, 0.0]);
        assert_eq!(simulation.advance(Until::events(100)), Ok(Reason::Idle));
        assert!(simulation.event_counts().physical() >= 2);
    }
}
