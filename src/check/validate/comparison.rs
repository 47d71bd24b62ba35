use crate::analysis::statistics::Estimate;

/// Largest deviation that passes, in standard errors. A normally distributed error exceeds it once in 16,000 cases.
pub const MOST_ERRORS: f64 = 4.0;

/// Largest standard error, relative to the expected value, for a meaningful comparison.
const LARGEST_ERROR: f64 = 0.05;

/// Source of a reference value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Short form, such as `mKLM 2019`.
    pub short: &'static str,
    /// Full reference.
    pub full: &'static str,
}

/// Tolerance of a comparison in addition to the statistical error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Size of the allowance in the unit of the quantity; 0 for none.
    pub amount: f64,
    /// Systematic difference that the allowance covers.
    pub reason: &'static str,
}

impl Allowance {
    /// Statistical errors only.
    pub const NONE: Self = Self { amount: 0.0, reason: "" };
}

/// Comparison of a measured quantity with its published value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Name of the quantity.
    pub quantity: &'static str,
    /// The measured value; `None` for insufficient data.
    pub measured: Option<f64>,
    /// Standard error of the measured value: 0 if nothing is random, `None` for insufficient data.
    pub standard_error: Option<f64>,
    /// The published or exact value.
    pub published: f64,
    /// Known systematic difference.
    pub allowance: Allowance,
    /// Source of the published value.
    pub source: Source,
}

/// Result of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The difference is within four standard errors plus the allowance.
    Pass,
    /// The difference is more than four standard errors plus the allowance.
    Fail,
    /// The standard error is unknown, or too large for a conclusion.
    Unresolved,
}

impl Verdict {
    /// Whether the quantity agrees with the published value.
    #[must_use]
    pub fn is_pass(self) -> bool {
        self == Self::Pass
    }
}

impl Comparison {
    pub(super) fn statistical(
        quantity: &'static str,
        measured: Option<Estimate>,
        published: f64,
        source: Source,
    ) -> Self {
        let measured = measured.filter(|estimate| estimate.mean.is_finite());
        Self {
            quantity,
            measured: measured.map(|estimate| estimate.mean),
            standard_error: measured.and_then(|estimate| estimate.standard_error),
            published,
            allowance: Allowance::NONE,
            source,
        }
    }

    pub(super) fn exact(quantity: &'static str, measured: Option<f64>, published: f64, source: Source) -> Self {
        let measured = measured.map(|mean| Estimate { mean, standard_error: Some(0.0) });
        Self::statistical(quantity, measured, published, source)
    }

    pub(super) fn allow(self, amount: f64, reason: &'static str) -> Self {
        Self { allowance: Allowance { amount, reason }, ..self }
    }

    /// Returns the measured minus the published value.
    #[must_use]
    pub fn difference(&self) -> Option<f64> {
        self.measured.map(|measured| measured - self.published)
    }

    /// Returns the difference in units of the standard error; `None` without a standard error.
    #[must_use]
    pub fn deviation(&self) -> Option<f64> {
        let error = self.standard_error.filter(|error| *error > 0.0)?;
        Some(self.difference()? / error)
    }

    /// Returns the verdict of the comparison.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let (Some(difference), Some(error)) = (self.difference(), self.standard_error) else {
            return Verdict::Unresolved;
        };
        let bound = MOST_ERRORS * error + self.allowance.amount;
        if !(bound.is_finite() && error <= LARGEST_ERROR * self.published.abs()) {
            Verdict::Unresolved
        } else if difference.abs() <= bound {
            Verdict::Pass
        } else {
            Verdict::Fail
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: Source = Source { short: "here", full: "this test" };

    fn comparison(mean: f64, standard_error: Option<f64>) -> Comparison {
        Comparison::statistical("Z", Some(Estimate { mean, standard_error }), 10.0, SOURCE)
    }

    #[test]
    fn four_standard_errors_pass_and_more_do_not() {
        assert_eq!(comparison(10.5, Some(0.125)).verdict(), Verdict::Pass);
        assert_eq!(comparison(9.5, Some(0.125)).verdict(), Verdict::Pass);
        assert_eq!(comparison(10.5_f64.next_up(), Some(0.125)).verdict(), Verdict::Fail);
        assert_eq!(comparison(9.5_f64.next_down(), Some(0.125)).verdict(), Verdict::Fail);
        assert_eq!(comparison(10.5, Some(0.125)).deviation(), Some(4.0));
    }

    #[test]
    fn an_allowance_adds_to_the_statistical_error() {
        let off = comparison(10.75, Some(0.125));
        assert_eq!(off.verdict(), Verdict::Fail);
        assert_eq!(off.allow(0.25, "why").verdict(), Verdict::Pass);
        assert_eq!(off.allow(0.25 - f64::EPSILON, "why").verdict(), Verdict::Fail);
    }

    #[test]
    fn exact_value_may_differ_only_by_its_allowance() {
        let exact = Comparison::exact("t", Some(1.5), 1.0, SOURCE);
        assert_eq!((exact.verdict(), exact.deviation()), (Verdict::Fail, None));
        assert_eq!(exact.allow(0.5, "why").verdict(), Verdict::Pass);
        assert_eq!(Comparison::exact("t", Some(1.0), 1.0, SOURCE).verdict(), Verdict::Pass);
    }

    #[test]
    fn unknown_value_or_error_does_not_pass() {
        assert_eq!(comparison(10.0, None).verdict(), Verdict::Unresolved);
        assert_eq!(comparison(10.0, Some(0.51)).verdict(), Verdict::Unresolved);
        assert_eq!(comparison(10.0, Some(f64::NAN)).verdict(), Verdict::Unresolved);
        assert_eq!(comparison(f64::NAN, Some(0.1)).verdict(), Verdict::Unresolved);
        assert_eq!(comparison(10.0, Some(0.1)).allow(f64::NAN, "why").verdict(), Verdict::Unresolved);
        assert_eq!(Comparison::exact("t", None, 1.0, SOURCE).verdict(), Verdict::Unresolved);
        assert!(!Verdict::Unresolved.is_pass());
    }
}
