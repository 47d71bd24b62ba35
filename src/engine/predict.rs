//! Prediction of the next contact and the next transition of one particle.
//!
//! | what | where |
//! |---|---|
//! | contacts in a grid of cells, and the transition to the next cell | [`in_cell`] |
//! | contacts in a Verlet list, and the time when the particle leaves its skin | [`in_list`] |
//! | the earliest contact with many particles, in SIMD lanes | [`batch`] |
//! | a filter for pairs that must be tested one by one | [`reach`] |
//! | contacts while diameters grow | [`growth`] |
//! | contacts with captured partners | this file |
//! | contacts with distant bonded partners | [`loose_bonds`] |
//! | contacts with walls and other surfaces | [`surfaces`] |
//!
//! [`super::images`] chooses the periodic images of a pair. The search for new neighbours of a list,
//! [`super::neighbours::packed`], uses the nearest image.

pub(super) mod batch;
mod growth;
mod in_cell;
mod in_list;
mod loose_bonds;
pub(super) mod reach;
mod surfaces;

use super::parts::Engine;
use super::prediction::Prediction;
use super::state::Body;
use crate::Vector;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::pairs::Pairs;
use crate::physics::detection::lanes::MOST_LANES;
use crate::physics::detection::{accelerated, inertial};
use crate::physics::motion::{RelativeState, stream_position};
use crate::physics::overlap::{Quadratic, Quartic, Side};
use batch::Batch;

#[derive(Debug, Clone)]
pub(in crate::engine) struct Scratch {
    pub near: Candidates,
    /// Marks the captured partners of the predicted particle, by index. Between predictions, no particle is marked.
    pub is_captured: Vec<bool>,
}

impl Scratch {
    /// `particles` is the number of particles, or 0 if no pair can be captured.
    pub fn new(particles: usize) -> Self {
        Self { near: Candidates::default(), is_captured: vec![false; particles] }
    }

    /// Makes room for more particles.
    pub fn enlarge(&mut self, particles: usize) {
        self.is_captured.resize(particles.max(self.is_captured.len()), false);
    }
}

