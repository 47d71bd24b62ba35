mod report;

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::block_times::{EARLY, block_times, feasible};
use super::free_time::mean_free_time;
use super::instrument::{Instrument, Setup};
use super::momentum_flow::{MomentumFlow, trace};
use super::quantity::Measured;
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::CurveAverage;
use crate::base::numbers::trunc_to_usize;
use crate::engine::event::Event;
use crate::model::measurement_plan::MOST_TRANSPORT_LAGS as MOST;
use crate::model::measurement_plan::Transport as Plan;

/// Default number of samples. Each sample removes the accumulated round-off of the flows.
const SAMPLES: u32 = 100;

/// Default number of lags per mean free time, and default length of the longest lag in mean free times.
const MOMENTS_PER_FREE_TIME: f64 = 2.0;
const LONGEST_FREE_TIMES: f64 = 40.0;

/// Smallest and largest default number of lags.
const FEWEST: f64 = 20.0;
const MOST_CHOSEN: f64 = 80.0;
/// The default span is at most the duration divided by this number.
const SPANS: f64 = 20.0;

/// Indices of the curves. Each curve has one element per lag, from lag 1 on.
const SHEAR: usize = 0;
const BULK: usize = 1;
/// Mean of the quantity whose mean square is [`BULK`].
const BULK_MEAN: usize = 2;
const HEAT: usize = 3;
const CURVES: usize = 4;

/// Helfand moments at one time, relative to the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Moments {
    /// `xy`, `xz`, `yz`.
    shear: [f64; 3],
    /// Trace of the moments `G_ab`, divided by the number of axes.
    bulk: f64,
    heat: [f64; 3],
}

/// Measures viscosity and thermal conductivity by Einstein-Helfand relations.
///
/// The moment `G_ab` changes by `sum m v_a v_b dt` between events and by `r_ij,a J_b` at events. The moment of the
/// energy changes by `sum (m/2 v^2) v_a dt` and `r_ij,a dE_i`. The moments are exact for particles without
/// acceleration. They are recorded at multiples of the interval and compared with all earlier moments, up to the span:
///
/// | coefficient | long-time limit of |
/// |---|---|
/// | shear viscosity | `<dG_xy^2> / (2 V T t)`, averaged over the pairs of axes |
/// | bulk viscosity | `<(dG_p - <dG_p>)^2> / (2 V T t)`, `G_p = trace(G) / D` |
/// | thermal conductivity | `<dG_x^2> / (2 V T^2 t)`, averaged over the axes |
///
/// The total energy is constant, so `<dG_p> = P V t`, where `P` is the pressure of the run. The conductivity is
/// measured only for a single species without potential energies. With several species, heat and matter flow together.
///
/// Small systems of constant energy and momentum have smaller coefficients: for a hundred spheres by a few per cent,
/// and by ten per cent for the conductivity.
///
/// Helfand, Phys. Rev. 119, 1 (1960), [doi:10.1103/PhysRev.119.1](https://doi.org/10.1103/PhysRev.119.1); Alder, Gass and Wainwright,
/// J. Chem. Phys. 53, 3813 (1970), [doi:10.1063/1.1673845](https://doi.org/10.1063/1.1673845).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Transport {
    samples: SamplingTimes,
    start: f64,
    interval: f64,
    lags: usize,
    /// Number of recorded moments; the first is at the start.
    written: u64,
    /// Flow of momentum. Includes the flow of heat if the conductivity is defined.
    flow: MomentumFlow,
    /// The latest recorded moments, at most one per lag. Empty if transport coefficients are not defined.
    moments: VecDeque<Moments>,
    /// Estimate of `P V` from the first span. It is subtracted before squaring to preserve precision.
    virial: Option<f64>,
    average: CurveAverage,
    is_meaningful: bool,
}

