//! Spectral density of a series at frequency zero: the variance of its mean, times the length of the series.

use std::f64::consts::TAU;
use std::ops::Range;

const STEPS: usize = 150;

/// Slowest relaxation time in the fit, as a fraction of the length of the series. Slower motion looks like a trend.
const SLOWEST: f64 = 1.0 / 12.0;

/// Slowest relaxation time in the fit to changes of a quantity, as a fraction of the length of the series.
const SLOWEST_DIFFERENCE: f64 = 1.0 / 50.0;

/// Components for the changes of a correlated quantity must increase the logarithm of the likelihood by at least this.
/// With a lower limit, one standard error in a few hundred would be far too small.
const LEAST_GAIN: f64 = 6.0;

/// Fastest relaxation time in the fit, as a number of values. Faster relaxations look like white noise.
const FASTEST: f64 = 0.5;

/// Ratio of successive relaxation times in the fit.
const RATIO: f64 = 1.5;

/// Minimum number of frequencies to distinguish the changes of an uncorrelated quantity from other noise.
const FEWEST_FOR_DIFFERENCES: usize = 20;

/// Exponent of the prior `S(0)^(-PRIOR)`, where `S(0)` is the spectral density at frequency zero. Non-negative weights
/// always fit some noise, and the prior offsets this.
const PRIOR: f64 = 0.5;

/// If the slowest relaxation of the fit has more than this fraction of the variance, the series is too short.
const MOST_IN_SLOWEST: f64 = 0.6;

/// Shares of the slowest relaxation in the density, between which the doubt rises from 1 to [`MOST_DOUBT`].
const DOUBTFUL: [f64; 2] = [0.5, 0.7];

/// Largest factor that enlarges the estimate, because slow motion may be slower than it seems. The value was chosen
/// with the test `claimed_errors_are_honest_where_noise_hides_slow_motion`.
const MOST_DOUBT: f64 = 3.0;

/// Number of lowest frequencies that are fitted one by one. To save time, higher frequencies are fitted in groups.
const ONE_BY_ONE: usize = 32;
const IN_A_GROUP: usize = 16;

/// The estimated density at frequency zero is raised to at least [`LEAST`] times the mean power at the [`LOWEST`]
/// lowest frequencies. White noise is affected once in 10,000 cases.
const LOWEST: usize = 6;
const LEAST: f64 = 0.3;

/// If the lowest frequency has more than this fraction of the power, the series is an oscillation or a drift.
const MOST_IN_ONE_SWING: f64 = 0.5;

/// Lower limit for powers and densities, in units of the variance. It prevents divisions by zero.
const NOTHING: f64 = 1e-12;

#[cfg(test)]
thread_local! {
    /// Number of fits in this thread. Tests count them, because a fit takes thousands of times longer than a mean.
    pub(super) static FITS: std::cell::Cell<u64> = const { std::cell::Cell::new(0) };
}

/// The spectral density at frequency zero, in units of the variance of the series.
#[derive(Debug, Clone, Copy)]
pub(super) struct Density {
    /// The most likely density; 1 if the values of the series are independent.
    pub at_zero: f64,
    /// Ratio of a safe upper estimate of the density to `at_zero`, between 1 and [`MOST_DOUBT`].
    pub doubt: f64,
}

#[derive(Clone)]
struct Part {
    /// Spectral density of the component with a weight of 1, averaged over each group of frequencies.
    density: Vec<f64>,
    at_zero: f64,
    weight: f64,
}

