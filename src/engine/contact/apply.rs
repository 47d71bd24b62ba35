//! Writes the velocities after a contact, and adds torques to spins. `impulse` is only recorded. [`super`] names the few
//! other functions that write velocities.

use crate::Vector;
use crate::engine::event::{CountedKind, Event, EventKind, Other, Outcome};
use crate::engine::observe::{Observe, show};
use crate::engine::parts::Engine;
use crate::engine::surfaces::Surface;
use std::ops::ControlFlow;

/// The partner of a particle in a momentum exchange.
#[derive(Debug, Clone, Copy)]
pub(in crate::engine) enum With {
    /// Another particle, which gets the opposite impulse.
    Particle(u32),
    Surface(u32),
    Bath,
    /// A restraint of a distance to an umbrella window.
    Restraint,
    Inlet(u32),
    /// A program that sets or scales velocities, or inserts and removes particles.
    Program,
}

#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Change {
    /// The kind of the counted event; `None` if the change is not an event.
    pub counted: Option<CountedKind>,
    pub particle: u32,
    pub other: With,
    /// Velocities of the particle and its partner after the change `[length / time]`.
    pub after: [Vector; 2],
    /// Momentum that the particle gains `[mass length / time]`.
    pub impulse: Vector,
    /// Angular momenta that the particle and its partner gain about their centres `[mass length^2 / time]`.
    pub torques: [Vector; 2],
    /// Vector along the line of contact towards the particle, and its squared length.
    pub line: Vector,
    pub squared: f64,
    /// Distance of the discontinuity `[length]`.
    pub distance: f64,
    /// Virial `r_ij . J` of the impulse `J` `[energy time]`.
    pub virial: f64,
    /// Potential energy that the pair gains `[energy]`.
    pub energy_step: f64,
    /// Kinetic energy lost to restitution `[energy]`; negative if the TC model lifts a particle at rest.
    pub dissipated: f64,
    /// Whether the TC model lifted a particle at rest. The energy counts as supplied.
    pub is_lifted: bool,
    /// Energy supplied from outside the system, except by the TC model `[energy]`.
    pub supplied: f64,
}

