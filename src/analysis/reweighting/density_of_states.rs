//! The density of states determined jointly by the energies of several ensembles.

use super::ensemble::Ensemble;

/// Largest numbers of Newton steps and of halvings of a step. Usually a few are enough.
const MOST_STEPS: usize = 100;
const MOST_HALVINGS: u32 = 30;

/// The iteration stops after a Newton step below this size. The remaining error is about the square of the step.
const LAST_STEP: f64 = 1e-9;

/// Relative round-off error of the minimised function.
const ROUNDING: f64 = 1e-12;

/// Minimum number of samples that two groups of ensembles share. With `n` shared samples, the difference of their
/// reduced free energies has a variance of `1 / n`.
const LEAST_SHARED: f64 = 1.0;

/// Histogram of the potential energy over all samples of several ensembles, for example at several temperatures.
#[derive(Debug, Clone, Copy)]
pub struct MultiHistogram<'h> {
    /// The ensembles.
    pub ensembles: &'h [Ensemble],
    /// Number of samples of each ensemble.
    pub samples: &'h [f64],
    /// The energy levels `[energy]`.
    pub energies: &'h [f64],
    /// Number of samples of all ensembles in each level.
    pub counts: &'h [f64],
}

/// The density of states of the potential energy, `g(E)`, up to a factor, from the samples of all ensembles.
///
/// The ensemble `k` has `N_k` samples, and configurations of energy `E` have the weight `exp(-u_k(E))` in this
/// ensemble. In a canonical ensemble, `u_k(E) = E / T_k`. If all ensembles together have `H(E)` samples in the level
/// `E`, the density of states is `g(E) = H(E) / sum_k N_k exp(f_k - u_k(E))` with the free energies
/// `exp(-f_k) = sum_E g(E) exp(-u_k(E))`.
///
/// This is the multi-histogram method: A. M. Ferrenberg and R. H. Swendsen, Phys. Rev. Lett. 63, 1195 (1989),
/// [doi:10.1103/PhysRevLett.63.1195](https://doi.org/10.1103/PhysRevLett.63.1195). With one level for each energy, as
/// for stepped potentials, it is the estimator MBAR: M. R. Shirts and J. D. Chodera, J. Chem. Phys. 129, 124105 (2008),
/// [doi:10.1063/1.2978177](https://doi.org/10.1063/1.2978177).
#[doc(alias = "WHAM")]
#[doc(alias = "MBAR")]
#[derive(Debug, Clone, PartialEq)]
pub struct DensityOfStates {
    energies: Vec<f64>,
    variances: Vec<f64>,
    /// Logarithm of the density of states of each level; minus infinity for a level without samples.
    logarithms: Vec<f64>,
    free_energies: Vec<f64>,
    means: Vec<Vec<f64>>,
}

/// Moments of the potential energy in the canonical ensemble.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Logarithm of the configurational partition function, `ln sum_E g(E) exp(-E / T)`, up to a constant.
    pub log_partition: f64,
    /// Mean of the energy, `<U>` `[energy]`.
    pub mean: f64,
    /// Variance of the energy, `<(U - <U>)^2>` `[energy^2]`.
    pub variance: f64,
}

/// The minimised function and its derivatives with respect to all free energies except the first.
struct Expansion {
    value: f64,
    gradient: Vec<f64>,
    /// Lower triangle of the matrix of second derivatives, row by row.
    hessian: Vec<Vec<f64>>,
}

