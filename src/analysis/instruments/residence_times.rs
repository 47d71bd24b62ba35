//! Times between the entry and the exit of particles.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::bins::Bins;
use super::histogram::Histogram;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number};
use super::system::{Sample, SystemDescription};
use crate::analysis::statistics::{BlockAverage, CurveAverage, Estimate};
use crate::engine::event::{Event, EventKind, Other};
use crate::model::SpeciesId;
use crate::model::measurement_plan::{BINS, ResidenceTimes as Plan};

/// With more species than this, the species are not measured separately. A scene may have one species per diameter.
const MOST_SPECIES: usize = 20;

/// Elements of the averages from which the standard deviation follows.
const DIFFERENCE: usize = 0;
const SQUARE: usize = 1;

/// Residence times: the time of a particle between its entry at an inlet and its exit at an outlet.
///
/// A particle that returns to an inlet has a new id, and a new residence time begins. The time for which it waits outside
/// does not count. Particles from the start have no known entry, and are counted separately when they leave. Particles
/// that are still inside at the end do not count, and most of them would have long residence times. This makes the mean
/// too small by about `s^2 / t`, where `s` is the standard deviation and `t` the duration of the measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ResidenceTimes {
    /// Time of entry and species of each particle that has entered and has not left.
    inside: BTreeMap<u32, (f64, SpeciesId)>,
    /// Number of particles that have left and were in the system at the start.
    from_start: u64,
    all: Times,
    /// Empty with one moving species, or with more than [`MOST_SPECIES`].
    by_species: Vec<(SpeciesId, Times)>,
}

/// Statistics of residence times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Times {
    mean: BlockAverage,
    /// The first residence time. It is subtracted from all times, because the variance of small numbers has less round-off.
    first: f64,
    /// Averages of these differences and of their squares.
    differences: CurveAverage,
    histogram: Histogram,
}

impl Times {
    fn new(plan: &Plan) -> Self {
        Self {
            mean: BlockAverage::new(1.0),
            first: 0.0,
            differences: CurveAverage::new(2),
            histogram: Histogram::up_to(plan.longest, Bins::planned(plan.bins, BINS)),
        }
    }

    fn add(&mut self, time: f64) {
        if self.histogram.count == 0 {
            self.first = time;
        }
        let difference = time - self.first;
        self.mean.add(time, 1.0);
        self.differences.add_all([difference, difference * difference]);
        self.histogram.add(time);
    }

    /// Returns `s = sqrt(<t^2> - <t>^2)`. The error follows from the errors of the two means.
    fn standard_deviation(&self) -> Option<Estimate> {
        let (mean, square) = (self.differences.mean(DIFFERENCE)?, self.differences.mean(SQUARE)?);
        let deviation = (square - mean * mean).max(0.0).sqrt();
        let of_variance = self.differences.combination(&[(SQUARE, 1.0), (DIFFERENCE, -2.0 * mean)])?;
        let standard_error = of_variance.standard_error.filter(|_| deviation > 0.0);
        Some(Estimate { mean: deviation, standard_error: standard_error.map(|error| 0.5 * error / deviation) })
    }
}

impl ResidenceTimes {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let species: Vec<SpeciesId> = setup.system.moving_species().map(SpeciesId).collect();
        let are_told_apart = (2..=MOST_SPECIES).contains(&species.len());
        let by_species = species.into_iter().filter(|_| are_told_apart).map(|id| (id, Times::new(plan)));
        Self { inside: BTreeMap::new(), from_start: 0, all: Times::new(plan), by_species: by_species.collect() }
    }

    fn leave(&mut self, particle: u32, time: f64) {
        let Some((entry, species)) = self.inside.remove(&particle) else {
            self.from_start += 1;
            return;
        };
        let of_species = self.by_species.iter_mut().find(|(id, _)| *id == species).map(|(_, times)| times);
        of_species.into_iter().chain([&mut self.all]).for_each(|times| times.add(time - entry));
    }
}

impl Instrument for ResidenceTimes {
    fn next_sample(&self) -> f64 {
        f64::INFINITY
    }

    fn sample(&mut self, _: &Sample<'_>, _: &SystemDescription) {}

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event, _: &SystemDescription) {
        match (event.kind, event.other) {
            (EventKind::Entry, Other::Inlet { species, .. }) => {
                self.inside.insert(event.particle.0, (event.time, species));
            }
            (EventKind::Exit, _) => self.leave(event.particle.0, event.time),
            _ => {}
        }
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let named = |id: SpeciesId| system.species_names.get(id.0 as usize).map_or("", String::as_str);
        let by_species = self.by_species.iter().map(|(id, times)| (Some(named(*id)), times));
        for (species, times) in [(None, &self.all)].into_iter().chain(by_species) {
            report(species, times, measured);
        }
        let exact = |count: u64| Some(Estimate { mean: count as f64, standard_error: Some(0.0) });
        let mut number = |name: &str, title: &str, count: u64, method: &str| {
            measured.numbers.push(Number::estimated(name, title, "1", exact(count), method));
        };
        number("residence_time_from_start", "Exits without a known entry", self.from_start, FROM_START);
        number("residence_time_unfinished", "Entries without an exit so far", self.inside.len() as u64, UNFINISHED);
    }
}

fn report(species: Option<&str>, times: &Times, measured: &mut Measured) {
    let suffix = species.map_or_else(String::new, |species| format!("_{species}"));
    let of = species.map_or_else(String::new, |species| format!(" of {species}"));
    let count = Estimate { mean: times.histogram.count as f64, standard_error: Some(0.0) };
    for (name, title, unit, estimate, method) in [
        ("residence_time", "Mean residence time", "time", times.mean.estimate(), MEAN),
        (
            "residence_time_deviation",
            "Standard deviation of the residence time",
            "time",
            times.standard_deviation(),
            DEVIATION,
        ),
        ("residence_time_count", "Residence times measured", "1", Some(count), COUNT),
    ] {
        let (name, title) = (format!("{name}{suffix}"), format!("{title}{of}"));
        measured.numbers.push(Number::estimated(&name, &title, unit, estimate, method));
    }
    let (width, densities) = times.histogram.density();
    let centres = Bins::of_width(0.0, width, densities.len()).centres();
    let (name, title) = (format!("residence_times{suffix}"), format!("Distribution of residence times{of}"));
    measured.curves.push(
        Curve::new(&name, &title, DISTRIBUTION)
            .variable("t", "time", centres)
            .series("p(t)", "1 / time", &densities)
            .normalised(
                Normalisation::of("residence times in the bin")
                    .by("residence_times", "1", times.histogram.count as f64)
                    .by("bin_width", "time", width),
            ),
    );
}

const MEAN: &str = "Mean time between the entry of a particle at an inlet and its exit at an outlet, over the particles \
    that have entered and left during the measurement.";
const DEVIATION: &str = "s = sqrt(<t^2> - <t>^2) of the residence times t.";
const COUNT: &str = "Number of particles that have entered and left during the measurement.";
const FROM_START: &str = "Number of particles that have left during the measurement, but were in the system at its \
    start. They are not part of the residence times.";
const UNFINISHED: &str = "Number of particles that have entered during the measurement and are still in the system. \
    They are not part of the residence times.";
const DISTRIBUTION: &str = "p(t) = n / (N w) for n residence times in a bin of width w, out of all N residence times. \
    Without the key longest, the bins end at eight times the mean of the first residence times. Errors are computed as \
    for independent times.";

#[cfg(test)]
mod tests;
