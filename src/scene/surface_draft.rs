//! Surfaces of a scene before validation.

use crate::model::{ContactLaw, Restitution, SurfaceLaw, SurfaceMotion, SurfaceShape, SurfaceVelocity};

/// A surface that particles collide with.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceDraft {
    pub(crate) name: String,
    pub(crate) shape: SurfaceShape,
    pub(crate) species: Vec<String>,
    pub(crate) law: SurfaceLaw,
    pub(crate) stages: Vec<String>,
    /// Motions of the surface. The times of a motion with a stage are relative to the beginning of this stage.
    pub(crate) motions: Vec<(Option<String>, SurfaceMotion)>,
    pub(crate) surface_velocity: Option<SurfaceVelocity>,
}

impl SurfaceDraft {
    /// Creates a surface that acts on all species and reflects them without loss.
    #[must_use]
    pub fn new(name: &str, shape: SurfaceShape) -> Self {
        let law = SurfaceLaw::Reflecting(ContactLaw::smooth(1.0));
        let (species, stages, motions) = (Vec::new(), Vec::new(), Vec::new());
        Self { name: name.to_owned(), shape, species, law, stages, motions, surface_velocity: None }
    }

    /// Sets the ratio of the normal speeds after and before a contact: a number from 0 to 1, or a function of the speed.
    #[must_use]
    pub fn restitution(self, restitution: impl Into<Restitution>) -> Self {
        self.with_law(|law| ContactLaw { restitution: restitution.into(), ..law })
    }

    /// Makes the surface rough, with a tangential restitution from -1 to 1. Without [`Self::friction`], contacts never
    /// slide.
    #[must_use]
    pub fn tangential_restitution(self, restitution: f64) -> Self {
        self.with_law(|law| law.with_tangential_restitution(restitution))
    }

    /// Makes the surface rough, with a friction coefficient. The tangential restitution is 0 unless it is set, too.
    #[must_use]
    pub fn friction(self, coefficient: f64) -> Self {
        self.with_law(|law| law.with_friction(coefficient))
    }

    /// Changes the contact law. A thermal surface becomes a reflecting one.
    fn with_law(self, change: impl FnOnce(ContactLaw) -> ContactLaw) -> Self {
        let law = self.law.contact().unwrap_or(ContactLaw::smooth(1.0));
        Self { law: SurfaceLaw::Reflecting(change(law)), ..self }
    }

    /// Sets the temperature of a thermal surface `[energy]`, which gives particles new velocities.
    #[must_use]
    pub fn temperature(self, temperature: f64) -> Self {
        Self { law: SurfaceLaw::Thermal { temperature }, ..self }
    }

    /// Makes the surface an outlet: particles that touch it leave the system.
    #[must_use]
    pub fn outlet(self) -> Self {
        Self { law: SurfaceLaw::Outlet, ..self }
    }

    /// Adds a stage of a run in which the surface is present. A surface without stages is present in the whole run.
    /// `measurement` is the part of the run after all stages listed in the scene.
    #[must_use]
    pub fn during(mut self, stage: &str) -> Self {
        self.stages.push(stage.to_owned());
        self
    }

    /// Adds a motion. It must begin after the end of the previous motion.
    #[must_use]
    pub fn motion(mut self, motion: SurfaceMotion) -> Self {
        self.motions.push((None, motion));
        self
    }

    /// Adds a motion with times relative to the beginning of a stage. `measurement` is the part of the run after all
    /// stages listed in the scene. All earlier stages must have a given duration.
    #[must_use]
    pub fn motion_in(mut self, stage: &str, motion: SurfaceMotion) -> Self {
        self.motions.push((Some(stage.to_owned()), motion));
        self
    }

    /// Sets the velocity of the material along the surface, as of a belt or a turning drum. The shape does not move. The
    /// surface must be rough or thermal, because smooth contacts do not depend on this velocity.
    #[must_use]
    pub fn surface_velocity(self, velocity: SurfaceVelocity) -> Self {
        Self { surface_velocity: Some(velocity), ..self }
    }

    /// Adds a species on which the surface acts. The surface then acts only on added species.
    #[must_use]
    pub fn only(mut self, species: &str) -> Self {
        self.species.push(species.to_owned());
        self
    }
}
