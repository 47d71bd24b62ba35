//! A run whose scene is changed while it pauses.

use std::path::Path;

use thiserror::Error;

use super::{Run, Stage};
use crate::model::{Limit, Scene};
use crate::scene::SceneError;

/// Reason why a run cannot go on with another scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// The text, or what it has in common with the state.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its spheres do not have the diameters of any scene.
    #[error("the diameters have grown, expected a stage before they grow: start the scene anew")]
    Grown,
}

impl Run {
    /// Run of a scene with other values (gravity, interactions, temperatures of walls, ...), from the positions and velocities that this one has now, at the
    /// start of the stage that it is in. Its particles, bonds and static meshes stay, in place of those of the text.
    ///
    /// `overrides` are as those of [`Scene::from_file_with`].
    ///
    /// # Errors
    /// [`ChangeError`] if the text has a mistake or does not fit the state, such as another box or a larger diameter, and if diameters grow.
    pub fn changed(&self, text: &str, name: &Path, overrides: &[(&str, &str)]) -> Result<Self, ChangeError> {
        if self.simulation.is_growing() || self.simulation.scale() != 1.0 {
            return Err(ChangeError::Grown);
        }
        let mut scene = Scene::from_toml_after(text, name, overrides, &self.simulation)?;
        self.leave_out_what_is_over(&mut scene);
        Ok(Self::new(scene))
    }

    /// Drops the stages before the present one.
    fn leave_out_what_is_over(&self, scene: &mut Scene) {
        let plan = &mut scene.run;
        let stage = self.state.stage.stage;
        let over = match stage {
            Stage::Preparation(number) | Stage::EquilibrationOf(number) | Stage::MeasurementOf(number) => {
                number as usize
            }
            Stage::Equilibration | Stage::Measurement => plan.stages.len(),
        };
        plan.stages.drain(..over.min(plan.stages.len()));
        match stage {
            Stage::MeasurementOf(_) => {
                if let Some(first) = plan.stages.first_mut() {
                    first.measured = first.measured.map(|_| Default::default());
                }
            }
            Stage::Measurement => (plan.equilibration, plan.until_stationary) = (Limit::default(), false),
            _ => {}
        }
    }
}
