//! Which quantities mean something in a scene.

use crate::Vector;
use crate::potential::Potential;
use crate::scene::{CountRegion, Scene};
use crate::simulation::Simulation;
use crate::space::{Boundary, Face};

/// What can be measured in a scene, and the constants that it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Meaning {
    /// Number of particles that move.
    pub moving: usize,
    /// Number of velocity components that are free: `D (N - 1)` where momentum is conserved, else `D N`.
    pub degrees_of_freedom: f64,
    /// Whether nothing from outside changes the total momentum: no walls, no gravity, no static particles.
    pub conserves_momentum: bool,
    /// Whether a kinetic temperature means something: particles that are not accelerated, at least two of them.
    pub has_temperature: bool,
    /// Whether the fluid is homogeneous, so that the virial gives its pressure.
    pub has_pressure: bool,
    /// Whether some pair has a hard core.
    pub has_core: bool,
    /// Whether the energy of some pair depends on its state.
    pub has_wells: bool,
    /// Particles that move per volume `[length^-D]`.
    pub number_density: f64,
    total_mass: f64,
    up: Option<Vector>,
    is_moving: Vec<bool>,
    masses: Vec<f64>,
    periods: Vector,
    regions: Vec<CountRegion>,
}

impl Meaning {
    /// What means something in this scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let species_of = |index: usize| &scene.species[scene.particles[index].species.0 as usize];
        let all = 0..scene.particles.len();
        let is_moving: Vec<bool> = all.clone().map(|index| !species_of(index).is_static()).collect();
        let moving = is_moving.iter().filter(|is_moving| **is_moving).count();
        let masses: Vec<f64> = all.map(|index| if is_moving[index] { species_of(index).mass } else { 0.0 }).collect();
        let is_accelerated = scene.species.iter().any(|species| species.acceleration != Vector::zeros());
        let has_walls = scene.space.boundary.iter().any(is_walled);
        let conserves_momentum = !is_accelerated && !has_walls && moving == scene.particles.len();
        let dimensions = scene.space.dimensions() as f64;
        let free = if conserves_momentum { moving.saturating_sub(1) } else { moving };
        let has_temperature = !is_accelerated && moving >= 2;
        let any = |has: fn(&Potential) -> bool| scene.interactions.iter().any(|i| has(&i.potential));
        let is_fluid = has_temperature && conserves_momentum && scene.space.is_fully_periodic();
        Self {
            moving,
            degrees_of_freedom: dimensions * free as f64,
            conserves_momentum,
            has_temperature,
            has_pressure: is_fluid,
            has_core: moving > 0 && any(|potential| potential.core().is_some()),
            has_wells: moving > 0 && any(|potential| potential.energies().iter().any(|u| u.is_finite() && *u != 0.0)),
            number_density: moving as f64 / scene.space.volume(),
            total_mass: masses.iter().sum(),
            up: super::upwards(scene),
            is_moving,
            masses,
            periods: scene.space.periods(),
            regions: scene.output.regions.clone(),
        }
    }

    /// Kinetic temperature `[energy]` from the kinetic energy and the total momentum.
    #[must_use]
    pub fn temperature(&self, kinetic: f64, momentum: &Vector) -> Option<f64> {
        let common = if self.conserves_momentum { momentum.norm_squared() / (2.0 * self.total_mass) } else { 0.0 };
        self.has_temperature.then(|| 2.0 * (kinetic - common).max(0.0) / self.degrees_of_freedom)
    }

    /// Whether there is a direction against gravity, and so a height.
    #[must_use]
    pub fn has_height(&self) -> bool {
        self.up.is_some()
    }

    /// The height of the centre of mass, and the numbers of particles in the regions.
    pub(super) fn positions(&self, simulation: &Simulation) -> (Option<f64>, Vec<usize>) {
        if self.up.is_none() && self.regions.is_empty() {
            return (None, Vec::new());
        }
        let snapshot = simulation.snapshot();
        let height = self.up.map(|up| {
            let moments = snapshot.positions.iter().zip(&snapshot.images).zip(&self.masses);
            let moment: f64 = moments
                .filter(|(_, mass)| **mass > 0.0)
                .map(|((position, image), mass)| {
                    let travelled =
                        Vector::from_fn(|k, _| if image[k] == 0 { 0.0 } else { f64::from(image[k]) * self.periods[k] });
                    mass * up.dot(&(position + travelled))
                })
                .sum();
            moment / self.total_mass
        });
        let moving = || snapshot.positions.iter().zip(&self.is_moving).filter(|(_, moves)| **moves);
        let count = |region: &CountRegion| moving().filter(|(position, _)| region.contains(position)).count();
        (height, self.regions.iter().map(count).collect())
    }
}

fn is_walled(boundary: &Boundary) -> bool {
    let is_wall = |face: &Face| matches!(face, Face::Wall { .. });
    matches!(boundary, Boundary::Bounded { lower, upper } if is_wall(lower) || is_wall(upper))
}
