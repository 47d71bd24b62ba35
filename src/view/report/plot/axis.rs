use crate::base::numbers::trunc_to_i32;
use crate::view::report::html;

/// Smallest range of a linear axis, relative to its values. Labels cannot show a smaller range.
const SMALLEST_SPAN: f64 = 1e-5;

/// Preferred number of labels on a linear axis, and smallest number on any axis.
const ENOUGH: usize = 4;
const FEWEST: usize = 3;

/// Approximate width of a letter `[pixels]`.
const LETTER: f64 = 7.0;

/// A linear or logarithmic axis between two positions `[pixels]`.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::view::report) struct Axis {
    low: f64,
    high: f64,
    is_logarithmic: bool,
    from: f64,
    to: f64,
}

impl Axis {
    /// Returns an axis between two finite values, which must be positive on a logarithmic axis.
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

    /// Extends both ends of the axis by a fraction of its length. A lower end at zero is not moved.
    pub fn widened(self, room: f64) -> Self {
        let margin = room * (self.high - self.low);
        let low = if self.low == 0.0 && !self.is_logarithmic { 0.0 } else { self.low - margin };
        Self { low, high: self.high + margin, ..self }
    }

    pub fn between(self, from: f64, to: f64) -> Self {
        Self { from, to, ..self }
    }

    pub fn has_place(&self, value: f64) -> bool {
        value.is_finite() && (!self.is_logarithmic || value > 0.0)
    }

