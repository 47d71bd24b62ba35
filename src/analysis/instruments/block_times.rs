use super::instrument::Setup;
use crate::analysis::sampling_times::SamplingTimes;

/// Fraction of an interval by which a sample may come early because times are rounded.
pub(super) const EARLY: f64 = 1e-6;

/// Shortest interval, as a fraction of the expected duration. Shorter intervals would take far too long.
const SHORTEST: f64 = 1e-8;

pub(super) fn feasible(interval: f64, duration: f64) -> f64 {
    interval.max(SHORTEST * duration)
}

/// Returns an interval near `interval` that spreads samples evenly over the time between two scalings of the
/// velocities. The ratio of the two intervals, or the inverse ratio, becomes a whole number plus or minus the golden
/// section.
pub(super) fn incommensurate(interval: f64, scaling: Option<f64>) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let Some(scaling) = scaling else { return interval };
    let nearest = |ratio: f64| {
        let whole = ratio.floor();
        let candidates = [whole - 1.0 + GOLDEN, whole + 1.0 - GOLDEN, whole + GOLDEN];
        let distance = |candidate: f64| (libm::log(candidate / ratio)).abs();
        candidates.into_iter().filter(|candidate| *candidate > 0.0).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
    };
    let ratio = interval / scaling;
    let found = if ratio >= 1.0 { nearest(ratio) } else { nearest(ratio.recip()).map(f64::recip) };
    found.filter(|found| found.is_finite()).map_or(interval, |found| found * scaling)
}

/// Without a given interval, divides the expected duration into `aim` blocks.
pub(super) fn block_times(setup: &Setup<'_>, given: Option<f64>, aim: u32) -> SamplingTimes {
    let (start, duration) = (setup.sample.time, setup.duration);
    match given {
        Some(interval) => SamplingTimes::given(start, feasible(interval, duration)),
        None => SamplingTimes::expecting(start, duration, aim, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::super::system::{Sample, SystemDescription};
    use super::*;
    use crate::base::numbers::trunc_to_usize;
    use crate::model::space::Space;

    #[test]
    fn sampling_is_uniform_in_time_since_rescaling() {
        for interval in [5.0, 50.0, 0.25, 3.0, 7.1, 1e-3, 5.001, 4.999] {
            let found = incommensurate(interval, Some(5.0));
            assert!((0.6..1.6).contains(&(found / interval)), "{interval} {found}");
            let mut phases = [0_u32; 10];
            let count = 20_000;
            (1..=count).for_each(|k| phases[trunc_to_usize(10.0 * (f64::from(k) * found / 5.0).fract())] += 1);
            // If the interval is short, the counts differ by up to the number of samples between two scalings.
            assert!(phases.iter().all(|n| n.abs_diff(count / 10) < 600), "{interval} {found} {phases:?}");
        }
        assert_eq!(incommensurate(0.3, None), 0.3);
    }

    #[test]
    fn too_short_interval_is_lengthened() {
        let system = SystemDescription::of_points(Space::periodic_cube(10.0), 1);
        let times = |start: f64| {
            let sample = Sample { time: start, ..Sample::default() };
            block_times(&Setup { system: &system, sample, duration: 1.0 }, Some(1e-90), 10)
        };
        let mut blocks = times(1e20);
        blocks.pass_early(1e20, EARLY);
        assert!(blocks.next() > 1e20);
        assert_eq!(times(0.0).next(), 1e-8);
    }
}
