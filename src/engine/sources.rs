//! Event sources, one file for each kind of event.
//!
//! A source owns data, returns the time of its next event, and executes the event. There are two kinds of sources:
//!
//! - Contacts and transitions of a particle: [`pair`], [`surface`], [`cell_transition`] and [`list_rebuild`].
//!   The event loop calls [`Engine::execute`] or [`Engine::execute_transition`].
//! - Global events: collisions with the heat bath ([`andersen`]), entries at an [`inlet`], the search for particles at
//!   [`rest`], the refresh of sliding images ([`super::images`]), new stages of growing diameters
//!   ([`super::distances`]), and reflections of a restrained distance ([`restraint`]). The earliest global event is due
//!   at [`Sources::next_global`].
//!
//! To add a source, add a file here, its data in [`Sources`], and a variant of [`Contact`] or [`GlobalEvent`]. For a global
//! event, also add its time to `global_events`, execute it in `execute_global`, and shift its times in `shift_sources` when
//! an epoch ends.

pub(super) mod andersen;
mod cell_transition;
pub(super) mod inlet;
pub(super) mod list_rebuild;
mod outlet;
pub(super) mod pair;
pub(super) mod rest;
mod restraint;
pub(super) mod surface;

use super::confinement::Confinement;
use super::neighbours::Neighbours;
use super::observe::Observe;
use super::pairs::rows::Rows;
use super::parts::Engine;
use super::prediction::{Contact, Prediction};
use super::state::State;
use super::surfaces::Surfaces;
use super::{EngineError, Invariant, InvariantBroken};
use crate::model::Scene;
use andersen::Andersen;
use inlet::Inlets;
use rest::Sleepers;
use restraint::Restraint;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use surface::SurfaceRandom;

/// Number of predictions that take as long as one step of the event loop.
const PER_STEP: u64 = 16;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Sources {
    pub surfaces: Surfaces,
    pub confinement: Option<Confinement>,
    pub surface_random: Option<SurfaceRandom>,
    pub andersen: Option<Andersen>,
    pub restraint: Option<Box<Restraint>>,
    pub inlets: Option<Box<Inlets>>,
    pub sleepers: Option<Box<Sleepers>>,
    /// Whether all velocity changes are recorded, for the pressure between walls or for a restraint.
    pub is_watched: bool,
    /// Time of the next global event since the epoch, or infinity.
    pub next_global: f64,
}

/// Global events. Simultaneous events are executed in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GlobalEvent {
    AndersenCollision,
    Reflection,
    ImageRefresh,
    DistanceStage,
    Entry,
    Rest,
}

pub(super) enum Repredict {
    /// The event has already predicted the particles that it changed. `steps` is the cost of its other work, in steps
    /// of the event loop.
    Nothing {
        steps: u64,
    },
    One(u32),
    Some(Vec<u32>),
    All,
}

