//! Slope of the linear part of a curve. The error includes the correlation of the points.

use crate::analysis::statistics::Estimate;

/// The last part of a curve is straight if the slopes of its two halves differ by less than this fraction of the whole
/// slope, or by less than three standard errors.
const STRAIGHT: f64 = 0.1;

const FEWEST: usize = 6;

/// Lags at which the curve should be straight: from a quarter of the longest lag to the longest lag.
pub(super) fn straight_part(longest: usize) -> std::ops::RangeInclusive<usize> {
    longest.div_ceil(4)..=longest
}

/// Terms of the least-squares slope over the lags `k spacing`: the index `offset + k` and the coefficient.
pub(super) fn slope_terms(lags: std::ops::RangeInclusive<usize>, spacing: f64, offset: usize) -> Vec<(usize, f64)> {
    let centre = 0.5 * (*lags.start() as f64 + *lags.end() as f64);
    let squares: f64 = lags.clone().map(|k| (k as f64 - centre) * (k as f64 - centre)).sum();
    lags.map(|k| (offset + k, (k as f64 - centre) / (squares * spacing))).collect()
}

/// Terms of the slope over the last three quarters of a curve, and of the difference between the slopes of the two
/// halves. `None` if there are too few points.
pub(super) fn straight_terms(longest: usize, spacing: f64, offset: usize) -> Option<[Vec<(usize, f64)>; 2]> {
    let part = straight_part(longest);
    let (first, last) = (*part.start(), *part.end());
    if last + 1 < first + FEWEST {
        return None;
    }
    let middle = first + (last - first) / 2;
    let mut bend = slope_terms(first..=middle, spacing, offset);
    bend.extend(slope_terms(middle..=last, spacing, offset).into_iter().map(|(k, c)| (k, -c)));
    Some([slope_terms(part, spacing, offset), bend])
}

/// Slope of a curve of means over the last three quarters. `None` if this part is not straight or has too few points.
///
/// `slope` estimates a linear combination of curve elements. It may correct the curve first.
pub(super) fn straight_slope(
    longest: usize,
    spacing: f64,
    offset: usize,
    slope: impl Fn(&[(usize, f64)]) -> Option<Estimate>,
) -> Option<Estimate> {
    let [whole, bend] = straight_terms(longest, spacing, offset)?;
    let whole = slope(&whole)?;
    is_small(&slope(&bend)?, &whole).then_some(whole)
}

/// Whether `part` is less than a tenth of `whole` or less than three standard errors of `part`.
pub(super) fn is_small(part: &Estimate, whole: &Estimate) -> bool {
    part.mean.abs() <= (STRAIGHT * whole.mean.abs()).max(3.0 * part.standard_error.unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::statistics::CurveAverage;

    fn of_means(average: &CurveAverage) -> impl Fn(&[(usize, f64)]) -> Option<Estimate> + '_ {
        |terms| average.combination(terms)
    }

    fn curve(f: impl Fn(f64) -> f64) -> CurveAverage {
        let mut average = CurveAverage::new(20);
        // Half of the curves are shifted by a constant, which does not change the slope.
        (0..16).for_each(|n| average.add_all((0..20).map(|k| f(f64::from(k)) + f64::from(n % 2))));
        average
    }

    #[test]
    fn a_straight_line_has_its_slope_and_a_bent_one_none() {
        let line = curve(|t| 3.0 * t + 1.0);
        let slope = straight_slope(16, 0.5, 2, of_means(&line)).unwrap();
        assert!((slope.mean - 6.0).abs() < 1e-12 && slope.standard_error.unwrap() < 1e-12, "{slope:?}");
        let parabola = curve(|t| t * t);
        assert_eq!(straight_slope(16, 0.5, 0, of_means(&parabola)), None);
    }

    #[test]
    fn a_bend_at_short_times_does_no_harm_and_too_few_points_are_none() {
        let late = curve(|t| if t < 4.0 { t * t } else { 8.0 * t - 16.0 });
        assert!((straight_slope(16, 1.0, 0, of_means(&late)).unwrap().mean - 8.0).abs() < 1e-12);
        assert_eq!(straight_slope(5, 1.0, 0, of_means(&late)), None);
    }
}
