mod walls;

use super::regions::Regions;
use super::volume::{Isobaric, filled};
use crate::Vector;
use crate::engine::event::EventCounts;
use crate::engine::{Energy, Simulation};
use crate::model::potential::Potential;
use crate::model::{Barostat, Scene, Thermostat};
use serde::{Deserialize, Serialize};
use std::convert::Infallible;

/// The observables that are defined for a scene, and the constants in their formulas.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ApplicableObservables {
    /// Number of moving particles.
    pub moving: usize,
    /// Number of axes that are not flat, `D`.
    pub dimensions: f64,
    /// Number of free velocity components: `D N`, minus one for each conserved component of the momentum.
    pub degrees_of_freedom: f64,
    /// Axes along which the total momentum, relative to the streaming velocity, is conserved.
    pub conserved_axes: [bool; 3],
    /// Whether the total momentum is conserved along all axes. False in a sheared box.
    pub conserves_momentum: bool,
    /// Whether a kinetic temperature is defined. It needs at least two moving particles and no acceleration.
    pub has_temperature: bool,
    /// Whether the particles have spins, and so a rotational energy.
    pub has_spins: bool,
    /// Whether events conserve the temperature. A thermostat may scale all velocities.
    pub conserves_temperature: bool,
    /// Whether a virial pressure is defined: for homogeneous or wall-confined fluids without shear.
    pub has_pressure: bool,
    /// Axes with a wall at both ends. All false if no virial pressure is defined.
    pub walled_axes: [bool; 3],
    /// For each axis, whether the pressure on the lower and on the upper wall is defined.
    pub pressed_walls: [[bool; 2]; 3],
    /// Areas of the lower and upper wall of each axis `[length^(D - 1)]`. `None` for infinite and adiabatic walls.
    pub heat_areas: [[Option<f64>; 2]; 3],
    /// The only axis between two walls, if it has no thermostat. The mean pressure on its walls is the virial pressure.
    pub(super) balanced_axis: Option<usize>,
    /// The axis whose two walls supply and remove all energy, if there is exactly one.
    pub(super) heated_axis: Option<usize>,
    /// Whether the fluid is homogeneous: periodic, without gravity and static particles.
    pub is_homogeneous: bool,
    /// Whether particles enter or leave. Quantities per particle are then undefined.
    pub has_flow: bool,
    /// Whether grains fall asleep.
    pub has_sleep: bool,
    /// Whether some pair has a hard core.
    pub has_core: bool,
    /// Whether some pair can have a potential energy.
    pub has_wells: bool,
    /// Number of moving particles per volume `[length^-D]`.
    pub number_density: f64,
    /// Whether a steady state is possible: contacts lose no energy, or the lost energy is replaced.
    pub has_steady_state: bool,
    /// True for equal hard particles on a line. Contacts then only exchange velocities, so averages depend on the
    /// start.
    pub only_exchanges_velocities: bool,
    /// Time between two scalings of all velocities by the thermostat `[time]`.
    pub(crate) scaling_interval: Option<f64>,
    /// Whether particles exchange their species.
    pub(crate) has_swaps: bool,
    pub(super) isobaric: Option<Isobaric>,
    /// Total volume of the particles at the start `[length^D]`.
    filled: f64,
    is_sheared: bool,
    total_mass: f64,
    up: Option<Vector>,
    /// Mass of each species; 0 for static species.
    masses: Vec<f64>,
    periods: Vector,
    regions: Regions,
}

/// Whether a pair can have a potential energy.
fn has_energy(potential: &Potential) -> bool {
    potential.energies().iter().any(|energy| energy.is_finite() && *energy != 0.0)
}

