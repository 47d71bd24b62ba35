//! The potential of mean force along a distance, from all windows of an exchange.

use std::convert::Infallible;

use serde::Deserialize;

use super::execute::ExchangeRecorder;
use super::replicas::{Exchange, ExchangeRow};
use crate::analysis::reweighting::{DensityOfStates, EnergyHistograms, EnergyLevels, Reweighting};
use crate::analysis::statistics::Estimate;

/// Free energies in a bin of the distance.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[non_exhaustive]
pub struct MeanForcePoint {
    /// Middle of the bin `[length]`.
    pub distance: f64,
    /// Width of the bin `[length]`.
    pub width: f64,
    /// Free energy, `F(r) = -T ln(p(r) / p_0)` `[energy]`. Here `p(r)` is the probability density of the distance, and
    /// `p_0` is the mean of `p` in the last window.
    pub free_energy: Estimate,
    /// Potential of mean force, `w(r) = -T ln(n(r) / n_0)` `[energy]`. Here `n(r)` is the probability density per unit
    /// volume. It is proportional to `p(r) / r^(D - 1)` in `D` dimensions. `n_0` is the mean of `n` in the last window.
    pub potential_of_mean_force: Estimate,
}

impl MeanForcePoint {
    /// Returns the point with the lowest free energy, selected by `of`. Points with an error estimate are preferred.
    #[must_use]
    pub fn lowest(points: &[Self], of: fn(&Self) -> Estimate) -> Option<&Self> {
        points.get(lowest(points.iter().map(of))?)
    }
}

/// The potential of mean force along the distance of an exchange between windows,
/// [`ExchangeEnsemble::Umbrella`](crate::model::ExchangeEnsemble::Umbrella).
///
/// Within each window, the probability density of the distance is proportional to the density without windows. The
/// equations of [`MultiHistogram`](crate::analysis::reweighting::MultiHistogram) determine the factors, with an energy
/// of zero inside the window and infinity outside. [`Reweighting`] determines the errors.
///
/// S. Kumar, J. M. Rosenberg, D. Bouzida, R. H. Swendsen and P. A. Kollman, J. Comput. Chem. 13, 1011 (1992),
/// [doi:10.1002/jcc.540130812](https://doi.org/10.1002/jcc.540130812).
#[doc(alias = "WHAM")]
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct MeanForce {
    /// Points of all visited bins, by ascending distance. Empty if some windows share too few distances.
    pub points: Vec<MeanForcePoint>,
    /// Whether some windows share too few distances with the other windows.
    pub is_torn: bool,
}

/// Distances in the windows of an exchange, kept in memory. Use this recorder for exchanges without a folder.
#[derive(Debug, Clone, Default)]
pub struct Distances {
    rows: Vec<Vec<f64>>,
}

impl ExchangeRecorder for Distances {
    type Error = Infallible;

    fn row(&mut self, row: &ExchangeRow<'_>) -> Result<(), Infallible> {
        self.rows.push(row.distances().collect());
        Ok(())
    }
}

impl Distances {
    /// Distances in all windows, for each recorded attempt `[length]`.
    #[must_use]
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Computes the potential of mean force from the recorded distances.
    #[must_use]
    pub fn mean_force(&self, exchange: &Exchange) -> MeanForce {
        let visit = |see: &mut dyn FnMut(&[f64])| {
            self.rows.iter().for_each(|row| see(row));
            Ok::<(), Infallible>(())
        };
        MeanForce::of(exchange, visit).unwrap_or_else(|none| match none {})
    }
}

impl MeanForce {
    /// Computes the potential. `visit` goes through the distances in all windows at all attempts. It is called twice:
    /// first for the visited bins, then for the histograms.
    pub(super) fn of<E>(
        exchange: &Exchange,
        mut visit: impl FnMut(&mut dyn FnMut(&[f64])) -> Result<(), E>,
    ) -> Result<Self, E> {
        let Some(umbrella) = &exchange.plan().umbrella else { return Ok(Self::default()) };
        let edges = umbrella.edges();
        let mut bins = EnergyLevels::of_bins(&edges[..edges.len() - 1]);
        visit(&mut |row| bins.see(row))?;
        let mut histograms = EnergyHistograms::new(exchange.ensembles(), bins, 0);
        visit(&mut |row| histograms.add(row, &[]))?;
        let [_, dimensions] = exchange.size();
        let found = Reweighting::new(&histograms, exchange.scene().seed());
        let last = umbrella.windows.last().copied().unwrap_or_default();
        let points =
            found.map(|reweighting| points(&reweighting, (&edges, last), exchange.temperatures()[0], dimensions));
        Ok(Self { is_torn: points.is_none() && !histograms.is_empty(), points: points.unwrap_or_default() })
    }
}

/// Returns the index of the lowest estimate. Estimates without an error are ignored if any estimate has an error.
fn lowest(all: impl Iterator<Item = Estimate>) -> Option<usize> {
    let by = |a: &Estimate, b: &Estimate| {
        let is_vague = |it: &Estimate| it.standard_error.is_none();
        is_vague(a).cmp(&is_vague(b)).then(a.mean.total_cmp(&b.mean))
    };
    all.enumerate().min_by(|(_, a), (_, b)| by(a, b)).map(|(place, _)| place)
}

