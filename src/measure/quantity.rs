//! What a run has measured: numbers and curves with standard errors, in the form in which they are written and drawn.

use serde::{Deserialize, Serialize};

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
