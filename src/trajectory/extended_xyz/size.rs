use crate::analysis::instruments::number_of_scalars;
use crate::base::numbers::trunc_to_usize;
use crate::base::shortest::Shortest;
use crate::model::Scene;

/// Approximate size of a number with all digits `[bytes]`.
const DIGITS: usize = 20;

/// Approximate size of the first two lines of a frame without bonds `[bytes]`.
const HEADING: usize = 300;
const BOND: usize = 16;
/// Approximate size of the image numbers of a particle `[bytes]`.
const PERIODS: usize = 7;

/// Estimates the size of a frame in a file `[bytes]`. Velocities of moving species have all digits.
pub(crate) fn frame_bytes(scene: &Scene) -> f64 {
    let length = |number: f64| {
        let mut text = Vec::new();
        Shortest(number).push(&mut text);
        text.len() + 1
    };
    let grows = scene.run.has_growth();
    let of_species: Vec<usize> = scene
        .species
        .iter()
        .map(|species| {
            let is_individual = species.individual.is_some();
            let radius = if grows || is_individual { DIGITS } else { length(0.5 * species.diameter) };
            let (velocity, mass) = match species.is_static() {
                true => (2 * 3, 2),
                false if species.has_different_masses() => (3 * DIGITS, 0),
                false => (3 * DIGITS, length(species.mass)),
            };
            species.name.len() + 3 * DIGITS + velocity + radius + mass + PERIODS + 1
        })
        .collect();
    let particles: usize =
        scene.particles.iter().filter_map(|particle| of_species.get(particle.species.0 as usize)).sum();
    let of_entering = scene.entering_species().filter_map(|species| of_species.get(species.0 as usize));
    let largest = of_entering.max().copied().unwrap_or(0);
    let entering = trunc_to_usize(scene.entering());
    let (particles, count) = (particles + largest * entering, scene.particles.len() + entering);
    let scalars = DIGITS * number_of_scalars(&scene.measure, scene.space.dimensions());
    let spins = if scene.has_spins() { 3 * DIGITS } else { 0 };
    let each = length(count as f64) + scalars + spins;
    (particles + each * count + BOND * scene.bonds.len() + HEADING) as f64
}
