//! Published results for the system that a scene describes.

use serde::{Deserialize, Serialize};

use super::equation_of_state::{face_centred_cubic, hard_disks, hard_spheres, tonks};
use super::kinetic_theory::{HardSphereFluid, collision_rate_of_disks, collision_rate_of_rods};
use crate::Vector;
use crate::model::scene::own_volume;
use crate::model::{Scene, Species, Thermostat};

/// Published value of a measured quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PublishedValue {
    /// The name of the observable, or of the number of an instrument: `compressibility_factor`.
    pub quantity: String,
    /// The value, in the units of the scene.
    pub value: f64,
    /// Label of the result: `mKLM`.
    pub label: String,
    /// Where it is published, and what it holds for.
    pub source: String,
}

/// The packing fractions for which the equations of the fluid are meant in three and two dimensions, and from which on that of the crystal is.
const FLUID: [f64; 2] = [0.53, 0.70];
const CRYSTAL: f64 = 0.52;

/// Transport coefficients, which a heat bath changes.
const TRANSPORT: [&str; 4] = ["diffusion_coefficient", "shear_viscosity", "bulk_viscosity", "thermal_conductivity"];

const MKLM: &str = "Pieprzyk et al., Phys. Chem. Chem. Phys. 21, 6886 (2019), doi:10.1039/C9CP00903E; infinite fluid";
const SPEEDY_CRYSTAL: &str =
    "Speedy, J. Phys.: Condens. Matter 10, 4387 (1998), doi:10.1088/0953-8984/10/20/006; face-centred cubic crystal";
const SPEEDY: &str = "Speedy, Mol. Phys. 62, 509 (1987), doi:10.1080/00268978700102371; infinite fluid, some per cent above that of small boxes";
const ENSKOG: &str =
    "Chapman and Cowling, The Mathematical Theory of Non-Uniform Gases (1970); neglects correlated collisions";
const DISKS: &str =
    "Henderson, Mol. Phys. 30, 971 (1975), doi:10.1080/00268977500102511, with two further terms; infinite fluid";
const TONKS: &str = "Tonks, Phys. Rev. 50, 955 (1936), doi:10.1103/PhysRev.50.955; exact for an infinite line";

/// Equal elastic hard particles in a periodic box.
struct Hard {
    packing_fraction: f64,
    number_density: f64,
    diameter: f64,
    mass: f64,
    /// Where it is known `[energy]`.
    temperature: Option<f64>,
}

/// Published values for a system in equilibrium, of so many particles by species, with diameters that have grown by a factor `scale`, at a mean
/// temperature `[energy]`, while a thermostat acts, whose Andersen collisions end the memory that transport comes from; none for a system about which nothing is known here: today that is all but equal elastic hard particles in a periodic box.
#[must_use]
pub fn of_system(
    scene: &Scene,
    thermostat: Option<&Thermostat>,
    population: &[usize],
    scale: f64,
    temperature: Option<f64>,
) -> Vec<PublishedValue> {
    let Some(hard) = hard(scene, population, scale, temperature) else { return Vec::new() };
    let mut values = match scene.space.dimensions() {
        3 => hard.spheres(),
        2 if hard.packing_fraction > FLUID[1] => Vec::new(),
        2 => hard.fluid(hard_disks, collision_rate_of_disks, "Henderson", DISKS),
        _ => hard.fluid(tonks, collision_rate_of_rods, "Tonks", TONKS),
    };
    if matches!(thermostat, Some(Thermostat::Andersen { .. })) {
        values.retain(|value| !TRANSPORT.contains(&value.quantity.as_str()));
    }
    values
}

