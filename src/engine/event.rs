//! Predictions of future events, and events that have happened.

mod counts;

pub use counts::{CountedKind, EventCountsBySpecies};

use crate::Vector;
use crate::base::exact::ExactSum;
use crate::model::ParticleId;
use serde::{Deserialize, Serialize};

pub use crate::physics::response::Outcome;

/// Kind of a physical event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum EventKind {
    /// Two particles at a discontinuity of their potential.
    Pair(Outcome),
    /// A particle at a surface, such as a wall of the box.
    Surface,
    /// A thermostat gives a particle a new velocity. The velocity comes from outside, and the event is not
    /// counted as a physical event.
    Thermostat,
}

/// The other party of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Other {
    /// Another particle.
    Particle(ParticleId),
    /// A surface.
    Surface {
        /// Index of the surface: 0 to 5 for the walls -x, +x, -y, +y, -z, +z of the box.
        surface: u32,
        /// Index of the face, edge or corner that is touched; 0 if there is only one face.
        feature: u32,
    },
    /// A heat bath.
    Bath,
}

/// A physical event that has happened.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Event {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// The particle of the event.
    pub particle: ParticleId,
    /// The other particle, the surface or the bath.
    pub other: Other,
    /// Unit vector from the partner (or the surface) to the particle. For a bath, it is along the impulse.
    pub normal: Vector,
    /// The momentum that the particle gained `[mass length / time]`; a partner gained the opposite.
    pub impulse: Vector,
    /// The angular momentum about its centre that the particle gained `[mass length^2 / time]`. It is zero,
    /// because all contacts are smooth.
    pub torque: Vector,
    /// Distance of the discontinuity `[length]`. For a surface, the distance of the particle's centre from
    /// it.
    pub distance: f64,
    /// Potential energy gained `[energy]`.
    pub energy_step: f64,
    /// Kinetic energy lost to restitution `[energy]`.
    pub dissipated: f64,
    /// Positions of the particle and its partner `[length]`, inside the box along periodic axes, within
    /// round-off; zero without a partner.
    pub positions: [Vector; 2],
    /// Velocities of the particle and its partner before the event `[length / time]`.
    pub before: [Vector; 2],
    /// Velocities of the particle and its partner after the event `[length / time]`.
    pub after: [Vector; 2],
}

impl Event {
    /// The other particle of a pair.
    #[inline]
    #[must_use]
    pub fn partner(&self) -> Option<ParticleId> {
        match self.other {
            Other::Particle(partner) => Some(partner),
            Other::Surface { .. } | Other::Bath => None,
        }
    }

    /// Returns the wall of the box at which the event happened: its axis (0, 1 or 2), and whether it is the
    /// upper wall.
    #[must_use]
    pub fn wall(&self) -> Option<(u8, bool)> {
        match self.other {
            Other::Surface { surface: number @ 0..6, .. } => Some(((number / 2).to_le_bytes()[0], number % 2 == 1)),
            _ => None,
        }
    }

    /// The momentum that the particle gained along [`Self::normal`] `[mass length / time]`.
    #[inline]
    #[must_use]
    pub fn normal_impulse(&self) -> f64 {
        self.impulse.dot(&self.normal)
    }

    /// Returns the number of the kind of event in files: 0 core, 1 capture, 2 release, 3 bounce, 4 to 9 the
    /// walls -x, +x, -y, +y, -z, +z, 10 thermostat, 11 another surface.
    #[must_use]
    pub fn code(&self) -> u8 {
        match (self.kind, self.wall()) {
            (EventKind::Pair(Outcome::Core), _) => 0,
            (EventKind::Pair(Outcome::Capture), _) => 1,
            (EventKind::Pair(Outcome::Release), _) => 2,
            (EventKind::Pair(Outcome::Bounce), _) => 3,
            (EventKind::Surface, Some((axis, is_upper))) => 4 + 2 * axis + u8::from(is_upper),
            (EventKind::Thermostat, _) => 10,
            (EventKind::Surface, None) => 11,
        }
    }
}

