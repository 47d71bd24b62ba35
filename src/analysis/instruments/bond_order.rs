//! Bond-orientational order, which compares the neighbours of a particle with the neighbours in a crystal.
//!
//! P. J. Steinhardt, D. R. Nelson and M. Ronchetti, Phys. Rev. B 28, 784 (1983),
//! [doi:10.1103/PhysRevB.28.784](https://doi.org/10.1103/PhysRevB.28.784).

mod harmonics;

use super::bins::Bins;
use super::budgeted_times::budgeted_times;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Normalisation, Number, Scalar};
use super::radial_distribution::shortened;
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::CurveAverage;
use crate::base::text::digits;
use crate::engine::CellList;
use crate::model::measurement_plan as plan;
use crate::model::measurement_plan::BINS;
use harmonics::Harmonics;
use serde::{Deserialize, Serialize};
use std::ops::Range;

const DEGREES: [usize; 2] = [6, 4];

/// Returns `q_l` of each particle, in the order of ids. In two dimensions, returns `|psi_l|`.
///
/// `q_l = sqrt(4 pi / (2 l + 1) sum_m |q_lm|^2)`, where `q_lm` is the mean of `Y_lm` over the directions to all
/// neighbours. `psi_l` is the mean of `exp(i l phi)`. Neighbours are moving particles closer than `cutoff` `[length]`,
/// which is at most half of the shortest period. The value is 0 for static particles, for particles without neighbours,
/// in one dimension, and for a degree of 0 or above 8.
#[must_use]
pub fn per_particle(system: &SystemDescription, sample: &Sample<'_>, cutoff: f64, degree: usize) -> Vec<f64> {
    let mut values = vec![0.0; system.species.len()];
    if let Some(harmonics) = Harmonics::new(degree, &system.axes().collect::<Vec<_>>()) {
        let cells = cell_list(system, sample, cutoff);
        cells.for_each_particle(|id, separations| {
            let mut sums = vec![0.0; harmonics.count()];
            separations.iter().for_each(|separation| harmonics.add(separation, &mut sums));
            values[id as usize] = length(&sums, separations.len()).unwrap_or(0.0);
        });
    }
    values
}

pub(super) fn scalars(plan: &plan::BondOrder, system: &SystemDescription, sample: &Sample<'_>) -> Vec<Scalar> {
    let Some(symbol) = symbol(system) else { return Vec::new() };
    let cutoff = cutoff(plan, system);
    let scalar =
        |degree| Scalar { name: format!("{symbol}{degree}"), values: per_particle(system, sample, cutoff, degree) };
    DEGREES.map(scalar).into()
}

fn symbol(system: &SystemDescription) -> Option<&'static str> {
    match system.space.dimensions() {
        3 => Some("q"),
        2 => Some("psi"),
        _ => None,
    }
}

fn cutoff(plan: &plan::BondOrder, system: &SystemDescription) -> f64 {
    let diameters = system.moving.iter().map(|&id| system.diameter_of(id));
    let cutoff = plan.cutoff.unwrap_or_else(|| 1.4 * diameters.fold(0.0, f64::max));
    cutoff.min(CellList::largest_range(&system.space))
}

pub(crate) fn shortened_cutoff(plan: &plan::BondOrder, system: &SystemDescription) -> Option<String> {
    plan.cutoff.and_then(|asked| shortened([asked, cutoff(plan, system)], &system.space, None))
}

fn cell_list(system: &SystemDescription, sample: &Sample<'_>, cutoff: f64) -> CellList {
    let range = cutoff.min(CellList::largest_range(&system.space));
    sample.cell_list(&system.space, range, &system.moving)
}

/// Length of the mean of `count` vectors, from their sum.
fn length(sums: &[f64], count: usize) -> Option<f64> {
    (count > 0).then(|| sums.iter().map(|sum| sum * sum).sum::<f64>().sqrt() / count as f64)
}

/// Measures the distribution, mean and global value of `q_6` and `q_4`; in two dimensions of `psi_6` and `psi_4`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct BondOrder {
    times: SamplingTimes,
    asked: f64,
    cutoff: f64,
    bins: usize,
    /// Holds the number of neighbours, then for each degree the mean order, the global order and the density in each
    /// bin.
    curve: CurveAverage,
}

