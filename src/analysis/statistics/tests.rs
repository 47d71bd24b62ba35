use super::*;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// Returns an autoregressive series `x' = rho x + noise`, with uniform noise of variance 1/12.
pub fn correlated(rho: f64, length: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut x = 0.0;
    let mut next = || {
        let noise = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        x = rho * x + noise;
        x
    };
    (0..1000).for_each(|_| {
        next();
    });
    (0..length).map(|_| next()).collect()
}

#[test]
fn only_finite_means_and_errors_remain() {
    let of = |mean, standard_error| Estimate { mean, standard_error };
    for estimate in [of(2.5, None), of(-2.5, Some(0.0)), of(f64::MAX, Some(0.5))] {
        assert_eq!(estimate.finite(), Some(estimate));
    }
    for not_finite in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(of(2.5, Some(not_finite)).finite(), Some(of(2.5, None)), "{not_finite}");
        for error in [None, Some(0.5), Some(not_finite)] {
            assert_eq!(of(not_finite, error).finite(), None, "{not_finite} {error:?}");
        }
    }
}

#[test]
fn the_error_of_a_correlated_series_is_that_of_theory() {
    // The variance of the mean of a long AR(1) series is `s^2 / (n (1 - rho)^2)`, with the variance `s^2` of the noise.
    for (rho, seed) in [(-0.5, 1), (0.0, 2), (0.5, 3), (0.9, 4)] {
        let (n, count) = (1000, 40);
        let error = |seed| standard_error(&correlated(rho, n, seed)).unwrap();
        let mean = (100 * seed..100 * seed + count).map(error).sum::<f64>() / count as f64;
        let exact = (1.0 / 12.0_f64).sqrt() / ((1.0 - rho) * (n as f64).sqrt());
        // The mean of forty errors is uncertain by 2.6 %. The bounds also cover a bias of 12 % and Student's factor.
        assert!((0.92..1.21).contains(&(mean / exact)), "rho {rho}: {mean} but {exact}");
    }
}

#[test]
fn anticorrelated_noise_reduces_the_error() {
    // With white noise e, the mean of x_k = e_(k+1) - 0.6 e_k has 0.4 times the error of the mean of e. For independent
    // values with the variance of x, the factor would be 1.17.
    let (n, count) = (200, 60);
    let error = |seed| {
        let noise = correlated(0.0, n + 1, seed);
        standard_error(&noise.windows(2).map(|two| two[1] - 0.6 * two[0]).collect::<Vec<_>>()).unwrap()
    };
    let mean = (3000..3000 + count).map(error).sum::<f64>() / count as f64;
    let exact = 0.4 * (1.0 / 12.0 / n as f64).sqrt();
    // The mean of sixty errors is uncertain by 3 %. The bounds also allow for a bias of up to 15 %.
    assert!((0.9..1.25).contains(&(mean / exact)), "{mean} but {exact}");
}

#[test]
fn bounded_quantity_adds_no_error_to_its_rate() {
    // Each value is the change of a relaxing or oscillating quantity, plus weak white noise.
    let (n, count) = (400_usize, 100);
    let noise = |seed: u64| correlated(0.0, n, 70_000 + seed);
    let relaxing = |seed: u64| correlated(0.8, n + 1, seed);
    let swinging = |seed: u64| -> Vec<f64> {
        let (mut a, mut b) = (0.0, 0.0);
        let (sine, cosine) = libm::sincos(0.4);
        let turned = correlated(0.0, n + 201, seed).into_iter().zip(correlated(0.0, n + 201, 80_000 + seed));
        let turned = turned.map(|(x, y)| {
            (a, b) = (0.93 * (cosine * a - sine * b) + x, 0.93 * (sine * a + cosine * b) + y);
            a
        });
        turned.skip(200).collect()
    };
    for (what, quantity) in [("relaxing", &relaxing as &dyn Fn(u64) -> Vec<f64>), ("swinging", &swinging)] {
        let series = |seed: u64| -> Vec<f64> {
            quantity(seed).windows(2).zip(noise(seed)).map(|(two, noise)| two[1] - two[0] + 0.1 * noise).collect()
        };
        let all: Vec<Vec<f64>> = (5000..5000 + count).map(series).collect();
        let means = all.iter().map(|series| series.iter().sum::<f64>() / n as f64);
        let scatter = (means.map(|mean| mean * mean).sum::<f64>() / count as f64).sqrt();
        let errors = all.iter().map(|series| standard_error(series).unwrap());
        let claimed = (errors.map(|error| error * error).sum::<f64>() / count as f64).sqrt();
        // With 100 seeds, the scatter is known to 7 %. The bounds 0.8 and 1.25 are widened by three times 7 %.
        assert!((0.63..1.5).contains(&(scatter / claimed)), "{what}: {}", scatter / claimed);
    }
}

