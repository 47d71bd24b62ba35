//! Restrains the distance `|R_A - R_B|` between the centres of mass of two groups to an umbrella window. The distance
//! is reflected at the ends of the window. A group may be a single particle.
//!
//! Between events of the members, the vector `R_A - R_B` changes at a constant rate. The time of a reflection therefore
//! follows from the equations for a pair. In a reflection, all members of a group change their velocities by the same
//! amount, because the force on particle `i` of group `A` is the fraction `m_i / M_A` of the force on the centre.
//! Momentum and energy are conserved, and motion within a group is unchanged.

use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

use super::Repredict;
use crate::Vector;
use crate::engine::contact::apply::{Change, With};
use crate::engine::contact::frame::stretch;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::{Chosen, EngineError, Invariant, Simulation};
use crate::model::components::Component;
use crate::model::{Bond, ParticleId};
use crate::physics::detection::inertial::next_event;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::{Quadratic, Side};
use crate::physics::response::{Approach, ContactLaw, respond};

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Member {
    id: ParticleId,
    /// Mass of the particle divided by the mass of the group.
    share: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Group {
    members: Vec<Member>,
    /// Connections between the members, along which positions are unwrapped.
    along: Component,
    inverse_mass: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Restraint {
    groups: [Group; 2],
    group_of: Vec<(ParticleId, usize)>,
    /// Lower and upper end of the window `[length]`. Without a restraint, they are 0 and infinity.
    window: [f64; 2],
    /// Time of the next reflection since the epoch, or infinity.
    next: f64,
    /// [`Side::Positive`] if the next reflection is at the lower end of the window.
    side: Side,
}

impl Restraint {
    #[inline]
    pub fn next_reflection(&self) -> f64 {
        self.next
    }

    pub fn shift(&mut self, shift: f64) {
        self.next -= shift;
    }

    fn members(&self) -> impl Iterator<Item = &Member> {
        self.groups.iter().flat_map(|group| &group.members)
    }

    fn group(&self, id: ParticleId) -> Option<usize> {
        let place = self.group_of.binary_search_by_key(&id, |of| of.0).ok()?;
        Some(self.group_of[place].1)
    }

    /// Returns the time until the distance reaches an end of the window, and the valid side of this end.
    fn next_end(&self, apart: &RelativeState) -> Option<(f64, Side)> {
        let [lower, upper] = self.window;
        let at = |distance: f64, side| {
            let after = next_event(&Quadratic::new(apart, distance * distance), side)?;
            Some((after, side))
        };
        let inner = if lower > 0.0 { at(lower, Side::Positive) } else { None };
        let outer = if upper < f64::INFINITY { at(upper, Side::Negative) } else { None };
        match (inner, outer) {
            (Some(inner), Some(outer)) if outer.0 < inner.0 => Some(outer),
            (inner, outer) => inner.or(outer),
        }
    }
}

impl Simulation {
    /// Keeps the distance between the centres of mass of two groups within a window `[length]`, by reflection at the
    /// ends. `[0, infinity]` removes the restraint.
    ///
    /// All particles of the groups must be mobile and have equal accelerations. In a periodic box, the upper end must
    /// be below half a period, and bonds must hold each group together.
    pub(crate) fn restrain_distance(&mut self, between: &[Vec<ParticleId>; 2], window: [f64; 2]) {
        let holds = |bond: &&Bond| self.scene.interactions[bond.interaction.0 as usize].potential.is_bond();
        let groups = between.each_ref().map(|group| {
            let bonds = self.scene.bonds.iter().filter(holds).map(|bond| bond.pair);
            (&group[..], Component::of_group(group, bonds).unwrap_or_else(|| Component::side_by_side(group.len())))
        });
        with_engine!(&mut self.engine, engine => engine.restrain(groups, window));
    }

    pub(crate) fn set_distance_window(&mut self, window: [f64; 2]) {
        with_engine!(&mut self.engine, engine => {
            engine.join();
            if let Some(restraint) = &mut engine.sources.restraint {
                restraint.window = window;
            }
            engine.predict_restraint();
        });
    }

    pub(crate) fn distance_window(&self) -> Option<[f64; 2]> {
        with_engine!(&self.engine, engine => engine.sources.restraint.as_ref().map(|restraint| restraint.window))
    }

    pub(crate) fn restrained_distance(&self) -> Option<f64> {
        with_engine!(&self.engine, engine => engine.restrained_distance())
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn restrain(&mut self, groups: [(&[ParticleId], Component); 2], window: [f64; 2]) {
        self.join();
        let ids = [(groups[0].0, 0), (groups[1].0, 1)];
        let mut group_of: Vec<(ParticleId, usize)> =
            ids.into_iter().flat_map(|(ids, number)| ids.iter().map(move |id| (*id, number))).collect();
        let groups = groups.map(|(ids, along)| {
            let mass = |id: &ParticleId| self.inverse_mass(self.number(*id)).recip();
            let all: f64 = ids.iter().map(mass).sum();
            let member = |id: &ParticleId| Member { id: *id, share: mass(id) / all };
            Group { members: ids.iter().map(member).collect(), along, inverse_mass: all.recip() }
        });
        group_of.sort_unstable();
        let restraint = Restraint { groups, group_of, window, next: f64::INFINITY, side: Side::Positive };
        self.sources.restraint = Some(Box::new(restraint));
        self.sources.is_watched = true;
        self.predict_restraint();
    }

    pub(in crate::engine) fn predict_restraint(&mut self) {
        let Some(restraint) = &self.sources.restraint else { return };
        let now = self.clock.now;
        let found = restraint.next_end(&self.centres_apart(restraint));
        if let Some(restraint) = &mut self.sources.restraint {
            (restraint.next, restraint.side) =
                found.map_or((f64::INFINITY, Side::Positive), |(after, side)| (now + after, side));
        }
        self.schedule_global();
    }

    pub(in crate::engine) fn watch_restraint(&mut self, change: &Change) {
        let Some(restraint) = &self.sources.restraint else { return };
        let partner = match change.other {
            With::Particle(partner) => Some(partner),
            With::Restraint => return,
            _ => None,
        };
        let group = |particle: u32| restraint.group(self.id(particle));
        let groups = (group(change.particle), partner.map(group));
        // Events between two members of a group do not change the motion of the centre.
        let is_changed = match groups {
            (None, None | Some(None)) => false,
            (one, other) => other != Some(one),
        };
        if is_changed {
            self.predict_restraint();
        }
    }

    fn restrained_distance(&self) -> Option<f64> {
        let restraint = self.sources.restraint.as_ref()?;
        Some(self.centres_apart(restraint).position.norm())
    }

    fn centres_apart(&self, restraint: &Restraint) -> RelativeState {
        let [a, b] = restraint.groups.each_ref().map(|group| self.centre(group));
        self.nearest(a.position - b.position, a.velocity - b.velocity, self.clock.now).0
    }

    fn centre(&self, group: &Group) -> RelativeState {
        let now = self.clock.now;
        let state = |member: &Member| self.state_at(self.number(member.id), now);
        let (positions, velocities): (Vec<Vector>, Vec<Vector>) = group.members.iter().map(state).unzip();
        let path = group.along.path(&positions, |apart| self.nearest(apart, Vector::zeros(), now).0.position);
        let share = |place: &u32| group.members[*place as usize].share;
        let from_first: Vector = group.along.ids.iter().zip(path).map(|(place, step)| step * share(place)).sum();
        let first = group.along.ids.first().map_or_else(Vector::zeros, |place| positions[*place as usize]);
        let velocity = group.members.iter().zip(velocities).map(|(member, velocity)| velocity * member.share).sum();
        RelativeState { position: first + from_first, velocity }
    }

    pub(in crate::engine) fn reflect_distance(
        &mut self,
        observe: &mut Observe<'_>,
    ) -> Result<(Repredict, ControlFlow<()>), EngineError> {
        let Some(restraint) = self.sources.restraint.take() else {
            return Err(self.broken(0, None, Invariant::GlobalEvent).into());
        };
        self.clock.now = restraint.next.max(self.clock.now);
        let members: Vec<u32> = restraint.members().map(|member| self.number(member.id)).collect();
        members.iter().for_each(|&particle| self.stream(particle, self.clock.now));
        let apart = self.centres_apart(&restraint);
        let mut flow = ControlFlow::Continue(());
        for change in &self.reflection(&restraint, &apart) {
            if self.apply(change, observe).is_break() {
                flow = ControlFlow::Break(());
            }
        }
        self.sources.restraint = Some(restraint);
        self.predict_restraint();
        self.count_standstill();
        self.check_time_stands_still(members[0], members.last().copied())?;
        Ok((Repredict::Some(members), flow))
    }

    fn reflection(&self, restraint: &Restraint, apart: &RelativeState) -> Vec<Change> {
        let [of_a, of_b] = restraint.groups.each_ref().map(|group| group.inverse_mass);
        let stretch = stretch(apart.position.norm_squared());
        let line = apart.position * stretch;
        let (radial, squared) = (apart.velocity.dot(&line), line.norm_squared());
        let approach = Approach { radial, squared, reduced_mass: (of_a + of_b).recip() };
        let response = respond(restraint.side, f64::INFINITY, &approach, &ContactLaw::smooth(1.0));
        let change = if squared > 0.0 { line * ((response.radial - radial) / squared) } else { Vector::zeros() };
        let [of_a, of_b] = self.separated(restraint, apart, shares(&change, [of_a, of_b]));
        let virial = approach.reduced_mass * (response.radial - radial) / stretch;
        let mut changes = Vec::new();
        for (group, gained) in restraint.groups.iter().zip([of_a, -of_b]) {
            for member in &group.members {
                let particle = self.number(member.id);
                let after = self.state.bodies[particle as usize].velocity + gained;
                let before = &self.state.bodies[particle as usize].velocity;
                let of_one = Change::of_one(With::Restraint, particle, before, after, self.inverse_mass(particle));
                let virial = if changes.is_empty() { virial } else { 0.0 };
                changes.push(Change { virial, supplied: 0.0, ..of_one });
            }
        }
        changes
    }

    /// Returns changes of the group velocities after which the distance moves away from the end of the window. If
    /// round-off prevents this, the changes are increased until the distance moves away.
    fn separated(&self, restraint: &Restraint, apart: &RelativeState, mut changes: [Vector; 2]) -> [Vector; 2] {
        let velocities = |group: &Group| -> Vec<(f64, Vector)> {
            let of = |member: &Member| (member.share, self.state.bodies[self.number(member.id) as usize].velocity);
            group.members.iter().map(of).collect()
        };
        let before = restraint.groups.each_ref().map(velocities);
        let of_centre = |of: &[(f64, Vector)], gained: Vector| {
            of.iter().fold(Vector::zeros(), |sum: Vector, (share, velocity)| sum + (velocity + gained) * *share)
        };
        let is_closing = |[a, b]: [Vector; 2]| {
            let velocity = of_centre(&before[0], a) - of_centre(&before[1], -b);
            match restraint.side {
                Side::Positive => velocity.dot(&apart.position) < 0.0,
                Side::Negative => velocity.dot(&apart.position) >= 0.0,
            }
        };
        let fastest = before.iter().flatten().fold(0.0, |most: f64, (_, velocity)| most.max(velocity.amax()));
        let Some(normal) = apart.position.try_normalize(0.0).filter(|_| is_closing(changes)) else { return changes };
        let inverse_masses = restraint.groups.each_ref().map(|group| group.inverse_mass);
        let mut change = restraint.side.sign() * f64::EPSILON * fastest;
        // The first change has the size of round-off. After 52 doublings, it would be as large as the largest velocity.
        for _ in 0..52 {
            let [a, b] = shares(&(normal * change), inverse_masses);
            changes = [changes[0] + a, changes[1] + b];
            if !is_closing(changes) {
                break;
            }
            change *= 2.0;
        }
        changes
    }
}

/// Splits a change of the relative velocity between two groups, in proportion to their inverse masses. The caller adds
/// the first part to the first velocity, and subtracts the second part from the second velocity. The sum of the parts
/// has little round-off.
fn shares(change: &Vector, [of_a, of_b]: [f64; 2]) -> [Vector; 2] {
    let less = change * (of_a.min(of_b) / (of_a + of_b));
    let more = change - less;
    if of_a < of_b { [less, more] } else { [more, less] }
}

#[cfg(test)]
mod tests;
