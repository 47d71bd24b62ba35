//! External drive of a simulation: thermostats and scaled velocities.

use super::sources::andersen::{Andersen, Bath};
use super::{Chosen, InvariantBroken, Simulation};
use crate::Vector;
use crate::engine::audit::{MOST_ROUND_OFF, unit_of_surface};
use crate::engine::contact::apply::{Change, With};
use crate::engine::pairs::rules::Rules;
use crate::engine::parts::Engine;
use crate::engine::surfaces::Surface;
use crate::model::state_point::StatePoint;
use crate::model::{ParticleId, Scene, Thermostat, ThermostatError};

impl Simulation {
    /// Replaces the heat bath; `None` removes it. The heat baths of different stages use different random numbers.
    ///
    /// The heat bath does not act along flat axes.
    ///
    /// # Errors
    /// [`ThermostatError`] if a temperature or rate is not positive, if no axes or only flat axes are given, or if no
    /// particle moves. [`ThermostatError::Rescaling`] for [`Thermostat::Rescaling`], which is not a heat bath: call
    /// [`Self::scale_velocities`] instead. After an error, the simulation is unchanged.
    pub fn set_thermostat(&mut self, thermostat: Option<&Thermostat>, stage: usize) -> Result<(), ThermostatError> {
        if let Some(thermostat) = thermostat {
            if matches!(thermostat, Thermostat::Rescaling { .. }) {
                return Err(ThermostatError::Rescaling);
            }
            let moving = self.moving() + self.scene.inlets.len();
            thermostat.settled(&self.scene.space, moving, self.choice.is_falling)?;
        }
        self.set_planned_thermostat(thermostat, self.stream_seed(), stage);
        Ok(())
    }

    /// Sets the heat bath of a validated thermostat. `None` and velocity rescaling remove the heat bath.
    ///
    /// `seed` is the value of [`Self::stream_seed`] at the beginning of the stage.
    pub(crate) fn set_planned_thermostat(&mut self, thermostat: Option<&Thermostat>, seed: u64, stage: usize) {
        let bath = thermostat.and_then(|thermostat| match *thermostat {
            Thermostat::Andersen { temperature, rate, axes } => Some(Bath { temperature, rate, axes }),
            Thermostat::Rescaling { .. } => None,
        });
        with_engine!(&mut self.engine, engine => engine.set_bath(bath, seed, stage));
    }

    /// Returns the seed of the random numbers of heat baths and volume moves. It depends on the seed of the scene and
    /// on the state point, so that different state points have independent random numbers.
    pub(crate) fn stream_seed(&self) -> u64 {
        StatePoint::of(&self.scene, &self.population()).seed(self.scene.seed)
    }

    /// Adds and removes surfaces at the start of a stage. Returns true if the surfaces have changed.
    pub(crate) fn set_stage_of_surfaces(&mut self, stage: &str) -> bool {
        with_engine!(&mut self.engine, engine => engine.set_stage_of_surfaces(stage))
    }

    /// Returns the particle that overlaps most with a surface of the scene, the name of the surface, and the depth of
    /// the overlap `[length]`. Overlaps within round-off are ignored.
    pub(crate) fn deepest_in_surface(&self) -> Option<(ParticleId, String, f64)> {
        with_engine!(&self.engine, engine => engine.deepest_in_surface())
    }

    /// Returns, for each surface of the scene, whether it exists in the current stage. The list is empty if all
    /// surfaces always exist.
    #[must_use]
    pub fn surfaces_present(&self) -> Vec<bool> {
        with_engine!(&self.engine, engine => engine.sources.surfaces.presence())
    }

    /// Sets the acceleration of all moving species. The change of the potential energy counts as supplied energy.
    pub(crate) fn set_gravity(&mut self, gravity: &Vector) {
        let mut moving = self.scene.species.iter_mut().filter(|species| !species.is_static()).peekable();
        if moving.peek().is_some_and(|species| species.acceleration != *gravity) {
            moving.for_each(|species| species.acceleration = *gravity);
            let scene = &self.scene;
            with_engine!(&mut self.engine, engine => engine.set_accelerations(scene));
        }
    }