#[test]
fn few_independent_values_have_the_error_of_students_distribution() {
    // Half-width of the central 68.27 % of Student's t, with 7, 10, 20 and 100 degrees of freedom.
    for (freedom, exact) in [(7.0, 1.0767), (10.0, 1.0526), (20.0, 1.0257), (100.0, 1.0050)] {
        assert!((student(freedom) - exact).abs() < 1e-3, "{freedom}: {}", student(freedom));
    }
}

#[test]
fn slow_motion_is_seen_under_fast_noise() {
    // The slow motion has a tenth of the variance, but causes two thirds of the squared error of the mean.
    let (n, count) = (400, 60);
    let series = |seed: u64| -> Vec<f64> {
        let noise = correlated(0.0, n, 9000 + seed);
        correlated(0.9, n, seed).iter().zip(noise).map(|(slow, fast)| slow + 7.0 * fast).collect()
    };
    let error = |seed| standard_error(&series(seed)).unwrap();
    let mean = (4000..4000 + count).map(error).sum::<f64>() / count as f64;
    let exact = ((100.0 + 49.0) / 12.0 / n as f64).sqrt();
    assert!((0.85..1.15).contains(&(mean / exact)), "{mean} but {exact}");
}

pub fn fits() -> u64 {
    spectrum::FITS.get()
}

#[test]
fn mean_without_error_needs_no_spectral_fit() {
    let mut average = BlockAverage::new(1.0);
    assert_eq!(average.mean(), None);
    correlated(0.5, 100, 1).iter().for_each(|&x| average.add(x, 1.0));
    let before = fits();
    let mean = average.mean().unwrap();
    assert_eq!(fits(), before);
    assert_eq!(average.estimate().unwrap().mean, mean);
    assert_eq!(fits(), before + 1);
    average.ratio(&average).unwrap();
    assert_eq!(fits(), before + 1, "what is constant, one over one, has no spectrum");
}

#[test]
fn a_ratio_to_zero_is_unknown_and_not_stationary() {
    let (mut zero, mut some) = (BlockAverage::new(1.0), BlockAverage::new(1.0));
    for x in correlated(0.0, 100, 3) {
        zero.add(0.0, 1.0);
        some.add(1.0 + x, 1.0);
    }
    for average in [&zero, &some] {
        assert_eq!(average.stationarity_of_ratio(&zero), Stationarity::Unknown);
        assert_eq!(average.ratio(&zero), None);
    }
    assert_eq!(zero.stationarity_of_ratio(&some), Stationarity::Constant);
}

/// `noise` is the amplitude of the white noise relative to the noise that drives the series.
pub fn under_noise(rho: f64, length: usize, noise: f64, seed: u64) -> Vec<f64> {
    let slow = correlated(rho, length, seed);
    slow.iter().zip(correlated(0.0, length, 500_000 + seed)).map(|(slow, fast)| slow + noise * fast).collect()
}

