use super::tracers::Tracers;
use super::{CURVES, Diffusion, INTEGRAL, MSD, VACF};
use crate::analysis::instruments::followed::followed;
use crate::analysis::instruments::logarithmic::{LOGARITHMIC, logarithmic_ticks};
use crate::analysis::instruments::quantity::{Curve, Measured, Normalisation, Number};
use crate::analysis::instruments::slope::{is_small, straight_terms};
use crate::analysis::instruments::system::SystemDescription;
use crate::analysis::statistics::{CurveAverage, Estimate};

/// The autocorrelation is integrated with cubics only if its second value exceeds this fraction of its first value. For
/// an exponential decay, the error is then at most about 0.1 %.
const SMOOTH: f64 = 0.6;

/// Particles are localised, as in a crystal, if at most this fraction of the final mean squared displacement is gained
/// over the straight part of the curve.
const LOCALISED: f64 = 0.3;

pub(super) fn report(diffusion: &Diffusion, system: &SystemDescription, measured: &mut Measured) {
    let groups = diffusion.tracers.groups();
    for group in 0..groups {
        let (suffix, of) = match group.checked_sub(1).and_then(|index| species(diffusion, system, index)) {
            Some(name) => (format!("_{name}"), format!(" of {name}")),
            None => (String::new(), String::new()),
        };
        let unit = "length^2 / time";
        let (name, title) = (format!("diffusion_coefficient{suffix}"), format!("Diffusion coefficient{of}"));
        let einstein = einstein(diffusion, system, group);
        measured.numbers.push(Number::estimated(&name, &title, unit, einstein, &method(EINSTEIN, system)));
        let name = format!("diffusion_coefficient_green_kubo{suffix}");
        let title = format!("Diffusion coefficient{of}, Green-Kubo");
        let green_kubo = green_kubo(diffusion, group).filter(|_| !followed(system).is_enclosed);
        measured.numbers.push(Number::estimated(&name, &title, unit, green_kubo, &method(GREEN_KUBO, system)));
    }
    measured.curves.push(linear(diffusion, system, MSD));
    measured.curves.push(logarithmic(diffusion, system));
    measured.curves.push(linear(diffusion, system, VACF));
    measured.curves.push(linear(diffusion, system, INTEGRAL));
}

fn method(at_rest: &str, system: &SystemDescription) -> String {
    let followed = followed(system);
    let sheared = if system.shear_rate == 0.0 { "" } else { SHEARED };
    let walled = match (followed.is_enclosed, followed.leaves_walls_out) {
        (true, _) => ENCLOSED,
        (false, true) => WALLED,
        (false, false) => "",
    };
    [at_rest, sheared, walled].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

fn species<'a>(diffusion: &Diffusion, system: &'a SystemDescription, index: usize) -> Option<&'a str> {
    let id = *diffusion.tracers.species.get(index)?;
    Some(system.species_names.get(id as usize)?)
}

fn offset(diffusion: &Diffusion, group: usize, kind: usize) -> usize {
    (group * CURVES + kind) * (diffusion.lags.steps + 1)
}

/// `D = 1 / (2 d) d<r^2>/dt` over the straight part of the curve, where `d` is the number of axes. `None` if the curve
/// bends there or the particles are localised.
fn einstein(diffusion: &Diffusion, system: &SystemDescription, group: usize) -> Option<Estimate> {
    if followed(system).is_enclosed {
        return None;
    }
    let steps = diffusion.lags.steps;
    let offset = offset(diffusion, group, MSD);
    let [slope, bend] = straight_terms(steps, diffusion.lags.interval(), offset)?;
    let whole = with_spread(diffusion, group, &slope, 0)?;
    let bend = with_spread(diffusion, group, &bend, 1)?;
    // The straight part is the last three quarters of the span. In free diffusion, the curve rises there by three
    // quarters of its final value.
    let grown = whole.mean * diffusion.lags.interval() * (steps + offset - slope.first()?.0) as f64;
    let is_diffusive = grown > LOCALISED * diffusion.linear.mean(offset + steps)?;
    let scale = 0.5 / Tracers::dimensions(system);
    (is_diffusive && is_small(&bend, &whole)).then(|| whole.times(scale))
}

/// Estimates a linear combination of mean squared displacements. The standard error is the largest of three estimates:
/// from blocks of time origins, from the axes, and from the particles.
fn with_spread(diffusion: &Diffusion, group: usize, terms: &[(usize, f64)], kind: usize) -> Option<Estimate> {
    let of_blocks = diffusion.linear.combination(terms)?;
    let origins = diffusion.linear.count(terms.first()?.0);
    let variance = diffusion.tracers.variance_of_mean(group, |tracer| diffusion.spread.sum(tracer, kind) / origins);
    let errors = [of_blocks.standard_error, diffusion.spread.error_by_axes(group, kind), variance.map(f64::sqrt)];
    Some(Estimate { standard_error: errors.into_iter().flatten().reduce(f64::max), ..of_blocks })
}

/// Integrates over all lags. `None` if the autocorrelation falls too steeply between two lags, or if the integral grows
/// over the second half.
///
/// The upper limit must not depend on noise. A limit at the first zero of the autocorrelation, for example, would cut
/// off the tail and omit it from the error.
fn green_kubo(diffusion: &Diffusion, group: usize) -> Option<Estimate> {
    let first = offset(diffusion, group, VACF);
    let at = |step: usize| diffusion.linear.mean(first + step);
    let steps = diffusion.lags.steps;
    let is_smooth = at(1)? > SMOOTH * at(0)?;
    let last = offset(diffusion, group, INTEGRAL) + steps;
    let whole = diffusion.linear.estimate(last)?;
    let growth = diffusion.linear.combination(&[(last, 1.0), (last - steps.div_ceil(2), -1.0)])?;
    (is_smooth && is_small(&growth, &whole)).then_some(whole)
}

