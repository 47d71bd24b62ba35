//! Coefficients and curves of transport.

use super::{BULK, BULK_MEAN, HEAT, SHEAR, Transport};
use crate::analysis::instruments::momentum_flow::trace;
use crate::analysis::instruments::quantity::{Curve, Measured, Number, Series, Variable};
use crate::analysis::instruments::slope::straight_slope;
use crate::analysis::instruments::system::SystemDescription;
use crate::analysis::statistics::Estimate;

const VISCOSITY: &str = "mass length^(2 - D) / time";
const CONDUCTIVITY: &str = "length^(2 - D) / time";

pub(super) fn report(transport: &Transport, system: &SystemDescription, measured: &mut Measured) {
    let scales = scales(transport, system);
    let number = |kind: usize, name: &str, title: &str, unit: &str, method: &str| {
        let scale = scales[kind];
        let slope = scale.and_then(|scale| Some(scaled(slope(transport, kind)?, scale)));
        Number::estimated(name, title, unit, slope, method)
    };
    measured.numbers.extend([
        number(SHEAR, "shear_viscosity", "Shear viscosity", VISCOSITY, SHEAR_METHOD),
        number(BULK, "bulk_viscosity", "Bulk viscosity", VISCOSITY, BULK_METHOD),
        number(HEAT, "thermal_conductivity", "Thermal conductivity", CONDUCTIVITY, HEAT_METHOD),
    ]);
    measured.curves.extend([
        curve(transport, "helfand_viscosity", "Viscosity over time", &[(SHEAR, "shear"), (BULK, "bulk")], &scales),
        curve(transport, "helfand_conductivity", "Thermal conductivity over time", &[(HEAT, "heat")], &scales),
    ]);
}

/// What takes `<dG^2> / t` to a coefficient, by curve; none where it means nothing.
fn scales(transport: &Transport, system: &SystemDescription) -> [Option<f64>; 4] {
    let dimensions = system.space.dimensions() as f64;
    let freedom = dimensions * (system.moving.len() as f64 - 1.0);
    let elapsed = transport.flow.time() - transport.start;
    // The mean of the temperature over all of the time.
    let temperature = trace(&transport.flow.kinetic) / (freedom * elapsed);
    let viscosity = Some(0.5 / (system.space.volume() * temperature))
        .filter(|scale| transport.is_meaningful && scale.is_finite() && *scale > 0.0);
    let heat = viscosity.filter(|_| transport.heat.is_some()).map(|scale| scale / temperature);
    [viscosity.filter(|_| dimensions > 1.0), viscosity, viscosity, heat]
}

fn scaled(estimate: Estimate, scale: f64) -> Estimate {
    Estimate { mean: estimate.mean * scale, standard_error: estimate.standard_error.map(|error| error * scale) }
}

/// Slope of the straight part of a curve over time.
fn slope(transport: &Transport, kind: usize) -> Option<Estimate> {
    // Elements count from lag 1.
    let combination = |terms: &[(usize, f64)]| combination(transport, kind, terms);
    straight_slope(transport.lags, transport.interval, 0, combination)
}

/// The mean of `sum c_k x_k^2` with terms of lags `k`, counted from 1; for the bulk of `sum c_k (x_k - <x_k>)^2`.
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
        // The derivative of -<x>^2.
        elements.push((element, -2.0 * c * mean));
    }
    let estimate = average.combination(&elements)?;
    Some(Estimate { mean: estimate.mean + square, ..estimate })
}

fn curve(transport: &Transport, name: &str, title: &str, kinds: &[(usize, &str)], scales: &[Option<f64>; 4]) -> Curve {
    let time = |lag: usize| lag as f64 * transport.interval;
    let series = kinds.iter().map(|&(kind, series)| {
        let at = |lag: usize| {
            let estimate = combination(transport, kind, &[(lag, 1.0)])?;
            Some(scaled(estimate, scales[kind]? / time(lag)))
        };
        let estimates: Vec<_> = (1..=transport.lags).map(at).collect();
        Series {
            name: series.to_owned(),
            unit: if kind == HEAT { CONDUCTIVITY } else { VISCOSITY }.to_owned(),
            values: estimates.iter().map(|estimate| Some(estimate.as_ref()?.mean)).collect(),
            standard_errors: estimates.iter().map(|estimate| estimate.as_ref()?.standard_error).collect(),
        }
    });
    Curve {
        name: name.to_owned(),
        title: title.to_owned(),
        method: RUNNING.to_owned(),
        series: series.collect(),
        variables: vec![Variable {
            name: "t".to_owned(),
            unit: "time".to_owned(),
            values: (1..=transport.lags).map(time).collect(),
        }],
        is_logarithmic: [false, false],
        published: Vec::new(),
    }
}

const SHEAR_METHOD: &str = "Slope of <dG_xy^2> / (2 V T) with dG_xy = sum m v_x v_y dt + sum r_x J_y, over the last three quarters of its \
    times, averaged over the pairs of axes; elastic, homogeneous systems of constant energy.";
const BULK_METHOD: &str = "Slope of <(dG_p - <dG_p>)^2> / (2 V T) with dG_p the trace of the Helfand moment divided by the number of axes; \
    elastic, homogeneous systems of constant energy.";
const HEAT_METHOD: &str = "Slope of <dG_x^2> / (2 V T^2) with dG_x = sum (m/2 v^2) v_x dt + sum r_x dE, averaged over the axes; one species \
    without potential energies only.";
const RUNNING: &str = "<dG^2> / (2 V T t) of Helfand's moments, for the conductivity divided by T once more; it approaches a straight line \
    over 1 / t, whose limit is the coefficient.";