#[test]
fn claimed_errors_are_honest_where_noise_hides_slow_motion() {
    // The slow part has 3 to 15 independent values and 2 to 70 % of the variance.
    for (rho, n, noise) in
        [(0.98, 300, 6.0), (0.98, 400, 12.0), (0.97, 200, 2.0), (0.98, 512, 12.0), (0.95, 300, 4.0), (0.95, 600, 4.0)]
    {
        let count = 200;
        let of = |seed: u64| {
            let series = under_noise(rho, n, noise, 700_000 + seed);
            let mean = series.iter().sum::<f64>() / n as f64;
            standard_error(&series).map(|error| [mean * mean, error * error])
        };
        let reported: Vec<[f64; 2]> = (0..count).filter_map(of).collect();
        let [scatter, claimed] = [0, 1].map(|k| reported.iter().map(|both| both[k]).sum::<f64>());
        let ratio = (scatter / claimed).sqrt();
        println!("rho {rho}, {n} values, noise {noise}: {ratio:.2}, reported {} of {count}", reported.len());
        // `standard_error` allows for motion slower than the series shows. Otherwise, the ratio would reach 1.85.
        assert!((0.65..1.4).contains(&ratio), "rho {rho}, {n} values, noise {noise}: {ratio}");
    }
}

#[test]
fn true_mean_is_within_two_errors_in_95_percent() {
    let is_near = |seed: &u64| {
        let mut average = BlockAverage::new(1.0);
        correlated(0.8, 4000, *seed).iter().for_each(|&x| average.add(x, 1.0));
        let Estimate { mean, standard_error } = average.estimate().unwrap();
        mean.abs() < 2.0 * standard_error.unwrap()
    };
    let near = (100..200).filter(is_near).count();
    // 95 of 100 means are expected within two standard errors, with a standard deviation of 2.1.
    assert!((89..=100).contains(&near), "{near}");
}

#[test]
fn errors_of_short_series_are_not_too_small() {
    let (n, rho, count) = (200, 0.85, 300);
    let all: Vec<(f64, Option<f64>)> = (0..count)
        .map(|seed| {
            let series = correlated(rho, n, 1000 + seed);
            (series.iter().sum::<f64>() / n as f64, standard_error(&series))
        })
        .collect();
    let scatter = (all.iter().map(|(mean, _)| mean * mean).sum::<f64>() / count as f64).sqrt();
    let reported: Vec<f64> = all.iter().filter_map(|(_, error)| *error).collect();
    assert!(reported.len() > 280, "{}", reported.len());
    let mean = reported.iter().sum::<f64>() / reported.len() as f64;
    // The scatter of 300 means is known to 1 / sqrt(600) = 4 %. Series of thirty decay times have a bias of 10 %.
    assert!((0.8..1.2).contains(&(mean / scatter)), "{mean} but {scatter}");
}

#[test]
fn monotonic_series_has_no_error() {
    let rising: Vec<f64> = (0..200).map(f64::from).collect();
    assert_eq!(standard_error(&rising), None);
    // The series consists of two constant halves, so at most two values are independent.
    let steps: Vec<f64> = (0..200).map(|k| if k < 100 { -1.0 } else { 1.0 }).collect();
    assert_eq!(standard_error(&steps), None);
}

#[test]
fn alternating_series_has_a_small_error() {
    let alternating: Vec<f64> = (0..100).map(|k| if k % 2 == 0 { -1.0 } else { 1.0 }).collect();
    assert!(standard_error(&alternating).unwrap() < 1e-3);
}

#[test]
fn a_ratio_of_means_is_no_mean_of_ratios() {
    let (mut a, mut b) = (BlockAverage::new(1.0), BlockAverage::new(1.0));
    for x in correlated(0.0, 4000, 7) {
        a.add(2.0 + x, 1.0);
        b.add(1.0 + x, 1.0);
    }
    let ratio = a.ratio(&b).unwrap();
    // The ratio is 2, so its error is the error of the mean of `a - 2 b = -x`.
    let error = (1.0 / 12.0_f64 / 4000.0).sqrt();
    assert!((ratio.standard_error.unwrap() / error - 1.0).abs() < 0.3, "{ratio:?}");
    assert!((ratio.mean - 2.0).abs() < 4.0 * error, "{ratio:?}: the mean of ratios is 2.10");
    assert_eq!(a.ratio(&BlockAverage::new(1.0)), None);
}