/// Returns the spectral density at frequency zero from the deviations of a series. `None` if the series is too short.
///
/// The periodogram at the lower half of the frequencies `w` is modelled as a sum of
/// - white noise, `1`;
/// - relaxations `exp(-k / t)` with about a dozen relaxation times `t`, up to a twelfth of the series. Their density is
///   `(1 - r)^2 / (1 - 2 r cos w + r^2)` with `r = exp(-1 / t)`;
/// - changes of an uncorrelated quantity between successive values, `1 - cos w`;
/// - if the likelihood increases enough, changes of a correlated quantity, `2 (1 - cos w) S(w)`. A single
///   relaxation has `S = (1 - r^2) / (1 - 2 r cos w + r^2)`, a double one
///   `S = (1 - r^2)^3 / ((1 + r^2) (1 - 2 r cos w + r^2)^2)`. The virial of a crystal and the momentum between two
///   walls behave like this. The variance of the mean of `n` changes is `2 / n^2` times the variance of the quantity.
///
/// The weights are the most likely non-negative weights (P. Whittle, Ark. Mat. 2, 423 (1953)): the values of a
/// periodogram are independent and exponentially distributed about the spectral density. Each step of the fit
/// multiplies each weight by the square root of a ratio of gradients and increases the likelihood: C. Févotte and J.
/// Idier, Neural Comput. 23, 2421 (2011), [doi:10.1162/NECO_a_00168](https://doi.org/10.1162/NECO_a_00168).
pub(super) fn density_at_zero(deviations: &[f64], variance: f64) -> Option<Density> {
    #[cfg(test)]
    FITS.set(FITS.get() + 1);
    let n = deviations.len();
    let count = (n / 4).max(8.min(n / 2));
    let (cosines, periodogram) = periodogram(deviations, variance, count);
    // The total power, over the positive and negative frequencies, equals the number of values.
    if 2.0 * periodogram[0] > MOST_IN_ONE_SWING * n as f64 {
        return None;
    }
    let groups = groups(count);
    let powers = Powers {
        sizes: groups.iter().map(|group| group.len() as f64).collect(),
        sums: groups.iter().map(|group| periodogram[group.clone()].iter().sum()).collect(),
    };
    let (mut parts, likelihood) = fit(parts(n, &cosines, &groups), &powers);
    if cosines.len() >= FEWEST_FOR_DIFFERENCES {
        let mut more = parts.clone();
        more.extend(lasting_differences(n, &cosines, &groups));
        let (more, likelier) = fit(more, &powers);
        if likelier > likelihood + LEAST_GAIN {
            parts = more;
        }
    }
    let mut doubt = 1.0;
    if let Some((index, variance)) = slowest(n) {
        let weight = parts[index].weight;
        if weight * variance > MOST_IN_SLOWEST {
            return None;
        }
        // The doubt depends on the share in the density, not in the variance, because fast noise adds to the variance.
        let part = (weight / at_zero(&parts) - DOUBTFUL[0]) / (DOUBTFUL[1] - DOUBTFUL[0]);
        doubt += (MOST_DOUBT - 1.0) * part.clamp(0.0, 1.0);
    }
    let lowest = periodogram.iter().take(LOWEST).sum::<f64>() / LOWEST as f64;
    Some(Density { at_zero: at_zero(&parts).max(LEAST * lowest), doubt })
}

/// Powers of a periodogram, summed over groups of frequencies.
struct Powers {
    sizes: Vec<f64>,
    sums: Vec<f64>,
}

/// Returns the components with their most likely weights, and the logarithm of the likelihood.
fn fit(mut parts: Vec<Part>, Powers { sizes, sums }: &Powers) -> (Vec<Part>, f64) {
    let total: f64 = sums.iter().sum();
    for part in &mut parts {
        part.weight = total / dot(&part.density, sizes);
    }
    let mut spectrum = vec![0.0; sizes.len()];
    let (mut shares, mut excess) = (spectrum.clone(), spectrum.clone());
    let add_up = |parts: &[Part], spectrum: &mut [f64]| {
        spectrum.fill(0.0);
        for part in parts {
            spectrum.iter_mut().zip(&part.density).for_each(|(sum, density)| *sum += part.weight * density);
        }
    };
    for _ in 0..STEPS {
        add_up(&parts, &mut spectrum);
        for (group, model) in spectrum.iter().enumerate() {
            shares[group] = sizes[group] / model;
            excess[group] = sums[group] / (model * model);
        }
        let at_zero = at_zero(&parts);
        for part in &mut parts {
            let down = dot(&part.density, &shares) + PRIOR * part.at_zero / at_zero;
            part.weight *= (dot(&part.density, &excess) / down).sqrt();
        }
    }
    add_up(&parts, &mut spectrum);
    let of_group = |((model, size), sum): ((&f64, &f64), &f64)| -size * libm::log(*model) - sum / model;
    let likelihood = spectrum.iter().zip(sizes).zip(sums).map(of_group).sum();
    (parts, likelihood)
}