impl Change {
    /// Creates a velocity change of one particle. All energy that the particle gains is supplied.
    #[inline]
    pub fn of_one(other: With, particle: u32, before: &Vector, after: Vector, inverse_mass: f64) -> Self {
        let gained = after - before;
        Self {
            counted: None,
            particle,
            other,
            after: [after, Vector::zeros()],
            impulse: gained / inverse_mass,
            torques: [Vector::zeros(); 2],
            line: gained,
            squared: gained.norm_squared(),
            distance: 0.0,
            virial: 0.0,
            energy_step: 0.0,
            dissipated: 0.0,
            is_lifted: false,
            supplied: 0.5 / inverse_mass * gained.dot(&(after + before)),
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline(always)]
    pub(in crate::engine) fn apply(&mut self, change: &Change, observe: &mut Observe<'_>) -> ControlFlow<()> {
        let before = self.change_velocities(change);
        self.account(change, &before);
        match change.counted {
            Some(kind) => show(observe, || self.event(*change, kind, before)),
            None => ControlFlow::Continue(()),
        }
    }

    #[inline(always)]
    fn change_velocities(&mut self, change: &Change) -> [Vector; 2] {
        let [of_particle, of_partner] = change.after;
        if !self.state.spins.is_empty() {
            self.change_spins(change.particle, change.other, change.torques);
        }
        let before = self.change_velocity(change.particle, of_particle);
        match change.other {
            With::Particle(partner) if self.is_static(partner) => [before, Vector::zeros()],
            With::Particle(partner) => [before, self.change_velocity(partner, of_partner)],
            _ => [before, Vector::zeros()],
        }
    }

    /// Writes the velocity of one particle, voids its prediction, and returns the previous velocity.
    #[inline]
    fn change_velocity(&mut self, particle: u32, after: Vector) -> Vector {
        let body = &mut self.state.bodies[particle as usize];
        body.version = body.version.wrapping_add(1);
        std::mem::replace(&mut body.velocity, after)
    }

    #[inline(never)]
    fn change_spins(&mut self, particle: u32, other: With, torques: [Vector; 2]) {
        let partner = if let With::Particle(partner) = other { Some(partner) } else { None };
        let partner = partner.filter(|partner| !self.is_static(*partner));
        for (particle, torque) in [Some(particle), partner].into_iter().flatten().zip(torques) {
            let inverse_inertia = self.inverse_inertia(particle);
            self.state.spins[particle as usize] += torque * inverse_inertia;
        }
    }

    /// The argument `change` is passed by value, so that it is written to memory only for observers.
    #[cold]
    #[inline(never)]
    fn event(&self, change: Change, kind: CountedKind, before: [Vector; 2]) -> Event {
        let position = |particle: u32| self.state.bodies[particle as usize].position;
        let first = position(change.particle);
        let (other, positions, after) = match change.other {
            With::Particle(partner) => (Other::Particle(self.id(partner)), [first, position(partner)], change.after),
            With::Surface(index) => {
                let named = self.sources.surfaces.get(index).map(|placed| (placed.number, placed.feature));
                let (surface, feature) = named.unwrap_or_default();
                (Other::Surface { surface, feature }, [first, Vector::zeros()], change.after)
            }
            With::Inlet(inlet) => {
                let species = self.pairs.rules.rows.species()[usize::from(self.row(change.particle))];
                (Other::Inlet { inlet, species }, [first, Vector::zeros()], change.after)
            }
            With::Bath | With::Restraint | With::Program => (Other::Bath, [first, Vector::zeros()], change.after),
        };
        let outcome = match kind {
            CountedKind::Core => EventKind::Pair(Outcome::Core),
            CountedKind::Capture => EventKind::Pair(Outcome::Capture),
            CountedKind::Release => EventKind::Pair(Outcome::Release),
            CountedKind::Bounce | CountedKind::Bond => EventKind::Pair(Outcome::Bounce),
            CountedKind::Wall => EventKind::Surface,
            CountedKind::Thermostat => EventKind::Thermostat,
            CountedKind::Exit => EventKind::Exit,
            CountedKind::Entry => EventKind::Entry,
            CountedKind::Rest => EventKind::Rest,
            CountedKind::Wake => EventKind::Wake,
        };
        let length = change.squared.sqrt();
        Event {
            time: self.time(),
            kind: outcome,
            particle: self.id(change.particle),
            other,
            normal: if length > 0.0 { change.line / length } else { Vector::zeros() },
            impulse: change.impulse,
            torques: change.torques,
            distance: change.distance,
            energy_step: if matches!(change.other, With::Particle(_)) { change.energy_step } else { change.supplied },
            dissipated: change.dissipated,
            positions,
            before,
            after,
        }
    }

    #[inline(always)]
    fn account(&mut self, change: &Change, before: &[Vector; 2]) {
        let particle = change.particle;
        if let Some(kind) = change.counted {
            self.counts.totals.count(kind);
            if TABLE {
                let row = usize::from(self.row(particle));
                match change.other {
                    With::Particle(partner) => {
                        self.counts.totals.core_static += u64::from(
                            kind == CountedKind::Core && (self.is_static(particle) || self.is_static(partner)),
                        );
                        self.counts.by_species.note_pair(row, usize::from(self.row(partner)), kind);
                    }
                    _ => self.counts.by_species.note_single(row, kind),
                }
            }
        }
        if change.virial != 0.0 {
            self.counts.totals.virial.add(change.virial);
        }
        let (dissipated, lifting) = if change.is_lifted { (0.0, -change.dissipated) } else { (change.dissipated, 0.0) };
        self.note_energies(change.energy_step, dissipated, change.supplied + lifting);
        if self.sources.is_watched {
            self.note_change(*change, *before);
        }
    }

    /// Adds a change to the sums for the pressure between walls, and passes it to the restraint.
    #[cold]
    #[inline(never)]
    fn note_change(&mut self, change: Change, before: [Vector; 2]) {
        self.watch_restraint(&change);
        let (partner, is_internal) = match change.other {
            With::Particle(partner) => (Some(partner), true),
            With::Restraint => (None, true),
            With::Surface(_) | With::Bath | With::Inlet(_) | With::Program => (None, false),
        };
        self.note_confined([Some(change.particle), partner], is_internal, &before);
        if let With::Surface(surface) = change.other {
            self.note_wall(&change, surface);
        }
    }

    fn note_wall(&mut self, change: &Change, surface: u32) {
        let side = self.sources.surfaces.get(surface).and_then(|placed| placed.shape.side());
        let Some((axis, is_upper)) = side else { return };
        self.note_push(change.particle, usize::from(axis), is_upper, change.impulse.dot(&change.line));
        let gained = change.supplied - change.dissipated;
        if gained != 0.0 {
            self.counts.totals.wall_heat[usize::from(axis)][usize::from(is_upper)].add(gained);
        }
    }
}
