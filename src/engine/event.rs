//! Events that have happened, and event counts.

mod counts;

pub use counts::{CountedKind, EventCountsBySpecies};

use crate::Vector;
use crate::base::exact::ExactSum;
use crate::model::{ParticleId, SpeciesId};
use serde::{Deserialize, Serialize};

pub use crate::physics::response::Outcome;

/// Kind of a physical event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum EventKind {
    /// A contact of two particles at a discontinuity of their potential.
    Pair(Outcome),
    /// A contact of a particle with a surface, such as a wall of the box.
    Surface,
    /// A thermostat gives a particle a new velocity. This is not counted as a physical event.
    Thermostat,
    /// A particle leaves the system at an outlet.
    Exit,
    /// A particle enters the system at an inlet. This is not counted as a physical event.
    Entry,
    /// A particle at rest falls asleep. This is not counted as a physical event.
    Rest,
    /// A sleeping particle wakes up. This is not counted as a physical event.
    Wake,
}

/// What the particle of an event interacts with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Other {
    /// Another particle.
    Particle(ParticleId),
    /// A surface.
    Surface {
        /// Index of the surface: 0 to 5 for the walls -x, +x, -y, +y, -z, +z of the box; from 6 on for the
        /// surfaces of the scene.
        surface: u32,
        /// Index of the touched face, edge or corner of the surface; 0 if the surface is a single face.
        feature: u32,
    },
    /// A heat bath. When a particle falls asleep or wakes, this is the other side, too.
    Bath,
    /// An inlet.
    Inlet {
        /// Index of the inlet in the scene.
        inlet: u32,
        /// Species of the particle that enters.
        species: SpeciesId,
    },
}

/// An event that has happened: a contact, a new velocity from a thermostat, an entry or an exit. A particle that falls
/// asleep or wakes is an event, too.
///
/// The velocity is zero before an entry and after an exit. The impulse is the momentum that the particle brings, or
/// minus the momentum that it takes away.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Event {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// The particle to which the event happened.
    pub particle: ParticleId,
    /// The other particle, the surface, the heat bath or the inlet.
    pub other: Other,
    /// Unit vector towards the particle from the other particle or surface. For a heat bath, the direction of the
    /// impulse.
    pub normal: Vector,
    /// Momentum that the particle gained `[mass length / time]`. A partner gains the opposite momentum.
    pub impulse: Vector,
    /// Angular momenta that the particle and the other particle gained about their centres `[mass length^2 / time]`.
    /// Zero for smooth contacts.
    pub torques: [Vector; 2],
    /// Distance of the discontinuity that the pair reached `[length]`. For a surface, the distance of the particle's
    /// centre from the surface. For an entry, the diameter of the particle. 0 for a heat bath.
    pub distance: f64,
    /// Potential energy that a pair gained, or energy that a surface or heat bath supplied `[energy]`.
    pub energy_step: f64,
    /// Kinetic energy dissipated in an inelastic contact; negative if the TC model lifts a particle at rest `[energy]`.
    pub dissipated: f64,
    /// Positions of the particle and of the other particle `[length]`. Along periodic axes, they are inside the box
    /// within round-off. Without another particle, the second position is zero.
    pub positions: [Vector; 2],
    /// Velocities of the particle and of the other particle before the event `[length / time]`.
    pub before: [Vector; 2],
    /// Velocities of the particle and of the other particle after the event `[length / time]`.
    pub after: [Vector; 2],
}

impl Event {
    /// The other particle of a pair event; `None` for other events.
    #[inline]
    #[must_use]
    pub fn partner(&self) -> Option<ParticleId> {
        match self.other {
            Other::Particle(partner) => Some(partner),
            Other::Surface { .. } | Other::Bath | Other::Inlet { .. } => None,
        }
    }

    /// Returns the axis (0, 1 or 2) of a wall of the box, and whether it is the upper wall; `None` for other events.
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

    /// Returns the code of the event in files: 0 core, 1 capture, 2 release, 3 bounce, 4 to 9 the
    /// walls -x, +x, -y, +y, -z, +z, 10 thermostat, 11 another surface, 12 exit, 13 entry, 14 rest, 15 wake.
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
            (EventKind::Exit, _) => 12,
            (EventKind::Entry, _) => 13,
            (EventKind::Rest, _) => 14,
            (EventKind::Wake, _) => 15,
        }
    }
}

