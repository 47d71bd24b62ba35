use super::results::{Results, StageMeans};
use crate::analysis::published::PublishedValue;

const FEWEST: usize = 2;

/// Quantity that distinguishes a crystal from a fluid of equal density.
const FACTOR: &str = "compressibility_factor";

/// Comparison of measured means with published values.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Agreement {
    /// Label of the published values, such as `mKLM`.
    pub label: String,
    /// `chi^2 = sum ((x - x_0) / error)^2`, where `x` is a mean, `error` its standard error, and `x_0` the published
    /// value for the size of the system, see [`PublishedValue::at_size`].
    pub chi_square: f64,
    /// `chi^2` with published values for infinite systems; `None` if no published value depends on the system size.
    pub without_size: Option<f64>,
    /// Number of means, which is also the number of degrees of freedom.
    pub freedom: usize,
    /// Number of means that were left out because the system is not in the published phase. If the compressibility
    /// factor is published for two phases, the nearer value determines the phase.
    pub other_phase: usize,
    /// Whether the published values refer to a crystal.
    pub is_of_crystal: bool,
}

/// Mean, standard error, published value, and whether the system is in the published phase.
type Pair<'p> = (f64, f64, &'p PublishedValue, bool);

impl Agreement {
    /// Describes the means that were left out, such as `, without 2 points that are crystals`; empty if there are none.
    #[must_use]
    pub fn left_out(&self) -> String {
        let phase = if self.is_of_crystal { "fluid" } else { "crystal" };
        match self.other_phase {
            0 => String::new(),
            1 => format!(", without 1 point that is a {phase}"),
            several => format!(", without {several} points that are {phase}s"),
        }
    }
}

