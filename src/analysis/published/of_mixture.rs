//! Published equation of state for the mixture of hard spheres that a scene describes.

use super::HardMixture;
use super::of_system::{PublishedValue, published};
use crate::Vector;
use crate::model::Scene;

const BMCSL: &str = "Boublik, J. Chem. Phys. 53, 471 (1970), doi:10.1063/1.1673824; Mansoori, Carnahan, Starling and Leland, J. Chem. Phys. 54, 1523 (1971), doi:10.1063/1.1675048; infinite fluid";

/// Largest packing fraction of a fluid of many sizes.
const FLUID: f64 = 0.62;

/// Lists published values for additive elastic hard spheres of several sizes in a periodic box. Returns no values for other
/// systems. `sizes` are diameters and numbers of particles `[length, 1]`, and `temperature` is the mean temperature
/// `[energy]`.
#[must_use]
pub fn of_mixture(
    scene: &Scene,
    population: &[usize],
    sizes: &[[f64; 2]],
    temperature: Option<f64>,
) -> Vec<PublishedValue> {
    let volume = scene.space.volume();
    let densities = sizes.iter().map(|[diameter, count]| [*diameter, count / volume]);
    let mixture = HardMixture::new(scene.space.dimensions(), densities).filter(|_| is_plain(scene, population));
    let Some(mixture) = mixture.filter(|mixture| mixture.packing_fraction() <= FLUID) else { return Vec::new() };
    let Some(factor) = mixture.compressibility_factor() else { return Vec::new() };
    let density = sizes.iter().map(|[_, count]| count).sum::<f64>() / volume;
    let pressure = temperature.filter(|it| *it > 0.0).map(|it| ("pressure", factor * density * it));
    let both = [("compressibility_factor", factor)].into_iter().chain(pressure);
    both.map(|(quantity, value)| published(quantity, value, "BMCSL", BMCSL)).collect()
}

fn is_plain(scene: &Scene, population: &[usize]) -> bool {
    let present: Vec<usize> = (0..population.len()).filter(|&species| population[species] > 0).collect();
    let is_plain = |a: usize, b: usize| {
        let Some(id) = scene.table.get(a, b) else { return false };
        let interaction = &scene.interactions[id.0 as usize];
        interaction.potential.is_hard_sphere()
            && !interaction.law.dissipates()
            && interaction.law.roughness.is_none()
            && scene.is_additive(a, b)
    };
    let moves = |species: &usize| {
        let species = &scene.species[*species];
        !species.is_static() && species.acceleration == Vector::zeros()
    };
    present.iter().all(moves)
        && present.iter().all(|&a| present.iter().all(|&b| is_plain(a, b)))
        && scene.bonds.is_empty()
        && scene.contact_time.is_none()
        && scene.shear_rate.is_none()
        && scene.space.is_fully_periodic()
}
