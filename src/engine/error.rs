//! Reasons why a simulation cannot continue.

use crate::model::{ParticleId, Scene};
use serde::{Deserialize, Serialize};
use std::fmt;
use thiserror::Error;

/// The reason why a simulation cannot continue.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The model needs infinitely many events in a finite time.
    #[error(transparent)]
    Arrest(#[from] Arrest),
    /// The state is impossible, because of a defect of the program or of the machine.
    #[error(transparent)]
    InvariantBroken(#[from] InvariantBroken),
}

impl EngineError {
    /// Returns the dynamical arrest; `None` for other errors.
    #[must_use]
    pub fn arrest(&self) -> Option<Arrest> {
        match self {
            Self::Arrest(arrest) => Some(*arrest),
            Self::InvariantBroken(_) => None,
        }
    }
}

/// Kind of a dynamical arrest.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Standstill {
    /// Time does not advance. Particles rest in contact, or infinitely many contacts happen in a finite time.
    Time {
        /// Number of events without an advance of time.
        events: u64,
    },
    /// An event storm: far more events happen within one contact time of the TC model than permanent contacts would
    /// cause. Spheres at rest in contact bounce elastically, with almost no relative velocity.
    Storm {
        /// Number of events in the storm.
        events: u64,
        /// Simulated time that passed during these events `[time]`.
        advance: f64,
    },
    /// An inelastic collapse of moving particles: the relative speed falls below the round-off of the velocities.
    Speed {
        /// Normal speed of approach at the last contact `[length / time]`.
        approach: f64,
    },
}

impl fmt::Display for Standstill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time { events } => write!(f, "{events} events without any advance of time, the last event between"),
            Self::Storm { events, advance } => {
                write!(f, "{events} events while time advances by {advance:.1e}, the last event between")
            }
            Self::Speed { approach } => {
                write!(f, "inelastic collapse, with an approach speed of {approach:.1e}, below round-off, between")
            }
        }
    }
}

/// A dynamical arrest: without a change of the model, the simulation would need infinitely many events to continue.
#[doc(alias = "DynamicalArrest")]
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "dynamical arrest at time {time}: {standstill} particle {} and {}{}",
    particle.0,
    match (partner, surface) {
        (Some(id), _) => format!("particle {}", id.0),
        (None, Some(number)) => nameless(*number),
        (None, None) => "a wall".to_owned(),
    },
    moving.filter(|number| *surface != Some(*number)).map_or_else(String::new, |number| format!(", while {} moves", nameless(number)))
)]
#[non_exhaustive]
pub struct Arrest {
    /// A particle that takes part in the arrest.
    pub particle: ParticleId,
    /// The other particle of the pair; `None` for a contact with a wall or another surface.
    pub partner: Option<ParticleId>,
    /// Index of the touched surface in the scene; `None` for a contact with a wall of the box or a particle.
    pub surface: Option<u32>,
    /// Index of the first surface that moves at the time of the arrest. It may leave the particles no room.
    pub moving: Option<u32>,
    /// Whether any contact in the scene dissipates energy.
    pub has_losses: bool,
    /// Simulated time of the arrest.
    pub time: f64,
    /// Kind of standstill.
    pub standstill: Standstill,
    /// Whether the scene uses the TC model.
    pub has_contact_time: bool,
}

fn nameless(number: u32) -> String {
    format!("surface {number} of the scene")
}

impl Arrest {
    /// Returns the error message, with the names of surfaces.
    #[must_use]
    pub fn told(&self, scene: &Scene) -> String {
        [self.surface, self.moving].into_iter().flatten().fold(self.to_string(), |text, number| {
            let surface = scene.surfaces.get(number as usize);
            surface.map_or(text.clone(), |it| text.replace(&nameless(number), &format!("surface `{}`", it.name)))
        })
    }

