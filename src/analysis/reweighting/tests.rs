use super::*;
use crate::model::random::{Purpose, Random};

const ENERGIES: [f64; 4] = [-3.0, -2.0, -1.0, 0.0];
const STATES: [f64; 4] = [1.0, 9.0, 44.0, 130.0];
const TEMPERATURES: [f64; 4] = [1.4, 0.8, 0.5, 0.35];

fn populations(temperature: f64) -> [f64; 4] {
    let weights: [f64; 4] = std::array::from_fn(|k| STATES[k] * (-ENERGIES[k] / temperature).exp());
    weights.map(|weight| weight / weights.iter().sum::<f64>())
}

/// Mean and variance of the energy, and the logarithm of the partition function.
fn exact(temperature: f64) -> [f64; 3] {
    let of = |power: i32| populations(temperature).iter().zip(ENERGIES).map(|(p, e)| p * e.powi(power)).sum::<f64>();
    let sum = STATES.iter().zip(ENERGIES).map(|(states, e)| states * (-e / temperature).exp()).sum::<f64>();
    [of(1), of(2) - of(1) * of(1), sum.ln()]
}

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 1e-11 * expected.abs().max(1.0)
}

#[test]
fn expected_counts_give_the_exact_density_of_states() {
    let samples = [1e4, 3e3, 2e4, 1e3];
    let count = |k: usize| (0..4).map(|at| samples[at] * populations(TEMPERATURES[at])[k]).sum::<f64>();
    let counts: Vec<f64> = (0..4).map(count).collect();
    let ensembles = Ensemble::canonical(&TEMPERATURES);
    let histogram = MultiHistogram { ensembles: &ensembles, samples: &samples, energies: &ENERGIES, counts: &counts };
    for start in [[0.0; 4], [0.0, -3.0, 50.0, -40.0]] {
        let density = histogram.solve(&start).unwrap();
        for (at, temperature) in TEMPERATURES.into_iter().enumerate() {
            let [first, here] = [TEMPERATURES[0], temperature].map(|t| exact(t)[2]);
            assert!(close(density.free_energies()[at], first - here), "{:?}", density.free_energies());
        }
        for temperature in [0.3, 0.35, 0.41, 0.77, 1.4, 3.0] {
            let ([mean, variance, _], found) = (exact(temperature), density.at(temperature));
            assert!(close(found.mean, mean) && close(found.variance, variance), "{temperature}: {found:?}");
        }
        let ratios: Vec<f64> = density.levels().zip(STATES).map(|((_, it), states)| it - states.ln()).collect();
        assert!(ratios.iter().all(|it| close(*it, ratios[0])), "{ratios:?}");
    }
}

/// MBAR over single samples, by fixed-point iteration of equation 11 of Shirts and Chodera.
fn mbar(temperatures: &[f64], energies: &[Vec<f64>]) -> Vec<f64> {
    let all: Vec<f64> = energies.concat();
    let samples: Vec<f64> = energies.iter().map(|it| it.len() as f64).collect();
    let mut free = vec![0.0; temperatures.len()];
    for _ in 0..20_000 {
        let denominator =
            |e: &f64| samples.iter().zip(&free).zip(temperatures).map(|((n, f), t)| n * (f - e / t).exp()).sum::<f64>();
        let denominators: Vec<f64> = all.iter().map(denominator).collect();
        let f = |t: &f64| -all.iter().zip(&denominators).map(|(e, d)| (-e / t).exp() / d).sum::<f64>().ln();
        free = temperatures.iter().map(f).collect();
        let first = free[0];
        free.iter_mut().for_each(|f| *f -= first);
    }
    free
}

fn histograms(temperatures: &[f64], rows: &[Vec<f64>]) -> EnergyHistograms {
    let mut levels = EnergyLevels::default();
    rows.iter().for_each(|row| levels.see(row));
    let mut histograms = EnergyHistograms::new(Ensemble::canonical(temperatures), levels, 0);
    rows.iter().for_each(|row| histograms.add(row, &[]));
    histograms
}