#[test]
fn memory_is_bounded_and_the_mean_is_exact() {
    let mut average = BlockAverage::new(0.5);
    (0..100_000).for_each(|k| average.add(f64::from(k), 0.5));
    assert!(average.bins.len() < MOST_BINS);
    assert_eq!(average.estimate().unwrap().mean, 49_999.5);
    let binned = average.bins.iter().sum::<f64>() * average.bin_weight + average.open_sum;
    assert_eq!(binned, average.sum);
}

#[test]
fn longer_and_cut_off_intervals_count_by_their_time() {
    let mut average = BlockAverage::new(1.0);
    (0..21).for_each(|_| average.add(1.0, 1.0));
    (0..10).for_each(|_| average.add(2.0, 2.0));
    average.add(7.0, 0.5);
    assert_eq!(average.estimate().unwrap().mean, (21.0 + 40.0 + 3.5) / 41.5);
    assert_eq!(average.bin_weight, 2.0);
    assert_eq!(average.bins.len(), 20, "ten of ones, one begun by the odd one, and nine of twos");
}

#[test]
fn too_few_values_give_none_and_never_nan() {
    let mut average = BlockAverage::new(1.0);
    assert_eq!(average.estimate(), None);
    average.add(f64::NAN, 1.0);
    average.add(1.0, 0.0);
    assert_eq!(average.estimate(), None);
    (0..7).for_each(|_| average.add(3.0, 1.0));
    assert_eq!(average.estimate(), Some(Estimate { mean: 3.0, standard_error: None }));
    average.add(3.0, 1.0);
    assert_eq!(average.estimate(), Some(Estimate { mean: 3.0, standard_error: Some(0.0) }));
}

#[test]
fn change_only_in_the_last_bin_gives_no_error() {
    // After `MOST_BINS` values, bins have a weight of 2. The value added last is in an incomplete bin.
    let series = |last: f64| {
        let mut average = BlockAverage::new(1.0);
        (0..MOST_BINS).for_each(|_| average.add(2.0, 1.0));
        average.add(last, 1.0);
        average
    };
    let (constant, other) = (series(2.0), series(3.0));
    assert_eq!(constant.stationarity(), Stationarity::Constant);
    assert_eq!(constant.estimate(), Some(Estimate { mean: 2.0, standard_error: Some(0.0) }));
    assert_eq!(other.stationarity(), Stationarity::Unknown);
    assert_eq!(other.estimate().unwrap().standard_error, None);
    assert!(other.estimate().unwrap().mean > 2.0);
    let ratio = other.ratio(&constant).unwrap();
    assert_eq!((ratio.standard_error, other.stationarity_of_ratio(&constant)), (None, Stationarity::Unknown));
    assert_eq!(constant.stationarity_of_ratio(&constant), Stationarity::Constant);
    let mut curve = CurveAverage::new(1);
    // The curve merges its bins at 64 and at 128 values. Value 129 is then in an incomplete bin.
    (0..128).for_each(|_| curve.add(0, 0.0));
    assert_eq!(curve.estimate(0), Some(Estimate { mean: 0.0, standard_error: Some(0.0) }));
    curve.add(0, 1.0);
    assert_eq!(curve.estimate(0).unwrap().standard_error, None);
}

#[test]
fn a_first_value_that_is_longer_than_all_others_does_not_hide_them() {
    let noise = correlated(0.0, 100, 7);
    let mut average = BlockAverage::new(1000.0);
    average.add(0.5, 1000.0);
    noise.iter().for_each(|x| average.add(*x, 1.0));
    let error = average.estimate().unwrap().standard_error.unwrap();
    let exact = (1.0 / 12.0 / 100.0_f64).sqrt();
    assert!((error / exact - 1.0).abs() < 0.5, "{error} {exact}");
}