fn groups(count: usize) -> Vec<Range<usize>> {
    let mut groups: Vec<Range<usize>> = (0..count.min(ONE_BY_ONE)).map(|k| k..k + 1).collect();
    let mut from = groups.len();
    while from < count {
        let to = (from + from / IN_A_GROUP).min(count);
        groups.push(from..to);
        from = to;
    }
    groups
}

/// Four partial sums let the processor compute in parallel.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (four_a, four_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = four_a.remainder().iter().zip(four_b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in four_a.zip(four_b) {
        (0..4).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

fn at_zero(parts: &[Part]) -> f64 {
    parts.iter().map(|part| part.weight * part.at_zero).sum::<f64>().max(NOTHING)
}

/// Cosines of the lowest angular frequencies, and the power at each, in units of the variance.
fn periodogram(deviations: &[f64], variance: f64, count: usize) -> (Vec<f64>, Vec<f64>) {
    let n = deviations.len();
    let turns: Vec<(f64, f64)> = (0..n).map(|k| libm::sincos(TAU * k as f64 / n as f64)).collect();
    let power = |frequency: usize| {
        let (mut sine, mut cosine, mut angle) = (0.0, 0.0, 0);
        for x in deviations {
            sine += x * turns[angle].0;
            cosine += x * turns[angle].1;
            angle += frequency;
            angle -= if angle >= n { n } else { 0 };
        }
        ((sine * sine + cosine * cosine) / (n as f64 * variance)).max(NOTHING)
    };
    (turns[1..=count].iter().map(|(_, cosine)| *cosine).collect(), (1..=count).map(power).collect())
}

fn part(at_zero: f64, cosines: &[f64], groups: &[Range<usize>], density: impl Fn(f64) -> f64) -> Part {
    let mean = |group: &Range<usize>| {
        cosines[group.clone()].iter().map(|cosine| density(*cosine)).sum::<f64>() / group.len() as f64
    };
    Part { density: groups.iter().map(mean).collect(), at_zero, weight: 0.0 }
}

/// Components of a series of `n` values: white noise, relaxations, and changes of an uncorrelated quantity.
fn parts(n: usize, cosines: &[f64], groups: &[Range<usize>]) -> Vec<Part> {
    let mut parts = vec![part(1.0, cosines, groups, |_| 1.0)];
    let mut time = SLOWEST * n as f64;
    while time >= FASTEST {
        let r = libm::exp(-1.0 / time);
        let density = |cosine: f64| (1.0 - r) * (1.0 - r) / (1.0 - 2.0 * r * cosine + r * r);
        parts.push(part(1.0, cosines, groups, density));
        time /= RATIO;
    }
    if cosines.len() >= FEWEST_FOR_DIFFERENCES {
        parts.push(part(0.0, cosines, groups, |cosine| 1.0 - cosine));
    }
    parts
}

/// Components for the changes of a correlated quantity, with a single and a double relaxation for each time. The
/// difference between the last and the first value adds `2 / n` to the density at all frequencies.
fn lasting_differences(n: usize, cosines: &[f64], groups: &[Range<usize>]) -> Vec<Part> {
    let ends = 2.0 / n as f64;
    let mut parts = Vec::new();
    let mut time = SLOWEST_DIFFERENCE * n as f64;
    while time >= FASTEST {
        let r = libm::exp(-1.0 / time);
        let rest = 1.0 - r * r;
        let turned = |cosine: f64| 1.0 - 2.0 * r * cosine + r * r;
        let of = |density: &dyn Fn(f64) -> f64| {
            part(ends, cosines, groups, |cosine| ends + 2.0 * (1.0 - cosine) * density(cosine))
        };
        parts.push(of(&|cosine| rest / turned(cosine)));
        parts.push(of(&|cosine| rest * rest * rest / ((1.0 + r * r) * turned(cosine) * turned(cosine))));
        time /= RATIO;
    }
    parts
}

/// Index of the component with the slowest relaxation, and its variance at a weight of 1. `None` for short series.
fn slowest(n: usize) -> Option<(usize, f64)> {
    let time = SLOWEST * n as f64;
    let r = libm::exp(-1.0 / time);
    (time >= FASTEST).then(|| (1, (1.0 - r) / (1.0 + r)))
}
