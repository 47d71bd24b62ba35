mod report;

use super::bins::Bins;
use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::quantity::Measured;
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{BlockAverage, CurveAverage};
use crate::base::numbers::{index, trunc_to_usize};
use crate::model::measurement_plan as plan;
use crate::model::measurement_plan::{BINS, MOST_WINDOWS, WINDOWS};
use serde::{Deserialize, Serialize};

/// With more species than this, all moving particles share one histogram.
const MOST_SPECIES: usize = 8;

/// Default end of a histogram, in thermal speeds `sqrt(T / m)` of the lightest particles. A fraction of 1e-12 of
/// Maxwell's distribution lies beyond.
const END: f64 = 8.0;

/// Masses in a group differ by less than this factor. Replacing a mass `m (1 + x)` by `m` changes Maxwell's distribution
/// by a relative amount of the order of `x`, and the mean over a group by the order of `x^2`.
const ALIKE: f64 = 1.002;

/// Number of operations per particle and sample.
const WORK: f64 = 20.0;

/// Histograms of speeds in time windows, one for each species.
///
/// `p(v) = n / (N w)`, where `n` of all `N` particles are in a bin of width `w`. Speeds are relative to the centre of
/// mass along axes with conserved momentum, and to the streaming velocity in a sheared box. Windows have equal lengths.
/// The last window ends with the measurement.
///
/// By default, the bins of each species end at 8 `sqrt(T / m)` of the first sample in which anything moves.
/// Neighbouring bins are merged until no speed lies beyond the last bin. If the plan specifies the end, faster
/// particles are in no bin, but `N` includes them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Speeds {
    start: f64,
    /// Expected duration of the measurement, and length of a window `[time]`.
    duration: f64,
    length: f64,
    most_windows: usize,
    interval: Option<f64>,
    times: SamplingTimes,
    bins: usize,
    /// Upper end of all histograms `[length / time]`; `None` if the temperature determines it.
    end: Option<f64>,
    classes: Vec<Class>,
    windows: Vec<Window>,
}

/// A group of particles that share a histogram.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Class {
    name: String,
    species: Vec<u32>,
    /// The masses of the moving particles, ascending, each with the number of particles `[mass]`. Nearly equal masses are
    /// replaced by their mean.
    masses: Vec<(f64, usize)>,
    /// Width of a bin `[length / time]`; 0 until something moves.
    width: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Window {
    number: usize,
    last: f64,
    temperature: BlockAverage,
    /// For each class, the average fraction of particles in each bin.
    histograms: Vec<CurveAverage>,
}

impl Class {
    fn count(&self) -> usize {
        self.masses.iter().map(|(_, count)| count).sum()
    }
}

impl Speeds {
    pub fn new(plan: &plan::Speeds, setup: &Setup<'_>) -> Self {
        let bins = Bins::planned(plan.bins, BINS);
        let most_windows = plan.windows.unwrap_or(WINDOWS).clamp(1, MOST_WINDOWS);
        let width = plan.largest.map_or(0.0, |largest| largest / bins as f64);
        let mut speeds = Self {
            start: setup.sample.time,
            duration: setup.duration,
            length: plan.window.unwrap_or(setup.duration / most_windows as f64),
            most_windows: index(most_windows),
            interval: plan.interval,
            times: budgeted_times(setup, plan.interval, WORK * setup.system.moving.len() as f64),
            bins,
            end: plan.largest,
            classes: classes(plan, width, setup.system),
            windows: Vec::new(),
        };
        speeds.look(&setup.sample, setup.system);
        speeds
    }

    fn bins(&self, class: usize) -> Bins {
        Bins::of_width(0.0, self.classes[class].width, self.bins)
    }

    /// Samples that are early by round-off are in the next window.
    fn window_at(&self, time: f64) -> usize {
        let passed = (time - self.start) / self.length;
        trunc_to_usize((passed + 1e-9).max(0.0)).min(self.most_windows - 1)
    }

    fn look(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let number = self.window_at(sample.time);
        if self.windows.last().is_none_or(|window| window.number < number) {
            self.open(number, sample, system);
        }
        let velocities = peculiar_velocities(sample, system);
        let temperature = temperature(&velocities, system);
        let mut speeds: Vec<Vec<f64>> = self.classes.iter().map(|class| Vec::with_capacity(class.count())).collect();
        let table = self.table(system);
        for &id in &system.moving {
            if let Some(class) = table[system.species[id as usize] as usize] {
                speeds[class].push(velocities[id as usize].norm());
            }
        }
        for (class, speeds) in speeds.iter().enumerate() {
            self.fit(class, speeds, temperature);
            self.count(class, speeds);
        }
        if let Some(window) = self.windows.last_mut() {
            window.last = sample.time;
            window.temperature.add(temperature, 1.0);
        }
    }

    fn open(&mut self, number: usize, sample: &Sample<'_>, system: &SystemDescription) {
        let is_last = number + 1 == self.most_windows;
        let rest = self.start + self.duration - sample.time;
        let duration = if is_last { rest.max(self.length) } else { self.length };
        if self.interval.is_none() {
            let setup = Setup { system, sample: *sample, duration };
            self.times = budgeted_times(&setup, None, WORK * system.moving.len() as f64);
        }
        self.windows.push(Window {
            number,
            last: sample.time,
            temperature: BlockAverage::new(1.0),
            histograms: vec![CurveAverage::new(self.bins); self.classes.len()],
        });
    }

