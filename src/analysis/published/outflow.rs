//! Outflow of grains from a container.

use std::f64::consts::PI;

use super::PublishedValue;
use crate::model::measurement_plan::Outlet;
use crate::model::scene::own_volume;
use crate::model::{Scene, Species};

/// Discharge coefficient `C` of Beverloo's law.
const DISCHARGE: f64 = 0.58;

/// Coefficient `k` of Beverloo's law, for spheres.
const EMPTY_ANNULUS: f64 = 1.4;

const FLOWING: f64 = 0.6;

const SOURCE: &str = "Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15, 260 (1961), doi:10.1016/0009-2509(61)85030-6; real, rough grains, \
    with C = 0.58, k = 1.4 and a packing fraction of 0.6";

/// Calculates the outflow rate `[1 / time]` through an opening by Beverloo's law. For a round opening, the rate is `C n
/// sqrt(g) (D - k d)^(5/2)` with the constants `C = 0.58` and `k = 1.4`, the number density `n`, gravity `g`, the
/// diameter `D` of the opening and the grain diameter `d`. For a rectangle, the rate is `(4 / pi) C n A sqrt(g D)`,
/// where `A` is the area after the edges are reduced by `k d`, and `D` is `4 A` over the circumference.
///
/// Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15, 260 (1961), [doi:10.1016/0009-2509(61)85030-6](https://doi.org/10.1016/0009-2509(61)85030-6);
/// rectangles: Fowler and Glastonbury, Chem. Eng. Sci. 10, 150 (1959), [doi:10.1016/0009-2509(59)80042-7](https://doi.org/10.1016/0009-2509(59)80042-7).
#[must_use]
pub fn beverloo(number_density: f64, gravity: f64, outlet: Outlet, grain: f64) -> f64 {
    let within = |edge: f64| (edge - EMPTY_ANNULUS * grain).max(0.0);
    let (area, width) = match outlet {
        Outlet::Round(diameter) => (0.25 * PI * within(diameter) * within(diameter), within(diameter)),
        Outlet::Rectangular(edges) => {
            let [a, b] = edges.map(within);
            (a * b, if a > 0.0 && b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 })
        }
    };
    4.0 / PI * DISCHARGE * number_density * area * (gravity * width).sqrt()
}

/// Rates through the outlets of a scene, for all moving species. Empty if grains have individual diameters.
/// `population` is the number of grains of each species.
pub fn of_flows(scene: &Scene, population: &[usize], gravity: f64) -> Vec<PublishedValue> {
    let grains: Vec<(&Species, f64)> = scene
        .species
        .iter()
        .zip(population)
        .filter(|(species, _)| !species.is_static())
        .map(|(species, count)| (species, *count as f64))
        .collect();
    if grains.iter().any(|(species, _)| species.individual.is_some()) {
        return Vec::new();
    }
    let sum = |of: fn(&Species) -> f64| grains.iter().map(|(species, count)| count * of(species)).sum::<f64>();
    let count = sum(|_| 1.0);
    let density = FLOWING * count / sum(|species| own_volume(species.diameter, 3));
    let (diameter, mass) = (sum(|species| species.diameter) / count, sum(|species| species.mass) / count);
    let outlets = scene.measure.flows.iter().filter_map(|flow| Some((&flow.name, flow.outlet?)));
    let of = |(name, outlet): (&String, Outlet)| {
        let rate = beverloo(density, gravity, outlet, diameter);
        [("rate", rate), ("mass_rate", mass * rate)].map(|(key, value)| PublishedValue {
            quantity: format!("flow_{name}_{key}"),
            value,
            finite_size: 0.0,
            label: "Beverloo".to_owned(),
            source: SOURCE.to_owned(),
        })
    };
    outlets.flat_map(of).filter(|published| published.value.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_outlet_flow_exceeds_circular_by_area_ratio() {
        let round = beverloo(1.1, 9.81, Outlet::Round(5.0), 0.5);
        // 0.58 * 1.1 * sqrt(9.81) * 4.3^2.5, where 4.3 is 5 minus 1.4 grain diameters.
        assert!((round - 76.617_207_912_919).abs() < 1e-11, "{round}");
        let square = beverloo(1.1, 9.81, Outlet::Rectangular([5.0, 5.0]), 0.5);
        assert!((square / round - 4.0 / PI).abs() < 1e-14);
        // The hydraulic width of a long slot is twice its shorter edge.
        let slot = beverloo(1.0, 1.0, Outlet::Rectangular([1e9, 2.0]), 0.5);
        assert!((slot / (1e9 * 1.3) - 4.0 / PI * 0.58 * 2.6_f64.sqrt()).abs() < 1e-6);
        for outlet in [Outlet::Round(0.6), Outlet::Rectangular([0.6, 9.0])] {
            assert_eq!(beverloo(1.0, 1.0, outlet, 0.5), 0.0);
        }
    }
}
