use std::f64::consts::{E, TAU};

use serde::{Deserialize, Serialize};

use super::block_times::feasible;
use super::followed::followed;
use super::free_time::mean_free_time;
use super::instrument::{Instrument, Setup};
use super::logarithmic::{LOGARITHMIC, Ticks, logarithmic, logarithmic_ticks, next_logarithmic};
use super::quantity::{Curve, Measured, Normalisation, Number};
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::statistics::{CurveAverage, Estimate};
use crate::base::numbers::trunc_to_u64;
use crate::model::measurement_plan as plan;

/// Memory for the positions at all time origins `[bytes]`.
const BUDGET: usize = 64 << 20;

/// Largest number of time origins in a span.
const ORIGINS: usize = 64;

/// The default shortest lag, in mean free times.
const FREE_TIMES: f64 = 0.2;

/// The default distance of the overlap, in mean diameters.
const OVERLAP: f64 = 0.3;

/// Curves of averages: `F_s`, `Q` and `Q^2`.
const CURVES: usize = 3;

/// Self-intermediate scattering function, overlap with an earlier state and its fluctuations, from several time origins.
///
/// A particle keeps its identity if it exchanges its species with another particle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Relaxation {
    /// The shortest lag is one tick.
    ticks: Ticks,
    /// The longest lag, and the time between two origins, in ticks.
    longest: u64,
    apart: u64,
    /// Time of the next sample, in ticks.
    next: u64,
    wave_number: f64,
    overlap: f64,
    drift: Vector,
    origins: Vec<Origin>,
    averages: CurveAverage,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Origin {
    tick: u64,
    positions: Vec<Vector>,
}

impl Relaxation {
    pub fn new(plan: &plan::Relaxation, setup: &Setup<'_>) -> Self {
        let (system, duration) = (setup.system, setup.duration);
        let diameters = system.moving.iter().map(|&id| system.diameter_of(id));
        let mean = diameters.sum::<f64>() / system.moving.len().max(1) as f64;
        let mean = if mean > 0.0 { mean } else { 1.0 };
        let free_time = mean_free_time(system, &setup.sample).map(|time| FREE_TIMES * time);
        let shortest = Ticks::shortest(setup.sample.time, duration);
        let tick = plan.interval.or(free_time).unwrap_or(1e-4 * duration).min(0.25 * duration);
        let tick = feasible(tick, duration).max(shortest);
        let longest = trunc_to_u64((plan.span.unwrap_or(0.25 * duration) / tick).clamp(1.0, 1e15));
        // A new origin and a checkpoint need two more copies.
        let room = (BUDGET / (size_of::<Vector>() * system.moving.len().max(1))).saturating_sub(2);
        let drift = followed(system).of(system.common_velocity(setup.sample.velocities));
        let mut relaxation = Self {
            ticks: Ticks { start: setup.sample.time, tick },
            longest,
            apart: longest.div_ceil(room.clamp(1, ORIGINS) as u64),
            next: 0,
            wave_number: plan.wave_number.unwrap_or(TAU / mean),
            overlap: plan.overlap.unwrap_or(OVERLAP * mean),
            drift,
            origins: Vec::new(),
            averages: CurveAverage::new(CURVES * LOGARITHMIC),
        };
        relaxation.look(&setup.sample, system, 0);
        relaxation
    }

    /// Takes a sample at tick `now`: starts a new origin if one is due, and updates the averages of all origins.
    fn look(&mut self, sample: &Sample<'_>, system: &SystemDescription, now: u64) {
        if system.moving.is_empty() {
            self.next = u64::MAX;
            return;
        }
        let followed = followed(system);
        let drifted = self.drift * (sample.time - self.ticks.start);
        let position = |id: &u32| followed.of(sample.unwrapped(*id as usize, &system.space)) - drifted;
        let positions: Vec<Vector> = system.moving.iter().map(position).collect();
        for origin in &self.origins {
            let Some(lag) = logarithmic(now - origin.tick) else { continue };
            let (mut scattering, mut overlap) = (0.0, 0.0);
            for (here, there) in positions.iter().zip(&origin.positions) {
                let moved = (here - there).norm();
                scattering += phase(self.wave_number * moved, followed.axes.len());
                overlap += f64::from(u8::from(moved < self.overlap));
            }
            let count = positions.len() as f64;
            let overlap = overlap / count;
            for (curve, value) in [scattering / count, overlap, overlap * overlap].into_iter().enumerate() {
                self.averages.add(curve * LOGARITHMIC + lag, value);
            }
        }
        let longest = self.longest;
        self.origins.retain(|origin| next_logarithmic(now - origin.tick) <= longest);
        if now.is_multiple_of(self.apart) {
            self.origins.push(Origin { tick: now, positions });
        }
        let next = |origin: &Origin| origin.tick.saturating_add(next_logarithmic(now - origin.tick));
        let begin = (now / self.apart + 1).saturating_mul(self.apart);
        self.next = self.origins.iter().map(next).fold(begin, u64::min);
    }

    /// The lags that have values.
    fn lags(&self) -> Vec<usize> {
        (0..LOGARITHMIC).filter(|&lag| self.averages.mean(lag).is_some()).collect()
    }