    fn table(&self, system: &SystemDescription) -> Vec<Option<usize>> {
        let mut table = vec![None; system.species_names.len()];
        for (number, class) in self.classes.iter().enumerate() {
            class.species.iter().for_each(|&species| table[species as usize] = Some(number));
        }
        table
    }

    fn fit(&mut self, class: usize, speeds: &[f64], temperature: f64) {
        if self.end.is_some() {
            return;
        }
        let fastest = speeds.iter().copied().filter(|speed| speed.is_finite()).fold(0.0, f64::max);
        if self.classes[class].width == 0.0 {
            let lightest = self.classes[class].masses.first().map_or(f64::INFINITY, |(mass, _)| *mass);
            let width = END * (temperature / lightest).sqrt() / self.bins as f64;
            self.classes[class].width = if width.is_normal() { width } else { 0.0 };
        }
        if self.classes[class].width == 0.0 {
            return;
        }
        while self.bins(class).index(fastest).is_none() {
            self.classes[class].width *= 2.0;
            for window in &mut self.windows {
                window.histograms[class] = window.histograms[class].joined_in_pairs();
            }
        }
    }

    fn count(&mut self, class: usize, speeds: &[f64]) {
        let bins = self.bins(class);
        let all = speeds.len().max(1) as f64;
        let mut numbers = vec![0_u64; self.bins];
        for speed in speeds {
            // Particles at rest are in the first bin, whatever its final width.
            let bin = if *speed == 0.0 { Some(0) } else { bins.index(*speed) };
            bin.into_iter().for_each(|bin| numbers[bin] += 1);
        }
        if let Some(window) = self.windows.last_mut() {
            window.histograms[class].add_all(numbers.iter().map(|&number| number as f64 / all));
        }
    }
}

impl Instrument for Speeds {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if self.times.is_due(sample.time) {
            self.look(sample, system);
        }
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        self.report_curves(system, measured);
    }
}

fn classes(plan: &plan::Speeds, width: f64, system: &SystemDescription) -> Vec<Class> {
    let is_asked_for = |name: &String| plan.species.as_ref().is_none_or(|species| species == name);
    let mut masses = vec![Vec::new(); system.species_names.len()];
    for &id in &system.moving {
        masses[system.species[id as usize] as usize].push(system.masses[id as usize]);
    }
    let mut present: Vec<(u32, Vec<f64>)> = (0..).zip(masses).filter(|(_, masses)| !masses.is_empty()).collect();
    present.retain(|(species, _)| is_asked_for(&system.species_names[*species as usize]));
    if present.len() > MOST_SPECIES {
        let (species, masses): (Vec<u32>, Vec<Vec<f64>>) = present.into_iter().unzip();
        return vec![Class { name: "all".to_owned(), species, masses: counted(masses.concat()), width }];
    }
    let one = |(species, masses): (u32, Vec<f64>)| Class {
        name: system.species_names[species as usize].clone(),
        species: vec![species],
        masses: counted(masses),
        width,
    };
    present.into_iter().map(one).collect()
}

/// Counts masses. Unequal masses that differ by less than [`ALIKE`] are replaced by their mean.
fn counted(mut masses: Vec<f64>) -> Vec<(f64, usize)> {
    masses.sort_by(f64::total_cmp);
    let alike = masses.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len()));
    let mut groups: Vec<Vec<(f64, usize)>> = Vec::new();
    for (mass, count) in alike {
        match groups.last_mut().filter(|group| mass < ALIKE * group[0].0) {
            Some(group) => group.push((mass, count)),
            None => groups.push(vec![(mass, count)]),
        }
    }
    let mean = |group: Vec<(f64, usize)>| {
        let count: usize = group.iter().map(|(_, count)| count).sum();
        let [(mass, _)] = group[..] else {
            let sum: f64 = group.iter().map(|(mass, count)| mass * *count as f64).sum();
            return (sum / count as f64, count);
        };
        (mass, count)
    };
    groups.into_iter().map(mean).collect()
}

/// Velocities relative to the streaming velocity, and relative to the centre of mass along axes with conserved
/// momentum. A single particle keeps its own velocity.
fn peculiar_velocities(sample: &Sample<'_>, system: &SystemDescription) -> Vec<Vector> {
    let both = sample.velocities.iter().zip(sample.positions);
    let mut velocities: Vec<Vector> =
        both.map(|(velocity, position)| velocity - system.streaming_velocity(position)).collect();
    if system.moving.len() > 1 {
        let common = system.common_velocity(&velocities);
        velocities.iter_mut().for_each(|velocity| *velocity -= common);
    }
    velocities
}

/// Each conserved component of the momentum removes one degree of freedom.
fn temperature(velocities: &[Vector], system: &SystemDescription) -> f64 {
    let moving = system.moving.iter().map(|&id| id as usize);
    let twice_kinetic: f64 = moving.map(|id| system.masses[id] * velocities[id].norm_squared()).sum();
    let count = system.moving.len();
    let taken = if count > 1 { system.axes().filter(|&axis| system.conserved_axes[axis]).count() } else { 0 };
    twice_kinetic / (system.space.dimensions() * count - taken).max(1) as f64
}

#[cfg(test)]
mod tests;