/// Event counts: the number of events of each kind since the start, and sums for the pressure and the audit.
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
    /// Contacts with walls of the box and with other surfaces.
    pub wall: u64,
    /// Transitions: particles that left their cell, or the skin of their Verlet list. They are not physical events.
    pub transition: u64,
    /// Physical events at a turning point, without a normal velocity towards the discontinuity.
    pub turning_point: u64,
    /// Physical events of overlapping particles, if the overlap was deeper than the round-off of the positions.
    pub in_invalid_state: u64,
    /// Contacts to which the TC model was applied: all contacts at infinite barriers, if the scene uses the model.
    pub tc_contacts: u64,
    /// Contacts in which the TC model changed the speed or the roughness.
    pub tc_altered: u64,
    /// Altered contacts that did not follow a recent contact, did not slide and were not lifted. The pair keeps
    /// speed in order to stay apart for a contact time.
    pub tc_kept: u64,
    /// Altered contacts that slid along the barrier.
    pub tc_slid: u64,
    /// Contacts of particles at rest to which the TC model supplied energy.
    pub tc_lifted: u64,
    /// Contacts in which the energy lost to friction went into the normal motion.
    pub tc_returned: u64,
    /// Deepest overlap at any event, as a fraction of the distance of the discontinuity.
    pub deepest_overlap: f64,
    /// Collisional virial: the sum of `r_ij . J` over pair events, with the separation `r_ij` and the impulse `J`
    /// `[energy time]`.
    pub virial: ExactSum,
    /// Along each axis between two walls, the sum of `x_i J_i` over the particles of all pair events
    /// `[energy time / length^D]`. `x_i` is the position relative to the middle of the box, and `J_i` the impulse. Each
    /// term is divided by the volume that is accessible to the centre of the particle.
    pub confined_virial: [ExactSum; 3],
    /// Along each axis between two walls, a sum over all changes of `m_i v_i^2` at events `[energy time / length^D]`.
    /// Each change is multiplied by the time of its event, and divided by the volume that is accessible to the centre
    /// of the particle. The integral of `sum m v^2` up to a time `t` is `t sum m v^2` minus this sum.
    pub confined_heating: [ExactSum; 3],
    /// For each axis, the inward momentum that particles received from the lower and from the upper wall
    /// `[energy time / length^D]`. It is divided by the wall area that is accessible to the centre of the particle; 0
    /// if the area is infinite.
    pub wall_push: [[ExactSum; 2]; 3],
    /// For each axis, the net energy that particles received from the lower and from the upper wall `[energy]`.
    pub wall_heat: [[ExactSum; 2]; 3],
    /// Kinetic energy dissipated in inelastic contacts `[energy]`.
    pub dissipated: ExactSum,
    /// Sum of all dissipated energies, each multiplied by the time of its event since the start of the simulation
    /// `[energy time]`. The integral of `dissipated` up to a time `t` is `t dissipated` minus this sum.
    pub dissipated_moment: ExactSum,
    /// Thermostat events; each event gives one particle a new velocity.
    pub thermostat: u64,
    /// Particles that have left at outlets.
    pub exit: u64,
    /// Particles that have entered at inlets.
    pub entry: u64,
    /// How many times a particle at rest fell asleep.
    pub rest: u64,
    /// How many times a sleeping particle woke up.
    pub wake: u64,
    /// Energy supplied from outside `[energy]`, for example by thermostats, moving surfaces, growth or shear.
    pub supplied: ExactSum,
    /// As [`Self::dissipated_moment`], for supplied energies `[energy time]`.
    pub supplied_moment: ExactSum,
    /// As [`Self::dissipated_moment`], for changes of the potential energy of pairs `[energy time]`.
    pub pair_energy_moment: ExactSum,
}

impl EventCounts {
    /// Number of physical events: Core, Capture, Release, Bounce, contacts with walls and other surfaces, and exits.
    #[must_use]
    pub fn physical(&self) -> u64 {
        self.core + self.capture + self.release + self.bounce + self.wall + self.exit
    }

    /// Returns how many times a moving particle took part in a Core event.
    #[must_use]
    pub fn core_contacts(&self) -> u64 {
        2 * self.core - self.core_static
    }

    /// Returns the counts and sums since `earlier`, with the deepest overlap of the whole run.
    pub(crate) fn since(&self, earlier: &Self) -> Self {
        let [mut since, mut before] = [*self, *earlier];
        for (count, before) in since.counts_mut().into_iter().zip(before.counts_mut()) {
            *count -= *before;
        }
        for (sum, before) in since.sums_mut().into_iter().zip(before.sums_mut()) {
            sum.subtract(before);
        }
        since
    }

    /// Adds counts and sums, and keeps the larger of the deepest overlaps.
    pub(crate) fn merge(&mut self, part: &Self) {
        let mut some = *part;
        for (count, more) in self.counts_mut().into_iter().zip(some.counts_mut()) {
            *count = count.wrapping_add(*more);
        }
        self.deepest_overlap = self.deepest_overlap.max(part.deepest_overlap);
        for (sum, more) in self.sums_mut().into_iter().zip(some.sums_mut()) {
            sum.merge(more);
        }
    }

    fn counts_mut(&mut self) -> [&mut u64; 20] {
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
            &mut self.tc_kept,
            &mut self.tc_slid,
            &mut self.tc_lifted,
            &mut self.tc_returned,
            &mut self.thermostat,
            &mut self.exit,
            &mut self.entry,
            &mut self.rest,
            &mut self.wake,
        ]
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
            CountedKind::Exit => self.exit += 1,
            CountedKind::Entry => self.entry += 1,
            CountedKind::Rest => self.rest += 1,
            CountedKind::Wake => self.wake += 1,
        }
    }
}
