//! Radii and masses that a file has of its particles, which are those of the species of the scene.

use std::collections::HashSet;
use std::path::PathBuf;

use super::Start;
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::trajectory::frame::FrameSpecies;

/// What single precision leaves of a number, relative to it, ten times over: many programs write that.
const SINGLE: f64 = 1e-6;

/// So many digits are not all that the number has, but what it was rounded to.
const ROUNDED: usize = 3;

/// The radii and masses of a file, each once.
#[derive(Debug)]
pub(in crate::scene) struct RadiiAndMasses {
    path: PathBuf,
    at: ConfigPath,
    /// The line with the masses.
    comment: usize,
    species: Vec<FrameSpecies>,
    /// Species, radius, and the first line that has both.
    radii: Vec<(u32, f64, usize)>,
}

impl RadiiAndMasses {
    pub(super) fn of(start: &Start, path: PathBuf, at: &ConfigPath) -> Self {
        let mut seen = HashSet::new();
        let lines = start.comment + 1..;
        let radii = lines.zip(&start.frame.particles).filter(|_| start.has_radii);
        let radii = radii.map(|(line, particle)| (particle.species.0, particle.radius, line));
        let radii = radii.filter(|(species, radius, _)| seen.insert((*species, radius.to_bits()))).collect();
        let species = start.frame.species.clone();
        Self { path, at: at.clone(), comment: start.comment, species, radii }
    }

    /// Refuses a file whose particles have other radii or masses than the species of the scene, which would silently take their place.
    pub(in crate::scene) fn agree(&self, scene: &SceneBuilder) -> Result<(), SceneError> {
        let named = |name: &str| scene.species.iter().find(|draft| draft.name == name);
        let wrong = |line: usize, problem: String| {
            let kind = SceneErrorKind::Coordinates { path: self.path.clone(), line, problem };
            Err(SceneError::new(self.at.key("path"), kind))
        };
        for &(species, radius, line) in &self.radii {
            let Some(draft) = self.species.get(species as usize).and_then(|it| named(&it.name)) else { continue };
            if !is_same(radius, 0.5 * draft.diameter) {
                return wrong(
                    line,
                    format!(
                        "the particle has a radius of {radius}, but the species `{}` of the scene one of {}: set its diameter to {}",
                        draft.name,
                        0.5 * draft.diameter,
                        2.0 * radius,
                    ),
                );
            }
        }
        for (in_file, draft) in self.species.iter().filter_map(|it| Some((it, named(&it.name)?))) {
            // What is static in one of them only was made so on purpose.
            if let (Some(mass), Some(of_scene)) = (in_file.mass.filter(|mass| mass.is_finite()), draft.mass)
                && !is_same(mass, of_scene)
            {
                return wrong(
                    self.comment,
                    format!(
                        "the species `{}` has a mass of {mass}, but {of_scene} in the scene: set its mass to {mass}, or take `species_mass` \
                         out of the file",
                        draft.name
                    ),
                );
            }
        }
        Ok(())
    }
}

/// Whether a number of a file is that of the scene but for the rounding with which it was written: to single precision, or to the last of its digits
/// if these are three or more.
fn is_same(written: f64, number: f64) -> bool {
    let off = (written - number).abs();
    let text = format!("{written:e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let places = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let half_a_unit = 0.5 * libm::pow(10.0, exponent.parse::<f64>().unwrap_or(0.0) - places as f64);
    // The half itself is a tie between two roundings.
    off <= SINGLE * number.abs() || (places + 1 >= ROUNDED && off <= half_a_unit * (1.0 + SINGLE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_same_but_for_the_rounding_of_their_digits() {
        for (written, number) in [(0.5, 0.5), (0.333, 1.0 / 3.0), (0.5, 0.500_000_4), (66.67, 66.666_666), (1e-5, 1e-5)]
        {
            assert!(is_same(written, number), "{written} {number}");
        }
        assert!(is_same(f64::from(0.1_f32), 0.1));
        for (written, number) in [(0.5, 0.501), (0.333, 0.334), (0.500_49, 0.5), (0.6, 0.55), (0.0, 0.5), (1.0, 2.0)] {
            assert!(!is_same(written, number), "{written} {number}");
        }
    }
}