    /// Returns the position of a value on the axis, from 0 to 1.
    pub fn fraction(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic { value.max(1e-300).log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    pub fn place(&self, value: f64) -> f64 {
        self.from + self.fraction(value) * (self.to - self.from)
    }

    /// Returns the value of each tick, and whether it has a label. At least three ticks have labels.
    pub fn marks(&self) -> Vec<(f64, bool)> {
        let decades = if self.is_logarithmic { self.decades() } else { None };
        decades.unwrap_or_else(|| self.evenly().steps().into_iter().map(|value| (value, true)).collect())
    }

    /// Returns a linear axis with the same ends. Short logarithmic axes use its ticks.
    fn evenly(&self) -> Self {
        match self.is_logarithmic {
            true => Self::new([self.low, self.high].map(|end| 10_f64.powf(end)), false).between(self.from, self.to),
            false => self.clone(),
        }
    }

    /// Returns the ends of the axis and their positions `[pixels]`. The ends of a logarithmic axis are logarithms.
    pub fn scale(&self) -> [f64; 4] {
        [self.low, self.high, self.from, self.to]
    }

    pub fn is_logarithmic(&self) -> bool {
        self.is_logarithmic
    }

    fn steps(&self) -> Vec<f64> {
        multiples(self.step(), [self.low, self.high])
    }

    /// Returns the largest step of 1, 2 or 5 times a power of ten with at least `ENOUGH` ticks. If labels of a
    /// horizontal axis would touch, `FEWEST` ticks are enough.
    fn step(&self) -> f64 {
        let power = 10_f64.powf((self.high - self.low).log10().floor());
        let ticks = |step: f64| multiples(step, [self.low, self.high]);
        let with = |count: usize| {
            [2.0, 1.0, 0.5, 0.2].map(|factor| factor * power).into_iter().find(|step| ticks(*step).len() >= count)
        };
        let step = with(ENOUGH).unwrap_or(0.1 * power);
        let letters: usize = ticks(step).iter().map(|value| self.linear_label(*value, step).chars().count() + 2).sum();
        let room = self.to - self.from;
        if room > 1.0 && LETTER * letters as f64 > room { with(FEWEST).unwrap_or(step) } else { step }
    }

    /// Returns ticks at one to nine times each power of ten. The powers have labels. If there are fewer than three
    /// labels, two and five times each power also have labels, or else all ticks. Returns `None` if there are fewer
    /// than three ticks.
    fn decades(&self) -> Option<Vec<(f64, bool)>> {
        let (low, high) = (trunc_to_i32(self.low.floor()), trunc_to_i32(self.high.ceil()));
        let number = self.high - self.low;
        let stride = trunc_to_i32((number / 6.0).ceil().max(1.0));
        let all = (low..=high).flat_map(|decade| (1..=9).map(move |digit| (decade, digit)));
        let all: Vec<(i32, i32, f64)> = all
            .map(|(decade, digit)| (decade, digit, format!("{digit}e{decade}").parse().unwrap_or(1.0)))
            .filter(|(.., value)| (-1e-9..=1.0 + 1e-9).contains(&self.fraction(*value)))
            .collect();
        let is_labelled: [fn(i32, i32, i32) -> bool; 3] = [
            |decade, digit, stride| digit == 1 && decade.rem_euclid(stride) == 0,
            |_, digit, _| matches!(digit, 1 | 2 | 5),
            |_, _, _| true,
        ];
        let marks = is_labelled.into_iter().map(|is_labelled| {
            let is_shown = |digit: i32, is: bool| is || number < 7.0 || (digit == 1 && number < 40.0);
            let marks = all.iter().map(|(decade, digit, value)| (*digit, *value, is_labelled(*decade, *digit, stride)));
            marks.filter(|(digit, _, is)| is_shown(*digit, *is)).map(|(_, value, is)| (value, is)).collect::<Vec<_>>()
        });
        marks.into_iter().find(|marks| marks.iter().filter(|mark| mark.1).count() >= FEWEST)
    }

    pub fn label(&self, value: f64) -> String {
        if self.is_logarithmic && self.decades().is_some() {
            let text = format!("{value:e}");
            return match text.split_once('e') {
                Some(_) if (0.01..1000.0).contains(&value) => format!("{value}"),
                Some(("1", exponent)) => html::power_of_ten(exponent.parse().unwrap_or(0)),
                _ => html::number(&text),
            };
        }
        let evenly = self.evenly();
        evenly.linear_label(value, evenly.step())
    }

    fn linear_label(&self, value: f64, step: f64) -> String {
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

fn multiples(step: f64, [low, high]: [f64; 2]) -> Vec<f64> {
    let first = (low / step - 1e-9).ceil();
    // No axis has more than a hundred steps.
    let values = (0..=100).map(|k| (first + f64::from(k)) * step);
    values.take_while(|value| *value <= high + 1e-9 * step).collect()
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
        assert_eq!(labels([-3.0, 13.0], false), ["−2", "0", "2", "4", "6", "8", "10", "12"]);
        assert_eq!(labels([-1.0, 1.0], false), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels([0.0, 4e-7], false), ["0", "1×10⁻⁷", "2×10⁻⁷", "3×10⁻⁷", "4×10⁻⁷"]);
        assert_eq!(labels([1.0, 1e4], true), ["1", "10", "100", "10³", "10⁴"]);
        assert_eq!(labels([0.5, 6.0], true), ["0.5", "1", "2", "5"]);
        assert_eq!(labels([1e-30, 1.0], true).len(), 7);
    }

    #[test]
    fn every_axis_has_three_labels_at_least() {
        for k in 0..500 {
            let (start, length) = (
                (f64::from(k) * 0.618_034).fract() * 20.0 - 10.0,
                10_f64.powf((f64::from(k) * 0.414_214).fract() * 8.0 - 4.0),
            );
            for axis in [
                Axis::new([start, start + length], false),
                Axis::new([10_f64.powf(start), 10_f64.powf(start + length.min(30.0))], true),
            ] {
                for axis in [axis.clone().between(90.0, 466.0), axis.between(268.0, 12.0)] {
                    let labels =
                        axis.marks().iter().filter(|mark| mark.1).map(|mark| axis.label(mark.0)).collect::<Vec<_>>();
                    assert!((FEWEST..=10).contains(&labels.len()), "{axis:?}: {labels:?}");
                    assert!(labels.windows(2).all(|two| two[0] != two[1]), "{axis:?}: {labels:?}");
                }
            }
        }
    }

    #[test]
    fn logarithmic_axes_have_ticks_between_powers() {
        let marks = Axis::new([1.0, 1000.0], true).marks();
        assert_eq!(marks.iter().filter(|mark| mark.1).count(), 4);
        assert_eq!(marks.len(), 28);
    }

    #[test]
    fn axis_of_equal_values_is_finite() {
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
