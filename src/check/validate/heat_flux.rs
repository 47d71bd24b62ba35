//! Compares the heat flux between two plates with kinetic theory, including temperature jumps.

use std::f64::consts::PI;

use super::state_point::{Compared, Watch, build, finish, one_species, plan};
use super::{Comparison, Effort, Source};
use crate::Vector;
use crate::analysis::published::GasBetweenPlates;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{RunPlan, Until};
use crate::scene::{Arrangement, Fill};

pub(super) const QUANTITIES: &[&str] = &["heat flux in", "heat flux out"];

const TEMPERATURES: [f64; 2] = [2.0, 1.0];
const START: f64 = 1.4;
/// Minimum number of contacts, for an accuracy of two per cent.
const FEWEST_EVENTS: u64 = 1_000_000;
/// Edge length of the plates, larger than the mean free path.
const WIDTH: f64 = 20.0;

const THEORY: Source = Source {
    short: "Enskog, Sone 1989",
    full: "Fourier's law with Enskog's conductivity; temperature jumps of hard spheres: Sone, Ohwada and Aoki, Phys. Fluids A 1, 363 (1989), doi:10.1063/1.857457",
};

/// Distance between the plates: about ten mean free paths, but at least forty diameters.
pub(super) fn distance(packing_fraction: f64) -> f64 {
    (10.0 * 0.12 / packing_fraction).max(40.0)
}

fn count(packing_fraction: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some thousand at most")]
    let count = (packing_fraction * 6.0 / PI * WIDTH * WIDTH * distance(packing_fraction)).round() as u64;
    count
}

pub(super) fn compare(packing_fraction: f64, effort: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let (distance, count) = (distance(packing_fraction), count(packing_fraction));
    let boundary = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Periodic];
    let size = Vector::new(distance, WIDTH, WIDTH);
    let scene = one_species(seed, Potential::hard_sphere(1.0)?, 1.0)
        .space(Space { lower: Vector::zeros(), size, boundary })
        .wall_temperatures(0, TEMPERATURES.map(Some))
        .fill(Fill::new(Arrangement::Random, "A").count(count))
        .temperature(START)
        .run(RunPlan { limit: Until::events(effort.events().max(FEWEST_EVENTS)), ..plan(effort) });
    let finished = finish(build(&scene)?, watch)?;
    let gas = GasBetweenPlates {
        distance: distance - 1.0,
        particles_per_area: count as f64 / (WIDTH * WIDTH),
        diameter: 1.0,
        mass: 1.0,
        temperatures: TEMPERATURES,
    };
    let flux = gas.heat_flux();
    // Change of the flux if each plate is moved outwards by half a diameter.
    let neglected = flux - GasBetweenPlates { distance, ..gas }.heat_flux();
    let walls = [("lower", flux), ("upper", -flux)].into_iter().zip(QUANTITIES);
    let compared = walls.map(|((side, flux), quantity)| {
        let measured = finished.observable(&format!("heat_flux_through_{side}_x_wall"));
        Comparison::statistical(quantity, measured, flux, THEORY).allow(neglected, NEGLECTED)
    });
    Ok(compared.collect())
}

const NEGLECTED: &str = "change of the flux if each plate moves by half a diameter; covers neglected terms in the density and in the mean free path";