fn linear(diffusion: &Diffusion, system: &SystemDescription, kind: usize) -> Curve {
    let steps = diffusion.lags.steps;
    let times = (0..=steps).map(|step| diffusion.lags.interval() * step as f64).collect();
    let elements = |group| (0..=steps).map(|step| offset(diffusion, group, kind) + step).collect();
    let (name, title, method, quantity) = match kind {
        MSD => ("mean_squared_displacement", "Mean squared displacement", DISPLACEMENT, SQUARE),
        VACF => ("velocity_autocorrelation", "Velocity autocorrelation", CORRELATION, PRODUCT),
        _ => ("diffusion_integral", "Integral of the velocity autocorrelation", RUNNING, SUMMED),
    };
    let curve = Curve::new(name, title, &self::method(method, system)).variable("t", "time", times);
    with_series(curve, diffusion, system, &quantity, &diffusion.linear, elements)
}

fn logarithmic(diffusion: &Diffusion, system: &SystemDescription) -> Curve {
    let average = &diffusion.logarithmic;
    let numbers: Vec<usize> = (0..LOGARITHMIC).filter(|&number| average.mean(number).is_some()).collect();
    let times = numbers.iter().map(|&number| diffusion.lags.ticks.duration(logarithmic_ticks(number))).collect();
    let elements = |group| numbers.iter().map(|number| group * LOGARITHMIC + number).collect();
    let (name, title) = ("mean_squared_displacement_logarithmic", "Mean squared displacement at logarithmic times");
    let curve = Curve::new(name, title, &method(DISPLACEMENT, system)).variable("t", "time", times);
    with_series(curve.logarithmic([true, true]), diffusion, system, &SQUARE, average, elements)
}

struct Quantity {
    symbol: &'static str,
    unit: &'static str,
    of_one: &'static str,
    is_by_axis: bool,
}

const SQUARE: Quantity = Quantity { symbol: "<dr^2>", unit: "length^2", of_one: "|r(t) - r(0)|^2", is_by_axis: false };
const PRODUCT: Quantity =
    Quantity { symbol: "<v(0).v(t)>", unit: "length^2 / time^2", of_one: "v(0) . v(t)", is_by_axis: false };
const SUMMED: Quantity = Quantity {
    symbol: "D(t)",
    unit: "length^2 / time",
    of_one: "the integral of v(0) . v(t) by cubic interpolation",
    is_by_axis: true,
};

fn with_series(
    curve: Curve,
    diffusion: &Diffusion,
    system: &SystemDescription,
    quantity: &Quantity,
    average: &CurveAverage,
    elements: impl Fn(usize) -> Vec<usize>,
) -> Curve {
    let with_group = |curve: Curve, group: usize| {
        let name = group.checked_sub(1).and_then(|index| species(diffusion, system, index));
        let origins = elements(group).into_iter().map(|element| average.count(element)).collect();
        let (particles, free_part) = (diffusion.tracers.count_of(group), diffusion.tracers.free_part_of(group));
        let free = if free_part.is_none() { ", each term divided by its factor 1 - m / M" } else { "" };
        let sum = format!("{} over all origins and particles{free}", quantity.of_one);
        let mut normalisation =
            Normalisation::of(&sum).by_each("origins", "1", origins).by("particles", "1", particles);
        if let Some(part) = free_part {
            normalisation = normalisation.by("free_part", "1", part);
        }
        if quantity.is_by_axis {
            normalisation = normalisation.by("axes", "1", Tracers::dimensions(system));
        }
        let symbol = quantity.symbol;
        let name = name.map_or(symbol.to_owned(), |name| format!("{symbol} {name}"));
        curve.series(&name, quantity.unit, &average.estimates(elements(group))).normalised(normalisation)
    };
    (0..diffusion.tracers.groups()).fold(curve, with_group)
}

const DISPLACEMENT: &str = "<|r(t) - r(0)|^2> over particles and origins, with unwrapped positions. If momentum is conserved, \
    positions are relative to the centre of mass, and the result is divided by 1 - m / M.";
const CORRELATION: &str = "<v(0) . v(t)> over particles and origins. If momentum is conserved, velocities are relative to the centre of \
    mass, and the result is divided by 1 - m / M, so that it is D T / m at t = 0.";
const RUNNING: &str =
    "(1 / D) times the integral of <v(0) . v(t)> from 0 to t by cubic interpolation, D the number of axes.";
const EINSTEIN: &str = "D = 1 / (2 d) times the slope of the mean squared displacement over the last three quarters of its times, by least \
    squares, d the number of axes. There is no value if the slopes of both halves differ by more than a tenth and three errors, or if \
    particles stay where they are. The error is the largest of the scatter of origins, of axes and of particles. It also includes the \
    contribution of the flow in the periodic box after the longest time, from mode-coupling theory. Not corrected for the size of the box.";
const GREEN_KUBO: &str = "D = (1 / d) times the integral of <v(0) . v(t)> over all times of its curve, d the number of axes. There is no \
    value if the integral grows over the second half of the times by more than a tenth and three errors. The error also includes the \
    contribution of the flow in the periodic box after the longest time, from mode-coupling theory. Not corrected for the size of the box.";
const WALLED: &str = "Axes with walls are left out of r, v and d, because displacements along them are bounded.";
const ENCLOSED: &str =
    "All axes have walls: the mean squared displacement is bounded, and there is no diffusion coefficient.";
const SHEARED: &str = "In this sheared box, r and v are the components along y and z, across the flow. Momentum is conserved along \
    these axes unless Andersen collisions change it. The number of axes does not include x.";
