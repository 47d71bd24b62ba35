//! Long-time tail of the velocity autocorrelation in a periodic box, and its contribution to diffusion.
//!
//! A moving particle sets up a flow that later drags it along. After collisions have erased its initial velocity, its
//! velocity decays like the transverse flows of the box. By mode-coupling theory (Ernst, Hauge and van Leeuwen, Phys.
//! Rev. Lett. 25, 1254, 1970, [doi:10.1103/PhysRevLett.25.1254](https://doi.org/10.1103/PhysRevLett.25.1254)), the
//! correlation `<v_x(0) v_x(t)>` is `(d - 1) / d T / M sum_k exp(-(nu + D) k^2 t)`. The sum is over all wave vectors
//! `k = 2 pi (n_x / L_x, ...)` except 0, and `M` is the mass of the whole system.

use std::f64::consts::{PI, TAU};

/// Number of intervals for Simpson's rule, equal in the logarithm of the time.
const INTERVALS: u32 = 400;

/// Number of decay times after which the slowest flow is negligible.
const DECAYS: f64 = 40.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VelocityTail<'b> {
    /// Temperature divided by the total moving mass, `T / M` `[length^2 / time^2]`.
    pub temperature_by_mass: f64,
    /// Sum `nu + D` of the kinematic viscosity and the diffusion coefficient `[length^2 / time]`.
    pub spreading: f64,
    /// Edges of the box `[length]` along its two or three dimensions.
    pub periods: &'b [f64],
}

impl VelocityTail<'_> {
    fn correlation(&self, time: f64) -> f64 {
        let dimensions = self.periods.len() as f64;
        // The sum over all wave vectors is a product of sums along the axes. The term of `k = 0` is subtracted.
        let decay = |period: &f64| self.spreading * (TAU / period) * (TAU / period) * time;
        let modes: f64 = self.periods.iter().map(|period| theta(decay(period))).product();
        (dimensions - 1.0) / dimensions * self.temperature_by_mass * (modes - 1.0)
    }

    /// Part of the diffusion coefficient that comes from the velocity autocorrelation after a time `[length^2 / time]`.
    pub fn beyond(&self, time: f64) -> f64 {
        let slowest = self.periods.iter().fold(0.0_f64, |a, b| a.max(*b)) / TAU;
        self.integral([time, time + DECAYS * slowest * slowest / self.spreading], |_| 1.0)
    }

    /// Part of the diffusion coefficient that is missing from the slope of the mean squared displacement, fitted by
    /// least squares between two times `[length^2 / time]`.
    ///
    /// The autocorrelation at a time `t` increases the slope of the mean squared displacement after `t`. The fitted
    /// slope contains this contribution completely if `t` is before the first time, and not at all if `t` is after the
    /// last time. In between it contains the fraction `(1 - u)^2 (2 + u) / 4`, where `u` grows linearly from -1 to 1.
    pub fn beyond_slope(&self, [first, last]: [f64; 2]) -> f64 {
        let missed = |time: f64| {
            let u = (2.0 * time - first - last) / (last - first);
            1.0 - 0.25 * (1.0 - u) * (1.0 - u) * (2.0 + u)
        };
        self.integral([first, last], missed) + self.beyond(last)
    }

    fn integral(&self, [first, last]: [f64; 2], weight: impl Fn(f64) -> f64) -> f64 {
        let step = libm::log(last / first) / f64::from(INTERVALS);
        let value = |k: u32| {
            let time = first * libm::exp(f64::from(k) * step);
            let coefficient = match k {
                0 | INTERVALS => 1.0,
                odd if odd % 2 == 1 => 4.0,
                _ => 2.0,
            };
            coefficient * time * weight(time) * self.correlation(time)
        };
        (0..=INTERVALS).map(value).sum::<f64>() * step / 3.0
    }
}

/// `sum exp(-n^2 s)` over all integers; for small `s` by Poisson's sum `sqrt(pi / s) sum exp(-(pi n)^2 / s)`.
fn theta(s: f64) -> f64 {
    let (scale, exponent) = if s < PI { ((PI / s).sqrt(), PI * PI / s) } else { (1.0, s) };
    // The exponent is at least pi, so the first omitted term, `2 exp(-16 exponent)`, is below 1e-21.
    scale * (1.0 + 2.0 * (1..4).map(|n| libm::exp(-f64::from(n * n) * exponent)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over_modes(tail: &VelocityTail<'_>, of_rate: impl Fn(f64) -> f64) -> f64 {
        let range = |axis: usize| if axis < tail.periods.len() { -40..=40 } else { 0..=0 };
        let mut sum = 0.0;
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    let wave = |n: i32, axis: usize| tail.periods.get(axis).map_or(0.0, |l| TAU * f64::from(n) / l);
                    let square =
                        [x, y, z].iter().zip(0..).map(|(n, axis)| wave(*n, axis) * wave(*n, axis)).sum::<f64>();
                    sum += if square > 0.0 { of_rate(tail.spreading * square) } else { 0.0 };
                }
            }
        }
        let dimensions = tail.periods.len() as f64;
        (dimensions - 1.0) / dimensions * tail.temperature_by_mass * sum
    }

    #[test]
    fn the_tail_is_the_sum_over_modes() {
        for periods in [&[7.0, 9.0, 13.0][..], &[11.0, 8.0]] {
            let tail = VelocityTail { temperature_by_mass: 0.003, spreading: 1.7, periods };
            for time in [0.05, 0.3, 2.0, 9.0] {
                let expected = over_modes(&tail, |rate| libm::exp(-rate * time));
                assert!((tail.correlation(time) / expected - 1.0).abs() < 1e-9, "{time}");
                let beyond = over_modes(&tail, |rate| libm::exp(-rate * time) / rate);
                assert!((tail.beyond(time) / beyond - 1.0).abs() < 1e-7, "{time}");
                // A mode with decay rate `rate` makes half of the mean squared displacement differ from a straight line
                // by `exp(-rate t) / rate^2`. `slope` is minus the least-squares slope of this term, derived by hand.
                let [first, last] = [time, 4.0 * time];
                let slope = |rate: f64| {
                    let x = 0.5 * rate * (last - first);
                    let ends = (x - 1.0) * libm::exp(-rate * first) + (x + 1.0) * libm::exp(-rate * last);
                    3.0 * ends / (rate * rate * x * x * (last - first))
                };
                let expected = over_modes(&tail, slope);
                let found = tail.beyond_slope([first, last]);
                assert!((found / expected - 1.0).abs() < 1e-7, "{time}: {found} {expected}");
            }
        }
    }

    #[test]
    fn an_infinite_box_has_the_tail_of_ernst_hauge_and_van_leeuwen() {
        // The tail is `(2 / 3) (T / rho) (4 pi (nu + D) t)^(-3/2)`, with a mass density `rho` of 0.7.
        let (edge, spreading, time) = (1000.0, 1.3, 20.0);
        let mass = 0.7 * edge * edge * edge;
        let tail = VelocityTail { temperature_by_mass: 1.9 / mass, spreading, periods: &[edge; 3] };
        let expected = 2.0 / 3.0 * 1.9 / 0.7 / libm::pow(4.0 * PI * spreading * time, 1.5);
        // The omitted term `k = 0` is a fraction 6e-6 of the sum, or 5e-5 at the later time.
        assert!((tail.correlation(time) / expected - 1.0).abs() < 1e-4);
        assert!((tail.correlation(4.0 * time) / tail.correlation(time) - 0.125).abs() < 1e-4);
    }
}