    /// Returns advice for the user on how to avoid the arrest.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match (self.has_contact_time, self.standstill) {
            // With losses and without a contact time, a collapse is possible without the moving surface, so the advice
            // does not mention it.
            (has_contact_time, Standstill::Time { .. } | Standstill::Speed { .. })
                if self.moving.is_some() && (has_contact_time || !self.has_losses) =>
            {
                "a moving surface leaves the particles no room: end its motion earlier, or give them more room"
            }
            (false, _) if !self.has_losses => {
                "start without particles that rest in contact or overlap: move them slightly apart, or give them a velocity"
            }
            (false, Standstill::Speed { .. }) => {
                "set dynamics.contact_time (the TC model) to make frequent contacts elastic, or raise the restitution to 1"
            }
            (false, Standstill::Time { .. }) => {
                "set dynamics.contact_time (the TC model) to make frequent contacts elastic, raise the restitution to 1, or start \
                 without particles that rest in contact or overlap"
            }
            (true, _) | (_, Standstill::Storm { .. }) => {
                "give the particles more room, or set a longer dynamics.contact_time: at these distances, they collide \
                 far more often than once per contact time"
            }
        }
    }
}

/// The state of the engine is impossible, because of a defect of the program or of the machine.
///
/// The run ends, because all later events would be meaningless. Every attempt to continue returns the same error.
#[doc(alias = "corrupted state")]
#[derive(Debug, Clone, Copy, PartialEq, Error, Serialize, Deserialize)]
#[error(
    "impossible state of particle {}{} at time {time}: expected {expected}",
    particle.0,
    partner.map_or(String::new(), |id| format!(" and particle {}", id.0))
)]
#[non_exhaustive]
pub struct InvariantBroken {
    /// The particle whose event or cell transition was to be executed.
    pub particle: ParticleId,
    /// The other particle, if the event is a pair event.
    pub partner: Option<ParticleId>,
    /// Simulated time at which the error was detected.
    pub time: f64,
    /// The invariant that does not hold.
    pub expected: Invariant,
}

impl InvariantBroken {
    /// Advice for the user.
    pub const CURE: &'static str = "this is a bug in Carom: please report the scene and the command; if the error does \
        not recur, check the memory of the machine";
}

/// An invariant that must hold in every state of the engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Invariant {
    /// A pair event is at a discontinuity that exists in the current state of the pair.
    Discontinuity,
    /// A captured pair is in the lists of both of its particles.
    CapturedPair,
    /// The surface of a predicted contact exists.
    Surface,
    /// Random numbers are available for a contact with a thermal surface.
    SurfaceRandom,
    /// A cell transition goes through a face that has a cell on its other side.
    Transition,
    /// If a particle leaves the skin of a Verlet list, the engine uses Verlet lists.
    VerletList,
    /// In a sheared box, the engine uses cells, not Verlet lists.
    Cells,
    /// The source of a global event exists. For a collision with a heat bath, this is the heat bath.
    GlobalEvent,
}