impl MultiHistogram<'_> {
    /// Solves the equations by Newton's method from a start near the solution. The solution minimises the convex
    /// function `sum_E H(E) ln sum_k N_k exp(f_k - u_k(E)) - sum_k N_k f_k`.
    ///
    /// `None` if there are no samples, or if some ensembles share no energies with the rest.
    #[must_use]
    pub fn solve(&self, start: &[f64]) -> Option<DensityOfStates> {
        let first = start.first()?;
        let reduced = self.reduced_energies();
        let mut free_energies: Vec<f64> = start.iter().map(|f| f - first).collect();
        let mut here = self.expansion(&reduced, &free_energies);
        for _ in 0..MOST_STEPS {
            let (mut step, is_determined) = downhill(here.hessian, &here.gradient);
            let length = step.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let (mut next, mut there) = self.beyond(&reduced, &free_energies, &step);
            for _ in 0..MOST_HALVINGS {
                if there.value <= here.value + ROUNDING * here.value.abs() {
                    break;
                }
                step.iter_mut().for_each(|x| *x *= 0.5);
                (next, there) = self.beyond(&reduced, &free_energies, &step);
            }
            (free_energies, here) = (next, there);
            if length <= LAST_STEP {
                return is_determined.then(|| self.density(&reduced, free_energies));
            }
        }
        None
    }

    /// Estimates free energies from the mean energies `<U>`. Between canonical ensembles, the estimate is the
    /// trapezoidal rule for `df / d(1/T) = <U>`. Between other ensembles, the free energy does not change.
    #[must_use]
    pub fn start(ensembles: &[Ensemble], means: &[f64]) -> Vec<f64> {
        let mut free_energies = vec![0.0; ensembles.len().min(1)];
        let mut last = 0.0;
        for (pair, means) in ensembles.windows(2).zip(means.windows(2)) {
            if let [Ensemble::Canonical { temperature: one }, Ensemble::Canonical { temperature: other }] = pair {
                last += 0.5 * (means[0] + means[1]) * (other.recip() - one.recip());
            }
            free_energies.push(last);
        }
        free_energies
    }

    /// For each level `E`, the exponents `u_k(E)` of all ensembles `k`.
    fn reduced_energies(&self) -> Vec<Vec<f64>> {
        let of = |energy: &f64| self.ensembles.iter().map(|ensemble| ensemble.reduced_energy(*energy)).collect();
        self.energies.iter().map(of).collect()
    }

    fn beyond(&self, reduced: &[Vec<f64>], free_energies: &[f64], step: &[f64]) -> (Vec<f64>, Expansion) {
        let steps = std::iter::once(0.0).chain(step.iter().copied());
        let next: Vec<f64> = free_energies.iter().zip(steps).map(|(f, step)| f + step).collect();
        let expansion = self.expansion(reduced, &next);
        (next, expansion)
    }

    /// Returns `ln N_k + f_k` for each ensemble `k` with `N_k` samples.
    fn offsets(&self, free_energies: &[f64]) -> Vec<f64> {
        self.samples.iter().zip(free_energies).map(|(samples, f)| libm::log(*samples) + f).collect()
    }

    fn expansion(&self, reduced: &[Vec<f64>], free_energies: &[f64]) -> Expansion {
        let count = free_energies.len();
        let offsets = self.offsets(free_energies);
        let mut terms = vec![0.0; count];
        let mut value = -self.samples.iter().zip(free_energies).map(|(samples, f)| samples * f).sum::<f64>();
        let mut gradient: Vec<f64> = self.samples.iter().skip(1).map(|samples| -samples).collect();
        let mut hessian: Vec<Vec<f64>> = (1..count).map(|length| vec![0.0; length]).collect();
        for (reduced, samples) in reduced.iter().zip(self.counts).filter(|(_, samples)| **samples > 0.0) {
            let sum = fill(&offsets, reduced, &mut terms);
            value += samples * sum;
            // For each ensemble `k`, the probability that a sample of this level comes from `k`.
            terms.iter_mut().for_each(|term| *term = libm::exp(*term - sum));
            for (row, own) in terms[1..].iter().enumerate().filter(|(_, own)| **own > 0.0) {
                gradient[row] += samples * own;
                hessian[row].iter_mut().zip(&terms[1..]).for_each(|(it, other)| *it -= samples * own * other);
                hessian[row][row] += samples * own;
            }
        }
        Expansion { value, gradient, hessian }
    }

    fn density(&self, reduced: &[Vec<f64>], free_energies: Vec<f64>) -> DensityOfStates {
        let offsets = self.offsets(&free_energies);
        let mut terms = vec![0.0; free_energies.len()];
        let logarithm = |(reduced, samples): (&Vec<f64>, &f64)| {
            let sum = fill(&offsets, reduced, &mut terms);
            if *samples > 0.0 { libm::log(*samples) - sum } else { f64::NEG_INFINITY }
        };
        let logarithms = reduced.iter().zip(self.counts).map(logarithm).collect();
        let energies = self.energies.to_vec();
        DensityOfStates { variances: vec![0.0; energies.len()], energies, logarithms, free_energies, means: Vec::new() }
    }
}

impl DensityOfStates {
    /// A known density of states, from ascending energies `[energy]` and the logarithms of their densities.
    #[must_use]
    pub fn of_levels(levels: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (energies, logarithms): (Vec<f64>, Vec<f64>) = levels.into_iter().unzip();
        let variances = vec![0.0; energies.len()];
        Self { energies, variances, logarithms, free_energies: Vec::new(), means: Vec::new() }
    }

    /// Sets the variance of the energies within each level, `[energy^2]`.
    #[must_use]
    pub fn with_variances(mut self, variances: &[f64]) -> Self {
        self.variances = variances.to_vec();
        self
    }

    /// Sets the mean in each level of all quantities that were measured along with the energies.
    #[must_use]
    pub fn with_means(mut self, means: Vec<Vec<f64>>) -> Self {
        self.means = means;
        self
    }