/// Event counts: how often each kind of event has happened since the start, and the sums that pressure and
/// the audit need.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EventCounts {
    /// Core events.
    pub core: u64,
    /// Core events with a static partner.
    pub core_static: u64,
    /// Capture events.
    pub capture: u64,
    /// Release events.
    pub release: u64,
    /// Bounce events.
    pub bounce: u64,
    /// Contacts with walls.
    pub wall: u64,
    /// Transitions: particles that left their cell, or the skin of their Verlet list. They are not physical
    /// events, but part of the cost of the neighbour search.
    pub transition: u64,
    /// Physical events at which the overlap function had a turning point: there was no relative normal
    /// velocity that an impulse could reverse.
    pub turning_point: u64,
    /// Physical events executed in an invalid state, deeper than the round-off of the positions.
    pub in_invalid_state: u64,
    /// Contacts that the TC model examined. These are all contacts at infinite barriers while the model is
    /// on.
    pub tc_contacts: u64,
    /// Contacts that the TC model made less dissipative.
    pub tc_altered: u64,
    /// Deepest overlap at any event, relative to the distance of its discontinuity.
    pub deepest_overlap: f64,
    /// Sum of `r_ij . J` over pair events, the collisional virial `[energy]`.
    pub virial: ExactSum,
    /// Along each axis between two walls, the sum of `x_i J_i` over the particles of all pair events. `x` is
    /// measured from the middle of the box. Each term is divided by the volume that the centres of the
    /// particle's species can reach `[energy / length^D]`.
    pub confined_virial: [ExactSum; 3],
    /// Along each axis between two walls, the sum of all changes of `m_i v_i^2` at events
    /// `[energy time / length^D]`. Each change is multiplied by its time and divided by the same volume. The
    /// integral of `sum m v^2` up to a time `t` is `t sum m v^2` minus this sum.
    pub confined_heating: [ExactSum; 3],
    /// For each axis, the inward momentum from its lower and its upper wall, divided by the wall area that
    /// centres of the particle's species can reach `[energy time / length^D]`; 0 if that area is infinite.
    pub wall_push: [[ExactSum; 2]; 3],
    /// For each axis, the net energy supplied by its lower and its upper wall `[energy]`: energy given minus
    /// energy taken.
    pub wall_heat: [[ExactSum; 2]; 3],
    /// Kinetic energy lost to restitution `[energy]`.
    pub dissipated: ExactSum,
    /// Sum of all dissipated energies, each multiplied by its time since the start of the simulation
    /// `[energy time]`. The integral of `dissipated` up to a time `t` is `t dissipated` minus this sum.
    pub dissipated_moment: ExactSum,
    /// Number of velocities that a thermostat has given.
    pub thermostat: u64,
    /// Energy from outside: from thermostats, growing diameters and sheared boxes `[energy]`.
    pub supplied: ExactSum,
    /// Sum of all supplied energies, each multiplied by its time since the start, as in
    /// [`Self::dissipated_moment`] `[energy time]`.
    pub supplied_moment: ExactSum,
    /// Sum of all changes of the potential energy of pairs, each multiplied by its time since the start
    /// `[energy time]`.
    pub pair_energy_moment: ExactSum,
}

impl EventCounts {
    /// Number of physical events: Core, Capture, Release, Bounce and wall.
    #[must_use]
    pub fn physical(&self) -> u64 {
        self.core + self.capture + self.release + self.bounce + self.wall
    }

    /// Returns the number of times that a moving particle took part in a Core event: two in each event, or
    /// one if the partner is static.
    #[must_use]
    pub fn core_contacts(&self) -> u64 {
        2 * self.core - self.core_static
    }

    /// Returns the difference between these event counts and `earlier` event counts. The deepest overlap
    /// still refers to the whole run.
    pub(crate) fn since(&self, earlier: &Self) -> Self {
        let mut since = *self;
        let mut before = *earlier;
        for (count, before) in since.counts_mut().into_iter().zip(before.counts_mut()) {
            *count -= *before;
        }
        for (sum, before) in since.sums_mut().into_iter().zip(earlier.sums()) {
            sum.subtract(before);
        }
        since
    }

    /// Adds the counts of a part of the system. The deepest overlap is the maximum.
    pub(crate) fn merge(&mut self, part: &Self) {
        let mut some = *part;
        for (count, more) in self.counts_mut().into_iter().zip(some.counts_mut()) {
            *count = count.wrapping_add(*more);
        }
        self.deepest_overlap = self.deepest_overlap.max(part.deepest_overlap);
        for (sum, more) in self.sums_mut().into_iter().zip(part.sums()) {
            sum.merge(more);
        }
    }

    /// Returns all event numbers.
    fn counts_mut(&mut self) -> [&mut u64; 12] {
        [
            &mut self.core,
            &mut self.core_static,
            &mut self.capture,
            &mut self.release,
            &mut self.bounce,
            &mut self.wall,
            &mut self.transition,
            &mut self.turning_point,
            &mut self.in_invalid_state,
            &mut self.tc_contacts,
            &mut self.tc_altered,
            &mut self.thermostat,
        ]
    }

    /// All sums.
    fn sums(&self) -> Vec<&ExactSum> {
        let Self {
            virial,
            confined_virial,
            confined_heating,
            wall_push,
            wall_heat,
            dissipated,
            dissipated_moment,
            supplied,
            supplied_moment,
            pair_energy_moment,
            ..
        } = self;
        let scalars = [virial, dissipated, dissipated_moment, supplied, supplied_moment, pair_energy_moment];
        let of_axes = confined_virial.iter().chain(confined_heating);
        let of_walls = wall_push.iter().chain(wall_heat).flatten();
        scalars.into_iter().chain(of_axes).chain(of_walls).collect()
    }

    fn sums_mut(&mut self) -> Vec<&mut ExactSum> {
        let Self {
            virial,
            confined_virial,
            confined_heating,
            wall_push,
            wall_heat,
            dissipated,
            dissipated_moment,
            supplied,
            supplied_moment,
            pair_energy_moment,
            ..
        } = self;
        let scalars = [virial, dissipated, dissipated_moment, supplied, supplied_moment, pair_energy_moment];
        let of_axes = confined_virial.iter_mut().chain(confined_heating);
        let of_walls = wall_push.iter_mut().chain(wall_heat).flatten();
        scalars.into_iter().chain(of_axes).chain(of_walls).collect()
    }

    #[inline]
    pub(super) fn count(&mut self, kind: CountedKind) {
        match kind {
            CountedKind::Core => self.core += 1,
            CountedKind::Capture => self.capture += 1,
            CountedKind::Release => self.release += 1,
            CountedKind::Bounce | CountedKind::Bond => self.bounce += 1,
            CountedKind::Wall => self.wall += 1,
            CountedKind::Thermostat => self.thermostat += 1,
        }
    }
}
