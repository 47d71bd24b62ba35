mod lags;
mod report;
mod spread;
mod tracers;

use serde::{Deserialize, Serialize};

use super::instrument::{Instrument, Setup};
use super::logarithmic::{LOGARITHMIC, logarithmic, next_logarithmic};
use super::quantity::Measured;
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::statistics::CurveAverage;
use crate::model::measurement_plan::Diffusion as Plan;
use lags::{Lags, TICKS_PER_STEP};
use spread::{Slopes, Spread};
use tracers::Tracers;

/// Memory for the positions, velocities and slopes at all time origins `[bytes]`.
const BUDGET: usize = 64 << 20;

/// Largest number of origins older than the span. Long lags need these origins. When there are more, every second
/// origin is dropped.
const MOST_LONG: usize = 16;

/// Largest number of origins that are not older than the span.
const MOST_YOUNG: usize = 6;

/// Indices of the linear curves of a group. `INTEGRAL` is the integral of the velocity autocorrelation.
const MSD: usize = 0;
const VACF: usize = 1;
const INTEGRAL: usize = 2;
const CURVES: usize = 3;

/// Mean squared displacement and velocity autocorrelation of particles, from several time origins.
///
/// Linear lags are multiples of the interval, up to the span. Logarithmic lags range from 1/32 of an interval to the
/// whole run. Lags that are not multiples of the interval occur only in the first two intervals. Each origin yields one
/// value per lag: the mean over all particles. Errors come from blocks of origins. The error of the slope also uses the
/// scatter of particles and of axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Diffusion {
    lags: Lags,
    tracers: Tracers,
    origins: Vec<Origin>,
    next: u64,
    /// Only origins whose number is a multiple of this stride are kept beyond the span.
    long_stride: u64,
    linear: CurveAverage,
    logarithmic: CurveAverage,
    spread: Spread,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Origin {
    tick: u64,
    positions: Vec<Vector>,
    /// Empty once the origin is older than the span.
    velocities: Vec<Vector>,
    /// For each group, the MSD and then the VACF at each linear lag. Empty once the origin is older than the span.
    curve: Vec<f64>,
    slopes: Slopes,
}

impl Origin {
    fn is_young(&self) -> bool {
        !self.curve.is_empty()
    }
}

