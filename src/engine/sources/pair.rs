//! Execution: a predicted contact of a pair becomes an event.

mod restitution;

pub(in crate::engine) use restitution::Arrival;

use crate::Vector;
use crate::engine::audit::{Meeting, is_surely_round_off};
use crate::engine::event::{CountedKind, Event, EventKind};
use crate::engine::observe::{Observe, show};
use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::engine::{Invariant, InvariantBroken};
use crate::model::ParticleId;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;
use crate::physics::response::{Approach, Outcome, Response};
use std::ops::ControlFlow;

/// A pair at a discontinuity.
struct Encounter {
    i: u32,
    j: u32,
    side: Side,
    /// `r_ij`.
    apart: Vector,
    /// Along `r_ij`, `stretch` times as long; in the direction of approach where the two are at the same point.
    line: Vector,
    /// See [`stretch`].
    stretch: f64,
    /// `v_ij`.
    velocity: Vector,
    /// How fast the discontinuity moves outwards.
    surface: f64,
    /// Along `line`.
    approach: Approach,
}

/// Factor of the line of centres, which makes its squared length an ordinary divisor.
///
/// Spheres of diameter 1 meet at `|r|^2` within some floats of 1. To divide by `1 + k eps` rounds up more often than down, by
/// a twentieth of a rounding in the mean, and that heats a fluid by the same amount in every event. Nine sixteenths spread
/// the roundings evenly, and leave a head-on collision of simple numbers exact. Spheres of diameter 4/3 are the ones whose squared
/// distance nine sixteenths take to a power of two: their line stays as long as it is.
#[inline]
fn stretch(squared: f64) -> f64 {
    // The digits of `9/16 |r|^2`, moved so that those next to a power of two, on either side, are the smallest numbers.
    let digits = (0.5625 * squared).to_bits().wrapping_add(NEAR_POWER_OF_TWO) & DIGITS;
    if digits < 2 * NEAR_POWER_OF_TWO { 1.0 } else { 0.75 }
}

/// The digits of a float.
const DIGITS: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;

