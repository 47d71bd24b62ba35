//! The error of a computed time, compared with the shift of the exact root by round-off.

use super::crossing::Crossing;
use super::dyadic::{Dyadic, scaled};
use super::polynomial::Polynomial;

/// The error of a computed time, and the shift of the root by round-off. Both are in ulp of the time.
#[derive(Debug, Clone, Copy)]
pub struct Distance {
    /// The exact time minus the computed time.
    pub error: f64,
    /// Largest shift of the root if round-off moves `f` up or down.
    pub condition: f64,
}

impl Distance {
    /// Returns the error divided by the allowed error. One ulp is allowed for the time itself.
    pub fn ratio(&self) -> f64 {
        self.error.abs() / (self.condition + 1.0)
    }
}

/// Larger distances are treated as infinite [ulp].
const FARTHEST: f64 = 1e40;

/// Returns the difference between `time` and a crossing. `rounding` is the largest error of `crossing.f`. The
/// polynomial is expanded exactly around `time`, so nearby roots lose no digits by cancellation.
pub fn distance(crossing: &Crossing, time: f64, rounding: f64) -> Distance {
    let at = Dyadic::from(time);
    let local = Local::new(&crossing.f, &at, last_place(time));
    let direction = if crossing.is_after(&at) { 1.0 } else { -1.0 };
    let offset = local.first(0.0, direction, |f| if direction > 0.0 { f <= 0.0 } else { f > 0.0 });
    let error = direction * offset;
    let rounding = local.in_its_units(rounding);
    let earlier = local.first(error, -1.0, |f| f.abs() >= rounding);
    let later = local.first(error, 1.0, |f| f.abs() >= rounding);
    Distance { error, condition: earlier.max(later) }
}

/// Exponent of the last binary place of a floating-point number.
pub fn last_place(x: f64) -> i64 {
    let biased = (x.to_bits() >> 52 & 0x7ff) as i64;
    biased.max(1) - 1075
}

/// A floating-point polynomial near a time. The variable is the distance from this time in ulp. The values are in units
/// of the largest coefficient.
struct Local {
    coefficients: Vec<f64>,
    unit: i64,
}

impl Local {
    fn new(f: &Polynomial, at: &Dyadic, last_place: i64) -> Self {
        let around = f.around(at);
        let to_ulp = last_place - at.exponent;
        let terms = around.coefficients.iter().enumerate().map(|(k, c)| {
            let exponent = around.exponent + to_ulp * k as i64;
            Dyadic { mantissa: c.clone(), exponent }.approximate()
        });
        let terms: Vec<_> = terms.collect();
        let unit = terms.iter().filter(|t| t.0 != 0.0).map(|t| t.1).max().unwrap_or(0);
        let scaled = terms.iter().map(|&(m, e)| scaled(m, e - unit));
        Self { coefficients: scaled.collect(), unit }
    }

    fn in_its_units(&self, x: f64) -> f64 {
        let (m, e) = Dyadic::from(x).approximate();
        scaled(m, e - self.unit)
    }

    fn value(&self, offset: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, c| sum * offset + c)
    }

    /// Returns the distance from `from` at which `holds` first becomes true, to one part in 1000.
    fn first(&self, from: f64, direction: f64, holds: impl Fn(f64) -> bool) -> f64 {
        let holds_at = |step: f64| holds(self.value(from + direction * step));
        let mut upper = 1e-3;
        while !holds_at(upper) {
            upper *= 2.0;
            if upper > FARTHEST {
                return f64::INFINITY;
            }
        }
        let mut lower = if upper > 1e-3 { 0.5 * upper } else { 0.0 };
        while upper - lower > 1e-3 * upper {
            let middle = 0.5 * (lower + upper);
            (lower, upper) = if holds_at(middle) { (lower, middle) } else { (middle, upper) };
            if upper < 1e-6 {
                return upper;
            }
        }
        upper
    }
}
