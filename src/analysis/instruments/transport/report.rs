use super::{BULK, BULK_MEAN, HEAT, SHEAR, Transport, pairs_of_axes};
use crate::analysis::instruments::quantity::{Curve, Measured, Normalisation, Number};
use crate::analysis::instruments::slope::straight_slope;
use crate::analysis::instruments::system::SystemDescription;
use crate::analysis::statistics::Estimate;

const VISCOSITY: &str = "mass length^(2 - D) / time";
const CONDUCTIVITY: &str = "length^(2 - D) / time";

pub(super) fn report(transport: &Transport, system: &SystemDescription, measured: &mut Measured) {
    let scales = scales(transport, system);
    let number = |kind: usize, name: &str, title: &str, unit: &str, method: &str| {
        let scale = scales[kind];
        let slope = scale.and_then(|scale| Some(slope(transport, kind)?.times(scale)));
        Number::estimated(name, title, unit, slope, method)
    };
    measured.numbers.extend([
        number(SHEAR, "shear_viscosity", "Shear viscosity", VISCOSITY, SHEAR_METHOD),
        number(BULK, "bulk_viscosity", "Bulk viscosity", VISCOSITY, BULK_METHOD),
        number(HEAT, "thermal_conductivity", "Thermal conductivity", CONDUCTIVITY, HEAT_METHOD),
    ]);
    measured.curves.extend([
        curve(transport, system, ["helfand_viscosity", "Viscosity over time"], &[(SHEAR, "shear"), (BULK, "bulk")]),
        curve(transport, system, ["helfand_conductivity", "Thermal conductivity over time"], &[(HEAT, "heat")]),
    ]);
}

/// Factors that turn `<dG^2> / t` into the transport coefficients, in the order of the curves. `None` if a coefficient
/// is not defined.
fn scales(transport: &Transport, system: &SystemDescription) -> [Option<f64>; 4] {
    let dimensions = system.space.dimensions() as f64;
    let temperature = transport.temperature(system);
    let viscosity = Some(0.5 / (system.space.volume() * temperature))
        .filter(|scale| transport.is_meaningful && scale.is_finite() && *scale > 0.0);
    let heat = viscosity.filter(|_| transport.flow.heat.is_some()).map(|scale| scale / temperature);
    [viscosity.filter(|_| dimensions > 1.0), viscosity, viscosity, heat]
}

fn slope(transport: &Transport, kind: usize) -> Option<Estimate> {
    // The terms are numbered by lag, so the offset is 0.
    let combination = |terms: &[(usize, f64)]| combination(transport, kind, terms);
    straight_slope(transport.lags, transport.interval, 0, combination)
}

/// Weighted sum `sum c_k <x_k^2>` of the mean squares at lags `k = 1, 2, ...`. For the bulk viscosity, the sum is `sum
/// c_k <(x_k - <x_k>)^2>`.
fn combination(transport: &Transport, kind: usize, terms: &[(usize, f64)]) -> Option<Estimate> {
    let (average, lags) = (&transport.average, transport.lags);
    let mut elements: Vec<(usize, f64)> = terms.iter().map(|(lag, c)| (kind * lags + lag - 1, *c)).collect();
    if kind != BULK {
        return average.combination(&elements);
    }
    let mut square = 0.0;
    for (lag, c) in terms {
        let element = BULK_MEAN * lags + lag - 1;
        let mean = average.mean(element)?;
        square += c * mean * mean;
        // Derivative of `-c <x>^2` with respect to `<x>`.
        elements.push((element, -2.0 * c * mean));
    }
    let estimate = average.combination(&elements)?;
    Some(Estimate { mean: estimate.mean + square, ..estimate })
}

/// Divisors that turn sums over all time origins into `<dG^2> / (2 V T t)`, or `<dG^2> / (2 V T^2 t)` for heat. `None`
/// if the coefficient is not defined.
fn normalisation(transport: &Transport, system: &SystemDescription, kind: usize) -> Option<Normalisation> {
    scales(transport, system)[kind]?;
    let dimensions = system.space.dimensions() as f64;
    let (sum, by) = match kind {
        SHEAR => ("dG^2 over all origins and pairs of axes", Some(("pairs_of_axes", pairs_of_axes(dimensions)))),
        HEAT => ("dG^2 over all origins and axes", Some(("axes", dimensions))),
        _ => ("(dG_p - <dG_p>)^2 over all origins", None),
    };
    let origins = (1..=transport.lags).map(|lag| transport.average.count(kind * transport.lags + lag - 1)).collect();
    let times = (1..=transport.lags).map(|lag| lag as f64 * transport.interval).collect();
    let temperature = transport.temperature(system);
    let mut normalisation = Normalisation::of(sum).by_each("origins", "1", origins);
    if let Some((name, number)) = by {
        normalisation = normalisation.by(name, "1", number);
    }
    let volume = 2.0 * system.space.volume();
    normalisation = normalisation.by("twice_volume", &format!("length^{dimensions}"), volume);
    normalisation = match kind {
        HEAT => normalisation.by("temperature_squared", "energy^2", temperature * temperature),
        _ => normalisation.by("temperature", "energy", temperature),
    };
    Some(normalisation.by_each("time", "time", times))
}

fn curve(
    transport: &Transport,
    system: &SystemDescription,
    [name, title]: [&str; 2],
    kinds: &[(usize, &str)],
) -> Curve {
    let scales = scales(transport, system);
    let time = |lag: usize| lag as f64 * transport.interval;
    let curve = Curve::new(name, title, RUNNING).variable("t", "time", (1..=transport.lags).map(time).collect());
    kinds.iter().fold(curve, |curve, &(kind, series)| {
        let at = |lag: usize| {
            let estimate = combination(transport, kind, &[(lag, 1.0)])?;
            Some(estimate.times(scales[kind]? / time(lag)))
        };
        let unit = if kind == HEAT { CONDUCTIVITY } else { VISCOSITY };
        let curve = curve.series(series, unit, &(1..=transport.lags).map(at).collect::<Vec<_>>());
        match normalisation(transport, system, kind) {
            Some(by) => curve.normalised(by),
            None => curve,
        }
    })
}

const SHEAR_METHOD: &str = "Slope of <dG_xy^2> / (2 V T) with dG_xy = sum m v_x v_y dt + sum r_x J_y, over the last three quarters of its \
    times, averaged over the pairs of axes; elastic, homogeneous systems of constant energy.";
const BULK_METHOD: &str = "Slope of <(dG_p - <dG_p>)^2> / (2 V T) with dG_p the trace of the Helfand moment divided by the number of axes; \
    elastic, homogeneous systems of constant energy.";
const HEAT_METHOD: &str = "Slope of <dG_x^2> / (2 V T^2) with dG_x = sum (m/2 v^2) v_x dt + sum r_x dE, averaged over the axes; one species \
    without potential energies only.";
const RUNNING: &str = "<dG^2> / (2 V T t) of Helfand's moments, for the conductivity divided by T once more; it approaches a straight line \
    over 1 / t, whose limit is the coefficient.";
