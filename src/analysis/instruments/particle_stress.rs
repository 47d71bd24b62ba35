//! Stress that contacts exert on each particle.

use std::collections::BTreeMap;

use super::bins::Bins;
use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::momentum_flow::{COMPONENTS, Tensor, trace};
use super::quantity::{Curve, Measured, Normalisation, Number, Scalar};
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::{BlockAverage, CurveAverage};
use crate::engine::event::{Event, EventKind};
use crate::model::measurement_plan::{BINS, ParticleStress as Plan};
use crate::model::scene::own_volume;
use crate::model::space::AXES;
use serde::{Deserialize, Serialize};

/// Name of the column of the contact pressures in the frames of a trajectory.
pub(crate) const CONTACT_PRESSURE: &str = "contact_pressure";

/// Beginning of the names of the columns of the contact stresses.
pub(crate) const CONTACT_STRESS: &str = "contact_stress_";

/// Largest pressure in the distribution, relative to the mean of all particles.
const LARGEST: f64 = 10.0;

/// Contact stress of each particle, averaged over intervals.
///
/// The mean stress inside a particle of volume `V` is `sum r_a J_b / (V t)`, positive in compression, over the contacts
/// of an interval of length `t`. `J` is the impulse on the particle, and `r` points from the contact to its centre.
/// The contact divides the line between two centres in the ratio of the diameters. The stress is symmetrised. It does
/// not include the motion of the particle, `m v_a v_b`.
///
/// Weber, Bull. Liais. Ponts Chauss. 20, 3-1 (1966); Goldenberg and Goldhirsch, Phys. Rev. Lett. 89, 084302 (2002),
/// [doi:10.1103/PhysRevLett.89.084302](https://doi.org/10.1103/PhysRevLett.89.084302).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct ParticleStress {
    times: SamplingTimes,
    bins: usize,
    since: f64,
    /// Diameters of the particles that are present, by id; empty if particles neither enter nor leave `[length]`.
    present: Vec<(u32, f64)>,
    current: Sums,
    /// Mean stress of each particle in the last complete interval.
    latest: Sums,
    pressure: BlockAverage,
    deviation: BlockAverage,
    distribution: CurveAverage,
}

/// Tensors of the particles that had contacts, by id.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(from = "Vec<(u32, Tensor)>", into = "Vec<(u32, Tensor)>")]
struct Sums(BTreeMap<u32, Tensor>);

impl From<Vec<(u32, Tensor)>> for Sums {
    fn from(entries: Vec<(u32, Tensor)>) -> Self {
        Self(entries.into_iter().collect())
    }
}

impl From<Sums> for Vec<(u32, Tensor)> {
    fn from(Sums(tensors): Sums) -> Self {
        tensors.into_iter().collect()
    }
}

impl Sums {
    /// Adds `r_a J_b / V`, symmetrised. `r` is the line from the other centre, or from the surface, times `share`, which
    /// includes the factor `1 / V`. Both particles of a pair have the same sign, because both `r` and `J` change their
    /// signs.
    fn add(&mut self, particle: u32, share: f64, event: &Event) {
        let (line, impulse) = (event.normal * (event.distance * share), event.impulse);
        let tensor = self.0.entry(particle).or_default();
        for (sum, [a, b]) in tensor.iter_mut().zip(COMPONENTS) {
            *sum += 0.5 * (line[a] * impulse[b] + line[b] * impulse[a]);
        }
    }

    fn of(&self, particle: u32) -> Tensor {
        self.0.get(&particle).copied().unwrap_or_default()
    }
}

impl ParticleStress {
    pub fn new(plan: &Plan, setup: &Setup<'_>) -> Self {
        let bins = Bins::planned(plan.bins, BINS);
        Self {
            // A sample takes some fifty operations per particle.
            times: budgeted_times(setup, plan.interval, 50.0 * setup.system.species.len() as f64),
            bins,
            since: setup.sample.time,
            present: present(&setup.sample, setup.system),
            current: Sums::default(),
            latest: Sums::default(),
            pressure: BlockAverage::new(1.0),
            deviation: BlockAverage::new(1.0),
            distribution: CurveAverage::new(bins),
        }
    }

    fn bins(&self) -> Bins {
        Bins::over(0.0, LARGEST, self.bins)
    }

    fn close_interval(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let duration = sample.time - self.since;
        if duration <= 0.0 {
            return;
        }
        self.since = sample.time;
        let (mut sums, dimensions) = (std::mem::take(&mut self.current), system.space.dimensions());
        let mut pressures = Vec::new();
        let mut latest = BTreeMap::new();
        for (id, species) in sample.ids.iter().zip(sample.species) {
            let species = species.0 as usize;
            let tensor = sums.0.remove(&id.0);
            let stress = tensor.unwrap_or_default().map(|sum| sum / duration);
            if system.species_masses[species].is_finite() {
                pressures.push(trace(&stress) / dimensions as f64);
            }
            if tensor.is_some() {
                latest.insert(id.0, stress);
            }
        }
        self.latest = Sums(latest);
        self.present = present(sample, system);
        self.add(&pressures);
    }

