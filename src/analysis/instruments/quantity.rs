//! Results of instruments: numbers and curves with standard errors.

use serde::{Deserialize, Serialize};

use crate::analysis::statistics::Estimate;

/// Results of all instruments of a run; the content of `measurements.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Measured {
    /// Single numbers, such as a diffusion coefficient.
    pub numbers: Vec<Number>,
    /// Curves and grids, such as a radial distribution function. Each curve is also written to its own table.
    pub curves: Vec<Curve>,
}

impl Measured {
    /// Returns the number with the given name.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<&Number> {
        self.numbers.iter().find(|number| number.name == name)
    }

    /// Calls a function for the units of all numbers, variables, series and divisors.
    pub(crate) fn for_each_unit(&mut self, mut change: impl FnMut(&mut String)) {
        self.numbers.iter_mut().for_each(|number| change(&mut number.unit));
        for curve in &mut self.curves {
            curve.variables.iter_mut().for_each(|variable| change(&mut variable.unit));
            for series in &mut curve.series {
                change(&mut series.unit);
                let divisors = series.normalisation.iter_mut().flat_map(|it| &mut it.divisors);
                divisors.for_each(|divisor| change(&mut divisor.unit));
            }
        }
    }

    /// Returns the curve with the given name.
    #[must_use]
    pub fn curve(&self, name: &str) -> Option<&Curve> {
        self.curves.iter().find(|curve| curve.name == name)
    }

    /// Adds the results of a user's instrument, and makes them acceptable for all readers.
    ///
    /// In names, characters other than letters, digits and `-` become `_`, because curves are saved in files of the
    /// same name. A number is appended to a name that is in use. Columns of a curve are cut to the length of the
    /// shortest column. Rows with an infinite or undefined variable are left out. Infinite and undefined values become
    /// unknown.
    pub(super) fn join(&mut self, own: Self) {
        for mut number in own.numbers {
            number.name = free_name(&number.name, self.numbers.iter().map(|other| other.name.as_str()));
            number.mean = number.mean.filter(|mean| mean.is_finite());
            number.standard_error = number.standard_error.filter(|error| error.is_finite());
            self.numbers.push(number);
        }
        for mut curve in own.curves {
            curve.name = free_name(&curve.name, self.curves.iter().map(|other| other.name.as_str()));
            curve.make_even();
            self.curves.push(curve);
        }
    }
}

pub(super) fn free_name<'n>(name: &str, taken: impl Iterator<Item = &'n str> + Clone) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let plain: String = name.chars().take(50).map(|c| if is_plain(c) { c } else { '_' }).collect();
    let plain = if plain.is_empty() { "unnamed".to_owned() } else { plain };
    let is_free = |name: &str| taken.clone().all(|other| other != name);
    if is_free(&plain) {
        return plain;
    }
    (2_u64..).map(|number| format!("{plain}_{number}")).find(|name| is_free(name)).unwrap_or(plain)
}

/// A scalar result: a mean with its standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Number {
    /// Name, unique in the run, in lower case with underscores: `diffusion_coefficient`.
    pub name: String,
    /// Display name.
    pub title: String,
    /// Unit, such as `length^2 / time`; `1` for a pure number.
    pub unit: String,
    /// The mean value; `None` for insufficient data.
    pub mean: Option<f64>,
    /// Standard error of the mean; `None` for insufficient data.
    pub standard_error: Option<f64>,
    /// Definition and measurement of the quantity, in one sentence with its equation.
    pub method: String,
}

impl Number {
    /// Creates a number from an estimate. `None`, or a mean that is not finite, stands for insufficient data.
    #[must_use]
    pub fn estimated(name: &str, title: &str, unit: &str, estimate: Option<Estimate>, method: &str) -> Self {
        let estimate = estimate.and_then(Estimate::finite);
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            unit: unit.to_owned(),
            mean: estimate.map(|estimate| estimate.mean),
            standard_error: estimate.and_then(|estimate| estimate.standard_error),
            method: method.to_owned(),
        }
    }

    /// Returns the mean with its standard error; `None` for insufficient data.
    #[must_use]
    pub fn estimate(&self) -> Option<Estimate> {
        self.mean.map(|mean| Estimate { mean, standard_error: self.standard_error })
    }
}