impl BondOrder {
    pub fn new(plan: &plan::BondOrder, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let cutoff = cutoff(plan, system);
        let bins = Bins::planned(plan.bins, BINS);
        let count = system.moving.len() as f64;
        let cube = (0..system.space.dimensions()).fold(1.0, |product, _| product * 3.0 * cutoff);
        // A candidate takes about three operations, and a neighbour 150. One candidate in six is a neighbour.
        let work = count * (100.0 + 30.0 * (count * cube / system.space.volume()).min(count));
        Self {
            times: budgeted_times(setup, plan.interval, work),
            asked: plan.cutoff.unwrap_or(cutoff),
            cutoff,
            bins,
            curve: CurveAverage::new(1 + DEGREES.len() * (2 + bins)),
        }
    }

    fn note(&self, system: &SystemDescription) -> String {
        shortened([self.asked, self.cutoff], &system.space, None).map_or_else(String::new, |why| format!(" ({why})"))
    }

    fn bins(&self) -> Bins {
        Bins::over(0.0, 1.0, self.bins)
    }

    /// Index in `curve` of the mean order of a degree.
    fn first(&self, degree: usize) -> usize {
        1 + degree * (2 + self.bins)
    }

    fn densities(&self, degree: usize) -> Range<usize> {
        let first = self.first(degree) + 2;
        first..first + self.bins
    }
}

impl Instrument for BondOrder {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) {
            return;
        }
        let bins = self.bins();
        let axes: Vec<usize> = system.axes().collect();
        let orders: Vec<Harmonics> = DEGREES.iter().filter_map(|&degree| Harmonics::new(degree, &axes)).collect();
        let mut of_all: Vec<Vec<f64>> = orders.iter().map(|harmonics| vec![0.0; harmonics.count()]).collect();
        let mut of_one = of_all.clone();
        let mut values = vec![0.0; self.curve.len()];
        let (mut bonds, mut bonded) = (0, 0.0_f64);
        cell_list(system, sample, self.cutoff).for_each_particle(|_, separations| {
            bonds += separations.len();
            bonded += f64::from(u8::from(!separations.is_empty()));
            for (index, harmonics) in orders.iter().enumerate() {
                of_one[index].fill(0.0);
                separations.iter().for_each(|separation| harmonics.add(separation, &mut of_one[index]));
                of_all[index].iter_mut().zip(&of_one[index]).for_each(|(all, one)| *all += one);
                if let Some(order) = length(&of_one[index], separations.len()) {
                    let first = self.first(index);
                    values[first] += order;
                    values[first + 2 + bins.nearest(order)] += bins.density(1.0);
                }
            }
        });
        // The order of a particle without neighbours is undefined, so means exclude these particles.
        values[1..].iter_mut().for_each(|value| *value /= bonded);
        values[0] = bonds as f64 / system.moving.len() as f64;
        for (index, sums) in of_all.iter().enumerate() {
            values[self.first(index) + 1] = length(sums, bonds).unwrap_or(f64::NAN);
        }
        self.curve.add_all(values);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let Some(symbol) = symbol(system) else { return };
        let global = match symbol {
            "q" => "sqrt(4 pi / (2 l + 1) sum_m |q_lm|^2), where q_lm is the mean of Y_lm",
            _ => "|mean of exp(i l phi)|",
        };
        let neighbours = format!("neighbours closer than {}{}", digits(self.cutoff), self.note(system));
        let mut number = |name: &str, title: &str, element: usize, method: &str| {
            measured.numbers.push(Number::estimated(name, title, "1", self.curve.estimate(element), method));
        };
        number("neighbours", "Number of neighbours", 0, &format!("mean number of {neighbours}"));
        // Each sample was normalised by the number of particles that had neighbours at this time.
        let normalisation = Normalisation::of(
            "fraction of particles in the bin, among the particles with neighbours, over all samples",
        )
        .by("samples", "1", self.curve.most())
        .by("bin_width", "1", self.bins().width());
        let method = format!(
            "probability density of {symbol}_l = {global} over the {neighbours}, among particles that have any"
        );
        let mut curve = Curve::new("bond_order", "Distribution of the bond order of particles", &method).variable(
            symbol,
            "1",
            self.bins().centres(),
        );
        for (index, degree) in DEGREES.iter().enumerate() {
            let (first, name) = (self.first(index), format!("{symbol}{degree}"));
            let one = format!("{name} = {global} over the {neighbours}");
            let method = format!("{one}, averaged over the particles that have neighbours");
            number(&name, &format!("Bond order {name}"), first, &method);
            let method = format!("{one}, with a single mean over the neighbours of all particles");
            number(&format!("{name}_global"), &format!("Global bond order {name}"), first + 1, &method);
            curve = curve
                .series(&format!("p({name})"), "1", &self.curve.estimates(self.densities(index)))
                .normalised(normalisation.clone());
        }
        measured.curves.push(curve);
    }
}

#[cfg(test)]
mod tests;