impl Transport {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let &Setup { system, sample, .. } = setup;
        let (interval, lags) = grid(plan, setup);
        let species = |id: &u32| system.species[*id as usize];
        let is_pure = system.moving.windows(2).all(|pair| species(&pair[0]) == species(&pair[1]));
        let flow = MomentumFlow::new(&sample, system);
        Self {
            samples: block_times(setup, None, SAMPLES),
            start: sample.time,
            interval,
            lags,
            written: 0,
            flow: if is_pure && !system.has_wells { flow.with_heat(&sample, system) } else { flow },
            moments: VecDeque::new(),
            virial: None,
            average: CurveAverage::new(CURVES * lags),
            is_meaningful: system.obstacle_to_transport().is_none(),
        }
    }

    pub fn temperature(&self, system: &SystemDescription) -> f64 {
        let freedom = system.space.dimensions() as f64 * (system.moving.len() as f64 - 1.0);
        trace(&self.flow.kinetic) / (freedom * (self.flow.time - self.start))
    }

    /// Advances to a sample and recomputes the flows. There must be no event in between.
    fn synchronise(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if self.is_meaningful {
            self.pass(sample.time, system);
            self.flow.synchronise(sample, system);
        }
    }

    /// Advances to a time, and records the moments at all multiples of the interval. There must be no event in between.
    fn pass(&mut self, time: f64, system: &SystemDescription) {
        loop {
            let due = self.start + self.written as f64 * self.interval;
            if due > time {
                return;
            }
            self.flow.pass(due);
            self.write(due, system);
        }
    }

    fn write(&mut self, time: f64, system: &SystemDescription) {
        let sum = |k: usize| self.flow.kinetic[k] + self.flow.collisional[k];
        let dimensions = system.space.dimensions() as f64;
        let now = Moments {
            shear: [sum(3), sum(4), sum(5)],
            bulk: (trace(&self.flow.kinetic) + trace(&self.flow.collisional)) / dimensions,
            heat: self.flow.heat.as_ref().map_or([0.0; 3], |heat| heat.integral.into()),
        };
        if self.moments.len() == self.lags {
            let virial = *self.virial.get_or_insert(now.bulk / (time - self.start));
            self.compare(&now, virial, dimensions);
            self.moments.pop_front();
        }
        self.moments.push_back(now);
        self.written += 1;
    }

    /// Adds the squared differences between the current moments and all stored moments, the most recent first.
    fn compare(&mut self, now: &Moments, virial: f64, dimensions: f64) {
        let square = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let pairs = pairs_of_axes(dimensions);
        let lags = || self.moments.iter().rev();
        let shear = lags().map(|then| square(&now.shear, &then.shear) / pairs);
        let bulk =
            lags().zip(1_u32..).map(|(then, lag)| now.bulk - then.bulk - virial * self.interval * f64::from(lag));
        let heat = lags().map(|then| square(&now.heat, &then.heat) / dimensions);
        let values = shear.chain(bulk.clone().map(|x| x * x)).chain(bulk).chain(heat);
        self.average.add_all(values);
    }
}

fn pairs_of_axes(dimensions: f64) -> f64 {
    (0.5 * dimensions * (dimensions - 1.0)).max(1.0)
}

fn grid(plan: &Plan, setup: &Setup<'_>) -> (f64, usize) {
    let free_time = mean_free_time(setup.system, &setup.sample);
    let part = setup.duration / SPANS;
    let longest = free_time.map_or(part, |time| part.min(LONGEST_FREE_TIMES * time));
    let chosen = |span: f64| {
        let fitting = free_time.map_or(FEWEST, |time| (span / time * MOMENTS_PER_FREE_TIME).round());
        fitting.clamp(FEWEST, MOST_CHOSEN)
    };
    let (interval, lags) = match (plan.interval, plan.span) {
        (Some(interval), Some(span)) => (interval, (span / interval).round()),
        (Some(interval), None) => (interval, (longest / interval).round().max(FEWEST)),
        (None, span) => {
            let span = span.unwrap_or(longest);
            (span / chosen(span), chosen(span))
        }
    };
    (feasible(interval, setup.duration), trunc_to_usize(lags.clamp(1.0, MOST as f64)))
}

impl Instrument for Transport {
    fn next_sample(&self) -> f64 {
        if self.is_meaningful { self.samples.next() } else { f64::INFINITY }
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if self.is_meaningful {
            self.synchronise(sample, system);
            self.samples.pass_early(sample.time, EARLY);
        }
    }

    fn has_events(&self) -> bool {
        self.is_meaningful
    }

    fn scaled(&mut self, before: &Sample<'_>, after: &Sample<'_>, system: &SystemDescription) {
        self.synchronise(before, system);
        self.synchronise(after, system);
    }

    fn event(&mut self, event: &Event, system: &SystemDescription) {
        self.pass(event.time, system);
        self.flow.event(event, system);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        report::report(self, system, measured);
    }
}

#[cfg(test)]
mod tests;
