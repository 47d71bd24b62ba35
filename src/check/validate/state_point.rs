//! Builds and runs the scene of a state point.

use std::ops::ControlFlow;

use thiserror::Error;

use super::{Comparison, Effort};
use crate::analysis::statistics::Estimate;
use crate::engine::{EngineError, Simulation};
use crate::model::error::PotentialError;
use crate::model::{Potential, RunPlan, Scene, Until};
use crate::run::audit;
use crate::run::{self, Ending, Finished};
use crate::scene::{InteractionDraft, SceneBuilder, SceneError, SpeciesDraft};

/// A callback, called every few hundredths of a second. A break ends the run.
pub type Watch<'a> = &'a mut dyn FnMut() -> ControlFlow<()>;

/// Reason why a state point could not be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StatePointError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// The potential is invalid.
    #[error(transparent)]
    Potential(#[from] PotentialError),
    /// The simulation could not continue.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The run failed its own audit.
    #[error("the audit of the run failed: {0}")]
    Unsound(audit::AuditFault),
    /// The caller stopped the run.
    #[error("interrupted")]
    Interrupted,
}

pub(super) fn one_species(seed: u64, potential: Potential, restitution: f64) -> SceneBuilder {
    let builder = SceneBuilder::new("validate").seed(seed).species(SpeciesDraft::new("A").mass(1.0).diameter(1.0));
    builder.interaction(InteractionDraft::new(potential).between("A", "A").restitution(restitution))
}

pub(super) fn plan(effort: Effort) -> RunPlan {
    let equilibration = Until::events(equilibration(effort));
    RunPlan { equilibration, limit: Until::events(effort.events()), ..RunPlan::default() }
}

pub(super) fn build(builder: &SceneBuilder) -> Result<Scene, StatePointError> {
    builder.build().map_err(|error| StatePointError::Scene(Box::new(error)))
}

pub(super) fn finish(scene: Scene, watch: Watch<'_>) -> Result<Finished, StatePointError> {
    let Ok(finished) = run::run(scene, &mut (), &mut |_| watch());
    match finished.ending {
        Ending::Interrupted => return Err(StatePointError::Interrupted),
        Ending::Arrested(arrest) => return Err(StatePointError::Engine(arrest.into())),
        Ending::Broken(broken) => return Err(StatePointError::Engine(broken.into())),
        // `Unsettled`, `Jammed` and `Blocked` cannot occur: no state point has stages or an automatic equilibration.
        Ending::Time
        | Ending::Events
        | Ending::Condition
        | Ending::Idle
        | Ending::GaveUp
        | Ending::Unsettled
        | Ending::Jammed(_)
        | Ending::Blocked(_) => {}
    }
    match finished.audit.faults().first() {
        Some(fault) => Err(StatePointError::Unsound(*fault)),
        None => Ok(finished),
    }
}

pub(super) fn advance(
    simulation: &mut Simulation,
    events: u64,
    watch: Watch<'_>,
    observe: impl FnMut(&crate::engine::event::Event),
) -> Result<(), StatePointError> {
    if watch().is_break() {
        return Err(StatePointError::Interrupted);
    }
    let end = simulation.event_counts().physical() + events;
    simulation.advance_with(Until::events(end), observe)?;
    Ok(())
}

pub(super) fn number(finished: &Finished, name: &str) -> Option<Estimate> {
    finished.measured.number(name)?.estimate()
}

/// Mean of independent values and its standard error; `None` for fewer than two.
pub(super) fn mean(values: &[f64]) -> Option<Estimate> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
    (values.len() > 1).then(|| Estimate { mean, standard_error: Some((variance / n).sqrt()) })
}

pub(super) type Compared = Result<Vec<Comparison>, StatePointError>;

/// Number of contacts before the measurement: 150 per particle. A dense lattice needs about a hundred to melt.
pub(super) fn equilibration(effort: Effort) -> u64 {
    150 * effort.particles()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_has_its_standard_error() {
        let estimate = mean(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!(estimate.mean, 2.5);
        assert!((estimate.standard_error.unwrap() - (5.0_f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(mean(&[1.0]), None);
        assert_eq!(mean(&[]), None);
    }
}
