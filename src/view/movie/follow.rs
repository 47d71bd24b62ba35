use crate::Vector;
use crate::model::ParticleId;
use crate::trajectory::Frame;
use crate::view::ViewError;

/// Point in the middle of all images of a movie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Follow {
    /// Centre of mass of all moving particles. Particles of unknown mass have equal masses.
    CentreOfMass,
    /// A particle.
    Particle(ParticleId),
}

impl Follow {
    /// Returns the unwrapped position of the followed point, if it exists `[length]`.
    fn place(self, frame: &Frame) -> Option<Vector> {
        let particles = || frame.particles.iter().enumerate();
        match self {
            Self::Particle(id) => particles().find(|(_, particle)| particle.id == id).map(|(k, _)| frame.unwrapped(k)),
            Self::CentreOfMass => {
                let (mut sum, mut total) = (Vector::zeros(), 0.0);
                for (k, particle) in particles().filter(|(_, particle)| !frame.is_static(particle)) {
                    let species = frame.species.get(particle.species.0 as usize);
                    let mass = species.and_then(|species| species.mass).filter(|mass| mass.is_finite()).unwrap_or(1.0);
                    sum += frame.unwrapped(k) * mass;
                    total += mass;
                }
                (total > 0.0).then(|| sum / total)
            }
        }
    }

    /// Wraps the particles along periodic axes, so that the followed point is in the middle of the box. For other axes,
    /// returns the coordinate to which the camera points.
    ///
    /// # Errors
    /// [`ViewError::NoParticle`] if the frame does not contain the particle.
    pub fn centred(self, mut frame: Frame) -> Result<(Frame, [Option<f64>; 3]), ViewError> {
        let place = match (self.place(&frame), self) {
            (Some(place), _) => place,
            (None, Self::Particle(id)) => return Err(ViewError::NoParticle(id)),
            (None, Self::CentreOfMass) => return Ok((frame, [None; 3])),
        };
        let middle = frame.lower + 0.5 * frame.size;
        let shift = Vector::from_fn(|k, _| if frame.periodic[k] { middle[k] - place[k] } else { 0.0 });
        let wrapped: Vec<Vector> =
            frame.particles.iter().map(|particle| frame.wrapped(&(particle.position + shift))).collect();
        for (particle, position) in frame.particles.iter_mut().zip(wrapped) {
            particle.position = position;
        }
        let focus = [0, 1, 2].map(|k| (!frame.periodic[k] && !frame.is_flat(k)).then_some(place[k]));
        Ok((frame, focus))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::render::tests::frame;

    #[test]
    fn followed_particle_is_centred_on_periodic_axes() {
        let mut scene = frame([10.0; 3], &[(0, [9.0, 1.0, 2.0], 0.5), (1, [1.0, 1.0, 4.0], 0.5), (2, [3.0; 3], 0.5)]);
        scene.periodic = [true, true, false];
        let (shown, focus) = Follow::Particle(ParticleId(0)).centred(scene.clone()).unwrap();
        assert_eq!(focus, [None, None, Some(2.0)]);
        let places: Vec<Vector> = shown.particles.iter().map(|particle| particle.position).collect();
        assert_eq!(places[..2], [Vector::new(5.0, 5.0, 2.0), Vector::new(7.0, 5.0, 4.0)]);
        // One of the two moving particles has the mass 3 and has crossed a periodic boundary.
        scene.species[0].mass = Some(3.0);
        scene.images = vec![[-1, 0, 0], [0; 3], [0; 3]];
        let (shown, focus) = Follow::CentreOfMass.centred(scene.clone()).unwrap();
        assert_eq!(focus, [None, None, Some(2.5)]);
        assert_eq!(shown.particles[0].position, Vector::new(4.5, 5.0, 2.0));
        assert!(matches!(Follow::Particle(ParticleId(7)).centred(scene), Err(ViewError::NoParticle(ParticleId(7)))));
        let still = frame([10.0; 3], &[(2, [3.0; 3], 0.5)]);
        assert_eq!(Follow::CentreOfMass.centred(still.clone()).unwrap(), (still, [None; 3]));
    }
}