    /// Configurational free energies `f_k`, divided by the temperatures, relative to the first ensemble.
    #[must_use]
    pub fn free_energies(&self) -> &[f64] {
        &self.free_energies
    }

    /// Energies of the levels, and logarithms of the density of states. Levels without samples have minus infinity.
    pub fn levels(&self) -> impl Iterator<Item = (f64, f64)> {
        self.energies.iter().copied().zip(self.logarithms.iter().copied())
    }

    /// Probabilities of the levels at a temperature `[energy]`: `g(E) exp(-E / T) / sum_E g(E) exp(-E / T)`.
    #[must_use]
    pub fn probabilities_at(&self, temperature: f64) -> Vec<f64> {
        let (mut weights, sum, _) = self.weights(temperature);
        weights.iter_mut().for_each(|weight| *weight /= sum);
        weights
    }

    /// Weights `g(E) exp(-E / T)` divided by the largest weight, the sum of these ratios, and the logarithm of the
    /// largest weight.
    fn weights(&self, temperature: f64) -> (Vec<f64>, f64, f64) {
        let exponents = || self.levels().map(|(energy, logarithm)| logarithm - energy / temperature);
        let most = exponents().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = exponents().map(|exponent| libm::exp(exponent - most)).collect();
        let sum = weights.iter().sum();
        (weights, sum, most)
    }

    /// Means of the quantities measured along with the energies, at a temperature `[energy]`: `<A> = sum_E
    /// <A>_E g(E) exp(-E / T) / sum_E g(E) exp(-E / T)`, with the mean `<A>_E` in each level.
    #[must_use]
    pub fn means_at(&self, temperature: f64) -> Vec<f64> {
        let (weights, sum, _) = self.weights(temperature);
        let mean = |of: &Vec<f64>| weights.iter().zip(of).map(|(weight, mean)| weight * mean).sum::<f64>() / sum;
        self.means.iter().map(mean).collect()
    }

    /// Moments of the potential energy at a temperature `[energy]`.
    #[must_use]
    pub fn at(&self, temperature: f64) -> Moments {
        let (weights, sum, most) = self.weights(temperature);
        let mean = weights.iter().zip(&self.energies).map(|(weight, energy)| weight * energy).sum::<f64>() / sum;
        let square = |(energy, variance): (&f64, &f64)| (energy - mean) * (energy - mean) + variance;
        let squares = self.energies.iter().zip(&self.variances).map(square);
        let variance = weights.iter().zip(squares).map(|(weight, square)| weight * square).sum::<f64>() / sum;
        Moments { log_partition: most + libm::log(sum), mean, variance }
    }
}

/// Writes `ln N_k + f_k - u_k(E)` into `terms` and returns the logarithm of the sum of their exponentials.
fn fill(offsets: &[f64], reduced: &[f64], terms: &mut [f64]) -> f64 {
    for ((term, offset), reduced) in terms.iter_mut().zip(offsets).zip(reduced) {
        *term = offset - reduced;
    }
    log_sum(terms)
}

fn log_sum(terms: &[f64]) -> f64 {
    let most = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + libm::log(terms.iter().map(|term| libm::exp(term - most)).sum())
}

/// Calculates the Newton step by Cholesky decomposition, from the lower triangle of `matrix`. Also returns whether the
/// samples determine the step. The step always goes downhill.
fn downhill(mut matrix: Vec<Vec<f64>>, gradient: &[f64]) -> (Vec<f64>, bool) {
    let count = gradient.len();
    let mut is_determined = true;
    for row in 0..count {
        let (done, rest) = matrix.split_at_mut(row);
        let own = &mut rest[0];
        for (column, other) in done.iter().enumerate() {
            let sum: f64 = own[..column].iter().zip(&other[..column]).map(|(a, b)| a * b).sum();
            own[column] = (own[column] - sum) / other[column];
        }
        let pivot = own[row] - own[..row].iter().map(|x| x * x).sum::<f64>();
        is_determined &= pivot >= LEAST_SHARED;
        own[row] = pivot.max(LEAST_SHARED).sqrt();
    }
    let mut step = vec![0.0; count];
    for row in 0..count {
        let sum: f64 = matrix[row][..row].iter().zip(&step).map(|(a, b)| a * b).sum();
        step[row] = (-gradient[row] - sum) / matrix[row][row];
    }
    for row in (0..count).rev() {
        let sum: f64 = (row + 1..count).map(|below| matrix[below][row] * step[below]).sum();
        step[row] = (step[row] - sum) / matrix[row][row];
    }
    (step, is_determined)
}