impl fmt::Display for Invariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Discontinuity => "a discontinuity that exists in the state of the pair",
            Self::CapturedPair => "a captured pair in the lists of both particles",
            Self::Surface => "a surface with this number",
            Self::SurfaceRandom => "random numbers of a thermal surface",
            Self::Transition => "a cell on the other side of the face",
            Self::VerletList => "a neighbour list of the particle",
            Self::Cells => "a cell of the particle",
            Self::GlobalEvent => "a source of the global event",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::engine::event::Event;
    use crate::engine::neighbours::grid::CellFace;
    use crate::engine::parts::Engine;
    use crate::engine::prediction::{Contact, Prediction};
    use crate::engine::{Reason, Until};
    use crate::model::ContactLaw;
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Face, Space};
    use crate::physics::overlap::Side;
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};
    use std::ops::ControlFlow;

    #[test]
    fn invariant_error_names_particles_and_time() {
        let broken = InvariantBroken {
            particle: ParticleId(3),
            partner: Some(ParticleId(7)),
            time: 1.5,
            expected: Invariant::Discontinuity,
        };
        let text = "impossible state of particle 3 and particle 7 at time 1.5: expected a discontinuity that exists in the state of the pair";
        assert_eq!(EngineError::from(broken).to_string(), text);
        let of_one = InvariantBroken { partner: None, expected: Invariant::Surface, ..broken };
        assert_eq!(
            of_one.to_string(),
            "impossible state of particle 3 at time 1.5: expected a surface with this number"
        );
    }

    /// Square wells, or hard spheres without a `range`, in a wide box with a wall at the lower end of x. Particle 40
    /// hits particle 41, and particle 42 flies away.
    fn wells<const TABLE: bool>(range: Option<f64>) -> Engine<false, TABLE> {
        let wall = Face::Wall(ContactLaw::smooth(1.0));
        let x = Boundary::Bounded { lower: wall, upper: Face::Open };
        let space = Space { boundary: [x, Boundary::Periodic, Boundary::Periodic], ..Space::periodic_cube(60.0) };
        let potential =
            range.map_or_else(|| Potential::hard_sphere(1.0), |range| Potential::square_well(1.0, range, 1.0));
        let at = |x: f64, y: f64| Vector::new(x, y, 30.0);
        let mut scene = SceneBuilder::new("wells")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(potential.unwrap()).between("A", "A"));
        // With these additional particles, the system is large enough for cells.
        for k in 0..40 {
            scene = scene.particle("A", Vector::new(3.0 + f64::from(k), 50.0, 50.0), Vector::zeros());
        }
        let scene = scene
            .particle("A", at(10.0, 10.0), Vector::new(1.0, 0.0, 0.0))
            .particle("A", at(13.0, 10.0), Vector::zeros())
            .particle("A", at(50.0, 30.0), Vector::new(2.0, 0.0, 0.0));
        Engine::new(&scene.build().unwrap())
    }

    fn end<const TABLE: bool>(
        mut engine: Engine<false, TABLE>,
        id: u32,
        change: impl Fn(&mut Prediction),
    ) -> (Result<Reason, EngineError>, usize) {
        let particle = engine.number(ParticleId(id));
        change(&mut engine.schedule.predictions[particle as usize]);
        engine.enqueue(particle);
        let mut shown = 0;
        let mut run = || {
            let mut show = |_: &Event| {
                shown += 1;
                ControlFlow::Continue(())
            };
            engine.advance(Until::time(4.0), &mut Some(&mut show))
        };
        let first = run();
        if first.is_err() {
            assert_eq!(run(), first, "it stays broken");
        }
        (first, shown)
    }

    fn broken(end: &Result<Reason, EngineError>) -> (u32, Option<u32>, Invariant) {
        let Err(EngineError::InvariantBroken(broken)) = end else { panic!("{end:?}") };
        (broken.particle.0, broken.partner.map(|id| id.0), broken.expected)
    }

    #[test]
    fn the_state_before_it_is_corrupted_is_sound() {
        assert_eq!(end(wells::<false>(None), 40, |_| {}), (Ok(Reason::Time), 1));
        assert_eq!(end(wells::<true>(Some(1.5)), 40, |_| {}), (Ok(Reason::Time), 3));
    }

    #[test]
    fn a_pair_at_a_discontinuity_that_it_does_not_have_ends_the_run() {
        let outwards = |prediction: &mut Prediction| {
            assert!(prediction.contact_time < 4.0);
            prediction.contact = Contact::Pair(Side::Negative);
        };
        let expected = (40, Some(41), Invariant::Discontinuity);
        for (found, shown) in [end(wells::<false>(None), 40, outwards), end(wells::<true>(Some(1.5)), 40, outwards)] {
            assert_eq!((broken(&found), shown), (expected, 0));
        }
    }

    #[test]
    fn a_contact_with_a_wall_that_is_not_there_ends_the_run() {
        let (found, shown) = end(wells::<false>(None), 42, |prediction| {
            prediction.reach(2, 1.0, 42);
            prediction.transition_time = f64::INFINITY;
        });
        assert_eq!((broken(&found), shown), ((42, None, Invariant::Surface), 0));
    }

    #[test]
    fn a_cell_transition_out_of_an_open_end_ends_the_run() {
        let (found, shown) = end(wells::<false>(None), 42, |prediction| {
            (prediction.transition_time, prediction.exit) = (0.5, CellFace { axis: 0, is_upper: true });
        });
        assert_eq!((broken(&found), shown), ((42, None, Invariant::Transition), 0));
    }

    #[test]
    fn a_pair_that_only_one_of_two_has_captured_ends_the_run() {
        let mut engine = wells::<true>(Some(1.5));
        engine.advance(Until::events(1), &mut None).unwrap();
        let [a, b] = [40, 41].map(|id| engine.number(ParticleId(id)));
        assert!(engine.pairs.states.remove(b, a));
        let (found, shown) = end(engine, 40, |_| {});
        let (.., expected) = broken(&found);
        assert_eq!((expected, shown), (Invariant::CapturedPair, 1), "the core, and not the release");
    }
}