    fn diameter(&self, particle: u32, system: &SystemDescription) -> f64 {
        if !system.has_flow {
            return system.diameter_of(particle);
        }
        let place = self.present.binary_search_by_key(&particle, |(id, _)| *id);
        place.map_or(1.0, |place| self.present[place].1)
    }

    /// Adds the pressures of the moving particles.
    fn add(&mut self, pressures: &[f64]) {
        if pressures.is_empty() {
            return;
        }
        let count = pressures.len() as f64;
        let mean = pressures.iter().sum::<f64>() / count;
        self.pressure.add(mean, 1.0);
        // Without contacts, there is nothing to compare with.
        if mean > 0.0 {
            let difference = pressures.iter().map(|pressure| pressure - mean);
            let square = difference.map(|difference| difference * difference).sum::<f64>() / count;
            self.deviation.add(square.sqrt() / mean, 1.0);
            let bins = self.bins();
            let mut densities = vec![0.0; bins.count];
            for bin in pressures.iter().filter_map(|pressure| bins.index(pressure / mean)) {
                densities[bin] += bins.density(1.0 / count);
            }
            self.distribution.add_all(densities);
        }
    }
}

fn present(sample: &Sample<'_>, system: &SystemDescription) -> Vec<(u32, f64)> {
    let all = sample.ids.iter().enumerate().filter(|_| system.has_flow);
    all.map(|(index, id)| (id.0, system.diameter_in(sample, index))).collect()
}

/// Pressure and stress of each particle in the last complete interval. They are zero before the first interval ends, and
/// for particles without contacts.
pub(super) fn scalars(stress: Option<&ParticleStress>, sample: &Sample<'_>, system: &SystemDescription) -> Vec<Scalar> {
    let of = |id: u32| stress.map(|stress| stress.latest.of(id)).unwrap_or_default();
    let column = |name: &str, value: &dyn Fn(&Tensor) -> f64| {
        Scalar::new(name, sample.ids.iter().map(|id| value(&of(id.0))).collect())
    };
    let dimensions = system.space.dimensions() as f64;
    let mut columns = vec![column(CONTACT_PRESSURE, &|stress| trace(stress) / dimensions)];
    for (index, [a, b]) in COMPONENTS.into_iter().enumerate() {
        if system.axes().filter(|axis| *axis == a || *axis == b).count() == usize::from(a != b) + 1 {
            columns.push(column(&format!("{CONTACT_STRESS}{}{}", AXES[a], AXES[b]), &|stress| stress[index]));
        }
    }
    columns
}

impl Instrument for ParticleStress {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if self.times.is_due(sample.time) {
            self.close_interval(sample, system);
        }
    }

    fn has_events(&self) -> bool {
        true
    }

    fn event(&mut self, event: &Event, system: &SystemDescription) {
        let dimensions = system.space.dimensions();
        match (event.kind, event.partner()) {
            (EventKind::Pair(_), Some(partner)) => {
                let ids = [event.particle, partner].map(|id| id.0);
                let diameters = ids.map(|id| self.diameter(id, system));
                for (id, diameter) in ids.into_iter().zip(diameters) {
                    let share = diameter / (diameters[0] + diameters[1]);
                    self.current.add(id, share / own_volume(diameter, dimensions), event);
                }
            }
            (EventKind::Surface, _) => {
                let volume = own_volume(self.diameter(event.particle.0, system), dimensions);
                self.current.add(event.particle.0, 1.0 / volume, event);
            }
            // New ids are larger than all others.
            (EventKind::Entry, _) if system.has_flow => self.present.push((event.particle.0, event.distance)),
            _ => {}
        }
    }

    fn report(&self, _: &SystemDescription, measured: &mut Measured) {
        let mut number = |name: &str, title: &str, unit: &str, average: &BlockAverage, method: &str| {
            measured.numbers.push(Number::estimated(name, title, unit, average.estimate(), method));
        };
        let unit = "energy / length^D";
        number("contact_pressure", "Contact pressure of a particle", unit, &self.pressure, PRESSURE);
        let title = "Relative deviation of the contact pressures";
        number("contact_pressure_deviation", title, "1", &self.deviation, DEVIATION);
        let intervals = self.distribution.most();
        measured.curves.push(
            Curve::new("contact_pressures", "Distribution of the contact pressures of particles", DISTRIBUTION)
                .variable("p / mean p", "1", self.bins().centres())
                .series("P(p / mean p)", "1", &self.distribution.estimates(0..self.bins))
                .normalised(
                    Normalisation::of(
                        "fraction of the moving particles in the bin, over the intervals with a positive mean",
                    )
                    .by("intervals", "1", intervals)
                    .by("bin_width", "1", self.bins().width()),
                ),
        );
    }
}

const PRESSURE: &str = "Trace of sum r_a J_b / (V t) divided by the dimension, for a particle of volume V with the \
    impulses J at a distance r from its centre in an interval of length t; mean over the moving particles and the \
    intervals.";
const DEVIATION: &str = "Standard deviation of the contact pressures of the moving particles in an interval, divided by \
    their mean; over the intervals with a positive mean.";
const DISTRIBUTION: &str = "Probability density of the contact pressures in an interval, divided by their mean, for the \
    moving particles, over the intervals with a positive mean. The density of larger values than the last is not shown.";

#[cfg(test)]
mod tests;