/// Returns the free energies of all bins, relative to the last window. A single bin would be a noisy reference, and the
/// lowest bin would be a biased reference.
fn points(
    reweighting: &Reweighting,
    (edges, last): (&[f64], [f64; 2]),
    temperature: f64,
    dimensions: f64,
) -> Vec<MeanForcePoint> {
    // Volume of the spherical shell of a bin, up to a constant factor.
    let volume = |pair: &[f64]| (libm::pow(pair[1], dimensions) - libm::pow(pair[0], dimensions)) / dimensions;
    let is_last = |pair: &[f64]| last[0] <= pair[0] && pair[1] <= last[1];
    let of_bins = |size: &dyn Fn(&[f64]) -> f64| -> Vec<Estimate> {
        let sizes: Vec<f64> = edges.windows(2).map(|pair| libm::log(size(pair))).collect();
        let whole = libm::log(edges.windows(2).filter(|pair| is_last(pair)).map(size).sum());
        reweighting.estimates(|density: &DensityOfStates| {
            let logarithms: Vec<f64> = density.levels().map(|(_, logarithm)| logarithm).collect();
            let of_last = edges.windows(2).zip(&logarithms).filter(|(pair, _)| is_last(pair)).map(|(_, it)| *it);
            let largest = of_last.clone().fold(f64::NEG_INFINITY, f64::max);
            let all = largest + libm::log(of_last.map(|it| libm::exp(it - largest)).sum());
            let zero = temperature * (whole - all);
            logarithms.iter().zip(&sizes).map(|(logarithm, size)| temperature * (size - logarithm) - zero).collect()
        })
    };
    let (free_energies, potentials) = (of_bins(&|pair| pair[1] - pair[0]), of_bins(&volume));
    let point = |((pair, free_energy), potential_of_mean_force): ((&[f64], Estimate), Estimate)| MeanForcePoint {
        distance: 0.5 * (pair[0] + pair[1]),
        width: pair[1] - pair[0],
        free_energy,
        potential_of_mean_force,
    };
    let all = edges.windows(2).zip(free_energies).zip(potentials).map(point);
    all.filter(|point| point.free_energy.mean.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::reweighting::Ensemble;
    use crate::model::random::{Purpose, Random};

    /// The density in the ball is constant, so the potentials of the bins differ only by noise.
    #[test]
    fn flat_tail_of_mean_force_is_zero() {
        let edges: Vec<f64> = (0..=20).map(|k| f64::from(k) / 20.0).collect();
        let (mut tails, mut squares) = (Vec::new(), 0.0);
        for seed in 0..12 {
            let mut random = Random::new(seed, Purpose::Volume, 0);
            let distances: Vec<f64> = (0..4000).map(|_| libm::cbrt(random.uniform())).collect();
            let mut bins = EnergyLevels::of_bins(&edges[..20]);
            distances.iter().for_each(|distance| bins.see(&[*distance]));
            let mut histograms = EnergyHistograms::new(vec![Ensemble::Window { ends: [0.0, 1.0] }], bins, 0);
            distances.iter().for_each(|distance| histograms.add(&[*distance], &[]));
            let all = points(&Reweighting::new(&histograms, 1).unwrap(), (&edges, [0.5, 1.0]), 0.8, 3.0);
            let tail: Vec<Estimate> = all.iter().rev().take(10).map(|point| point.potential_of_mean_force).collect();
            squares += tail.iter().map(|it| (it.mean / it.standard_error.unwrap()).powi(2)).sum::<f64>() / 120.0;
            tails.push(tail.iter().map(|it| it.mean).sum::<f64>() / 10.0);
        }
        let mean = tails.iter().sum::<f64>() / 12.0;
        // With the lowest bin as reference, the mean would be too high by about 0.07.
        assert!(mean.abs() < 0.01, "{tails:?}");
        assert!((0.5..1.6).contains(&squares), "the errors agree with the scatter: {squares}");
    }

    #[test]
    fn bin_with_one_sample_does_not_remove_errors_of_others() {
        let edges = [0.0, 0.005, 0.2, 0.4, 0.6, 0.8, 1.0];
        let mut random = Random::new(1, Purpose::Volume, 0);
        let mut distances: Vec<f64> = (0..2000).map(|_| 0.05 + 0.95 * random.uniform()).collect();
        distances[700] = 0.002;
        let mut bins = EnergyLevels::of_bins(&edges[..6]);
        distances.iter().for_each(|distance| bins.see(&[*distance]));
        let mut histograms = EnergyHistograms::new(vec![Ensemble::Window { ends: [0.0, 1.0] }], bins, 0);
        distances.iter().for_each(|distance| histograms.add(&[*distance], &[]));
        let all = points(&Reweighting::new(&histograms, 1).unwrap(), (&edges, [0.0, 1.0]), 0.8, 3.0);
        let potential = |place: usize| all[place].potential_of_mean_force;
        // The first bin contains one sample in a very small shell, so its potential is low and has no error estimate.
        assert!(potential(0).mean < 0.0 && potential(0).standard_error.is_none());
        assert!(
            (1..6)
                .all(|place| potential(place).standard_error.is_some()
                    && all[place].free_energy.standard_error.is_some())
        );
        let lowest = MeanForcePoint::lowest(&all, |point| point.potential_of_mean_force).unwrap();
        assert!(lowest.distance > 0.005, "{lowest:?}");
    }
}