/// Floats on either side of a power of two that still round to one side: contacts are some tens of floats from their distance, and the
/// bias falls with the number.
const NEAR_POWER_OF_TWO: u64 = 1 << 16;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Moves a particle along its free flight to `time`.
    #[inline]
    pub(in crate::engine) fn stream(&mut self, particle: u32, time: f64) {
        let (position, velocity) = self.state_at(particle, time);
        let body = &mut self.state.bodies[particle as usize];
        (body.position, body.velocity, body.time) = (position, velocity, time);
    }

    /// A pair reaches a discontinuity.
    pub(in crate::engine) fn execute_pair(
        &mut self,
        [i, j]: [u32; 2],
        side: Side,
        time: f64,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let flown = [i, j].map(|particle| time - self.state.bodies[particle as usize].time);
        self.stream(i, time);
        self.stream(j, time);
        let (state, interaction) = self.pair_state(i, j);
        let Some((seen, restitution, surface)) = self.discontinuity(state, interaction, side, time) else {
            return Err(self.broken(i, Some(j), Invariant::Discontinuity));
        };
        let pair = self.encounter(i, j, side, surface);
        let before = self.velocities(i, j);
        self.note_state(&pair, &seen, flown);
        let (response, tangential_scale) = self.leave(&pair, &seen, restitution, time);

        let Approach { radial, squared, reduced_mass } = pair.approach;
        // Per length of the line.
        let change = (response.radial - radial) / squared;
        let impulse = reduced_mass * change;
        self.change_velocities(&pair, change, tangential_scale);
        if seen.energy_step == f64::INFINITY || response.outcome == Outcome::Bounce {
            self.separate(&pair);
        }
        self.counts.totals.count(response.outcome);
        if TABLE {
            self.count_by_species(i, j, &response, &seen);
        }
        if self.sources.confinement.is_some() {
            self.note_confined([i, j], &before);
        }
        self.counts.totals.virial += reduced_mass * (response.radial - radial) / pair.stretch;
        let (energy_step, dissipated) = match response.outcome {
            Outcome::Capture | Outcome::Release => (seen.energy_step, 0.0),
            _ if tangential_scale != 1.0 => (0.0, 0.0),
            _ => (0.0, -0.5 * impulse * (radial + response.radial)),
        };
        self.note_energies(energy_step, dissipated);
        if self.sources.lees_edwards.is_some() {
            // Energy is conserved as seen from one of the two; the other one's image moves faster than it does.
            let faster = (before[0] - before[1]) - pair.velocity;
            let gained = (self.state.bodies[i as usize].velocity - before[0]) / self.inverse_mass(i);
            self.note_supplied(faster.dot(&gained));
        }
        if surface != 0.0 {
            self.note_supplied(impulse * surface * squared.sqrt());
        }
        self.set_state_after(i, j, response.outcome, state, interaction)?;
        Ok(show(observe, || {
            let length = squared.sqrt();
            Event {
                time: self.time(),
                kind: EventKind::Pair(response.outcome),
                particle: self.name(i),
                partner: Some(self.name(j)),
                normal: pair.line / length,
                impulse: impulse * length,
                distance: seen.distance,
                energy_step,
                dissipated,
                positions: [i, j].map(|particle| self.state.bodies[particle as usize].position),
                before,
                after: self.velocities(i, j),
            }
        }))
    }

    /// Gives both their new velocities, from the change of `v_ij` along the line, per length of it, and the factor of what is across; their
    /// predictions are void.
    #[inline]
    fn change_velocities(&mut self, pair: &Encounter, change: f64, tangential_scale: f64) {
        let Encounter { i, j, ref line, ref velocity, ref approach, .. } = *pair;
        self.change_relative_velocity(i, j, &(line * change));
        if tangential_scale != 1.0 {
            let tangential = velocity - line * (approach.radial / approach.squared);
            self.change_relative_velocity(i, j, &(tangential * (tangential_scale - 1.0)));
        }
        self.state.bodies[i as usize].events = self.state.bodies[i as usize].events.wrapping_add(1);
        if self.inverse_mass(j) > 0.0 {
            self.state.bodies[j as usize].events = self.state.bodies[j as usize].events.wrapping_add(1);
        }
    }

    /// Counts an event of a pair for its species.
    #[inline]
    fn count_by_species(&mut self, i: u32, j: u32, response: &Response, seen: &Discontinuity) {
        let kind = match response.outcome {
            Outcome::Core => CountedKind::Core,
            Outcome::Capture => CountedKind::Capture,
            Outcome::Release => CountedKind::Release,
            Outcome::Bounce if seen.energy_step == f64::INFINITY => CountedKind::Bond,
            Outcome::Bounce => CountedKind::Bounce,
        };
        self.counts.totals.core_static +=
            u64::from(kind == CountedKind::Core && (self.is_static(i) || self.is_static(j)));
        let [a, b] = [i, j].map(|particle| usize::from(self.row(particle)));
        self.counts.by_species.note_pair(a, b, kind);
    }

    #[inline]
    fn velocities(&self, i: u32, j: u32) -> [Vector; 2] {
        [i, j].map(|particle| self.state.bodies[particle as usize].velocity)
    }

    /// A pair as it is now, both particles streamed to the same time.
    #[inline]
    fn encounter(&self, i: u32, j: u32, side: Side, surface: f64) -> Encounter {
        let (a, b) = (&self.state.bodies[i as usize], &self.state.bodies[j as usize]);
        let (state, _) = self.nearest(a.position - b.position, a.velocity - b.velocity, a.time);
        let RelativeState { position: apart, velocity } = state;
        let stretch = stretch(apart.norm_squared());
        let mut line = apart * stretch;
        if line.norm_squared() < f64::MIN_POSITIVE {
            line = any_normal(&velocity) * stretch;
        }
        let reduced_mass = 1.0 / (self.inverse_mass(i) + self.inverse_mass(j));
        let squared = line.norm_squared();
        let radial = velocity.dot(&line) - opening(surface, squared);
        Encounter {
            i,
            j,
            side,
            apart,
            line,
            stretch,
            velocity,
            surface,
            approach: Approach { radial, squared, reduced_mass },
        }
    }

    /// Takes note of an overlap or a turning point, of a pair whose states were written so long ago.
    #[inline]
    fn note_state(&mut self, pair: &Encounter, seen: &Discontinuity, flown: [f64; 2]) {
        let sign = pair.side.sign();
        let squared = pair.apart.norm_squared();
        if (squared - seen.squared) * sign < 0.0 {
            let depth = sign * (seen.distance - squared.sqrt());
            self.counts.totals.deepest_overlap = self.counts.totals.deepest_overlap.max(depth / seen.distance);
            if !is_surely_round_off(depth, seen.distance) {
                let &Encounter { i, j, velocity, surface, .. } = pair;
                let meeting = Meeting { pair: [i, j], velocity, flown, distance: seen.distance, surface };
                self.note_overlap(depth, seen.distance, self.round_off_of_pair(&meeting));
            }
        }
        if (pair.velocity.dot(&pair.apart) - opening(pair.surface, squared)) * sign >= 0.0 {
            self.counts.totals.turning_point += 1;
        }
    }

    #[inline]
    fn set_state_after(
        &mut self,
        i: u32,
        j: u32,
        outcome: Outcome,
        state: u16,
        interaction: u16,
    ) -> Result<(), InvariantBroken> {
        if TABLE {
            match outcome {
                Outcome::Capture => self.set_pair_state(i, j, state + 1, interaction),
                Outcome::Release if state > 1 => self.set_pair_state(i, j, state - 1, interaction),
                Outcome::Release => self.release(i, j, interaction)?,
                Outcome::Core | Outcome::Bounce => {}
            }
        }
        Ok(())
    }

    /// Adds `change` to `v_i - v_j`, at constant total momentum.
    ///
    /// The heavier particle takes its share `w / (w_i + w_j)`, and the lighter one what is left of the change: the two add up to all
    /// of it. Two shares that are rounded each for itself do not, always by the same amount, and an elastic contact would have a
    /// restitution of `1 +- eps` in every event.
    #[inline]
    fn change_relative_velocity(&mut self, i: u32, j: u32, change: &Vector) {
        let (wi, wj) = (self.inverse_mass(i), self.inverse_mass(j));
        let less = change * (wi.min(wj) / (wi + wj));
        let more = change - less;
        let (of_i, of_j) = if wi < wj { (less, more) } else { (more, less) };
        self.state.bodies[i as usize].velocity += of_i;
        self.state.bodies[j as usize].velocity -= of_j;
    }

    /// Rounds a reflection outwards: the pair must leave the discontinuity in the numbers that detection will see.
    ///
    /// A change below the spacing of the velocities' floats does nothing, and the same event would be due again for ever.
    /// Changes of one such spacing, doubled until they count, change the energy by round-off only. At relative rest a pair
    /// outside of its core stays where it is, but one at the end of its bond must come inside.
    fn separate(&mut self, pair: &Encounter) {
        let &Encounter { i, j, side, ref apart, ref line, surface, ref approach, .. } = pair;
        let opening = opening(surface, apart.norm_squared());
        let closing = |engine: &Self| {
            let between = engine.state.bodies[i as usize].position - engine.state.bodies[j as usize].position;
            let velocity = engine.state.bodies[i as usize].velocity - engine.state.bodies[j as usize].velocity;
            let velocity = if engine.sources.lees_edwards.is_some() {
                engine.nearest(between, velocity, engine.state.bodies[i as usize].time).0.velocity
            } else {
                velocity
            };
            match side {
                Side::Positive => velocity.dot(apart) < opening,
                Side::Negative => velocity.dot(apart) >= opening,
            }
        };
        if !closing(self) {
            return;
        }
        let speed = self.state.bodies[i as usize].velocity.amax().max(self.state.bodies[j as usize].velocity.amax());
        let mut change = side.sign() * f64::EPSILON * speed;
        let normal = line / approach.squared.sqrt();
        // 52 doublings take a float's spacing to the float itself.
        for _ in 0..52 {
            self.change_relative_velocity(i, j, &(normal * change));
            if !closing(self) {
                return;
            }
            change *= 2.0;
        }
    }

    /// The state of a pair that the user names.
    pub(in crate::engine) fn state_of_pair(&self, a: ParticleId, b: ParticleId) -> u16 {
        self.pair_state(self.number(a), self.number(b)).0
    }

    /// State and interaction of a pair: as the moving one of them keeps it, or that of an uncaptured pair.
    pub(in crate::engine) fn pair_state(&self, i: u32, j: u32) -> (u16, u16) {
        if !TABLE {
            return (0, 0);
        }
        let (keeper, other) = if self.is_static(i) { (j, i) } else { (i, j) };
        self.pairs.states.get(keeper, other).map_or_else(
            || (0, self.pairs.rules.meeting(self.row(i), self.row(j)).interaction),
            |captured| (captured.state, captured.interaction),
        )
    }

    /// The discontinuity that a pair is at, its restitution, and how fast it moves outwards; none if its state has none on that side, for
    /// which no prediction is ever made.
    #[inline]
    fn discontinuity(&self, state: u16, interaction: u16, side: Side, time: f64) -> Option<(Discontinuity, f64, f64)> {
        let interaction = if TABLE { interaction } else { self.pairs.rules.meeting(0, 0).interaction };
        let steps = &self.pairs.rules.steps[usize::from(interaction)];
        let mut seen = steps.seen_from(state, side)?;
        let surface = self.growth_of(seen.distance);
        if self.sources.growth.is_some() {
            seen.distance *= self.scale_at(time);
            seen.squared = seen.distance * seen.distance;
        }
        Some((seen, steps.restitution, surface))
    }

    /// A pair in state 0 again: uncaptured, unless a bond of its own keeps its interaction.
    fn release(&mut self, i: u32, j: u32, interaction: u16) -> Result<(), InvariantBroken> {
        let meeting = self.pairs.rules.meeting(self.row(i), self.row(j));
        if meeting.exists && meeting.interaction == interaction {
            return self.remove_pair_state(i, j);
        }
        self.set_pair_state(i, j, 0, interaction);
        Ok(())
    }

    #[inline]
    pub(in crate::engine) fn inverse_mass(&self, particle: u32) -> f64 {
        let species = self.row(particle);
        self.pairs.rules.species[usize::from(species)].inverse_mass
    }
}

/// `r . u` of a discontinuity that moves outwards at the speed `u`.
#[inline]
fn opening(surface: f64, squared: f64) -> f64 {
    if surface == 0.0 { 0.0 } else { surface * squared.sqrt() }
}

/// A direction for two particles at the same point: the one in which they approach.
fn any_normal(velocity: &Vector) -> Vector {
    velocity.try_normalize(0.0).map_or(Vector::x(), |direction| -direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_has_a_squared_length_next_to_a_power_of_two() {
        for diameter in [1.0, 4.0 / 3.0, 2.0 / 3.0, 8.0 / 3.0, 0.7, 1e-3, 1e9, 1.5, std::f64::consts::SQRT_2] {
            let contact: f64 = diameter * diameter;
            for ulps in -40..=40_i64 {
                let squared = f64::from_bits(contact.to_bits().wrapping_add_signed(ulps));
                let stretch = stretch(squared);
                let digits = (stretch * stretch * squared).to_bits() & DIGITS;
                assert!(digits > 1000 && digits < DIGITS - 1000, "{diameter} {ulps}");
            }
        }
        assert_eq!((stretch(1.0), stretch((4.0_f64 / 3.0).powi(2))), (0.75, 1.0));
    }
}
