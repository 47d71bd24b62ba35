//! What a run has measured: numbers and curves with standard errors, in the form in which they are written and drawn.

use serde::{Deserialize, Serialize};

use crate::analysis::statistics::Estimate;

/// Everything that a run has measured; the content of `measurements.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Measured {
    /// Single numbers, such as a diffusion coefficient.
    pub numbers: Vec<Number>,
    /// Curves and grids, such as a radial distribution function; each is a table of its own, too.
    pub curves: Vec<Curve>,
}

/// A number with its standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Name, unique in the run, in lower case with underscores: `diffusion_coefficient`.
    pub name: String,
    /// Name for people.
    pub title: String,
    /// Unit, such as `length^2 / time`; `1` for a pure number.
    pub unit: String,
    /// The mean; `None` for insufficient data.
    pub mean: Option<f64>,
    /// Its standard error; `None` for insufficient data.
    pub standard_error: Option<f64>,
    /// How it is defined and measured, in a sentence with its equation.
    pub method: String,
}

impl Number {
    /// A number of an estimate, if there is one.
    pub(super) fn estimated(name: &str, title: &str, unit: &str, estimate: Option<Estimate>, method: &str) -> Self {
        // What is not finite is not known.
        let estimate = estimate.filter(|estimate| estimate.mean.is_finite());
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            unit: unit.to_owned(),
            mean: estimate.map(|estimate| estimate.mean),
            standard_error: estimate.and_then(|estimate| estimate.standard_error).filter(|error| error.is_finite()),
            method: method.to_owned(),
        }
    }
}

/// A number of each particle at one time, such as its bond order: a column of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalar {
    /// Name, unique in its frame, of ASCII letters, digits and underscores: `q6`.
    pub name: String,
    /// The values, finite, in the order of the particles.
    pub values: Vec<f64>,
}

/// One or more quantities that depend on one variable, or on the coordinates of a grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name, unique in the run; `measurements/NAME.csv` is its table.
    pub name: String,
    /// Name for people.
    pub title: String,
    /// How it is defined and measured, in a sentence with its equation.
    pub method: String,
    /// The independent variables: one for a curve, up to three for a grid. All columns have the same length.
    pub variables: Vec<Variable>,
    /// What was measured.
    pub series: Vec<Series>,
    /// Whether a plot has logarithmic axes, of the variable and of the values.
    pub is_logarithmic: [bool; 2],
    /// Published or exact curves to draw beside it; empty if there are none.
    pub published: Vec<Published>,
}

/// An independent variable of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Variable {
    /// Name for people and head of its column: `r`.
    pub name: String,
    /// Unit: `length`.
    pub unit: String,
    /// Its values.
    pub values: Vec<f64>,
}

/// A measured quantity along the variables of its curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Name for people and head of its column: `g(r) A-B`.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// The means; `None` for insufficient data.
    pub values: Vec<Option<f64>>,
    /// Their standard errors.
    pub standard_errors: Vec<Option<f64>>,
}

/// A curve from elsewhere, to compare with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// What it is, for the legend: `Carnahan and Starling`.
    pub label: String,
    /// Authors, journal, DOI.
    pub source: String,
    /// Values of the variable.
    pub x: Vec<f64>,
    /// Values of the quantity.
    pub y: Vec<f64>,
}
