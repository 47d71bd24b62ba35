//! Compares the radii and masses in a coordinate file with the species of the scene.

use std::collections::{HashMap, HashSet};

use super::{Origin, Start};
use crate::Vector;
use crate::scene::builder::SceneBuilder;
use crate::scene::diagnostic::SceneError;
use crate::scene::unvalidated::{Group, LocatedGroup, SpeciesDraft};
use crate::trajectory::frame::FrameSpecies;

/// Relative tolerance for numbers in single precision: about ten times the round-off.
const SINGLE: f64 = 1e-6;

/// Numbers with at least this many digits may have been rounded in their last digit.
const ROUNDED: usize = 3;

#[derive(Debug)]
pub(in crate::scene) struct RadiiAndMasses {
    origin: Origin,
    /// Number of the line that contains the masses of the species.
    comment: usize,
    species: Vec<FrameSpecies>,
    /// Species, radius and line number of each distinct radius; empty if the frame has no radii.
    radii: Vec<(u32, f64, usize)>,
    /// Species, mass and line number of each distinct mass; empty if the file has no column of masses.
    masses: Vec<(u32, f64, usize)>,
    /// Momenta of the particles; empty if the file has velocities.
    momenta: Vec<Vector>,
    group: usize,
}

impl RadiiAndMasses {
    pub(super) fn of(start: &Start<'_>, origin: Origin, group: usize) -> Self {
        let once = |values: &mut dyn Iterator<Item = (u32, f64, usize)>| {
            let (mut seen, mut last) = (HashSet::new(), None);
            let mut is_new = |key: (u32, u64)| last.replace(key) != Some(key) && seen.insert(key);
            values.filter(|(species, value, _)| is_new((*species, value.to_bits()))).collect()
        };
        let particles = || (start.comment + 1..).zip(&start.frame.particles);
        let radii = particles().filter(|_| start.has_radii);
        let masses = particles().zip(&start.beside.masses);
        Self {
            origin,
            comment: start.comment,
            species: start.frame.species.clone(),
            radii: once(&mut radii.map(|(line, particle)| (particle.species.0, particle.radius, line))),
            masses: once(&mut masses.map(|((line, particle), mass)| (particle.species.0, *mass, line))),
            momenta: start.beside.momenta.clone(),
            group,
        }
    }

    pub(in crate::scene) fn set_velocities(&self, scene: &mut SceneBuilder) {
        let masses: HashMap<&str, f64> =
            scene.species.iter().filter_map(|draft| Some((draft.name.as_str(), draft.mass?))).collect();
        let dimensions = scene.parts.space.dimensions();
        let Some(LocatedGroup { group: Group::Listed(listed), .. }) = scene.groups.get_mut(self.group) else { return };
        // Static species have no mass. Static particles with a velocity are rejected later.
        let of_names: Vec<f64> =
            listed.names.iter().map(|name| masses.get(name.as_str()).copied().unwrap_or(1.0)).collect();
        let ratios: Vec<Option<&SpeciesDraft>> =
            listed.names.iter().map(|name| scene.species.iter().find(|draft| draft.name == *name)).collect();
        for (particle, momentum) in listed.particles.iter_mut().zip(&self.momenta) {
            let at = particle.species.0 as usize;
            let ratio = ratios.get(at).copied().flatten().zip(particle.diameter);
            let ratio = ratio.map_or(1.0, |(draft, diameter)| draft.ratio_of_masses(diameter, dimensions));
            particle.velocity = momentum / (of_names.get(at).copied().unwrap_or(1.0) * ratio);
        }
    }

    /// Rejects a file with radii or masses that differ from the species of the scene. Such values would be ignored.
    pub(in crate::scene) fn agree(&self, scene: &SceneBuilder) -> Result<(), SceneError> {
        let named = |name: &str| scene.species.iter().find(|draft| draft.name == name && draft.individual.is_none());
        let wrong = |line: usize, problem: String| Err(self.origin.wrong(line, problem));
        for &(species, radius, line) in &self.radii {
            let Some(draft) = self.species.get(species as usize).and_then(|it| named(&it.name)) else { continue };
            if !is_same(radius, 0.5 * draft.diameter) {
                return wrong(
                    line,
                    format!(
                        "the particle has a radius of {radius}, but the species `{}` of the scene has {}: set its diameter to {}",
                        draft.name,
                        0.5 * draft.diameter,
                        2.0 * radius,
                    ),
                );
            }
        }
        for &(species, mass, line) in &self.masses {
            let draft = self.species.get(species as usize).and_then(|it| named(&it.name));
            if let Some((draft, of_scene)) = draft.and_then(|draft| Some((draft, draft.mass?)))
                && mass > 0.0
                && !is_same(mass, of_scene)
            {
                let name = &draft.name;
                return wrong(
                    line,
                    format!(
                        "the particle has a mass of {mass}, but the species `{name}` of the scene has {of_scene}: set its mass to {mass}"
                    ),
                );
            }
        }
        for (in_file, draft) in self.species.iter().filter_map(|it| Some((it, named(&it.name)?))) {
            // Masses are compared only if the species moves both in the file and in the scene.
            if let (Some(mass), Some(of_scene)) = (in_file.mass.filter(|mass| mass.is_finite()), draft.mass)
                && !is_same(mass, of_scene)
            {
                return wrong(
                    self.comment,
                    format!(
                        "the species `{}` has a mass of {mass}, but {of_scene} in the scene: set its mass to {mass}{}",
                        draft.name,
                        if self.origin.path.is_some() { ", or remove `species_mass` from the file" } else { "" },
                    ),
                );
            }
        }
        Ok(())
    }
}

/// Whether two numbers are equal within single precision. The last of three or more digits may be rounded.
fn is_same(written: f64, number: f64) -> bool {
    let off = (written - number).abs();
    let text = format!("{written:e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let places = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let half_a_unit = 0.5 * libm::pow(10.0, exponent.parse::<f64>().unwrap_or(0.0) - places as f64);
    // A number exactly between two roundings may be rounded up or down.
    off <= SINGLE * number.abs() || (places + 1 >= ROUNDED && off <= half_a_unit * (1.0 + SINGLE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_match_if_they_differ_only_by_rounded_digits() {
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