    fn time(&self, lag: usize) -> f64 {
        self.ticks.duration(logarithmic_ticks(lag))
    }

    /// The time at which `F_s` falls to `1 / e`, by linear interpolation over the logarithm of the time.
    fn relaxation_time(&self) -> Option<Estimate> {
        let target = E.recip();
        let known = self.lags().into_iter().filter_map(|lag| Some((self.time(lag), self.averages.estimate(lag)?)));
        let known: Vec<(f64, Estimate)> = known.collect();
        let after = known.iter().position(|(_, value)| value.mean <= target)?;
        let [(first, above), (second, below)] = *known.get(after.checked_sub(1)?..=after)? else { return None };
        let slope = (below.mean - above.mean) / libm::log(second / first);
        let time = first * libm::exp((target - above.mean) / slope);
        let error = above.standard_error.zip(below.standard_error).map(|(one, other)| one.max(other));
        Some(Estimate { mean: time, standard_error: error.map(|error| time * error / slope.abs()) })
    }

    /// `N (<Q^2> - <Q>^2)` with the error of both means.
    fn susceptibility(&self, lag: usize, particles: f64) -> Option<Estimate> {
        let [overlap, square] = [1, 2].map(|curve| curve * LOGARITHMIC + lag);
        let (count, mean) = (self.averages.count(overlap), self.averages.mean(overlap)?);
        if count < 2.0 {
            return None;
        }
        let of_errors = self.averages.combination(&[(square, 1.0), (overlap, -2.0 * mean)])?;
        let variance = (self.averages.mean(square)? - mean * mean).max(0.0);
        let scale = particles * count / (count - 1.0);
        let standard_error = of_errors.standard_error.map(|error| scale * error);
        Some(Estimate { mean: scale * variance, standard_error })
    }
}

/// The mean of `exp(i q.r)` over all directions of `q` in one, two or three dimensions, for `x = |q| |r|`.
fn phase(x: f64, dimensions: usize) -> f64 {
    match dimensions {
        1 => libm::cos(x),
        2 => libm::j0(x),
        _ if x == 0.0 => 1.0,
        _ => libm::sin(x) / x,
    }
}

impl Instrument for Relaxation {
    fn next_sample(&self) -> f64 {
        if self.next == u64::MAX { f64::INFINITY } else { self.ticks.time(self.next) }
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let now = self.ticks.passed(sample.time, self.next);
        if now > self.next {
            // After a missed sample, no origin can be completed.
            self.origins.clear();
            self.next = (now / self.apart + 1).saturating_mul(self.apart);
        } else if now == self.next {
            self.look(sample, system, now);
        }
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let particles = system.moving.len() as f64;
        let lags = self.lags();
        let times: Vec<f64> = lags.iter().map(|&lag| self.time(lag)).collect();
        let of = |curve: usize| -> Vec<Option<Estimate>> {
            lags.iter().map(|&lag| self.averages.estimate(curve * LOGARITHMIC + lag)).collect()
        };
        let origins = || lags.iter().map(|&lag| self.averages.count(lag)).collect();
        let normalised =
            |sum: &str| Normalisation::of(sum).by_each("origins", "1", origins()).by("particles", "1", particles);
        let (q, a) = (self.wave_number, self.overlap);
        let mean = ["cos(q r)", "J_0(q r)", "sin(q r) / (q r)"][followed(system).axes.len().clamp(1, 3) - 1];
        let time = "The time at which the self-intermediate scattering function falls to 1 / e, by linear interpolation over the logarithm of the time. There is no value if it does not fall so far, or has fallen before the shortest time.";
        measured.numbers.push(Number::estimated(
            "relaxation_time",
            "Relaxation time",
            "time",
            self.relaxation_time(),
            time,
        ));
        let method = format!(
            "F_s = <{mean}> over origins and particles, the mean of cos(q.r) over all directions of q, for q = {q} and the displacement r of a particle. Q is the fraction of particles with r < {a}. If momentum is conserved, displacements are relative to the centre of mass."
        );
        let curve = Curve::new("relaxation", "Relaxation", &method).variable("t", "time", times.clone());
        let curve = curve
            .series("F_s(q,t)", "1", &of(0))
            .normalised(normalised(&format!("{mean} over all origins and particles")));
        let curve = curve
            .series("Q(t)", "1", &of(1))
            .normalised(normalised("number of particles with r < a, over all origins"));
        measured.curves.push(curve.logarithmic([true, false]));
        let method = format!(
            "N (<Q^2> - <Q>^2) over origins, for the fraction Q of particles that moved by less than {a}. Fluctuations of quantities that are constant in this run do not contribute."
        );
        let fluctuations: Vec<_> = lags.iter().map(|&lag| self.susceptibility(lag, particles)).collect();
        let curve =
            Curve::new("four_point_susceptibility", "Four-point susceptibility", &method).variable("t", "time", times);
        measured.curves.push(curve.series("chi_4(t)", "1", &fluctuations).logarithmic([true, false]));
    }
}

#[cfg(test)]
mod tests;