/// State of a particle at the time of its prediction.
pub(in crate::engine) struct Streamed {
    pub number: u32,
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub time: f64,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline]
    pub(in crate::engine) fn state_at(&self, particle: u32, time: f64) -> (Vector, Vector) {
        streamed::<FALLING>(&self.state.bodies[particle as usize], &self.acceleration(particle), time)
    }

    pub(in crate::engine) fn streamed(&self, number: u32, time: f64) -> Streamed {
        let (position, velocity) = self.state_at(number, time);
        Streamed { number, position, velocity, acceleration: self.acceleration(number), time }
    }

    pub(in crate::engine) fn predict(&self, particle: u32, time: f64, scratch: &mut Scratch) -> Prediction {
        let me = self.streamed(particle, time);
        let mut prediction = Prediction::NONE;
        if TABLE {
            self.predict_captured(&me, &mut prediction);
        }
        match &self.neighbours {
            Neighbours::Lists(verlet) => self.predict_in_list(&me, verlet, &mut prediction),
            Neighbours::Cells(cells) => self.predict_in_cell(&me, cells, scratch, &mut prediction),
        }
        if self.is_loosely_bonded(particle) {
            self.predict_loose_bonds(&me, &mut prediction);
        }
        prediction
    }

    /// Predicts contacts with captured partners. A captured pair is between two discontinuities and can reach both.
    fn predict_captured(&self, me: &Streamed, prediction: &mut Prediction) {
        let Pairs { states, rules, .. } = &self.pairs;
        let captured = states.of(me.number);
        if captured.is_empty() {
            return;
        }
        let is_batch = self.are_captured_nearest(me.number);
        if is_batch {
            let wraps = self.ranges.may_be_overstretched
                || self.neighbours.verlet().is_none_or(|verlet| verlet.wraps(&me.position));
            self.batch_of(me, wraps).earliest_of_captured::<FALLING>(me, captured, rules, prediction);
            if !FALLING {
                return;
            }
        }
        for captured in captured {
            if is_batch && !rules.meeting(self.row(me.number), self.row(captured.partner)).is_accelerated {
                continue;
            }
            let (state, _) = self.relative(me, captured.partner);
            let steps = &rules.steps[usize::from(captured.interaction)];
            for side in [Side::Positive, Side::Negative] {
                let Some(seen) = steps.seen_from(captured.state, side) else { continue };
                let horizon = prediction.contact_time - me.time;
                let squared = self.squared_of_pair(seen.squared, [me.number, captured.partner]);
                if let Some(dt) = self.detect(me, captured.partner, &state, (squared, side), horizon) {
                    self.offer(me, captured.partner, side, dt, prediction);
                }
            }
        }
    }

    /// Predicts the first contact with an uncaptured particle. If `wraps` is true, nearest images may lie across a side
    /// of the box.
    #[inline(always)]
    pub(in crate::engine) fn predict_batch(
        &self,
        me: &Streamed,
        wraps: bool,
        (others, length): (&[u32], usize),
        prediction: &mut Prediction,
    ) {
        if let Some(growing) = self.distances.growing() {
            return self.predict_growing(me, growing, wraps, others, prediction);
        }
        self.predict_uncaptured(me, wraps, others, length, prediction);
    }

    /// Like [`Self::predict_batch`], for contact distances that do not change with time.
    #[inline(never)]
    fn predict_uncaptured(
        &self,
        me: &Streamed,
        wraps: bool,
        others: &[u32],
        length: usize,
        prediction: &mut Prediction,
    ) {
        let before = prediction.contact_time;
        let met = self.batch_of(me, wraps).earliest_contact::<FALLING, TABLE>(me, others, length, before);
        if met.other != NO_PARTICLE && prediction.is_before(me.number, met.other, met.time, &self.state.bodies) {
            prediction.meet(me.number, met.other, Side::Positive, met.time, &self.state.bodies);
        }
        if FALLING
            && TABLE
            && let Some(reaches) = self.pairs.rules.accelerated(self.row(me.number))
        {
            let others = &others[..length.next_multiple_of(MOST_LANES)];
            self.predict_within_reach(me, wraps, others, &reaches, prediction);
        }
    }

    #[inline]
    pub(in crate::engine) fn batch_of(&self, me: &Streamed, wraps: bool) -> Batch<'_> {
        let row = self.row(me.number);
        Batch {
            width: self.hardware.width,
            bodies: &self.state.bodies,
            periods: &self.state.periods,
            wraps,
            acceleration: me.acceleration,
            reaches: self.pairs.rules.inertial(row),
            radii: &self.state.sizes.radii,
            has_one_row: self.ranges.has_one_row,
            rows: &self.state.rows,
        }
    }

    /// Predicts the contact of an uncaptured pair at its outermost discontinuity. The pair comes from outside.
    #[inline]
    pub(in crate::engine) fn predict_uncaptured_pair(&self, me: &Streamed, other: u32, prediction: &mut Prediction) {
        if other == me.number {
            return;
        }
        let squared = if TABLE {
            let meeting = self.pairs.rules.meeting(self.row(me.number), self.row(other));
            if !meeting.exists {
                return;
            }
            self.squared_of_pair(meeting.squared, [me.number, other])
        } else {
            self.pairs.rules.meeting(0, 0).squared
        };
        let (state, is_across) = self.relative(me, other);
        let horizon = prediction.contact_time - me.time;
        if let Some(dt) = self.detect(me, other, &state, (squared, Side::Positive), horizon) {
            self.offer(me, other, Side::Positive, dt, prediction);
        }
        self.predict_in_further_images(me, other, (&state, is_across), squared, prediction);
    }

    #[inline]
    pub(in crate::engine) fn predict_in_further_images(
        &self,
        me: &Streamed,
        other: u32,
        (nearest, is_across): (&RelativeState, bool),
        squared: f64,
        prediction: &mut Prediction,
    ) {
        self.for_each_further_image(nearest, is_across, |state| {
            if let Some(dt) = self.detect(me, other, state, (squared, Side::Positive), f64::INFINITY) {
                self.offer(me, other, Side::Positive, dt, prediction);
            }
        });
    }

    /// Returns the position and velocity of `me` relative to the nearest image of another particle. The flag is true if
    /// the image lies across the sliding sides of a sheared box.
    #[inline]
    pub(in crate::engine) fn relative(&self, me: &Streamed, other: u32) -> (RelativeState, bool) {
        let (position, velocity) = self.state_at(other, me.time);
        self.nearest(me.position - position, me.velocity - velocity, me.time)
    }

    /// Returns the time until the pair reaches a discontinuity at the given squared distance, from the given side.
    /// Events later than `horizon` may be omitted.
    #[inline]
    pub(in crate::engine) fn detect(
        &self,
        me: &Streamed,
        other: u32,
        state: &RelativeState,
        (squared, side): (f64, Side),
        horizon: f64,
    ) -> Option<f64> {
        if FALLING && TABLE {
            let acceleration = me.acceleration - self.acceleration(other);
            if acceleration != Vector::zeros() {
                if side == Side::Positive && is_out_of_reach(state, &acceleration, squared, horizon) {
                    return None;
                }
                return accelerated::next_event(&Quartic::new(state, &acceleration, squared), side);
            }
        }
        if !self.distances.are_constant() {
            return self.distances.next_contact(state, squared.sqrt(), me.time);
        }
        inertial::next_event(&Quadratic::new(state, squared), side)
    }

    /// Stores a pair event if it is the earliest so far. If events are simultaneous, lower ids come first.
    #[inline]
    pub(in crate::engine) fn offer(&self, me: &Streamed, other: u32, side: Side, dt: f64, prediction: &mut Prediction) {
        let time = me.time + dt;
        if prediction.is_before(me.number, other, time, &self.state.bodies) {
            prediction.meet(me.number, other, side, time, &self.state.bodies);
        }
    }
}

/// Factor by which squared reaches are enlarged, so that round-off cannot hide a contact.
pub(in crate::engine) const SLACK_FACTOR: f64 = 1.0 + 1e-9;

/// Returns true if a pair is too far apart to meet within the time `T = horizon`, even if the particles fly straight at
/// each other.
///
/// The condition is `|r| > s + |v| T + |a| T^2 / 2` with the contact distance `s` and a margin for round-off. The
/// result is false if `T` is infinite or NaN.
#[inline]
pub(in crate::engine) fn is_out_of_reach(
    state: &RelativeState,
    acceleration: &Vector,
    squared: f64,
    horizon: f64,
) -> bool {
    let speed = state.velocity.norm() + 0.5 * acceleration.norm() * horizon;
    let reach = squared.sqrt() + speed * horizon;
    state.position.norm_squared() > reach * reach * SLACK_FACTOR
}

#[inline]
pub(in crate::engine) fn streamed<const FALLING: bool>(
    body: &Body,
    acceleration: &Vector,
    time: f64,
) -> (Vector, Vector) {
    let dt = time - body.time;
    if FALLING {
        (stream_position(&body.position, &body.velocity, acceleration, dt), body.velocity + acceleration * dt)
    } else {
        (body.position + body.velocity * dt, body.velocity)
    }
}
