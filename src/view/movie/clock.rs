use super::index::Index;
use crate::base::numbers::trunc_to_usize;

/// Larger times, or times with more decimals, use scientific notation.
const LARGEST: f64 = 1e9;
const MOST_DIGITS: usize = 6;

/// Format of the simulated time. It has enough digits to distinguish successive images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clock {
    /// Decimal notation with this number of decimals.
    Plain(usize),
    /// Scientific notation with this number of decimals.
    Powers(usize),
}

impl Clock {
    pub fn of(index: &Index) -> Self {
        let times = || index.places.iter().map(|place| place.time);
        let steps = times().zip(times().skip(1)).map(|(a, b)| b - a);
        let steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        Self::with(mean, times().fold(0.0, |most, time| time.abs().max(most)))
    }

    fn with(step: f64, largest: f64) -> Self {
        if !(step > 0.0 && step.is_finite()) {
            // A single frame, or a time that does not advance.
            return if largest == 0.0 || (1e-2..LARGEST).contains(&largest) { Self::Plain(2) } else { Self::Powers(4) };
        }
        let is_enough = |digits: &usize| {
            let unit = format!("1e-{digits}").parse().unwrap_or(1.0);
            ((step / unit).round() * unit - step).abs() <= 0.005 * step
        };
        let digits = (0..=MOST_DIGITS).find(is_enough);
        match digits {
            Some(digits) if largest < LARGEST => Self::Plain(digits),
            _ => Self::Powers(trunc_to_usize((largest / step).log10().ceil() + 1.0).min(15)),
        }
    }

    pub fn text(self, time: f64) -> String {
        match self {
            Self::Plain(digits) => format!("{time:.digits$}"),
            Self::Powers(digits) => format!("{time:.digits$e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_as_many_digits_as_their_steps() {
        for (step, largest, expected) in [
            (1.0, 80.0, Clock::Plain(0)),
            (0.5, 10.0, Clock::Plain(1)),
            (0.25, 10.0, Clock::Plain(2)),
            (0.1 + 1e-12, 10.0, Clock::Plain(1)),
            (1.0 / 3.0, 10.0, Clock::Plain(3)),
            (20.0, 1e4, Clock::Plain(0)),
            (1e-9, 1e-7, Clock::Powers(3)),
            (1e8, 1e10, Clock::Powers(3)),
            (f64::NAN, 3.0, Clock::Plain(2)),
            (f64::NAN, 0.0, Clock::Plain(2)),
            (f64::NAN, 1e-20, Clock::Powers(4)),
        ] {
            assert_eq!(Clock::with(step, largest), expected, "{step} {largest}");
        }
        assert_eq!(Clock::Plain(2).text(2.5678), "2.57");
        assert_eq!(Clock::Powers(2).text(1.25e-7), "1.25e-7");
    }
}
