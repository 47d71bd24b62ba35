//! Published results for the system that a scene describes.

use serde::{Deserialize, Serialize};

use super::equation_of_state::{face_centred_cubic, hard_disks, hard_spheres, tonks};
use super::finite_size::fewer_contacts;
use super::kinetic_theory::{FITTED_SPHERES, HardSphereFluid, collision_rate_of_disks, collision_rate_of_rods};
use crate::Vector;
use crate::model::scene::own_volume;
use crate::model::{Scene, Species, Thermostat};

/// Published value of a measured quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PublishedValue {
    /// Name of an observable, or of a number that an instrument reports, such as `compressibility_factor`.
    pub quantity: String,
    /// The value, in the units of the scene.
    pub value: f64,
    /// Finite-size correction: the expected value at this system size minus the published value. 0 if unknown. It is of
    /// first order in `1 / N`, or in `1 / L` for the diffusion coefficient.
    #[serde(default)]
    pub finite_size: f64,
    /// Short name of the result, such as `mKLM`.
    pub label: String,
    /// The publication, and the conditions under which the result holds.
    pub source: String,
}

impl PublishedValue {
    /// Whether the value is for the crystal instead of the fluid.
    #[must_use]
    pub fn is_of_crystal(&self) -> bool {
        self.label == CRYSTAL_LABEL
    }

    /// The expected value for a system of this size.
    #[must_use]
    pub fn at_size(&self) -> f64 {
        self.value + self.finite_size
    }
}

/// Largest packing fractions of the fluid in three and in two dimensions, and smallest packing fraction of the crystal.
const FLUID: [f64; 2] = [0.53, 0.70];
const CRYSTAL: f64 = 0.52;

pub(crate) const CRYSTAL_LABEL: &str = "Speedy, crystal";

/// Largest packing fraction at which Enskog's viscosity is accurate enough for the finite-size correction of diffusion.
const DIFFUSING: f64 = 0.42;

/// Transport coefficients. An Andersen heat bath destroys velocity correlations and changes these coefficients.
const TRANSPORT: [&str; 5] = [
    "diffusion_coefficient",
    "diffusion_coefficient_infinite",
    "shear_viscosity",
    "bulk_viscosity",
    "thermal_conductivity",
];

const MKLM: &str = "Pieprzyk et al., Phys. Chem. Chem. Phys. 21, 6886 (2019), doi:10.1039/C9CP00903E; infinite fluid";
const SPEEDY_CRYSTAL: &str =
    "Speedy, J. Phys.: Condens. Matter 10, 4387 (1998), doi:10.1088/0953-8984/10/20/006; face-centred cubic crystal";
const SPEEDY: &str = "Speedy, Mol. Phys. 62, 509 (1987), doi:10.1080/00268978700102371; a fit to simulations of some 500 spheres, at other sizes by Yeh and Hummer, J. Phys. Chem. B 108, 15873 (2004), times nu / (nu + D), with Enskog's coefficients";
const ENSKOG: &str =
    "Chapman and Cowling, The Mathematical Theory of Non-Uniform Gases (1970); neglects correlated collisions";
const DISKS: &str =
    "Henderson, Mol. Phys. 30, 971 (1975), doi:10.1080/00268977500102511, with two further terms; infinite fluid";
const TONKS: &str = "Tonks, Phys. Rev. 50, 955 (1936), doi:10.1103/PhysRev.50.955; exact for an infinite line";

/// Equal elastic hard particles in a periodic box.
struct Hard {
    count: u64,
    dimensions: f64,
    is_cube: bool,
    /// Whether the energy is constant (no Andersen heat bath).
    is_isolated: bool,
    packing_fraction: f64,
    number_density: f64,
    diameter: f64,
    mass: f64,
    temperature: Option<f64>,
}

/// Lists published values for equal elastic hard particles in equilibrium in a periodic box. Returns no values for
/// other systems, and no transport coefficients with an Andersen thermostat. `population` is the number of particles of
/// each species, `scale` is the growth factor of the diameters, and `temperature` is the mean temperature `[energy]`.
#[must_use]
pub fn of_system(
    scene: &Scene,
    thermostat: Option<&Thermostat>,
    population: &[usize],
    scale: f64,
    temperature: Option<f64>,
) -> Vec<PublishedValue> {
    let is_bathed = matches!(thermostat, Some(Thermostat::Andersen { .. }));
    let Some(hard) = hard(scene, is_bathed, population, scale, temperature) else { return Vec::new() };
    let mut values = match scene.space.dimensions() {
        3 => hard.spheres(),
        2 if hard.packing_fraction > FLUID[1] => Vec::new(),
        2 => hard.fluid(hard_disks, collision_rate_of_disks, "Henderson", DISKS),
        _ => hard.fluid(tonks, collision_rate_of_rods, "Tonks", TONKS),
    };
    if is_bathed {
        values.retain(|value| !TRANSPORT.contains(&value.quantity.as_str()));
    }
    values
}

