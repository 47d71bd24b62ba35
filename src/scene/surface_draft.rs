//! Surfaces of a scene before validation.

use crate::model::{SurfaceLaw, SurfaceMotion, SurfaceShape};

/// A surface that particles meet, with the names of the species that meet it.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceDraft {
    pub(crate) name: String,
    pub(crate) shape: SurfaceShape,
    pub(crate) species: Vec<String>,
    pub(crate) law: SurfaceLaw,
    pub(crate) stages: Vec<String>,
    /// Motions. If a motion names a stage, its times count from the beginning of the stage.
    pub(crate) motions: Vec<(Option<String>, SurfaceMotion)>,
}

impl SurfaceDraft {
    /// A surface that all species meet, and that reflects without loss.
    #[must_use]
    pub fn new(name: &str, shape: SurfaceShape) -> Self {
        let law = SurfaceLaw::Reflecting { restitution: 1.0 };
        Self { name: name.to_owned(), shape, species: Vec::new(), law, stages: Vec::new(), motions: Vec::new() }
    }

    /// Sets the ratio of the normal speeds after and before a contact, 0 to 1.
    #[must_use]
    pub fn restitution(self, restitution: f64) -> Self {
        Self { law: SurfaceLaw::Reflecting { restitution }, ..self }
    }

    /// Sets a temperature: particles leave the surface with velocities from the flux of a gas `[energy]`.
    #[must_use]
    pub fn temperature(self, temperature: f64) -> Self {
        Self { law: SurfaceLaw::Thermal { temperature }, ..self }
    }

    /// Adds a stage of a run in which the surface is present. Without any such stage, the surface is present
    /// in all stages. `measurement` stands for everything after the stages that the scene lists.
    #[must_use]
    pub fn during(mut self, stage: &str) -> Self {
        self.stages.push(stage.to_owned());
        self
    }

    /// Adds a motion, which must begin after the previous one has ended.
    #[must_use]
    pub fn motion(mut self, motion: SurfaceMotion) -> Self {
        self.motions.push((None, motion));
        self
    }

    /// Adds a motion whose times refer to the beginning of a stage. `measurement` stands for everything after
    /// the stages that the scene lists. All earlier stages must end at given times.
    #[must_use]
    pub fn motion_in(mut self, stage: &str, motion: SurfaceMotion) -> Self {
        self.motions.push((Some(stage.to_owned()), motion));
        self
    }

    /// Adds a species that meets the surface. The surface is then restricted to the added species.
    #[must_use]
    pub fn only(mut self, species: &str) -> Self {
        self.species.push(species.to_owned());
        self
    }
}