/// A per-particle scalar at one time, such as the bond order: a column of a trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Scalar {
    /// Name, unique in its frame, of ASCII letters, digits and underscores: `q6`.
    pub name: String,
    /// One finite value for each particle, in the order of the particles.
    pub values: Vec<f64>,
}

impl Scalar {
    /// Creates a scalar from one value for each particle.
    #[must_use]
    pub fn new(name: &str, values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), values }
    }
}

/// A measured function of one variable, such as a correlation function, or a field on a grid.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Curve {
    /// Name, unique in the run. The table of the curve is `measurements/NAME.csv`.
    pub name: String,
    /// Display name.
    pub title: String,
    /// Definition and measurement of the curve, in one sentence with its equation.
    pub method: String,
    /// The independent variables: one for a curve, up to three for a grid.
    pub variables: Vec<Variable>,
    /// Measured series. All series and variables have the same number of rows.
    pub series: Vec<Series>,
    /// Whether a plot has logarithmic axes: first for the variable, then for the values.
    pub is_logarithmic: [bool; 2],
    /// Published or exact curves that are drawn together with this curve; may be empty.
    pub published: Vec<Published>,
}

impl Curve {
    /// Creates a curve without columns, on linear axes.
    #[must_use]
    pub fn new(name: &str, title: &str, method: &str) -> Self {
        Self { name: name.to_owned(), title: title.to_owned(), method: method.to_owned(), ..Self::default() }
    }

    /// Adds an independent variable with its column of values.
    #[must_use]
    pub fn variable(mut self, name: &str, unit: &str, values: Vec<f64>) -> Self {
        self.variables.push(Variable { name: name.to_owned(), unit: unit.to_owned(), values });
        self
    }

    /// Adds a measured quantity: one estimate for each value of the variables, `None` for insufficient data.
    #[must_use]
    pub fn series(mut self, name: &str, unit: &str, estimates: &[Option<Estimate>]) -> Self {
        self.series.push(Series {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: estimates.iter().map(|estimate| estimate.map(|estimate| estimate.mean)).collect(),
            standard_errors: estimates.iter().map(|estimate| estimate.and_then(|it| it.standard_error)).collect(),
            normalisation: None,
        });
        self
    }

    /// Sets the normalisation of the series that was added last.
    #[must_use]
    pub fn normalised(mut self, by: Normalisation) -> Self {
        if let Some(series) = self.series.last_mut() {
            series.normalisation = Some(by);
        }
        self
    }

    pub(super) fn logarithmic(self, is_logarithmic: [bool; 2]) -> Self {
        Self { is_logarithmic, ..self }
    }

    pub(super) fn beside(self, published: impl IntoIterator<Item = Published>) -> Self {
        Self { published: published.into_iter().collect(), ..self }
    }

    /// Cuts all columns to the same number of rows, and removes rows in which a variable is not finite.
    fn make_even(&mut self) {
        let lengths = self.variables.iter().map(|variable| variable.values.len());
        let others = self.series.iter().flat_map(|series| [series.values.len(), series.standard_errors.len()]);
        let rows = lengths.chain(others).min().unwrap_or(0);
        let is_kept = |row: &usize| self.variables.iter().all(|variable| variable.values[*row].is_finite());
        let kept: Vec<usize> = (0..rows).filter(is_kept).collect();
        for variable in &mut self.variables {
            variable.values = kept.iter().map(|&row| variable.values[row]).collect();
        }
        let divisors = self.series.iter_mut().filter_map(|series| series.normalisation.as_mut());
        for divisor in divisors.flat_map(|it| &mut it.divisors).filter(|divisor| divisor.values.len() != 1) {
            divisor.values = kept.iter().map(|&row| divisor.values.get(row).copied().unwrap_or(0.0)).collect();
        }
        for column in self.series.iter_mut().flat_map(|series| [&mut series.values, &mut series.standard_errors]) {
            *column = kept.iter().map(|&row| column[row].filter(|value| value.is_finite())).collect();
        }
    }
}

/// An independent variable of a curve or grid, with its values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Variable {
    /// Name of the variable in plots and table headers, for example `r`.
    pub name: String,
    /// Unit, for example `length`.
    pub unit: String,
    /// The values.
    pub values: Vec<f64>,
}