fn level(random: &mut Random, temperature: f64) -> f64 {
    let mut left = random.uniform();
    for (population, energy) in populations(temperature).into_iter().zip(ENERGIES) {
        left -= population;
        if left < 0.0 {
            return energy;
        }
    }
    ENERGIES[3]
}

/// Each sample repeats the previous sample with probability `p`, so the inefficiency is `(1 + p) / (1 - p)`.
fn sampled(seed: u64, count: usize, probability: f64) -> Vec<Vec<f64>> {
    let mut random = Random::new(seed, Purpose::Placement, 0);
    let mut row: Vec<f64> = TEMPERATURES.iter().map(|t| level(&mut random, *t)).collect();
    let mut next = || {
        for (energy, temperature) in row.iter_mut().zip(TEMPERATURES) {
            if random.uniform() >= probability {
                *energy = level(&mut random, temperature);
            }
        }
        row.clone()
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn histogram_reweighting_equals_mbar() {
    let mut random = Random::new(9, Purpose::Placement, 0);
    let rounded = sampled(1, 200, 0.0).into_iter().map(|row| row.iter().map(|e| e * (1.0 + 1e-15)).collect());
    let continuous = (0..200).map(|_| TEMPERATURES.iter().map(|t| 1.5 * t * random.exponential()).collect());
    for rows in [rounded.collect::<Vec<Vec<f64>>>(), continuous.collect()] {
        let reweighting = Reweighting::new(&histograms(&TEMPERATURES, &rows), 1).unwrap();
        let energies: Vec<Vec<f64>> = (0..4).map(|at| rows.iter().map(|row| row[at]).collect()).collect();
        let expected = mbar(&TEMPERATURES, &energies);
        for (found, expected) in reweighting.density().free_energies().iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-10, "{:?} {expected:?}", reweighting.density().free_energies());
        }
    }
}

#[test]
fn binned_energies_keep_their_moments() {
    // Six harmonic coordinates: <U> = 3 T, and the variance is 3 T^2.
    let mut random = Random::new(2, Purpose::Placement, 0);
    let mut harmonic = |t: &f64| t * (0..3).map(|_| random.exponential()).sum::<f64>();
    let rows: Vec<Vec<f64>> = (0..20_000).map(|_| TEMPERATURES.iter().map(&mut harmonic).collect()).collect();
    let histograms = histograms(&TEMPERATURES, &rows);
    assert_eq!(histograms.levels(), 4096);
    let reweighting = Reweighting::new(&histograms, 1).unwrap();
    let temperatures = [0.36, 0.6, 1.0, 1.3];
    let found = reweighting.estimates(|density| {
        let moments = temperatures.map(|t| density.at(t));
        moments.iter().zip(temperatures).flat_map(|(it, t)| [it.mean / t, it.variance / (t * t)]).collect()
    });
    for estimate in found {
        let deviation = (estimate.mean - 3.0) / estimate.standard_error.unwrap();
        assert!(deviation.abs() < 3.5 && estimate.standard_error.unwrap() < 0.06, "{estimate:?}");
    }
}

#[test]
fn bootstrap_errors_match_the_scatter_over_seeds() {
    let temperatures = [0.37, 0.5, 0.63, 1.0];
    let expected: Vec<f64> = temperatures.iter().flat_map(|t| [exact(*t)[0], exact(*t)[1]]).collect();
    // Independent rows, correlated rows, and strongly correlated rows with few blocks.
    for (count, probability, tolerance) in [(400, 0.0, 0.25), (3000, 0.8, 0.25), (1200, 0.95, 0.35)] {
        let mut squares = vec![0.0; expected.len()];
        let mut seeds = 0.0;
        for seed in 0..48 {
            let rows = sampled(seed, count, probability);
            let reweighting = Reweighting::new(&histograms(&TEMPERATURES, &rows), seed).unwrap();
            let moments = |density: &DensityOfStates| {
                temperatures.iter().map(|t| density.at(*t)).flat_map(|it| [it.mean, it.variance]).collect()
            };
            let found = reweighting.estimates(moments);
            let Some(errors) = found.iter().map(|it| it.standard_error).collect::<Option<Vec<f64>>>() else { continue };
            seeds += 1.0;
            for (place, (it, error)) in found.iter().zip(errors).enumerate() {
                squares[place] += ((it.mean - expected[place]) / error).powi(2);
            }
        }
        assert!(seeds >= 40.0, "{seeds}");
        let ratios: Vec<f64> = squares.iter().map(|it| (it / seeds).sqrt()).collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        println!("{count} {probability}: {mean:.3} {ratios:.2?} of {seeds}");
        assert!((mean - 1.0).abs() < tolerance, "{count}, {probability}: {mean} {ratios:?}");
    }
}