impl Sources {
    pub fn of(scene: &Scene, rows: &Rows, state: &State) -> Self {
        let surfaces = Surfaces::of(scene, rows.species());
        let confinement = Confinement::of(scene, rows);
        Self {
            is_watched: confinement.is_some(),
            confinement,
            surface_random: SurfaceRandom::of(scene, &surfaces),
            surfaces,
            andersen: None,
            restraint: None,
            inlets: Inlets::of(scene).map(Box::new),
            sleepers: Sleepers::of(scene, state).map(Box::new),
            next_global: f64::INFINITY,
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the time of the next event of each global source, since the epoch; infinity if there is none.
    fn global_events(&self) -> [(GlobalEvent, f64); 6] {
        [
            (
                GlobalEvent::AndersenCollision,
                self.sources.andersen.as_ref().map_or(f64::INFINITY, Andersen::next_collision),
            ),
            (
                GlobalEvent::Reflection,
                self.sources.restraint.as_ref().map_or(f64::INFINITY, |restraint| restraint.next_reflection()),
            ),
            (GlobalEvent::ImageRefresh, self.images.next_refresh()),
            (GlobalEvent::DistanceStage, self.distances.next_stage()),
            (GlobalEvent::Entry, self.sources.inlets.as_ref().map_or(f64::INFINITY, |inlets| inlets.next())),
            (GlobalEvent::Rest, self.sources.sleepers.as_ref().map_or(f64::INFINITY, |sleepers| sleepers.next())),
        ]
    }

    pub(super) fn schedule_global(&mut self) {
        let events = self.global_events();
        self.sources.next_global = events.iter().fold(f64::INFINITY, |next, (_, due)| next.min(*due));
    }

    fn due_global(&self) -> Option<GlobalEvent> {
        self.global_events().iter().find(|(_, due)| *due <= self.sources.next_global).map(|(event, _)| *event)
    }

    /// Whether global events may continue for ever.
    pub(super) fn acts_for_ever(&self) -> bool {
        self.sources.andersen.is_some()
            || self.sources.restraint.is_some()
            || self.sources.inlets.as_ref().is_some_and(|inlets| inlets.next() < f64::INFINITY)
            || !self.distances.are_constant()
            || self.images.are_sliding()
            || self.will_wake_some()
    }

    /// Executes the predicted contact of a particle. Returns whether the observer continues. Returns `None` if the
    /// prediction is outdated, or if it only continues a search for contacts with moving surfaces.
    #[inline]
    pub(super) fn execute(
        &mut self,
        particle: u32,
        prediction: &Prediction,
        time: f64,
        observe: &mut Observe<'_>,
    ) -> Result<Option<ControlFlow<()>>, InvariantBroken> {
        match prediction.contact {
            _ if self.is_void(prediction) => Ok(None),
            Contact::Pair(side) => self.execute_pair([particle, prediction.partner], side, time, observe).map(Some),
            Contact::Surface => self.execute_surface(particle, prediction.partner_version, time, observe).map(Some),
        }
    }

    /// Whether a prediction must not be executed. This is the case if the motion of the partner has changed since the
    /// prediction, if the partner is absent, or if the prediction only continues a search for contacts with moving
    /// surfaces.
    #[inline(always)]
    pub(super) fn is_void(&self, prediction: &Prediction) -> bool {
        match prediction.contact {
            Contact::Pair(_) => {
                let partner = self.state.bodies.get(prediction.partner as usize);
                partner.is_none_or(|partner| partner.version != prediction.partner_version)
            }
            Contact::Surface => prediction.is_search(),
        }
    }

    #[inline]
    pub(super) fn execute_transition(&mut self, particle: u32, time: f64) -> Result<(), InvariantBroken> {
        match self.neighbours {
            Neighbours::Cells(_) => self.cross(particle, time),
            Neighbours::Lists(_) => self.rebuild_list(particle, time),
        }
    }

    /// Executes the global event that is due. Returns its cost in steps, and whether the observer continues.
    pub(super) fn execute_global(&mut self, observe: &mut Observe<'_>) -> Result<(u64, ControlFlow<()>), EngineError> {
        let silent = ControlFlow::Continue(());
        let (repredict, flow) = match self.due_global() {
            Some(GlobalEvent::AndersenCollision) => self.andersen_collision(observe)?,
            Some(GlobalEvent::Reflection) => self.reflect_distance(observe)?,
            Some(GlobalEvent::ImageRefresh) => (self.refresh_images()?, silent),
            Some(GlobalEvent::DistanceStage) => (self.begin_distance_stage()?, silent),
            Some(GlobalEvent::Entry) => self.let_in(observe)?,
            Some(GlobalEvent::Rest) => self.look_for_rest(observe)?,
            None => return Err(self.broken(0, None, Invariant::GlobalEvent).into()),
        };
        let mut steps = self.steps_of_all();
        match repredict {
            Repredict::Nothing { steps: others } => steps = others,
            Repredict::One(particle) => {
                self.repredict(particle, self.clock.now);
                steps = 0;
            }
            Repredict::Some(particles) => {
                particles.into_iter().for_each(|particle| self.repredict(particle, self.clock.now))
            }
            Repredict::All => self.start_anew(),
        }
        self.schedule_global();
        Ok((steps, flow))
    }

    pub(super) fn shift_sources(&mut self, shift: f64) {
        if let Some(andersen) = &mut self.sources.andersen {
            andersen.shift(shift);
        }
        if let Some(restraint) = &mut self.sources.restraint {
            restraint.shift(shift);
        }
        if let Some(inlets) = &mut self.sources.inlets {
            inlets.shift(shift);
        }
        if let Some(sleepers) = &mut self.sources.sleepers {
            sleepers.shift(shift);
        }
        self.distances.shift(shift);
        self.shift_images(shift);
        self.schedule_global();
    }

    /// Cost of predicting all particles, in steps of the event loop.
    pub(super) fn steps_of_all(&self) -> u64 {
        self.state.bodies.len() as u64 / PER_STEP
    }
}
