//! A granular gas that cools by Haff's law.
//!
//! The law is valid for dilute gases and small `1 - e^2`, because it assumes uncorrelated velocities.

use super::state_point::{Compared, Watch, advance, build, mean, one_species};
use super::{Comparison, Effort, Source};
use crate::engine::Simulation;
use crate::model::potential::Potential;
use crate::scene::{Fill, Lattice};

pub(super) const COUNT: u64 = 4000;
/// Contacts per particle before and during the measurement. The first contacts destroy the lattice. Clusters form
/// later.
const CONTACTS: [u64; 2] = [5, 15];

pub(super) const QUANTITIES: &[&str] = &["cooling per contact"];

const HAFF: Source = Source {
    short: "Haff 1983",
    full: "Haff, J. Fluid Mech. 134, 401 (1983), by contacts s per particle: d ln T / ds = -(1 - e^2) / 3",
};
const SONINE: &str = "velocities are not Maxwellian: a_2 / 4 of van Noije and Ernst, Granular Matter 1, 57 (1998)";

const GASES: u64 = 8;

pub(super) fn compare(restitution: f64, _: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let mut slopes = Vec::new();
    for gas in 0..GASES {
        // The seeds of the gases differ in the high bits, because seeds that users choose differ in the low bits.
        slopes.extend(cool(restitution, seed.wrapping_add(gas << 32), watch)?);
    }
    let e = restitution;
    let rate = (1.0 - e * e) / 3.0;
    // Second Sonine coefficient of a homogeneously cooling gas in three dimensions.
    let sonine = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e));
    Ok(vec![
        Comparison::statistical(QUANTITIES[0], mean(&slopes), rate, HAFF).allow(0.25 * rate * sonine.abs(), SONINE),
    ])
}

/// Returns the decrease of the logarithm of the temperature in each block of one contact per particle.
fn cool(restitution: f64, seed: u64, watch: Watch<'_>) -> Result<Vec<f64>, super::StatePointError> {
    let scene = one_species(seed, Potential::hard_sphere(1.0)?, restitution)
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(COUNT).packing_fraction(0.10))
        .temperature(1.0);
    let mut simulation = Simulation::without_plan(build(&scene)?);
    let block = COUNT / 2;
    for _ in 0..CONTACTS[0] {
        advance(&mut simulation, block, watch, |_| {})?;
    }
    let mut slopes = Vec::new();
    let mut last = simulation.energy().kinetic;
    for _ in 0..CONTACTS[1] {
        advance(&mut simulation, block, watch, |_| {})?;
        let kinetic = simulation.energy().kinetic;
        slopes.push(-libm::log(kinetic / last));
        last = kinetic;
    }
    Ok(slopes)
}
