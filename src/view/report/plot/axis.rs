//! Axes: which values they span, and where their ticks are.

use crate::base::numbers::trunc_to_i32;
use crate::view::report::html;

/// An axis smaller than this part of its values could not be labelled.
const SMALLEST_SPAN: f64 = 1e-5;

/// A linear or logarithmic axis between two places `[pixels]`.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::view::report) struct Axis {
    low: f64,
    high: f64,
    is_logarithmic: bool,
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that spans two finite values, which on a logarithmic axis are positive. Where they (nearly) coincide, it
    /// spans their neighbourhood.
    pub fn new([low, high]: [f64; 2], is_logarithmic: bool) -> Self {
        let (low, high) = (low.clamp(-1e300, 1e300), high.clamp(-1e300, 1e300));
        let (low, high) = match is_logarithmic {
            true => {
                let [low, high] = [low, high].map(|value| value.max(1e-300).log10());
                if high - low < 0.1 { (low - 0.5, high + 0.5) } else { (low, high) }
            }
            false if high - low <= SMALLEST_SPAN * low.abs().max(high.abs()) => {
                let half = if low == 0.0 { 1.0 } else { 5.0 * SMALLEST_SPAN * low.abs().max(high.abs()) };
                (low - half, high + half)
            }
            false => (low, high),
        };
        Self { low, high, is_logarithmic, from: 0.0, to: 1.0 }
    }

    /// Axis with room beyond both ends, relative to its length. Zero stays an end.
    pub fn widened(self, room: f64) -> Self {
        let margin = room * (self.high - self.low);
        let low = if self.low == 0.0 && !self.is_logarithmic { 0.0 } else { self.low - margin };
        Self { low, high: self.high + margin, ..self }
    }

    /// Axis between other places.
    pub fn between(self, from: f64, to: f64) -> Self {
        Self { from, to, ..self }
    }

    /// Whether a value has a place: logarithmic axes have none for values that are not positive.
    pub fn has_place(&self, value: f64) -> bool {
        value.is_finite() && (!self.is_logarithmic || value > 0.0)
    }

    /// From 0 at the lower end to 1 at the upper one, and beyond.
    pub fn fraction(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic { value.max(1e-300).log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    /// Where a value is `[pixels]`.
    pub fn place(&self, value: f64) -> f64 {
        self.from + self.fraction(value) * (self.to - self.from)
    }

    /// The values with ticks, and whether each has a label.
    pub fn marks(&self) -> Vec<(f64, bool)> {
        if self.is_logarithmic { self.decades() } else { self.steps().into_iter().map(|value| (value, true)).collect() }
    }

    fn steps(&self) -> Vec<f64> {
        let step = self.step();
        let first = (self.low / step - 1e-9).ceil();
        // A span is at most ten steps.
        let values = (0..=10).map(|k| (first + f64::from(k)) * step);
        values.filter(|value| *value <= self.high + 1e-9 * step).collect()
    }

    /// 1, 2 or 5 times a power of ten, some five to the span.
    fn step(&self) -> f64 {
        let raw = (self.high - self.low) / 5.0;
        let power = 10_f64.powf(raw.log10().floor());
        let factors = [1.0, 2.0, 5.0, 10.0];
        power * factors.into_iter().find(|factor| factor * power >= raw * (1.0 - 1e-9)).unwrap_or(10.0)
    }

    /// Powers of ten, with two to nine times them where they are few; 1, 2 and 5 are labelled where there is hardly one.
    fn decades(&self) -> Vec<(f64, bool)> {
        let (low, high) = (trunc_to_i32(self.low.floor()), trunc_to_i32(self.high.ceil()));
        let number = self.high - self.low;
        let stride = trunc_to_i32((number / 6.0).ceil().max(1.0));
        let mut marks = Vec::new();
        for decade in low..=high {
            for digit in 1..=9 {
                let value = format!("{digit}e{decade}").parse().unwrap_or(1.0);
                let is_labelled = match digit {
                    1 => decade.rem_euclid(stride) == 0,
                    2 | 5 => number < 1.6,
                    _ => false,
                };
                let is_shown = is_labelled || number < 7.0 || (digit == 1 && number < 40.0);
                if is_shown && (-1e-9..=1.0 + 1e-9).contains(&self.fraction(value)) {
                    marks.push((value, is_labelled));
                }
            }
        }
        marks
    }

    /// Label beside the tick of a value.
    pub fn label(&self, value: f64) -> String {
        if self.is_logarithmic {
            let text = format!("{value:e}");
            return match text.split_once('e') {
                Some(_) if (0.01..1000.0).contains(&value) => format!("{value}"),
                Some(("1", exponent)) => html::power_of_ten(exponent.parse().unwrap_or(0)),
                _ => html::number(&text),
            };
        }
        let step = self.step();
        if value.abs() < 1e-9 * step {
            return "0".to_owned();
        }
        let largest = self.low.abs().max(self.high.abs());
        let step_exponent = trunc_to_i32(step.log10().floor());
        if (1e-3..1e6).contains(&largest) && step_exponent > -7 {
            return html::number(&format!("{value:.*}", (-step_exponent).max(0) as usize));
        }
        let exponent = trunc_to_i32(largest.log10().floor());
        let digits = (exponent - step_exponent).clamp(0, 6) as usize;
        let mantissa = format!("{:.digits$}", value / 10_f64.powi(exponent));
        html::number(&format!("{mantissa}e{exponent}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: [f64; 2], is_logarithmic: bool) -> Vec<String> {
        let axis = Axis::new(range, is_logarithmic);
        axis.marks().into_iter().filter(|mark| mark.1).map(|mark| axis.label(mark.0)).collect()
    }

    #[test]
    fn ticks_are_at_round_numbers() {
        assert_eq!(labels([0.0, 1.0], false), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels([-3.0, 13.0], false), ["0", "5", "10"]);
        assert_eq!(labels([-1.0, 1.0], false), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels([0.0, 4e-7], false), ["0", "1×10⁻⁷", "2×10⁻⁷", "3×10⁻⁷", "4×10⁻⁷"]);
        assert_eq!(labels([1.0, 1e4], true), ["1", "10", "100", "10³", "10⁴"]);
        assert_eq!(labels([0.5, 6.0], true), ["0.5", "1", "2", "5"]);
        assert_eq!(labels([1e-30, 1.0], true).len(), 7);
    }

    #[test]
    fn values_that_coincide_have_an_axis() {
        for range in [[0.0, 0.0], [5.0, 5.0], [-3.0, -3.0], [1e300, 1e300], [162.0, 162.0 + 1e-12], [-1e308, 1e308]] {
            for is_logarithmic in [false, true] {
                let axis = Axis::new(range, is_logarithmic);
                let marks = axis.marks();
                assert!(marks.len() >= 2 && marks.len() < 80, "{range:?}: {marks:?}");
                for (value, _) in marks {
                    assert!(axis.place(value).is_finite());
                    let label = axis.label(value);
                    assert!(label.len() < 24 && !label.contains("inf") && !label.contains("NaN"), "{label}");
                }
            }
        }
    }
}