    /// Whether a heat bath gives particles new velocities.
    #[must_use]
    pub fn has_andersen(&self) -> bool {
        self.thermostat().is_some()
    }

    /// The current heat bath, as a thermostat without flat axes; `None` if there is no heat bath.
    #[must_use]
    pub fn thermostat(&self) -> Option<Thermostat> {
        let bath = with_engine!(&self.engine, engine => engine.sources.andersen.as_ref().map(Andersen::bath));
        bath.map(|Bath { temperature, rate, axes }| Thermostat::Andersen { temperature, rate, axes })
    }

    /// Multiplies all velocities, relative to `drift` and to the streaming velocity of a sheared box, by a factor.
    /// The energy gained counts as supplied energy.
    pub fn scale_velocities(&mut self, factor: f64, drift: &Vector) {
        with_engine!(&mut self.engine, engine => engine.scale_velocities(factor, drift));
    }

    pub(crate) fn broken(&self) -> Option<InvariantBroken> {
        with_engine!(&self.engine, engine => engine.broken)
    }

    pub(crate) fn is_growing(&self) -> bool {
        with_engine!(&self.engine, engine => !engine.distances.are_constant())
    }

    /// The factor by which diameters have grown since the start of the simulation, including growth in progress.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale * with_engine!(&self.engine, engine => engine.scale())
    }

    /// The factor by which diameters have grown, without growth in progress.
    pub(crate) fn grown(&self) -> f64 {
        self.scale
    }

    /// Returns the diameters of the species at the start `[length]`, without the factor [`Self::scale`].
    pub(crate) fn first_diameters(&self) -> &[f64] {
        &self.first_diameters
    }

    /// Time since the start of the simulation `[time]`, without the start time of the scene.
    pub(crate) fn elapsed(&self) -> f64 {
        with_engine!(&self.engine, engine => engine.elapsed())
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub(super) fn scale_velocities(&mut self, factor: f64, drift: &Vector) {
        self.join();
        self.wake_all();
        for particle in self.particles().filter(|&p| !self.is_static(p)).collect::<Vec<_>>() {
            self.stream(particle, self.clock.now);
            let body = self.state.bodies[particle as usize];
            let streaming = self.streaming_velocity(&body.position) + drift;
            self.give_velocity(particle, streaming + (body.velocity - streaming) * factor);
        }
        self.start_anew();
    }

    fn set_stage_of_surfaces(&mut self, stage: &str) -> bool {
        let Some(surfaces) = self.sources.surfaces.in_stage(stage) else { return false };
        self.join();
        self.wake_all();
        self.sources.surfaces = surfaces;
        self.start_anew();
        true
    }

    fn deepest_in_surface(&self) -> Option<(ParticleId, String, f64)> {
        let surfaces = &self.sources.surfaces;
        let mut deepest: Option<(u32, u32, f64)> = None;
        for particle in self.particles().filter(|&particle| !self.is_static(particle)) {
            let me = self.streamed(particle, self.clock.now);
            let around = (&me.position, self.radius(particle));
            surfaces.for_each_near(around, self.row(particle), self.time(), |placed, position| {
                let rounding = MOST_ROUND_OFF * unit_of_surface(around.1);
                let depth = -placed.shape.gap(position, around.1);
                let is_of_scene = placed.shape.side().is_none();
                if is_of_scene && depth > rounding && deepest.is_none_or(|(.., other)| depth > other) {
                    deepest = Some((particle, placed.number, depth));
                }
            });
        }
        deepest.map(|(particle, number, depth)| (self.id(particle), surfaces.name(number).to_owned(), depth))
    }

    /// Sets the accelerations of `scene`. Everything else in `scene` must be unchanged.
    fn set_accelerations(&mut self, scene: &Scene) {
        self.join();
        self.wake_all();
        for particle in self.particles().filter(|&p| !self.is_static(p)).collect::<Vec<_>>() {
            self.stream(particle, self.clock.now);
        }
        let before = self.energy().potential;
        let rows = self.pairs.rules.rows.clone();
        self.pairs.rules = Rules::with_rows(scene, rows);
        let gained = self.energy().potential - before;
        self.note_energies(0.0, 0.0, gained);
        self.start_anew();
    }

    /// Changes the velocity of a particle from outside the dynamics. The energy gained counts as supplied energy.
    pub(super) fn give_velocity(&mut self, particle: u32, after: Vector) {
        let before = self.state.bodies[particle as usize].velocity;
        let change = Change::of_one(With::Program, particle, &before, after, self.inverse_mass(particle));
        let _ = self.apply(&change, &mut None);
        self.forget_contacts(particle);
    }

    /// Discards all predictions and predicts all particles again.
    pub(super) fn start_anew(&mut self) {
        for body in &mut self.state.bodies {
            body.version = body.version.wrapping_add(1);
        }
        if let Some(sleepers) = &mut self.sources.sleepers {
            sleepers.skip_event();
        }
        self.schedule.queue.clear();
        for particle in self.particles() {
            if !self.is_static(particle) {
                self.repredict(particle, self.clock.now);
            }
        }
        self.predict_restraint();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Until;
    use crate::model::space::{Boundary, Space};
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn disks(are_static: [bool; 2]) -> Simulation {
        let boundary = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
        let mut scene = SceneBuilder::new("disks")
            .space(Space { lower: Vector::zeros(), size: Vector::new(9.0, 9.0, 0.0), boundary })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "B"));
        scene.insert_species(SpeciesDraft::new("B").diameter(1.0).fixed());
        for (is_static, x) in are_static.into_iter().zip([2.0, 6.0]) {
            let name = if is_static { "B" } else { "A" };
            scene.insert_particle(name, Vector::new(x, 3.0, 0.0), Vector::zeros());
        }
        Simulation::without_plan(scene.build().unwrap())
    }

    #[test]
    fn ineffective_thermostat_is_rejected_and_leaves_bath_unchanged() {
        let bath = |temperature, rate, axes| Thermostat::Andersen { temperature, rate, axes };
        let good = bath(1.0, 2.0, [true; 3]);
        let number = |name, value| ThermostatError::Number { name, value };
        let mut simulation = disks([false, true]);
        simulation.set_thermostat(Some(&good), 1).unwrap();
        let mut alone = simulation.clone();
        for (refused, error) in [
            (bath(-1.0, 2.0, [true; 3]), number("temperature", -1.0)),
            (bath(0.0, 2.0, [true; 3]), number("temperature", 0.0)),
            (bath(f64::INFINITY, 2.0, [true; 3]), number("temperature", f64::INFINITY)),
            (bath(1.0, -2.0, [true; 3]), number("rate", -2.0)),
            (bath(1.0, f64::INFINITY, [true; 3]), number("rate", f64::INFINITY)),
            (bath(1.0, 2.0, [false; 3]), ThermostatError::NoAxis),
            (bath(1.0, 2.0, [false, false, true]), ThermostatError::FlatAxes),
            (Thermostat::Rescaling { temperature: 1.0, interval: 1.0 }, ThermostatError::Rescaling),
        ] {
            assert_eq!(simulation.set_thermostat(Some(&refused), 2), Err(error), "{refused:?}");
        }
        assert!(simulation.set_thermostat(Some(&bath(f64::NAN, 2.0, [true; 3])), 2).is_err());
        for simulation in [&mut simulation, &mut alone] {
            simulation.advance(Until::time(20.0)).unwrap();
        }
        assert!(alone.event_counts().thermostat > 20);
        assert_eq!(simulation.snapshot(), alone.snapshot());
        assert_eq!(disks([true; 2]).set_thermostat(Some(&good), 1), Err(ThermostatError::NothingMoves));

        assert_eq!(simulation.thermostat(), Some(bath(1.0, 2.0, [true, true, false])));
        simulation.set_thermostat(None, 3).unwrap();
        assert!(!simulation.has_andersen());
    }
}
