//! Redraws or scales velocities during a run.

use std::convert::Infallible;

use super::{Cloud, draw, mass, settle};
use crate::Vector;
use crate::analysis::observables::ApplicableObservables;
use crate::engine::Simulation;
use crate::model::random::{Purpose, Random};
use crate::model::{Particle, Thermostat, ThermostatError};

impl Simulation {
    /// Draws Maxwell velocities for all moving particles, and scales them to the kinetic temperature `temperature`
    /// `[energy]`. The net momentum is zero along axes where momentum is conserved. In a sheared box, velocities are
    /// relative to the streaming velocity.
    ///
    /// The velocities differ from the initial velocities of a scene with the same `seed`. The change of energy is
    /// counted as supplied energy, as in [`Self::set_velocities`].
    ///
    /// # Errors
    /// [`ThermostatError::Number`] for a temperature that is not positive, and [`ThermostatError::NothingMoves`]. An
    /// error leaves the simulation unchanged.
    #[doc(alias = "velocity create")]
    pub fn thermalize(&mut self, temperature: f64, seed: u64) -> Result<(), ThermostatError> {
        // This thermostat only checks the temperature and that a particle can move.
        let bath = Thermostat::Andersen { temperature, rate: 1.0, axes: [true; 3] };
        bath.settled(self.scene().space(), self.moving(), false)?;
        let mut particles = Vec::new();
        let Ok(()) = self.for_each_now(|now| {
            let diameter = now.diameter;
            particles.push(Particle { diameter, ..Particle::new(now.species, now.position, Vector::zeros()) });
            Ok::<(), Infallible>(())
        });
        let scene = self.scene();
        let conserved = scene.conserved_axes_with(self.thermostat().as_ref());
        let cloud = Cloud { temperature, conserved, dimensions: scene.space.dimensions() };
        let mut random = Random::new(seed, Purpose::Thermalizing, 0);
        draw(&mut particles, &scene.species, &scene.space, temperature, &mut random);
        let all = 0..particles.len();
        settle(&mut particles, &[all], &scene.species, &cloud);
        let streaming =
            |particle: &Particle| match mass(particle, (&scene.species, scene.space.dimensions())).is_finite() {
                true => scene.streaming_velocity(&particle.position),
                false => Vector::zeros(),
            };
        let velocities: Vec<Vector> = particles.iter().map(|it| it.velocity + streaming(it)).collect();
        // This cannot fail, because static particles and flat axes have zero velocity.
        let set = self.set_velocities(&velocities);
        debug_assert_eq!(set, Ok(()));
        Ok(())
    }

    /// Scales all velocities once to a temperature `[energy]`. [`Thermostat::Rescaling`] repeats this during a run.
    ///
    /// # Errors
    /// [`ThermostatError::Number`] for a temperature that is not positive, and [`ThermostatError::NoTemperature`] if
    /// fewer than two particles can move, if particles are accelerated, or if all are at rest. An error leaves the
    /// simulation unchanged.
    pub fn rescale(&mut self, temperature: f64) -> Result<(), ThermostatError> {
        let applicable = ApplicableObservables::of_simulation(self);
        let is_accelerated = !applicable.has_temperature;
        Thermostat::Rescaling { temperature, interval: 1.0 }.settled(
            self.scene().space(),
            applicable.moving,
            is_accelerated,
        )?;
        let scaling = applicable.scaling(&self.energy(), temperature);
        let (factor, drift) = scaling.ok_or(ThermostatError::NoTemperature)?;
        self.scale_velocities(factor, &drift);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    #[test]
    fn thermalized_velocities_are_exact_and_independent_of_the_start() {
        let scene = SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2))
            .temperature(1.0)
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let velocities = |simulation: &Simulation| simulation.snapshot().velocities;
        let start = velocities(&simulation);
        for (temperature, error) in [
            (-1.0, ThermostatError::Number { name: "temperature", value: -1.0 }),
            (0.0, ThermostatError::Number { name: "temperature", value: 0.0 }),
        ] {
            assert_eq!(simulation.thermalize(temperature, 1), Err(error));
            assert_eq!(simulation.rescale(temperature), Err(error));
            assert_eq!(velocities(&simulation), start);
        }
        simulation.thermalize(2.0, simulation.scene().seed()).unwrap();
        let first = velocities(&simulation);
        assert!((simulation.energy().kinetic - 3.0 * 107.0).abs() < 1e-9 && simulation.energy().momentum.norm() < 1e-9);
        let alike: f64 = first.iter().zip(&start).map(|(a, b)| a.dot(b)).sum();
        assert!(
            alike.abs() < 0.2 * 3.0 * 108.0 * 2.0_f64.sqrt() / 1.3,
            "the new velocities differ from the start velocities, although the seed is the same"
        );
        simulation.thermalize(2.0, 2).unwrap();
        assert_ne!(velocities(&simulation), first);
        simulation.rescale(0.5).unwrap();
        assert!((simulation.energy().kinetic - 0.75 * 107.0).abs() < 1e-9);
        simulation.set_velocities(&[Vector::zeros(); 108]).unwrap();
        assert_eq!(simulation.rescale(1.0), Err(ThermostatError::NoTemperature));
    }
}