impl Results {
    /// Compares a quantity with published values. The argument `quantity` is an index into [`Results::quantities`].
    /// Labels with fewer than two means are left out.
    #[must_use]
    pub fn agreements(&self, quantity: usize) -> Vec<Agreement> {
        let Some(name) = self.quantities.get(quantity).map(|it| &it.name) else { return Vec::new() };
        let mut all: Vec<(&str, Vec<Pair<'_>>)> = Vec::new();
        for (_, means) in self.means() {
            let measured = means.values.get(quantity).copied().flatten().map(|it| it.estimate);
            let error = measured.and_then(|it| it.standard_error).filter(|error| *error > 0.0);
            let Some((measured, error)) = measured.zip(error) else { continue };
            let is_crystal = self.is_crystal(means);
            for known in means.published.iter().filter(|it| it.quantity == *name) {
                let is_phase = is_crystal.is_none_or(|is_crystal| is_crystal == known.is_of_crystal());
                let pair = (measured.mean, error, known, is_phase);
                match all.iter_mut().find(|(label, _)| *label == known.label) {
                    Some((_, pairs)) => pairs.push(pair),
                    None => all.push((&known.label, vec![pair])),
                }
            }
        }
        all.iter().filter(|(_, pairs)| pairs.len() >= FEWEST).map(|(label, pairs)| agreement(label, pairs)).collect()
    }

    /// Whether the compressibility factor is nearer to the published crystal than to the published fluid.
    fn is_crystal(&self, means: &StageMeans) -> Option<bool> {
        let at = self.quantities.iter().position(|it| it.name == FACTOR)?;
        let measured = means.values.get(at).copied().flatten()?.estimate.mean;
        let known = |is_crystal: bool| {
            let mut all = means.published.iter().filter(|it| it.quantity == FACTOR);
            all.find(|it| it.is_of_crystal() == is_crystal).map(PublishedValue::at_size)
        };
        let [fluid, crystal] = [known(false)?, known(true)?];
        Some((measured - crystal).abs() < (measured - fluid).abs())
    }
}

fn agreement(label: &str, all: &[Pair<'_>]) -> Agreement {
    let pairs: Vec<&Pair<'_>> = all.iter().filter(|(.., is_phase)| *is_phase).collect();
    let chi_square = |expected: fn(&PublishedValue) -> f64| {
        pairs.iter().map(|(mean, error, known, _)| (mean - expected(known)) / error).map(|x| x * x).sum()
    };
    let has_size = pairs.iter().any(|(_, _, known, _)| known.finite_size != 0.0);
    Agreement {
        label: label.to_owned(),
        chi_square: chi_square(PublishedValue::at_size),
        without_size: has_size.then(|| chi_square(|known| known.value)),
        freedom: pairs.len(),
        other_phase: all.len() - pairs.len(),
        is_of_crystal: all.iter().any(|(_, _, known, _)| known.is_of_crystal()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::published::CRYSTAL_LABEL as CRYSTAL;
    use crate::analysis::statistics::Estimate;
    use crate::sweep::{Group, MeasuredQuantity, Pooled, StageMeans};

    fn group(mean: f64, error: f64, published: &[(&str, f64, f64)]) -> Group {
        let known = |(label, value, finite_size): &(&str, f64, f64)| PublishedValue {
            quantity: "z".to_owned(),
            value: *value,
            finite_size: *finite_size,
            label: (*label).to_owned(),
            source: String::new(),
        };
        let value = Pooled { estimate: Estimate { mean, standard_error: Some(error) }, scatter: None, runs: 1 };
        let published = published.iter().map(known).collect();
        let means = StageMeans { stage: "measurement".to_owned(), runs: 1, values: vec![Some(value)], published };
        Group { places: vec![0], repeats: 0, measurements: vec![means] }
    }

    #[test]
    fn deviations_use_published_values_at_the_run_size() {
        let z = MeasuredQuantity { name: "z".to_owned(), title: "z".to_owned(), unit: "1".to_owned() };
        let groups = vec![
            group(5.0, 0.5, &[("A", 6.0, -0.5), ("B", 4.0, 0.0)]),
            group(7.0, 1.0, &[("A", 9.0, 0.0), ("B", 7.0, 0.0)]),
            // Means without an error are left out.
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
            other_phase: 0,
            is_of_crystal: false,
        };
        assert_eq!(results.agreements(0), [of("A", 5.0, Some(8.0), 2), of("B", 4.0, None, 2)]);
        assert_eq!(results.agreements(1), []);
    }

    #[test]
    fn each_point_is_judged_by_the_phase_that_it_is_in() {
        let of = |name: &str| MeasuredQuantity { name: name.to_owned(), title: String::new(), unit: "1".to_owned() };
        let known = |quantity: &str, label: &str, value| PublishedValue {
            quantity: quantity.to_owned(),
            value,
            finite_size: 0.0,
            label: label.to_owned(),
            source: String::new(),
        };
        let at = |z: f64, rate: f64, published: Vec<PublishedValue>| {
            let estimate = |mean| Estimate { mean, standard_error: Some(0.1) };
            let values = [z, rate].map(|mean| Some(Pooled { estimate: estimate(mean), scatter: None, runs: 1 })).into();
            let means = StageMeans { stage: "measurement".to_owned(), runs: 1, values, published };
            Group { places: vec![0], repeats: 0, measurements: vec![means] }
        };
        let fluid = |z, rate| vec![known(FACTOR, "mKLM", z), known("rate", "from mKLM", rate)];
        let both = |z, rate, crystal| [fluid(z, rate), vec![known(FACTOR, CRYSTAL, crystal)]].concat();
        let results = Results {
            quantities: vec![of(FACTOR), of("rate")],
            stages: vec!["measurement".to_owned()],
            points: Vec::new(),
            groups: vec![
                at(12.1, 37.0, fluid(12.0, 37.0)),
                // A crystal and a fluid at a density with published values for both phases.
                at(11.8, 33.0, both(16.0, 50.0, 11.7)),
                at(16.1, 50.0, both(16.0, 50.0, 11.7)),
            ],
        };
        let counts = |quantity: usize| -> Vec<(String, f64, usize, usize)> {
            let all = results.agreements(quantity);
            all.into_iter().map(|it| (it.label, it.chi_square.round(), it.freedom, it.other_phase)).collect()
        };
        assert_eq!(counts(0), [("mKLM".to_owned(), 2.0, 2, 1), (CRYSTAL.to_owned(), 1.0, 1, 1)]);
        assert_eq!(counts(1), [("from mKLM".to_owned(), 0.0, 2, 1)]);
        let left_out: Vec<String> = results.agreements(0).iter().map(Agreement::left_out).collect();
        assert_eq!(left_out, [", without 1 point that is a crystal", ", without 1 point that is a fluid"]);
    }
}