impl ApplicableObservables {
    /// The observables that are defined for this scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let species_of = |index: usize| &scene.species[scene.particles[index].species.0 as usize];
        let all = 0..scene.particles.len();
        let is_moving = |index: usize| !species_of(index).is_static();
        let moving = all.clone().filter(|&index| is_moving(index)).count();
        let mass = |index: usize| if is_moving(index) { scene.mass(&scene.particles[index]) } else { 0.0 };
        let is_accelerated = scene.species.iter().any(|species| species.acceleration != Vector::zeros());
        let has_surfaces = !scene.surfaces.is_empty();
        let has_walls = (0..3).any(|axis| scene.space.walls(axis) > 0);
        let is_alone = !is_accelerated && !has_walls && !has_surfaces && moving == scene.particles.len();
        let has_flow = scene.has_flow();
        let has_temperature = !is_accelerated && moving >= 2 && !has_flow;
        let any = |has: fn(&Potential) -> bool| scene.interactions.iter().any(|i| has(&i.potential));
        let is_homogeneous = has_temperature && is_alone && scene.space.is_fully_periodic();
        let has_static = moving < scene.particles.len();
        let is_reached = |index: usize| scene.space.accessible_volume(scene.diameter(&scene.particles[index])) > 0.0;
        let has_room = all.clone().filter(|&index| is_moving(index)).all(is_reached);
        // Rough walls also exert tangential forces, which the virial of the particles leaves out.
        let has_smooth_walls = has_walls && !has_surfaces && !scene.has_rough_walls();
        let is_confined = has_smooth_walls && scene.space.is_closed() && has_temperature && has_room && !has_static;
        let walled_axes = std::array::from_fn(|axis| is_confined && scene.space.walls(axis) == 2);
        let mut applicable = Self {
            moving,
            dimensions: scene.space.dimensions() as f64,
            degrees_of_freedom: 0.0,
            conserved_axes: [false; 3],
            conserves_momentum: false,
            has_temperature,
            has_spins: (moving > 0 || has_flow) && scene.has_spins(),
            conserves_temperature: false,
            has_pressure: (is_homogeneous || is_confined) && scene.shear_rate.is_none(),
            walled_axes,
            pressed_walls: if moving >= 2 && !has_flow && !has_static && !has_surfaces && has_room {
                walls::pressed(&scene.space)
            } else {
                [[false; 2]; 3]
            },
            heat_areas: if moving > 0 || has_flow { walls::heat_areas(scene) } else { [[None; 2]; 3] },
            balanced_axis: None,
            heated_axis: None,
            is_homogeneous,
            has_flow,
            has_sleep: scene.sleep().is_some(),
            has_core: moving > 0 && !has_flow && any(|potential| potential.core().is_some()),
            has_wells: moving > 0 && !has_flow && any(has_energy),
            number_density: moving as f64 / scene.space.volume(),
            has_steady_state: true,
            only_exchanges_velocities: false,
            scaling_interval: None,
            has_swaps: false,
            isobaric: None,
            filled: filled(scene),
            is_sheared: scene.shear_rate.is_some(),
            total_mass: all.map(mass).sum(),
            up: super::upwards(scene),
            masses: scene.species.iter().map(|it| if it.is_static() { 0.0 } else { it.mass }).collect(),
            periods: scene.space.periods(),
            regions: Regions::of(scene.output.regions.clone()),
        };
        applicable.set_thermostat(scene, scene.run.thermostat.as_ref());
        applicable
    }

    /// The observables that are defined for a simulation with its current heat bath.
    #[must_use]
    pub fn of_simulation(simulation: &Simulation) -> Self {
        let mut applicable = Self::of(simulation.scene());
        applicable.set_thermostat(simulation.scene(), simulation.thermostat().as_ref());
        applicable
    }

    /// Updates the observables at the start of a stage.
    pub(crate) fn set_thermostat(&mut self, scene: &Scene, thermostat: Option<&Thermostat>) {
        self.scaling_interval = match thermostat {
            Some(&Thermostat::Rescaling { interval, .. }) => Some(interval),
            _ => None,
        };
        self.number_density = self.moving as f64 / scene.space.volume();
        self.conserved_axes = scene.conserved_axes_with(thermostat);
        self.has_steady_state = scene.has_steady_state_with(thermostat);
        self.only_exchanges_velocities = scene.only_exchanges_velocities_with(thermostat);
        self.balanced_axis = walls::balanced(&self.walled_axes, thermostat);
        self.heated_axis = walls::heated(&self.heat_areas)
            .filter(|_| thermostat.is_none() && !self.is_sheared && !self.has_flow && scene.has_elastic_pairs());
        self.conserves_temperature = !self.has_wells && scene.conserves_heat_with(thermostat);
        let conserved = self.conserved_axes.iter().filter(|is_conserved| **is_conserved).count();
        self.conserves_momentum = conserved == scene.space.dimensions() && scene.shear_rate.is_none();
        self.degrees_of_freedom = (scene.space.dimensions() * self.moving).saturating_sub(conserved) as f64;
    }

    /// Must be called after [`Self::set_thermostat`].
    pub(crate) fn set_swaps(&mut self, has_swaps: bool) {
        self.has_swaps = has_swaps;
        // A swap move changes the moment `sum m x v / V`, whose time derivative is the difference of the two pressures.
        if has_swaps {
            self.balanced_axis = None;
        }
    }

    /// The argument `grown` is the growth factor of all diameters since the start of the simulation.
    pub(crate) fn set_barostat(&mut self, scene: &Scene, acting: Option<(&Barostat, &Thermostat)>, grown: f64) {
        self.isobaric = Isobaric::of(acting, self.filled * libm::pow(grown, scene.space.dimensions() as f64));
    }

    /// Pressure `[energy / length^D]` from the events in a time interval. The argument `confined` is the integral of
    /// `sum m v^2 / V` along each axis between walls.
    pub(super) fn pressure(
        &self,
        counted: &EventCounts,
        duration: f64,
        temperature: f64,
        confined: &[f64; 3],
    ) -> Option<f64> {
        if !self.has_pressure {
            return None;
        }
        let walled: Vec<usize> = (0..3).filter(|&axis| self.walled_axes[axis]).collect();
        Some(if walled.is_empty() {
            self.number_density
                * (temperature + counted.virial.total() / (self.dimensions * self.moving as f64 * duration))
        } else {
            // A driven or dissipative system has a different temperature for each axis and species.
            let sum: f64 = walled.iter().map(|&axis| confined[axis] + counted.confined_virial[axis].total()).sum();
            sum / (walled.len() as f64 * duration)
        })
    }

    /// Kinetic temperature `[energy]` from the kinetic energy and momentum, both relative to the streaming velocity.
    #[must_use]
    pub fn temperature(&self, kinetic: f64, momentum: &Vector) -> Option<f64> {
        self.has_temperature.then(|| {
            let common = self.conserved(momentum).norm_squared() / (2.0 * self.total_mass);
            2.0 * (kinetic - common).max(0.0) / self.degrees_of_freedom
        })
    }

    /// Returns the factor `sqrt(T / T_now)` for velocities relative to the drift, and the drift.
    pub(crate) fn scaling(&self, energy: &Energy, temperature: f64) -> Option<(f64, Vector)> {
        let now = self.temperature(energy.thermal, &energy.peculiar_momentum).filter(|now| *now > 0.0)?;
        Some(((temperature / now).sqrt(), self.drift(&energy.peculiar_momentum)))
    }

    /// Kinetic energy that particles gained in events so far `[energy]`, and the sum of each gain times the time of its
    /// event `[energy time]`. In a sheared box, only the dissipated energy counts.
    pub(super) fn heated(&self, counts: &EventCounts, pair_energy: f64) -> [f64; 2] {
        let lost = [counts.dissipated.total(), counts.dissipated_moment.total()];
        if self.is_sheared {
            return lost.map(|lost| -lost);
        }
        let supplied = [counts.supplied.total(), counts.supplied_moment.total()];
        let stored = [pair_energy, counts.pair_energy_moment.total()];
        [0, 1].map(|k| supplied[k] - lost[k] - stored[k])
    }

    /// Velocity of the centre of mass `[length / time]`, or zero along axes whose momentum is not conserved. The given
    /// momentum and the result are relative to the streaming velocity.
    #[must_use]
    pub fn drift(&self, momentum: &Vector) -> Vector {
        if self.moving == 0 { Vector::zeros() } else { self.conserved(momentum) / self.total_mass }
    }

    fn conserved(&self, momentum: &Vector) -> Vector {
        Vector::from_fn(|k, _| if self.conserved_axes[k] { momentum[k] } else { 0.0 })
    }

    /// Whether gravity defines a height.
    #[must_use]
    pub fn has_height(&self) -> bool {
        self.up.is_some()
    }

    pub(super) fn positions(&self, simulation: &Simulation) -> (Option<f64>, Vec<usize>) {
        if self.up.is_none() && self.regions.is_empty() {
            return (None, Vec::new());
        }
        let (mut moment, mut mass, mut moving) = (0.0, 0.0, Vec::new());
        let up = self.up.unwrap_or_default();
        let Ok(()) = simulation.for_each_now(|particle| {
            let is_static = self.masses[particle.species.0 as usize] == 0.0;
            let own = if is_static { 0.0 } else { simulation.mass_of(&particle) };
            if own > 0.0 {
                let image = particle.image;
                let travelled =
                    Vector::from_fn(|k, _| if image[k] == 0 { 0.0 } else { f64::from(image[k]) * self.periods[k] });
                moment += own * up.dot(&(particle.position + travelled));
                mass += own;
                moving.push(particle.position);
            }
            Ok::<(), Infallible>(())
        });
        let height = self.up.filter(|_| mass > 0.0).map(|_| moment / mass);
        (height, self.regions.count(moving.iter()))
    }
}

#[cfg(test)]
mod tests;
