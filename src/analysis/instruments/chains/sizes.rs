use super::{gyration, unwrapped};
use crate::Vector;
use crate::analysis::instruments::system::{Sample, SystemDescription};
use crate::analysis::observables::ApplicableObservables;
use crate::engine::{Simulation, Snapshot};
use crate::model::Scene;
use crate::model::components::{Component, components};

const NAMES: [&str; 2] = ["mean_square_radius_of_gyration", "mean_square_end_to_end_distance"];

/// Names and units of the sizes of bonded molecules: the mean square radius of gyration `<sum_i |r_i - mean r|^2 / n>`,
/// and the mean square end-to-end distance `<|r_n - r_1|^2>` of linear chains.
pub const CHAIN_SIZES: [(&str, &str); 2] = [(NAMES[0], "length^2"), (NAMES[1], "length^2")];

#[derive(Debug, Clone)]
pub(crate) struct ChainSizes {
    system: SystemDescription,
    components: Vec<Component>,
}

impl ChainSizes {
    pub fn of(scene: &Scene) -> Self {
        Self::with(SystemDescription::of(scene))
    }

    /// Finds the molecules of a simulation, even if the initial particles have been removed from the scene.
    pub fn of_simulation(simulation: &Simulation, applicable: &ApplicableObservables) -> Self {
        Self::with(SystemDescription::of_simulation(simulation, applicable))
    }

    fn with(system: SystemDescription) -> Self {
        Self { components: components(system.species.len(), &system.bonds), system }
    }

    pub fn names(&self) -> &'static [&'static str] {
        match (self.components.is_empty(), self.components.iter().any(|it| it.is_linear)) {
            (true, _) => &[],
            (false, false) => &NAMES[..1],
            (false, true) => &NAMES,
        }
    }

    /// Returns the mean square sizes in a snapshot `[length^2]`, in the order of [`Self::names`].
    pub fn at(&self, snapshot: &Snapshot) -> Vec<f64> {
        let sample = Sample::of(snapshot);
        let [mut gyrations, mut ends, mut linear] = [0.0; 3];
        for component in &self.components {
            let path = unwrapped(component, &sample, &self.system);
            gyrations += gyration(&path);
            if component.is_linear {
                ends += path.last().map_or(0.0, Vector::norm_squared);
                linear += 1.0;
            }
        }
        let means = [gyrations / self.components.len() as f64, ends / linear];
        means[..self.names().len()].to_vec()
    }
}
