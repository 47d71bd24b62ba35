//! The proof that nothing will ever happen again.
//!
//! No event for a long time is no proof: two spheres in a large periodic box meet after thousands of crossings. What can be shown is that
//! no particle meets a wall, and that all pairs recede along the axes that are not periodic, where nothing comes back.

use super::event_loop::Engine;
use super::predict::Streamed;
use crate::Vector;
use crate::physics::detection::{accelerated, inertial, plane};
use crate::physics::motion::RelativeState;
use crate::physics::overlap::{Quadratic, Quartic, Side};

/// Pairs that are looked at in some hundredths of a second. With more of them the end is seen when no particle changes its cell any more.
const MOST_PAIRS: usize = 4_000_000;

/// Transitions without an event after which a proof is tried first: they take longer than the proof.
const FIRST_PROOF: u64 = 20_000;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Whether it is time to try a proof: after ever more transitions since the last event.
    #[inline]
    pub(super) fn is_proof_due(&self) -> bool {
        let quiet = self.tally.transition - self.transitions_at_event;
        let pairs = (self.bodies.len() as u64).saturating_pow(2);
        quiet >= FIRST_PROOF.max(pairs / 16) && quiet.is_power_of_two()
    }

    /// Whether it can be shown that nothing will ever happen again, by the states now.
    pub(super) fn is_over(&self) -> bool {
        if self.kicks.is_some() || self.growing.is_some() || self.shear.is_some() {
            return false;
        }
        if self.predictions.iter().all(|prediction| prediction.wake_time() == f64::INFINITY) {
            return true;
        }
        // Contacts of the pairs that are inside of a step of theirs are always predicted.
        if self.predictions.iter().any(|prediction| prediction.contact_time < f64::INFINITY) {
            return false;
        }
        let moving: Vec<Streamed> = self
            .particles()
            .filter(|&particle| !self.is_static(particle))
            .map(|particle| self.streamed(particle, self.now))
            .collect();
        if moving.len().saturating_mul(self.bodies.len()) > MOST_PAIRS {
            return false;
        }
        moving.iter().all(|me| !self.meets_wall(me))
            && moving.iter().all(|me| {
                self.particles()
                    .filter(|&other| other != me.id && (other > me.id || self.is_static(other)))
                    .all(|other| self.never_meet(me, other))
            })
    }

    fn meets_wall(&self, me: &Streamed) -> bool {
        let radius = self.rules.species[usize::from(self.species[me.id as usize])].radius;
        self.walls.iter().any(|wall| {
            let axis = usize::from(wall.face.axis);
            let inwards = if wall.face.is_upper { -1.0 } else { 1.0 };
            let height = inwards * (me.position[axis] - wall.at) - radius;
            plane::next_event(height, inwards * me.velocity[axis], inwards * me.acceleration[axis]).is_some()
        })
    }

    /// Whether a pair recedes for ever along the axes that are not periodic, or does not move relative to each other at all.
    fn never_meet(&self, me: &Streamed, other: u32) -> bool {
        let Some(squared) = self.squared_range_from_outside(me.id, other) else { return true };
        let (position, velocity) = self.state_at(other, self.now);
        let velocity = me.velocity - velocity;
        let acceleration = me.acceleration - self.acceleration(other);
        if velocity == Vector::zeros() && acceleration == Vector::zeros() {
            return true;
        }
        let open = |vector: Vector| {
            Vector::from_fn(|axis, _| if self.periods[axis] == f64::INFINITY { vector[axis] } else { 0.0 })
        };
        let is_anywhere_periodic = self.periods.iter().any(|period| period.is_finite());
        let state = RelativeState { position: open(me.position - position), velocity: open(velocity) };
        if is_anywhere_periodic && state.position.norm_squared() <= squared {
            return false;
        }
        let acceleration = open(acceleration);
        let next = if acceleration == Vector::zeros() {
            inertial::next_event(&Quadratic::new(&state, squared), Side::Positive)
        } else {
            accelerated::next_event(&Quartic::new(&state, &acceleration, squared), Side::Positive)
        };
        next.is_none()
    }

    /// The square of the distance at which a pair that is outside of its potential meets; `None` for pairs that never do, or are inside.
    fn squared_range_from_outside(&self, a: u32, b: u32) -> Option<f64> {
        if !TABLE {
            return Some(self.rules.meeting(0, 0).squared);
        }
        if let Some(known) = self.memory.get(a, b) {
            let steps = &self.rules.steps[usize::from(known.interaction)];
            let seen = (known.state == 0).then(|| steps.seen_from(0, Side::Positive)).flatten();
            return seen.map(|seen| seen.squared);
        }
        let meeting = self.rules.meeting(self.species[a as usize], self.species[b as usize]);
        meeting.exists.then_some(meeting.squared)
    }
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::engine::{Reason, Simulation, Until};
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Face, Space};
    use crate::scene::SceneBuilder;

    /// Two balls ten apart along y, with a relative velocity.
    fn balls(boundary: [Boundary; 3], velocity: [f64; 3]) -> Simulation {
        let mut space = Space::periodic_cube(40.0);
        space.boundary = boundary;
        let scene = SceneBuilder::new("balls")
            .species("ball", 0.3, 1.0)
            .interaction("ball", "ball", Potential::square_well(1.0, 1.5, 0.1).unwrap(), 1.0)
            .space(space)
            .particle("ball", Vector::new(20.0, 15.0, 20.0), Vector::zeros())
            .particle("ball", Vector::new(20.0, 25.0, 20.0), Vector::from(velocity))
            .build()
            .unwrap();
        Simulation::new(scene)
    }

    const PERIODIC: Boundary = Boundary::Periodic;
    const OPEN: Boundary = Boundary::OPEN;

    #[test]
    fn only_what_recedes_where_nothing_comes_back_is_over() {
        let wall = Face::Wall { restitution: 1.0 };
        let below = Boundary::Bounded { lower: wall, upper: Face::Open };
        for (boundary, velocity, expected) in [
            ([OPEN; 3], [0.0, 1.0, 0.0], true),
            ([OPEN; 3], [0.3, -1.0, 0.0], true),
            ([OPEN; 3], [0.01, -1.0, 0.0], false),
            ([PERIODIC; 3], [0.3, 1.0, 0.1], false),
            // They pass each other for ever, but that is not shown.
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
    fn balls_that_part_in_open_space_have_an_end() {
        let mut simulation = balls([OPEN; 3], [0.01, -1.0, 0.0]);
        assert_eq!(simulation.advance(Until::events(100)), Ok(Reason::Idle));
        assert!(simulation.tally().physical() >= 2);
    }
}
