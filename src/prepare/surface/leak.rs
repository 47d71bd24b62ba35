//! Leaks of static surfaces: holes and joints that a moving species can pass.

use serde::{Deserialize, Serialize};

use crate::base::numbers::id;
use crate::engine::CellList;
use crate::model::StaticSurface;
use crate::model::space::{Boundary, Space};
use crate::model::{ParticleId, Scene, SpeciesId};
use crate::prepare::packing::occupancy::Contacts;
use crate::prepare::surface::Layout;

impl StaticSurface {
    /// Creates a surface from the spheres of a layout; `first` is the id of its first sphere.
    pub(crate) fn new(name: String, species: SpeciesId, first: usize, layout: &Layout) -> Self {
        let number_of = |index: usize| id(first + index);
        Self {
            name,
            species,
            particles: number_of(0)..number_of(layout.points.len()),
            hole: layout.hole,
            rims: layout
                .rims
                .iter()
                .map(|rim| rim.iter().map(|&index| ParticleId(number_of(index))).collect())
                .collect(),
        }
    }
}

/// A static-sphere surface with holes that a species can pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Leak {
    /// Name of the surface that leaks.
    #[serde(rename = "mesh")]
    pub surface: String,
    /// Name of the species that can pass.
    pub species: String,
    /// Circumradius of the largest hole `[length]`.
    pub hole: f64,
    /// Contact distance of the species and the surface `[length]`.
    pub contact: f64,
}

/// A gap between an open end of a static-sphere surface and another surface, wide enough for a species to pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Name of the surface with the open end.
    #[serde(rename = "mesh")]
    pub surface: String,
    /// Name of the surface to which the open end is joined.
    pub other: String,
    /// Median distance from the spheres along the open end to the nearest spheres of the other surface `[length]`.
    pub width: f64,
    /// Name of the species that can pass.
    pub species: String,
}

impl Scene {
    /// Returns the leaks of the static surfaces. A particle can pass a hole if its contact distance with the static
    /// spheres is less than the circumradius of the hole.
    #[must_use]
    pub fn leaks(&self) -> Vec<Leak> {
        let contacts = self.contacts();
        let mut leaks = Vec::new();
        for surface in &self.static_surfaces {
            let Some(hole) = surface.hole else { continue };
            for (index, species) in self.species.iter().enumerate().filter(|(_, species)| !species.is_static()) {
                let contact = contacts.smallest(index, surface.species.0 as usize);
                // A species that does not collide with the surface is meant to pass.
                if contact > 0.0 && contact < hole {
                    leaks.push(Leak { surface: surface.name.clone(), species: species.name.clone(), hole, contact });
                }
            }
        }
        leaks
    }

    /// Returns the leaking joints between static surfaces.
    ///
    /// A joint is an open end near another surface. The distances from its spheres to this surface are less than three
    /// contact distances, and their quartiles differ by less than a factor of 1.5. The joint leaks if `sqrt(d^2 + g^2)
    /// / 2` exceeds the contact distance. Here `d` is the spacing of the spheres along the open end, and `g` is the
    /// median width of the gap. Wider openings are assumed to be intended.
    #[must_use]
    pub fn gaps(&self) -> Vec<Gap> {
        let contacts = self.contacts();
        let mut gaps = Vec::new();
        for (number, surface) in self.static_surfaces.iter().enumerate() {
            for (index, species) in self.species.iter().enumerate().filter(|(_, species)| !species.is_static()) {
                let contact = contacts.smallest(index, surface.species.0 as usize);
                if contact == 0.0 {
                    continue;
                }
                for rim in &surface.rims {
                    gaps.extend(self.gap_along(rim, number, contact).map(|(other, width)| Gap {
                        surface: surface.name.clone(),
                        other: self.static_surfaces[other].name.clone(),
                        width,
                        species: species.name.clone(),
                    }));
                }
            }
        }
        gaps
    }

    /// Returns the other surface of a leaking joint, and the width of the gap.
    fn gap_along(&self, rim: &[ParticleId], surface: usize, contact: f64) -> Option<(usize, f64)> {
        let position = |id: u32| self.particles[id as usize].position;
        let open = Space { boundary: [Boundary::OPEN; 3], ..self.space };
        let mut joint: Option<(usize, f64)> = None;
        for (other, candidate) in self.static_surfaces.iter().enumerate().filter(|(other, _)| *other != surface) {
            let spheres = candidate.particles.clone().map(|number| (number, position(number)));
            let spheres = CellList::new(&open, 0.0, 3.0 * contact, spheres);
            let nearest = |id: &ParticleId| spheres.distance_to_nearest(&position(id.0));
            let mut widths: Vec<f64> = rim.iter().filter_map(nearest).collect();
            widths.sort_by(f64::total_cmp);
            let (Some(&near), Some(&far)) = (widths.get(rim.len() / 4), widths.get(3 * rim.len() / 4)) else {
                continue;
            };
            if far > 1.5 * near {
                continue;
            }
            let width = widths[rim.len() / 2];
            if joint.is_none_or(|(_, least)| width < least) {
                joint = Some((other, width));
            }
        }
        let along = rim.windows(2).map(|pair| (position(pair[0].0) - position(pair[1].0)).norm());
        let spacing = along.fold(0.0, f64::max);
        joint.filter(|(_, width)| 0.5 * libm::hypot(spacing, *width) > contact)
    }