impl Diffusion {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let lags = Lags::new(plan, setup);
        let each = size_of::<Vector>() * (2 * MOST_YOUNG + MOST_LONG + 1) + size_of::<[f64; 2]>() * (MOST_YOUNG + 1);
        let tracers = Tracers::new(&setup.sample, setup.system, BUDGET / each);
        let groups = tracers.groups();
        let mut diffusion = Self {
            linear: CurveAverage::new(groups * CURVES * (lags.steps + 1)),
            logarithmic: CurveAverage::new(groups * LOGARITHMIC),
            spread: Spread::new(&lags, &tracers),
            lags,
            tracers,
            origins: Vec::new(),
            next: 0,
            long_stride: 1,
        };
        diffusion.look(&setup.sample, setup.system, 0);
        diffusion
    }

    /// Takes a sample at tick `now`: starts a new origin if one is due, and updates the curves of all origins.
    fn look(&mut self, sample: &Sample<'_>, system: &SystemDescription, now: u64) {
        let frame = self.tracers.frame(sample, system);
        let groups = self.tracers.groups();
        let length = self.lags.steps + 1;
        if now.is_multiple_of(self.lags.origin_ticks()) {
            let (positions, velocities) = (frame.positions.clone(), frame.velocities.clone());
            let (curve, slopes) = (vec![0.0; groups * 2 * length], self.spread.begin());
            self.origins.push(Origin { tick: now, positions, velocities, curve, slopes });
        }
        for origin in &mut self.origins {
            let age = now - origin.tick;
            let linear = self.lags.linear(age).filter(|_| origin.is_young());
            let logarithmic = logarithmic(age);
            if linear.is_none() && logarithmic.is_none() {
                continue;
            }
            let moved = |k: usize| frame.positions[k] - origin.positions[k];
            let displacements = self.tracers.means(|k| moved(k).norm_squared());
            if let Some(number) = logarithmic {
                for (group, value) in displacements.iter().enumerate() {
                    self.logarithmic.add(group * LOGARITHMIC + number, *value);
                }
            }
            if let Some(step) = linear {
                self.spread.follow(&mut origin.slopes, step, &self.tracers, moved);
                let correlations = self.tracers.means(|k| frame.velocities[k].dot(&origin.velocities[k]));
                for (group, (msd, vacf)) in displacements.into_iter().zip(correlations).enumerate() {
                    origin.curve[(2 * group + MSD) * length + step] = msd;
                    origin.curve[(2 * group + VACF) * length + step] = vacf;
                }
            }
        }
        self.retire(now, system);
        self.next = self.next_tick(now);
    }

    fn retire(&mut self, now: u64, system: &SystemDescription) {
        let span = self.lags.steps as u64 * TICKS_PER_STEP;
        let (length, groups) = (self.lags.steps + 1, self.tracers.groups());
        let weight = self.lags.interval() / Tracers::dimensions(system);
        for origin in self.origins.iter_mut().filter(|origin| origin.is_young() && now - origin.tick >= span) {
            let mut values = Vec::with_capacity(groups * CURVES * length);
            for curves in origin.curve.chunks_exact(2 * length) {
                values.extend_from_slice(curves);
                values.extend(integrals(&curves[length..]).map(|integral| weight * integral));
            }
            self.linear.add_all(values);
            self.spread.add(&origin.slopes);
            (origin.curve, origin.velocities, origin.slopes) = (Vec::new(), Vec::new(), Slopes::default());
        }
        let origin_ticks = self.lags.origin_ticks();
        let is_kept =
            |origin: &Origin, stride: u64| origin.is_young() || (origin.tick / origin_ticks).is_multiple_of(stride);
        self.origins.retain(|origin| is_kept(origin, self.long_stride));
        if self.origins.iter().filter(|origin| !origin.is_young()).count() > MOST_LONG {
            self.long_stride *= 2;
            self.origins.retain(|origin| is_kept(origin, self.long_stride));
        }
    }

    fn next_tick(&self, now: u64) -> u64 {
        let of = |origin: &Origin| {
            let age = now - origin.tick;
            let linear = self.lags.next_linear(age).filter(|_| origin.is_young());
            origin.tick + linear.unwrap_or(u64::MAX - origin.tick).min(next_logarithmic(age))
        };
        let origin_ticks = self.lags.origin_ticks();
        let begin = (now / origin_ticks + 1).saturating_mul(origin_ticks);
        self.origins.iter().map(of).fold(begin, u64::min)
    }
}

impl Instrument for Diffusion {
    fn next_sample(&self) -> f64 {
        self.lags.ticks.time(self.next)
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let now = self.lags.ticks.passed(sample.time, self.next);
        if now > self.next {
            // After a missed sample, no origin can be completed.
            self.origins.clear();
            self.next = self.next_tick(now);
        } else if now == self.next {
            self.look(sample, system, now);
        }
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        report::report(self, system, measured);
    }
}

/// Integrals of a function from the first value up to each value, at a spacing of 1. Each step uses the cubic through
/// four values, or trapezoids if there are fewer values.
fn integrals(values: &[f64]) -> impl Iterator<Item = f64> {
    let last = values.len().saturating_sub(1);
    let step = move |k: usize| match (k, last) {
        (_, ..3) => 0.5 * (values[k] + values[k + 1]),
        (0, _) => (9.0 * values[0] + 19.0 * values[1] - 5.0 * values[2] + values[3]) / 24.0,
        (k, last) if k + 1 == last => {
            (9.0 * values[last] + 19.0 * values[k] - 5.0 * values[k - 1] + values[k - 2]) / 24.0
        }
        (k, _) => (13.0 * (values[k] + values[k + 1]) - values[k - 1] - values[k + 2]) / 24.0,
    };
    let sums = (0..last).scan(0.0, move |sum, k| {
        *sum += step(k);
        Some(*sum)
    });
    std::iter::once(0.0).chain(sums)
}

#[cfg(test)]
mod tests;
