//! Surfaces of a scene, before they are checked.

use crate::model::{SurfaceLaw, SurfaceMotion, SurfaceShape};

/// A surface that particles meet, with the names of the species that do.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceDraft {
    pub(crate) name: String,
    pub(crate) shape: SurfaceShape,
    pub(crate) species: Vec<String>,
    pub(crate) law: SurfaceLaw,
    pub(crate) stages: Vec<String>,
    /// Each with the stage since whose beginning its times count, if it has one.
    pub(crate) motions: Vec<(Option<String>, SurfaceMotion)>,
}

impl SurfaceDraft {
    /// A surface that all species meet, and that reflects without loss.
    #[must_use]
    pub fn new(name: &str, shape: SurfaceShape) -> Self {
        let law = SurfaceLaw::Reflecting { restitution: 1.0 };
        Self { name: name.to_owned(), shape, species: Vec::new(), law, stages: Vec::new(), motions: Vec::new() }
    }

    /// With a ratio of the normal speeds after and before a contact, 0 to 1.
    #[must_use]
    pub fn restitution(self, restitution: f64) -> Self {
        Self { law: SurfaceLaw::Reflecting { restitution }, ..self }
    }

    /// With a temperature: particles leave it with velocities from the flux of a gas `[energy]`.
    #[must_use]
    pub fn temperature(self, temperature: f64) -> Self {
        Self { law: SurfaceLaw::Thermal { temperature }, ..self }
    }

    /// In one more stage of a run, where it is not there in all; `measurement` names what comes after those that the scene lists.
    #[must_use]
    pub fn during(mut self, stage: &str) -> Self {
        self.stages.push(stage.to_owned());
        self
    }

    /// With one more motion, which begins when the one before it has ended, or later.
    #[must_use]
    pub fn motion(mut self, motion: SurfaceMotion) -> Self {
        self.motions.push((None, motion));
        self
    }

    /// With one more motion, whose times are since a stage has begun; `measurement` names what comes after those that the scene lists. The stages before it
    /// end at given times.
    #[must_use]
    pub fn motion_in(mut self, stage: &str, motion: SurfaceMotion) -> Self {
        self.motions.push((Some(stage.to_owned()), motion));
        self
    }

    /// Adds a species that meets the surface, if not all do.
    #[must_use]
    pub fn only(mut self, species: &str) -> Self {
        self.species.push(species.to_owned());
        self
    }
}