fn hard(scene: &Scene, population: &[usize], scale: f64, temperature: Option<f64>) -> Option<Hard> {
    let mut present = population.iter().enumerate().filter(|(_, count)| **count > 0);
    let (Some((at, &count)), None) = (present.next(), present.next()) else { return None };
    let species: &Species = scene.species.get(at)?;
    let interaction = &scene.interactions[scene.table.get(at, at)?.0 as usize];
    let is_plain = interaction.potential.is_hard_sphere()
        && interaction.restitution == 1.0
        && interaction.potential.core() == Some(species.diameter)
        && !species.is_static()
        && species.acceleration == Vector::zeros()
        && scene.bonds.is_empty()
        && scene.contact_time.is_none()
        && scene.shear_rate.is_none()
        && scene.space.is_fully_periodic();
    is_plain.then(|| {
        let (volume, diameter) = (scene.space.volume(), species.diameter * scale);
        Hard {
            packing_fraction: count as f64 * own_volume(diameter, scene.space.dimensions()) / volume,
            number_density: count as f64 / volume,
            diameter,
            mass: species.mass,
            temperature: temperature.filter(|temperature| *temperature > 0.0),
        }
    })
}

impl Hard {
    /// The compressibility factor, and the pressure that follows from it.
    fn pressure(&self, compressibility: f64, label: &str, source: &str) -> Vec<PublishedValue> {
        let pressure =
            self.temperature.map(|temperature| ("pressure", compressibility * self.number_density * temperature));
        let both = [("compressibility_factor", compressibility)].into_iter().chain(pressure);
        both.map(|(quantity, value)| published(quantity, value, label, source)).collect()
    }

    fn spheres(&self) -> Vec<PublishedValue> {
        let mut values = Vec::new();
        let phi = self.packing_fraction;
        if phi <= FLUID[0] {
            values.extend(self.pressure(hard_spheres(phi), "mKLM", MKLM));
            if let Some(temperature) = self.temperature {
                let Self { packing_fraction, diameter, mass, .. } = *self;
                let fluid = HardSphereFluid { packing_fraction, diameter, mass, temperature };
                values.extend(collisions(fluid.collision_rate(), "from mKLM", MKLM));
                let simulated = fluid.simulated_diffusion_coefficient();
                values.push(published("diffusion_coefficient", simulated, "Speedy", SPEEDY));
                for (quantity, value) in [
                    ("diffusion_coefficient", fluid.diffusion_coefficient()),
                    ("shear_viscosity", fluid.shear_viscosity()),
                    ("bulk_viscosity", fluid.bulk_viscosity()),
                    ("thermal_conductivity", fluid.thermal_conductivity()),
                ] {
                    values.push(published(quantity, value, "Enskog", ENSKOG));
                }
            }
        }
        if phi >= CRYSTAL {
            values.extend(self.pressure(face_centred_cubic(phi), "Speedy, crystal", SPEEDY_CRYSTAL));
        }
        values
    }

    /// The pressure of disks or rods, and the collision rate that comes with it.
    fn fluid(
        &self,
        compressibility: fn(f64) -> f64,
        collision_rate: fn(f64, f64, f64, f64) -> f64,
        label: &str,
        source: &str,
    ) -> Vec<PublishedValue> {
        let mut values = self.pressure(compressibility(self.packing_fraction), label, source);
        let rate = self.temperature.map(|t| collision_rate(self.packing_fraction, self.diameter, self.mass, t));
        values.extend(rate.into_iter().flat_map(|rate| collisions(rate, &format!("from {label}"), source)));
        values
    }
}

/// The collision rate by both of its names.
fn collisions(rate: f64, label: &str, source: &str) -> [PublishedValue; 2] {
    ["collision_rate", "core_rate"].map(|quantity| published(quantity, rate, label, source))
}

