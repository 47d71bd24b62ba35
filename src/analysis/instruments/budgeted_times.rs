use super::block_times::incommensurate;
use super::instrument::Setup;
use crate::analysis::sampling_times::SamplingTimes;
use crate::base::numbers::trunc_to_u32;

const MOST: f64 = 200.0;

/// Smallest number of expensive samples. Sixteen blocks are just enough for a standard error.
const FEWEST: f64 = 16.0;

/// Number of floating-point operations for all samples, even in a short run. They take about one second.
const FREE: f64 = 5e8;

/// Further operations per particle and flight, the time in which a particle travels the mean distance of neighbours.
const PER_FLIGHT: f64 = 200.0;

/// Evenly spaced sampling times for expensive samples.
///
/// Without a given interval, the expected duration contains 16 to 200 samples, depending on a budget of operations. The
/// argument `work` is the number of floating-point operations of a sample. If velocities are scaled, the interval is
/// [`incommensurate`] with the scalings.
pub(super) fn budgeted_times(setup: &Setup<'_>, given: Option<f64>, work: f64) -> SamplingTimes {
    let start = setup.sample.time;
    // The shortest interval that floating-point times can resolve.
    let shortest = 4.0 * f64::EPSILON * (start.abs() + setup.duration);
    match given {
        Some(interval) => SamplingTimes::given(start, interval.max(shortest)),
        None => {
            let aim = trunc_to_u32(aim(setup, work));
            let interval = incommensurate(setup.duration / f64::from(aim), setup.system.scaling_interval);
            SamplingTimes::expecting(start, interval * f64::from(aim), aim, shortest)
        }
    }
}

fn aim(setup: &Setup<'_>, work: f64) -> f64 {
    let (system, sample) = (setup.system, &setup.sample);
    let count = system.moving.len().max(1) as f64;
    let square = |&id: &u32| sample.velocities.get(id as usize).map_or(0.0, |v| v.norm_squared());
    let speed = (system.moving.iter().map(square).sum::<f64>() / count).sqrt();
    let room = system.space.volume() / count;
    let spacing = match system.space.dimensions() {
        3 => libm::cbrt(room),
        2 => room.sqrt(),
        _ => room,
    };
    let flights = setup.duration * speed / spacing;
    let budget = FREE + if flights.is_finite() { PER_FLIGHT * flights * count } else { 0.0 };
    (budget / work.max(1.0)).clamp(FEWEST, MOST).floor()
}

#[cfg(test)]
mod tests {
    use super::super::system::{Sample, SystemDescription};
    use super::*;
    use crate::Vector;
    use crate::model::space::Space;

    fn times(start: f64, duration: f64, given: Option<f64>, work: f64) -> SamplingTimes {
        let system = SystemDescription::of_points(Space::periodic_cube(10.0), 1000);
        let velocities = vec![Vector::new(1.0, 0.0, 0.0); 1000];
        let sample = Sample { time: start, velocities: &velocities, ..Sample::default() };
        budgeted_times(&Setup { system: &system, sample, duration }, given, work)
    }

    #[test]
    fn times_are_multiples_and_begin_after_the_start() {
        let mut times = times(5.0, 100.0, Some(0.1), 1.0);
        assert!(!times.is_due(5.0));
        for k in 1..1000 {
            assert_eq!(times.next(), 5.0 + f64::from(k) * 0.1);
            assert!(times.is_due(times.next()));
        }
        assert!(times.is_due(1e3) && times.next() > 1e3 && times.next() < 1e3 + 0.2);
    }

    #[test]
    fn expensive_samples_are_taken_less_often() {
        assert_eq!(times(0.0, 100.0, None, 1.0).next(), 0.5);
        // The budget is 5e8 + 200 * 1000 * 100 = 5.2e8 operations.
        assert_eq!(times(0.0, 100.0, None, 5.2e6).next(), 1.0);
        assert_eq!(times(0.0, 100.0, None, 1e12).next(), 100.0 / 16.0);
    }

    #[test]
    fn automatic_interval_doubles() {
        let mut times = times(0.0, 1.0, None, 1.0);
        let mut count = 0;
        while times.next() < 1000.0 {
            assert!(times.is_due(times.next()));
            count += 1;
        }
        assert!(count < 200 * 12, "{count}");
    }

    #[test]
    fn an_interval_below_the_spacing_of_numbers_still_goes_on() {
        let mut times = times(1e6, 1.0, Some(1e-300), 1.0);
        for _ in 0..100 {
            let now = times.next();
            assert!(times.is_due(now) && times.next() > now);
        }
    }
}
