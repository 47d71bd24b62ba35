use serde::{Deserialize, Serialize};

use super::scale_of_scene;
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
    /// Diameter of a particle `[length]`.
    pub diameter: f64,
    /// Mass of a particle; `None` for a static species.
    pub mass: Option<f64>,
}

impl System {
    pub(super) fn of(finished: &Finished) -> Self {
        let (simulation, scene) = (&finished.simulation, finished.simulation.scene());
        let (space, scale) = (scene.space(), scale_of_scene(simulation));
        let all = scene.species().iter().zip(simulation.population()).filter(|(_, count)| *count > 0);
        let species: Vec<SpeciesSummary> = all
            .map(|(species, count)| SpeciesSummary {
                name: species.name.clone(),
                count,
                diameter: species.diameter * scale,
                mass: (!species.is_static()).then_some(species.mass),
            })
            .collect();
        let dimensions = space.dimensions();
        let volume = space.is_closed().then(|| space.volume());
        let moving = || species.iter().filter(|species| species.mass.is_some());
        let by_volume = |sum: f64| volume.map(|volume| sum / volume);
        Self {
            dimensions,
            size: space.size.into(),
            volume,
            number_density: by_volume(moving().map(|species| species.count as f64).sum()),
            packing_fraction: by_volume(
                moving().map(|species| species.count as f64 * own_volume(species.diameter, dimensions)).sum(),
            ),
            species,
        }
    }
}