fn hard(scene: &Scene, is_bathed: bool, population: &[usize], scale: f64, temperature: Option<f64>) -> Option<Hard> {
    let mut present = population.iter().enumerate().filter(|(_, count)| **count > 0);
    let (Some((at, &count)), None) = (present.next(), present.next()) else { return None };
    let species: &Species = scene.species.get(at)?;
    let interaction = &scene.interactions[scene.table.get(at, at)?.0 as usize];
    let is_plain = interaction.potential.is_hard_sphere()
        && !interaction.law.dissipates()
        && interaction.law.roughness.is_none()
        && interaction.potential.core() == Some(species.diameter)
        && !species.is_static()
        && species.individual.is_none()
        && species.acceleration == Vector::zeros()
        && scene.bonds.is_empty()
        && scene.contact_time.is_none()
        && scene.shear_rate.is_none()
        && scene.space.is_fully_periodic();
    is_plain.then(|| {
        let (volume, diameter) = (scene.space.volume(), species.diameter * scale);
        Hard {
            count: count as u64,
            dimensions: scene.space.dimensions() as f64,
            is_cube: scene.space.is_cube(),
            is_isolated: !is_bathed,
            packing_fraction: count as f64 * own_volume(diameter, scene.space.dimensions()) / volume,
            number_density: count as f64 / volume,
            diameter,
            mass: species.mass,
            temperature: temperature.filter(|temperature| *temperature > 0.0),
        }
    })
}

impl Hard {
    /// Compressibility factor `Z` and pressure. In a finite system, `Z - 1` is smaller by the fraction `fewer`.
    fn pressure(&self, compressibility: f64, fewer: f64, label: &str, source: &str) -> Vec<PublishedValue> {
        let pressure = self.temperature.map(|temperature| ("pressure", self.number_density * temperature));
        let both = [("compressibility_factor", 1.0)].into_iter().chain(pressure);
        let shift = -fewer * (compressibility - 1.0);
        both.map(|(quantity, unit)| {
            let finite_size = unit * shift;
            PublishedValue { finite_size, ..published(quantity, unit * compressibility, label, source) }
        })
        .collect()
    }

    fn pressure_of_fluid(&self, compressibility: fn(f64) -> f64, label: &str, source: &str) -> Vec<PublishedValue> {
        let fewer = fewer_contacts(compressibility, self.packing_fraction, self.count);
        self.pressure(compressibility(self.packing_fraction), fewer, label, source)
    }

    fn spheres(&self) -> Vec<PublishedValue> {
        let mut values = Vec::new();
        let phi = self.packing_fraction;
        if phi <= FLUID[0] {
            values.extend(self.pressure_of_fluid(hard_spheres, "mKLM", MKLM));
            if let Some(temperature) = self.temperature {
                let Self { packing_fraction, diameter, mass, .. } = *self;
                let fluid = HardSphereFluid { packing_fraction, diameter, mass, temperature };
                values.extend(self.collisions(fluid.collision_rate(), hard_spheres, "from mKLM", MKLM));
                values.extend(self.diffusion(&fluid));
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
            // The centre of mass does not vibrate, so only `N - 1` of `N` particles contribute.
            let fewer = 1.0 / self.count as f64;
            values.extend(self.pressure(face_centred_cubic(phi), fewer, CRYSTAL_LABEL, SPEEDY_CRYSTAL));
        }
        values
    }

    fn diffusion(&self, fluid: &HardSphereFluid) -> Vec<PublishedValue> {
        let simulated = fluid.simulated_diffusion_coefficient();
        let value = published("diffusion_coefficient", simulated, "Speedy", SPEEDY);
        if !self.is_cube || self.packing_fraction > DIFFUSING {
            return vec![value];
        }
        let Some(fitted) = fluid.slower_diffusion(FITTED_SPHERES) else { return vec![value] };
        let finite_size = fluid.slower_diffusion(self.count as f64).map_or(0.0, |slower| fitted - slower);
        let infinite = published("diffusion_coefficient_infinite", simulated + fitted, "Speedy", SPEEDY);
        vec![PublishedValue { finite_size, ..value }, infinite]
    }

    fn fluid(
        &self,
        compressibility: fn(f64) -> f64,
        collision_rate: fn(f64, f64, f64, f64) -> f64,
        label: &str,
        source: &str,
    ) -> Vec<PublishedValue> {
        let mut values = self.pressure_of_fluid(compressibility, label, source);
        let rate = self.temperature.map(|t| collision_rate(self.packing_fraction, self.diameter, self.mass, t));
        let rates = |rate| self.collisions(rate, compressibility, &format!("from {label}"), source);
        values.extend(rate.into_iter().flat_map(rates));
        values
    }

    /// Lists the collision rate under two names. At constant energy, the rate is higher than for Maxwellian velocities
    /// by the fraction `1 / (4 f)`, where `f` is the number of degrees of freedom.
    fn collisions(&self, rate: f64, compressibility: fn(f64) -> f64, label: &str, source: &str) -> [PublishedValue; 2] {
        let fewer = fewer_contacts(compressibility, self.packing_fraction, self.count);
        let freedom = self.dimensions * (self.count as f64 - 1.0);
        let faster = if self.is_isolated && freedom > 0.0 { 0.25 / freedom } else { 0.0 };
        let finite_size = rate * (faster - fewer);
        ["collision_rate", "core_rate"]
            .map(|quantity| PublishedValue { finite_size, ..published(quantity, rate, label, source) })
    }
}

pub(super) fn published(quantity: &str, value: f64, label: &str, source: &str) -> PublishedValue {
    let [quantity, label, source] = [quantity, label, source].map(str::to_owned);
    PublishedValue { quantity, value, finite_size: 0.0, label, source }
}

#[cfg(test)]
mod tests;