/// A measured quantity of a curve or grid, with one value in each row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Series {
    /// Name of the quantity in plots and table headers, for example `g(r) A-B`.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// The mean values; `None` for insufficient data.
    pub values: Vec<Option<f64>>,
    /// The standard errors of the values.
    pub standard_errors: Vec<Option<f64>>,
    /// The divisors that turned a sum into the values of this series; `None` if unknown.
    #[serde(default)]
    pub normalisation: Option<Normalisation>,
}

/// Divisors of the values of a series. A value times all divisors is the original count or sum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Normalisation {
    /// Description of the sum or count before division, for example `pairs in the bin, over all samples`.
    pub sum: String,
    /// The divisors; empty if the values are plain counts.
    pub divisors: Vec<Divisor>,
}

/// A number by which the values of a series were divided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Divisor {
    /// Name of the divisor, in lower case with underscores, for example `samples`.
    pub name: String,
    /// Unit of the divisor; `1` for a pure number.
    pub unit: String,
    /// A single divisor for all values, or one divisor for each value. Infinite and undefined divisors are stored as 0.
    pub values: Vec<f64>,
}

impl Normalisation {
    /// Creates the normalisation of a sum or count, without divisors.
    #[must_use]
    pub fn of(sum: &str) -> Self {
        Self { sum: sum.to_owned(), divisors: Vec::new() }
    }

    /// Divides all values by the same number.
    #[must_use]
    pub fn by(self, name: &str, unit: &str, value: f64) -> Self {
        self.by_each(name, unit, vec![value])
    }

    /// Divides each value of the series by the element of `values` at the same index.
    #[must_use]
    pub fn by_each(mut self, name: &str, unit: &str, mut values: Vec<f64>) -> Self {
        // Results files cannot store infinite or undefined values.
        values.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = 0.0);
        self.divisors.push(Divisor { name: name.to_owned(), unit: unit.to_owned(), values });
        self
    }
}

/// A published or exact curve, for comparison with a measured curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Published {
    /// Label in the legend: `Carnahan and Starling`.
    pub label: String,
    /// Authors, journal, DOI.
    pub source: String,
    /// Values of the independent variable.
    pub x: Vec<f64>,
    /// Values of the quantity, in the order of `x`.
    pub y: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn user_results_get_unique_names_and_equal_columns() {
        let estimate = |mean: f64| Some(Estimate { mean, standard_error: Some(0.5) });
        let number = |name: &str, mean: f64| Number::estimated(name, "", "1", estimate(mean), "");
        let mut measured = Measured { numbers: vec![number("pressure", 1.0)], curves: vec![Curve::new("g", "", "")] };
        let pairs = Normalisation::of("pairs").by("samples", "1", 7.0).by_each("ideal", "1", vec![2.0, 5.0, f64::NAN]);
        let curve = Curve::new("../g r", "", "")
            .variable("r", "length", vec![1.0, f64::NAN, 3.0, 4.0])
            .series("g", "1", &[estimate(1.0), None, estimate(f64::INFINITY)])
            .normalised(pairs);
        let own = Measured {
            numbers: vec![number("pressure", 2.0), number("pressure", f64::NAN)],
            curves: vec![curve, Curve::new("", "", "")],
        };
        measured.join(own);
        let names: Vec<_> = measured.numbers.iter().map(|number| number.name.as_str()).collect();
        assert_eq!(names, ["pressure", "pressure_2", "pressure_3"]);
        assert_eq!(measured.numbers[2].mean, None);
        assert_eq!(measured.number("pressure_2").map(|number| number.mean), Some(Some(2.0)));
        assert!(measured.number("pressure_4").is_none() && measured.curve("pressure").is_none());
        assert_eq!(measured.curve("___g_r"), Some(&measured.curves[1]));
        let names: Vec<_> = measured.curves.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["g", "___g_r", "unnamed"]);
        assert_eq!(measured.curves[1].variables[0].values, [1.0, 3.0]);
        assert_eq!(measured.curves[1].series[0].values, [Some(1.0), None]);
        assert_eq!(measured.curves[1].series[0].standard_errors, [Some(0.5); 2]);
        let divisors = &measured.curves[1].series[0].normalisation.as_ref().unwrap().divisors;
        assert_eq!((&divisors[0].values[..], &divisors[1].values[..]), (&[7.0][..], &[2.0, 0.0][..]));
    }
}
