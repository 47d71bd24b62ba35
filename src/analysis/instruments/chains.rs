//! Sizes of bonded molecules: bond lengths, end-to-end distances, radii of gyration.

mod report;
mod sizes;

use super::bins::Bins;
use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::quantity::Measured;
use super::system::{Sample, SystemDescription};
use crate::Vector;
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::CurveAverage;
use crate::base::numbers::id;
use crate::model::components::{Component, components};
use crate::model::measurement_plan as plan;
use crate::model::measurement_plan::BINS;
use crate::model::space::nearest_image;
use serde::{Deserialize, Serialize};

pub use sizes::CHAIN_SIZES;
pub(crate) use sizes::ChainSizes;

/// Largest number of kinds of molecules in the report.
const MOST_GROUPS: usize = 256;

/// Largest number of end-to-end distributions, one for each chain length. Short chains have priority.
const MOST_DISTRIBUTIONS: usize = 8;

/// Longest end-to-end distance in the distribution, in units of `sqrt(n) b` for `n` bonds of maximum length `b`. Fewer
/// than one random walk in a million is longer.
const LONGEST_WALK: f64 = 4.0;

/// Measures the lengths of bonds and the sizes of molecules. Nearest images unwrap a molecule, because bonds are
/// shorter than half a period.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Chains {
    times: SamplingTimes,
    bins: usize,
    bond_lengths: [f64; 2],
    groups: Vec<Group>,
    /// The mean length of a bond, the mean square length, and the probability density of the length in each bin.
    bonds: CurveAverage,
    /// Mean square end-to-end distance and mean square radius of gyration of each group.
    sizes: CurveAverage,
    /// Densities of the end-to-end distance: the bins of one group after the other.
    ends: CurveAverage,
    /// The molecules, which follow from the bonds of the scene.
    #[serde(skip)]
    components: Option<Vec<Component>>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Group {
    is_linear: bool,
    particles: u32,
    components: u32,
    /// Index of the distribution in [`Chains::ends`], and upper limit of the bins `[length]`.
    distribution: Option<(usize, f64)>,
}

impl Chains {
    pub fn new(plan: &plan::Chains, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let bins = Bins::planned(plan.bins, BINS);
        let components = components(system.species.len(), &system.bonds);
        let groups = groups(&components, system.bond_lengths[1]);
        let distributions = groups.iter().filter(|group| group.distribution.is_some()).count();
        Self {
            times: budgeted_times(setup, plan.interval, 50.0 * system.bonds.len() as f64),
            bins,
            bond_lengths: system.bond_lengths,
            bonds: CurveAverage::new(2 + bins),
            sizes: CurveAverage::new(2 * groups.len()),
            ends: CurveAverage::new(distributions * bins),
            groups,
            components: Some(components),
        }
    }

    fn bins_of_bonds(&self) -> Bins {
        let [shortest, longest] = self.bond_lengths;
        Bins::over(shortest, longest - shortest, self.bins)
    }

    fn sample_bonds(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let bins = self.bins_of_bonds();
        let periods = system.space.periods();
        let each = 1.0 / system.bonds.len() as f64;
        let density = bins.density(each);
        let mut values = vec![0.0; 2 + self.bins];
        for &[a, b] in &system.bonds {
            let separation = sample.positions[a as usize] - sample.positions[b as usize];
            let length = nearest_image(separation, &periods, sample.displacement).norm();
            values[0] += each * length;
            values[1] += each * length * length;
            // Round-off may put a bond length slightly outside of the range.
            let place = bins.place(length);
            if place > -1e-6 && place < self.bins as f64 * (1.0 + 1e-6) {
                values[2 + bins.nearest(length)] += density;
            }
        }
        self.bonds.add_all(values);
    }

    fn sample_components(&mut self, components: &[Component], sample: &Sample<'_>, system: &SystemDescription) {
        let mut sizes = vec![0.0; self.sizes.len()];
        let mut ends = vec![0.0; self.ends.len()];
        for component in components {
            let kind = (component.is_linear, component.ids.len());
            let is_its = |group: &Group| (group.is_linear, group.particles as usize) == kind;
            let Some(index) = self.groups.iter().position(is_its) else { continue };
            let group = &self.groups[index];
            let each = 1.0 / f64::from(group.components);
            let path = unwrapped(component, sample, system);
            let end_to_end = path.last().map_or(0.0, Vector::norm_squared);
            sizes[2 * index] += each * if group.is_linear { end_to_end } else { f64::NAN };
            sizes[2 * index + 1] += each * gyration(&path);
            if let Some((distribution, longest)) = group.distribution {
                let bins = Bins::over(0.0, longest, self.bins);
                if let Some(bin) = bins.index(end_to_end.sqrt()) {
                    ends[distribution * self.bins + bin] += bins.density(each);
                }
            }
        }
        self.sizes.add_all(sizes);
        self.ends.add_all(ends);
    }
}

impl Instrument for Chains {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) || system.bonds.is_empty() {
            return;
        }
        let components = self.components.take().unwrap_or_else(|| components(system.species.len(), &system.bonds));
        self.sample_bonds(sample, system);
        self.sample_components(&components, sample, system);
        self.components = Some(components);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        if !self.groups.is_empty() {
            self.report_bonds(system.bonds.len() as f64, measured);
            self.report_sizes(measured);
            self.report_ends(measured);
        }
    }
}

/// Groups molecules by kind and size. Linear molecules come first. Sizes increase within each kind.
fn groups(components: &[Component], longest_bond: f64) -> Vec<Group> {
    let mut kinds: Vec<(bool, u32)> =
        components.iter().map(|component| (!component.is_linear, id(component.ids.len()))).collect();
    kinds.sort_unstable();
    let group = |same: &[(bool, u32)]| Group {
        is_linear: !same[0].0,
        particles: same[0].1,
        components: id(same.len()),
        distribution: None,
    };
    let mut groups: Vec<Group> = kinds.chunk_by(|a, b| a == b).map(group).take(MOST_GROUPS).collect();
    let linear = groups.iter_mut().filter(|group| group.is_linear && longest_bond > 0.0);
    for (index, group) in linear.take(MOST_DISTRIBUTIONS).enumerate() {
        let bonds = f64::from(group.particles - 1);
        group.distribution = Some((index, longest_bond * bonds.min(LONGEST_WALK * bonds.sqrt())));
    }
    groups
}

fn unwrapped(component: &Component, sample: &Sample<'_>, system: &SystemDescription) -> Vec<Vector> {
    let periods = system.space.periods();
    component.path(sample.positions, |apart| nearest_image(apart, &periods, sample.displacement))
}

/// Square of the radius of gyration, `sum_i |r_i - mean r|^2 / n`.
fn gyration(path: &[Vector]) -> f64 {
    let count = path.len() as f64;
    let centre = path.iter().sum::<Vector>() / count;
    path.iter().map(|position| (position - centre).norm_squared()).sum::<f64>() / count
}

#[cfg(test)]
mod tests;
