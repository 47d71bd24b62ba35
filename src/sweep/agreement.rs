//! How far the means of a sweep are from what is published.

use super::results::Results;
use crate::analysis::published::PublishedValue;

/// Of fewer means the deviations say nothing.
const FEWEST: usize = 2;

/// Deviations of the means of a quantity from published values, squared and in units of their standard errors.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Agreement {
    /// Label of the published values: `mKLM`.
    pub label: String,
    /// `chi^2 = sum ((x - x_0) / error)^2` with what is expected of systems of the size of the runs, [`PublishedValue::at_size`].
    pub chi_square: f64,
    /// That with the values as they are published; `None` where they are the same.
    pub without_size: Option<f64>,
    /// Number of the means in it, and of its degrees of freedom: nothing is fitted.
    pub freedom: usize,
}

/// A mean, its error, and what is published.
type Pair<'p> = (f64, f64, &'p PublishedValue);

impl Results {
    /// Agreement of a quantity, by its place, with each published result that covers two state points and measured stages at least.
    #[must_use]
    pub fn agreements(&self, quantity: usize) -> Vec<Agreement> {
        let Some(name) = self.quantities.get(quantity).map(|it| &it.name) else { return Vec::new() };
        let mut all: Vec<(&str, Vec<Pair<'_>>)> = Vec::new();
        for (_, means) in self.means() {
            let measured = means.values.get(quantity).copied().flatten();
            let error = measured.and_then(|it| it.error).filter(|error| *error > 0.0);
            let Some((measured, error)) = measured.zip(error) else { continue };
            for known in means.published.iter().filter(|it| it.quantity == *name) {
                match all.iter_mut().find(|(label, _)| *label == known.label) {
                    Some((_, pairs)) => pairs.push((measured.mean, error, known)),
                    None => all.push((&known.label, vec![(measured.mean, error, known)])),
                }
            }
        }
        all.iter().filter(|(_, pairs)| pairs.len() >= FEWEST).map(|(label, pairs)| agreement(label, pairs)).collect()
    }
}

fn agreement(label: &str, pairs: &[Pair<'_>]) -> Agreement {
    let chi_square = |expected: fn(&PublishedValue) -> f64| {
        pairs.iter().map(|(mean, error, known)| (mean - expected(known)) / error).map(|x| x * x).sum()
    };
    let has_size = pairs.iter().any(|(.., known)| known.finite_size != 0.0);
    Agreement {
        label: label.to_owned(),
        chi_square: chi_square(PublishedValue::at_size),
        without_size: has_size.then(|| chi_square(|known| known.value)),
        freedom: pairs.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Group, MeasuredQuantity, Pooled, StageMeans};

    /// A state point with a mean, its error, and what is published about it.
    fn group(mean: f64, error: f64, published: &[(&str, f64, f64)]) -> Group {
        let known = |(label, value, finite_size): &(&str, f64, f64)| PublishedValue {
            quantity: "z".to_owned(),
            value: *value,
            finite_size: *finite_size,
            label: (*label).to_owned(),
            source: String::new(),
        };
        let value = Pooled { mean, error: Some(error), scatter: None, runs: 1 };
        let published = published.iter().map(known).collect();
        let means = StageMeans { stage: "measurement".to_owned(), runs: 1, values: vec![Some(value)], published };
        Group { places: vec![0], repeats: 0, measurements: vec![means] }
    }

    #[test]
    fn deviations_are_from_what_is_expected_at_the_size_of_the_runs() {
        let z = MeasuredQuantity { name: "z".to_owned(), title: "z".to_owned(), unit: "1".to_owned() };
        let groups = vec![
            group(5.0, 0.5, &[("A", 6.0, -0.5), ("B", 4.0, 0.0)]),
            group(7.0, 1.0, &[("A", 9.0, 0.0), ("B", 7.0, 0.0)]),
            // Conserved: without an error there is no deviation.
            group(9.0, 0.0, &[("A", 1.0, 0.0), ("C", 1.0, 0.0)]),
            group(9.0, 1.0, &[("C", 8.0, 0.0)]),
        ];
        let (stages, points) = (vec!["measurement".to_owned()], Vec::new());
        let results = Results { quantities: vec![z], stages, points, groups };
        let of = |label: &str, chi_square, without_size, freedom| Agreement {
            label: label.to_owned(),
            chi_square,
            without_size,
            freedom,
        };
        assert_eq!(results.agreements(0), [of("A", 5.0, Some(8.0), 2), of("B", 4.0, None, 2)]);
        assert_eq!(results.agreements(1), []);
    }
}