#[test]
fn errors_repeat_and_follow_from_the_seed() {
    let histograms = histograms(&TEMPERATURES, &sampled(1, 300, 0.3));
    let of = |seed| Reweighting::new(&histograms, seed).unwrap().estimates(|density| vec![density.at(0.6).mean]);
    assert_eq!(of(1), of(1));
    assert_ne!(of(1)[0].standard_error, of(2)[0].standard_error);
    assert_eq!(of(1)[0].mean, of(2)[0].mean);
}

#[test]
fn missing_overlap_gives_no_curves_and_short_series_no_errors() {
    let rows: Vec<Vec<f64>> = (0..100).map(|k| vec![-50.0 + f64::from(k % 2), f64::from(k % 3)]).collect();
    assert!(Reweighting::new(&histograms(&[0.1, 5.0], &rows), 1).is_none());
    assert!(
        Reweighting::new(&EnergyHistograms::new(Ensemble::canonical(&[0.1, 5.0]), EnergyLevels::default(), 0), 1)
            .is_none()
    );
    let few = Reweighting::new(&histograms(&TEMPERATURES, &sampled(1, 7, 0.0)), 1).unwrap();
    assert_eq!(few.estimates(|density| vec![density.at(0.6).mean])[0].standard_error, None);
    let same = Reweighting::new(&histograms(&[0.5, 1.0], &vec![vec![-2.0, -2.0]; 50]), 1).unwrap();
    let found = same.estimates(|density| vec![density.at(0.7).mean, density.at(0.7).variance]);
    assert!(found.iter().all(|it| it.standard_error == Some(0.0)), "{found:?}");
    assert_eq!([found[0].mean, found[1].mean], [-2.0, 0.0]);
}

#[test]
fn other_quantities_follow_from_their_means_in_the_levels() {
    let (values, mut random) = ([7.0, -1.0, 3.0, 0.5], Random::new(8, Purpose::Placement, 0));
    let rows = sampled(4, 4000, 0.3);
    let mut levels = EnergyLevels::default();
    rows.iter().for_each(|row| levels.see(row));
    let mut histograms = EnergyHistograms::new(Ensemble::canonical(&TEMPERATURES), levels, 2);
    for row in &rows {
        let mut both = |e: &f64| {
            let level = ENERGIES.iter().position(|it| it == e).unwrap();
            [values[level] + random.uniform() - 0.5, e * e]
        };
        histograms.add(row, &row.iter().flat_map(&mut both).collect::<Vec<f64>>());
    }
    let reweighting = Reweighting::new(&histograms, 1).unwrap();
    for temperature in [0.36, 0.6, 1.1] {
        let found = reweighting.estimates(|density| density.means_at(temperature));
        let exact = |of: [f64; 4]| populations(temperature).iter().zip(of).map(|(p, x)| p * x).sum::<f64>();
        for (it, expected) in found.iter().zip([exact(values), exact(ENERGIES.map(|e| e * e))]) {
            let error = it.standard_error.unwrap();
            assert!((it.mean - expected).abs() < 3.5 * error && error < 0.1, "{it:?}, expected {expected}");
        }
        let moments = reweighting.density().at(temperature);
        assert!(close(found[1].mean, moments.variance + moments.mean * moments.mean));
    }
}
