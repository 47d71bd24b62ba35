use std::convert::Infallible;

use serde::{Deserialize, Serialize};

use super::scale_of_scene;
use crate::engine::Simulation;
use crate::model::Species;
use crate::model::scene::own_volume;
use crate::run::Finished;

/// The system at the end of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct System {
    /// Number of axes along which particles can move.
    pub dimensions: usize,
    /// Edges of the box; 0 along flat axes.
    pub size: [f64; 3],
    /// Volume, area or length of the box; `None` if a side is open.
    pub volume: Option<f64>,
    /// Number of moving particles per volume; `None` if a side is open.
    pub number_density: Option<f64>,
    /// Fraction of the box that moving particles fill; `None` if a side is open.
    pub packing_fraction: Option<f64>,
    /// Species with particles.
    pub species: Vec<SpeciesSummary>,
}

/// A species at the end of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpeciesSummary {
    /// Name of the species.
    pub name: String,
    /// Number of particles of this species.
    pub count: usize,
    /// Diameter of a particle `[length]`; the mean diameter if diameters are individual.
    pub diameter: f64,
    /// Mass of a particle, or the mean mass if masses are individual; `None` for a static species.
    pub mass: Option<f64>,
    /// The smallest and the largest diameter `[length]`, if diameters are individual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameters: Option<[f64; 2]>,
}

/// Sums over the particles of a species.
#[derive(Clone, Copy)]
struct Sums {
    diameter: f64,
    mass: f64,
    volume: f64,
    range: [f64; 2],
}

/// Returns sums over the particles with individual diameters.
fn sums(simulation: &Simulation) -> Vec<Sums> {
    let scene = simulation.scene();
    let none = Sums { diameter: 0.0, mass: 0.0, volume: 0.0, range: [f64::INFINITY, 0.0] };
    let mut all = vec![none; scene.species().len()];
    let dimensions = scene.space().dimensions();
    let Ok(()) = simulation.for_each_now(|particle| {
        if let Some(diameter) = particle.diameter {
            let sums = &mut all[particle.species.0 as usize];
            sums.diameter += diameter;
            sums.mass += simulation.mass_of(&particle);
            sums.volume += own_volume(diameter, dimensions);
            sums.range = [sums.range[0].min(diameter), sums.range[1].max(diameter)];
        }
        Ok::<(), Infallible>(())
    });
    all
}

/// Returns diameters and numbers of particles. Each particle with an individual diameter has an entry.
pub(super) fn sizes(simulation: &Simulation, scale: f64) -> Vec<[f64; 2]> {
    let species = simulation.scene().species();
    let equal = species.iter().zip(simulation.population()).filter(|(species, _)| species.individual.is_none());
    let mut sizes: Vec<[f64; 2]> = equal
        .map(|(species, count)| [species.diameter * scale, count as f64])
        .filter(|[_, count]| *count > 0.0)
        .collect();
    let Ok(()) = simulation.for_each_now(|particle| {
        sizes.extend(particle.diameter.map(|diameter| [diameter, 1.0]));
        Ok::<(), Infallible>(())
    });
    sizes
}

impl System {
    pub(super) fn of(finished: &Finished) -> Self {
        let (simulation, scene) = (&finished.simulation, finished.simulation.scene());
        let (space, scale) = (scene.space(), scale_of_scene(simulation));
        let dimensions = space.dimensions();
        let (own, population) = (sums(simulation), simulation.population());
        let present = || scene.species().iter().zip(&population).zip(&own).filter(|((_, count), _)| **count > 0);
        let volumes = present().filter(|((species, _), _)| !species.is_static());
        let filled = volumes.map(|((species, count), own)| match species.individual {
            Some(_) => own.volume,
            None => *count as f64 * own_volume(species.diameter * scale, dimensions),
        });
        let filled: f64 = filled.sum();
        let summary = |((species, &count), own): ((&Species, &usize), &Sums)| {
            let is_individual = species.individual.is_some();
            let mean = |sum: f64| sum / count as f64;
            let mass = if is_individual { mean(own.mass) } else { species.mass };
            SpeciesSummary {
                name: species.name.clone(),
                count,
                diameter: if is_individual { mean(own.diameter) } else { species.diameter * scale },
                mass: (!species.is_static()).then_some(mass),
                diameters: is_individual.then_some(own.range),
            }
        };
        let species: Vec<SpeciesSummary> = present().map(summary).collect();
        let volume = space.is_closed().then(|| space.volume());
        let moving = || species.iter().filter(|species| species.mass.is_some());
        let by_volume = |sum: f64| volume.map(|volume| sum / volume);
        Self {
            dimensions,
            size: space.size.into(),
            volume,
            number_density: by_volume(moving().map(|species| species.count as f64).sum()),
            packing_fraction: by_volume(filled),
            species,
        }
    }
}