fn published(quantity: &str, value: f64, label: &str, source: &str) -> PublishedValue {
    PublishedValue { quantity: quantity.to_owned(), value, label: label.to_owned(), source: source.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Space};
    use crate::scene::SceneBuilder;

    /// Two particles of mass 3 and diameter 2 in a box, in some dimensions.
    fn scene(dimensions: usize, potential: Potential, restitution: f64) -> Scene {
        let mut space = Space::periodic_cube(10.0);
        for axis in dimensions..3 {
            (space.boundary[axis], space.size[axis]) = (Boundary::Flat, 0.0);
        }
        SceneBuilder::new("two")
            .space(space)
            .species("unused", 1.0, 1.0)
            .species("A", 3.0, 2.0)
            .interaction("A", "A", potential, restitution)
            .particle("A", Vector::new(1.5, 0.0, 0.0), Vector::zeros())
            .particle("A", Vector::new(6.5, 0.0, 0.0), Vector::zeros())
            .build()
            .unwrap()
    }

    fn hard() -> Potential {
        Potential::hard_sphere(2.0).unwrap()
    }

    fn value(values: &[PublishedValue], quantity: &str) -> f64 {
        values.iter().find(|value| value.quantity == quantity).unwrap().value
    }

    #[test]
    fn values_are_those_of_the_units_of_the_scene() {
        let temperature = 5.0;
        let spheres = of_system(&scene(3, hard(), 1.0), None, &[0, 2], 1.0, Some(temperature));
        let phi = 2.0 * std::f64::consts::PI / 6.0 * 8.0 / 1000.0;
        assert_eq!(value(&spheres, "compressibility_factor"), hard_spheres(phi));
        assert!((value(&spheres, "pressure") - hard_spheres(phi) * 2.0 / 1000.0 * temperature).abs() < 1e-15);
        // Of a thin gas: sqrt(16 pi T / m) rho sigma^2.
        let thin = (16.0 * std::f64::consts::PI * temperature / 3.0).sqrt() * 2.0 / 1000.0 * 4.0;
        assert!((value(&spheres, "collision_rate") / thin - 1.0).abs() < 0.03);
        let disks = of_system(&scene(2, hard(), 1.0), None, &[0, 2], 1.5, Some(temperature));
        assert_eq!(value(&disks, "compressibility_factor"), hard_disks(2.0 * std::f64::consts::PI / 4.0 * 9.0 / 100.0));
        let rods = of_system(&scene(1, hard(), 1.0), None, &[0, 2], 1.0, None);
        assert_eq!(value(&rods, "compressibility_factor"), 1.0 / 0.6);
        assert!(rods.iter().all(|value| value.quantity == "compressibility_factor"));
    }

    #[test]
    fn nothing_is_published_about_other_systems() {
        let nothing = |scene: &Scene| assert_eq!(of_system(scene, None, &[0, 2], 1.0, Some(1.0)), []);
        nothing(&scene(3, Potential::square_well(2.0, 1.5, 1.0).unwrap(), 1.0));
        nothing(&scene(3, hard(), 0.9));
        // Contact at another distance than the diameter that fills the space.
        nothing(&scene(3, Potential::hard_sphere(1.0).unwrap(), 1.0));
        let mut walls = scene(3, hard(), 1.0);
        walls.space.boundary[0] = Boundary::walls(1.0);
        nothing(&walls);
        let mut falling = scene(3, hard(), 1.0);
        falling.species[1].acceleration.z = -1.0;
        nothing(&falling);
        assert_eq!(of_system(&scene(3, hard(), 1.0), None, &[1, 2], 1.0, Some(1.0)), []);
    }

    #[test]
    fn nothing_is_published_about_transport_in_a_heat_bath() {
        let bath = Thermostat::Andersen { temperature: 5.0, rate: 1.0, axes: [true; 3] };
        let scaling = Thermostat::Rescaling { temperature: 5.0, interval: 1.0 };
        let of = |thermostat: Option<&Thermostat>| -> Vec<String> {
            let values = of_system(&scene(3, hard(), 1.0), thermostat, &[0, 2], 1.0, Some(5.0));
            values.into_iter().map(|value| value.quantity).collect()
        };
        assert_eq!(of(Some(&bath)), ["compressibility_factor", "pressure", "collision_rate", "core_rate"]);
        assert_eq!(of(Some(&scaling)), of(None));
        assert!(of(None).iter().any(|quantity| quantity == "diffusion_coefficient"));
    }

    #[test]
    fn a_crystal_has_its_own_equation() {
        let labels = |scale: f64| -> Vec<String> {
            let values = of_system(&scene(3, hard(), 1.0), None, &[0, 2], scale, None);
            values.into_iter().map(|value| value.label).collect()
        };
        let scale_of = |phi: f64| (phi / (2.0 * std::f64::consts::PI / 6.0 * 8.0 / 1000.0)).cbrt();
        assert_eq!(labels(scale_of(0.49)), ["mKLM"]);
        assert_eq!(labels(scale_of(0.525)), ["mKLM", "Speedy, crystal"]);
        assert_eq!(labels(scale_of(0.6)), ["Speedy, crystal"]);
    }
}