    pub(crate) fn contacts(&self) -> Contacts {
        let of_species = self.table.map(|id| self.interactions[id.0 as usize].potential.core());
        Contacts::of(of_species).among(&self.species, self.diameters_of_species())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two coaxial cylinders. The lower cylinder ends at the height 9, and the upper cylinder starts at `height`.
    fn scene(spacing: f64, height: f64) -> Scene {
        Scene::from_toml(
            format!(
                r#"
                [space]
                size = [30.0, 30.0, 30.0]
                x = "open"
                y = "open"
                z = "open"
                [[species]]
                name = "ball"
                mass = 1.0
                diameter = 1.0
                [[species]]
                name = "mesh"
                diameter = 1.0
                static = true
                [[interaction]]
                species = ["ball", "mesh"]
                potential = "hard-sphere"
                [[particle]]
                species = "ball"
                position = [5.0, 5.0, 5.0]
                [[mesh]]
                name = "lower"
                species = "mesh"
                surface = "cylinder"
                base = [5.0, 5.0, 0.0]
                axis = [0.0, 0.0, 1.0]
                radius = 4.0
                length = 9.0
                spacing = {spacing}
                [[mesh]]
                name = "upper"
                species = "mesh"
                surface = "cylinder"
                base = [5.0, 5.0, {height}]
                axis = [0.0, 0.0, 1.0]
                radius = 4.0
                length = 9.0
                [run]
                until_time = 1.0
                "#
            ),
            "scene.toml",
        )
        .unwrap()
    }

    #[test]
    fn a_spacing_that_leaks_is_reported() {
        assert_eq!(scene(1.3, 10.0).leaks(), []);
        let leaks = scene(1.6, 10.0).leaks();
        assert_eq!(leaks.len(), 1);
        assert_eq!((leaks[0].surface.as_str(), leaks[0].species.as_str()), ("lower", "ball"));
        assert!(leaks[0].hole > leaks[0].contact);
    }

    #[test]
    fn default_spacing_holds_the_smallest_particles_of_an_inlet() {
        let text = r#"
            space = { size = [30.0, 30.0, 30.0] }
            species = [
                { name = "grain", mass = 1.0, diameter = { distribution = "uniform", lower = 0.2, upper = 1.8 }, diameters = "individual" },
                { name = "mesh", diameter = 1.0, static = true },
            ]
            interaction = [
                { species = ["grain", "grain"], potential = "hard-sphere" },
                { species = ["grain", "mesh"], potential = "hard-sphere" },
            ]
            inlet = [{ name = "feed", species = "grain", rate = 1.0, region = { lower = [12.0, 12.0, 12.0], upper = [18.0, 18.0, 18.0] } }]
            mesh = [
                { name = "wall", species = "mesh", surface = "cylinder", base = [15.0, 15.0, 0.0], axis = [0.0, 0.0, 1.0], radius = 9.0, length = 29.0 },
            ]
            run = { until_time = 1.0 }
            "#;
        let scene = Scene::from_toml(text, "feed.toml").unwrap();
        assert_eq!(scene.leaks(), []);
        // The spacing for the mean diameter would leave holes for the smallest grains.
        let spaced = text.replace("length = 29.0", "length = 29.0, spacing = 1.0");
        assert_eq!(Scene::from_toml(spaced, "feed.toml").unwrap().leaks().len(), 1);
    }

    #[test]
    fn surface_without_interaction_does_not_leak() {
        let text = r#"
            space = { size = [30.0, 30.0, 30.0] }
            species = [
                { name = "grain", mass = 1.0, diameter = 1.0 },
                { name = "mesh", diameter = 1.0, static = true },
                { name = "plug", diameter = 1.0, static = true },
            ]
            interaction = [
                { species = ["grain", "mesh"], potential = "hard-sphere" },
                { species = ["grain", "plug"], potential = "none" },
            ]
            particle = [{ species = "grain", position = [5.0, 5.0, 5.0] }]
            mesh = [
                { name = "wall", species = "mesh", surface = "cylinder", base = [5.0, 5.0, 0.0], axis = [0.0, 0.0, 1.0], radius = 4.0, length = 9.0, spacing = 2.0 },
                { name = "plug", species = "plug", surface = "cylinder", base = [15.0, 5.0, 0.0], axis = [0.0, 0.0, 1.0], radius = 4.0, length = 9.0, spacing = 2.0 },
            ]
            run = { until_time = 1.0 }
            "#;
        let leaks = Scene::from_toml(text, "plug.toml").unwrap().leaks();
        assert_eq!(leaks.iter().map(|leak| leak.surface.as_str()).collect::<Vec<_>>(), ["wall"], "{leaks:?}");
    }

    #[test]
    fn a_joint_with_a_gap_is_reported_but_neither_a_tight_one_nor_an_opening() {
        assert_eq!(scene(0.9, 10.0).gaps(), []);
        assert_eq!(scene(0.9, 13.0).gaps(), []);
        let gaps = scene(0.9, 11.2).gaps();
        assert!(gaps.iter().any(|gap| gap.surface == "lower" && gap.other == "upper"), "{gaps:?}");
    }
}