#[test]
fn error_of_a_bounded_rate_comes_from_its_end_values() {
    for rho in [0.0, 0.8, 0.9] {
        let (n, count) = (400, 200);
        let squares = |seed: u64| {
            let bounded = correlated(rho, n + 1, 40_000 + seed);
            let rates: Vec<f64> = bounded.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let mean = rates.iter().sum::<f64>() / n as f64;
            [mean * mean, error_of_ends(&rates).map_or(0.0, |error| error * error)]
        };
        let all: Vec<[f64; 2]> = (0..count).map(squares).collect();
        let given: Vec<&[f64; 2]> = all.iter().filter(|both| both[1] > 0.0).collect();
        let [scatter, claimed] = [0, 1].map(|k| given.iter().map(|both| both[k]).sum::<f64>());
        let ratio = (scatter / claimed).sqrt();
        // The scatter of 200 means is known to 5 %.
        assert!(given.len() > 180 && (0.85..1.15).contains(&ratio), "{rho}: {ratio}, {}", given.len());
    }
    // The sum of independent rates is a random walk. One in six walks looks bounded, so 8 +- 2.6 of 50 walks do.
    let walks = (0..50).filter(|seed| error_of_ends(&correlated(0.0, 400, 60_000 + seed)).is_some()).count();
    assert!(walks <= 16, "{walks}");
}

fn variance(series: Vec<f64>) -> Estimate {
    let (mut values, mut squares) = (BlockAverage::new(1.0), BlockAverage::new(1.0));
    for x in series {
        values.add(x, 1.0);
        squares.add(x * x, 1.0);
    }
    values.variance(&squares).unwrap()
}

#[test]
fn a_variance_is_that_about_the_true_mean() {
    // With 21 independent values, the variance about the sample mean is 4.8 % too small. Its average is known to 1 %.
    let (rho, length, count) = (0.9, 400, 500);
    let all = (0..count).map(|seed| variance(correlated(rho, length, 90_000 + seed)).mean);
    let exact = 1.0 / 12.0 / (1.0 - rho * rho);
    let ratio = all.sum::<f64>() / (count as f64 * exact);
    assert!((ratio - 1.0).abs() < 0.032, "{ratio}");
}

#[test]
fn the_error_of_a_variance_is_honest_where_noise_hides_slow_motion() {
    // The slow motion has 21, 32 or 63 independent values, and the noise has the same variance. Without the lower bound
    // for the error of a variance, the rms deviation would be 1.16 standard errors for 32 values.
    let (rho, count) = (0.9_f64, 200);
    let exact = 2.0 / 12.0 / (1.0 - rho * rho);
    let noise = (1.0 - rho * rho).sqrt().recip();
    for length in [400, 600, 1200] {
        let deviation = |seed: u64| {
            let (slow, fast) = (correlated(rho, length, 120_000 + seed), correlated(0.0, length, 130_000 + seed));
            let it = variance(slow.iter().zip(&fast).map(|(slow, fast)| slow + noise * fast).collect());
            Some((it.mean - exact) / it.standard_error?)
        };
        let all: Vec<f64> = (0..count).filter_map(deviation).collect();
        let rms = (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
        let far = all.iter().filter(|x| x.abs() > 3.0).count();
        println!("{length}: {rms}, {far} of {}", all.len());
        // The rms of 200 deviations is known to 5 %, or to 8 % with outliers.
        assert!(all.len() >= 160 && (0.7..1.05).contains(&rms) && far <= 6, "{length}: {rms}, {far} of {}", all.len());
    }
}

#[test]
fn a_variance_of_few_independent_values_has_no_error() {
    let claims = (0..200).filter(|seed| variance(correlated(0.9, 100, 150_000 + seed)).standard_error.is_some());
    let claims = claims.count();
    assert!(claims <= 4, "{claims}");
}

#[test]
fn a_variance_has_no_error_where_its_mean_has_none() {
    // The series changes sign once, so its mean is unknown. The mean of its squares is well known.
    let (mut values, mut squares) = (BlockAverage::new(1.0), BlockAverage::new(1.0));
    for (k, noise) in correlated(0.0, 64, 7).into_iter().enumerate() {
        let x = if k < 32 { 1.0 + noise } else { -1.0 - noise };
        values.add(x, 1.0);
        squares.add(x * x, 1.0);
    }
    assert!(squares.estimate().unwrap().standard_error.is_some());
    assert_eq!(values.estimate().unwrap().standard_error, None);
    assert_eq!(values.variance(&squares).unwrap().standard_error, None);
}
