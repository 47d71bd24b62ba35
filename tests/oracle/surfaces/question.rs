//! Exact polynomials of a motion and a feature, with an interval for each rounded coefficient.

use super::rounded::{ROUND_OFF, Rounded};
use super::rule::{Exact, Kind, Overlap};
use crate::dyadic::Dyadic;
use crate::polynomial::Polynomial;

/// A polynomial with exact coefficients, constant term first. The errors are half the widths of the box.
#[derive(Debug, Clone)]
pub struct Form {
    pub coefficients: Vec<Dyadic>,
    pub errors: Vec<f64>,
    pub computed: Vec<f64>,
}

impl Form {
    /// `roundings[k]` is the number of roundings of a term of degree `k`.
    pub fn new(terms: &[Rounded], computed: &[f64], roundings: &[u32]) -> Self {
        let error = |(term, n): (&Rounded, &u32)| term.error + f64::from(*n) * ROUND_OFF * (term.size + term.error);
        Self {
            coefficients: terms.iter().map(|term| term.exact.clone()).collect(),
            errors: terms.iter().zip(roundings).map(error).collect(),
            computed: computed.to_vec(),
        }
    }

    /// Returns the position of Carom's coefficients in the box, in units of the errors.
    pub fn place_of_computed(&self) -> Vec<f64> {
        let part = |((exact, error), computed): ((&Dyadic, &f64), &f64)| {
            let off = (&Dyadic::from(*computed) - exact).to_f64();
            if off == 0.0 { 0.0 } else { off / error }
        };
        self.coefficients.iter().zip(&self.errors).zip(&self.computed).map(part).collect()
    }

    /// Returns the exact coefficients, shifted by multiples of the errors.
    pub fn moved(&self, parts: &[f64]) -> Vec<Dyadic> {
        let terms = self.coefficients.iter().zip(&self.errors).zip(parts);
        terms.map(|((c, error), part)| c + &(&Dyadic::from(*error) * &Dyadic::from(*part))).collect()
    }
}

/// Meaning of the overlap function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The height above a plane.
    Linear,
    /// A squared distance times this sign. The leading coefficient has the same sign.
    Square(i32),
    /// The height above a face, followed by the contact distance. The face is solid on both sides.
    TwoSided,
}

pub const DISTANCE: usize = 3;

/// The overlap function and the extents, which decide the next event.
#[derive(Debug, Clone)]
pub struct Question {
    pub shape: Shape,
    pub forms: Vec<Form>,
    /// The overlap function without acceleration, if the acceleration across a line is zero within rounding.
    pub without_acceleration: Option<Form>,
}

pub struct Functional {
    pub form: usize,
    pub weights: Vec<Dyadic>,
}

impl Functional {
    pub fn value(&self, coefficients: &[Dyadic]) -> Dyadic {
        let terms = self.weights.iter().zip(coefficients).map(|(weight, c)| weight * c);
        terms.fold(Dyadic::zero(), |sum, term| &sum + &term)
    }
}

impl Question {
    pub fn exact(&self) -> Exact {
        let middles: Vec<_> = self.forms.iter().map(|form| form.coefficients.clone()).collect();
        self.with(&middles).expect("the exact square is one")
    }

    /// Returns whether the contact distance of a face is smaller than the rounding errors of heights.
    pub fn is_thin(&self) -> bool {
        let Form { coefficients, errors, .. } = &self.forms[0];
        self.shape == Shape::TwoSided && coefficients[DISTANCE].to_f64() <= errors[DISTANCE]
    }

    /// Replaces the overlap function by the function without acceleration.
    pub fn straight(&self) -> Option<Self> {
        let mut forms = self.forms.clone();
        forms[0] = self.without_acceleration.clone()?;
        Some(Self { shape: self.shape, forms, without_acceleration: None })
    }

    /// Returns `None` if the leading coefficient of a squared distance has the wrong sign.
    pub fn with(&self, coefficients: &[Vec<Dyadic>]) -> Option<Exact> {
        let (first, extents) = coefficients.split_first().expect("an overlap function");
        let overlap = match self.shape {
            Shape::TwoSided => Overlap::Height(Polynomial::new(&first[..DISTANCE]), first[DISTANCE].clone()),
            Shape::Square(sign) if first.len() > 2 && first[first.len() - 1].sign() == -sign => return None,
            _ => Overlap::Value(Polynomial::new(first)),
        };
        Some(Exact { overlap, extents: extents.iter().map(|extent| Polynomial::new(extent)).collect() })
    }

    /// Returns a linear function of the coefficients that is zero if the event happens at `t`.
    pub fn functional(&self, kind: Kind, t: f64) -> Functional {
        let form = match kind {
            Kind::Entry(k) | Kind::Touch(k) => k + 1,
            _ => 0,
        };
        let mut count = self.forms[form].coefficients.len();
        let is_two_sided = form == 0 && self.shape == Shape::TwoSided;
        count -= usize::from(is_two_sided);
        let time = Dyadic::from(t);
        let mut weights = vec![Dyadic::from(1.0)];
        for k in 1..count {
            weights.push(&weights[k - 1] * &time);
        }
        if matches!(kind, Kind::TurningPoint | Kind::Touch(_)) {
            weights.pop();
            weights = weights.iter().enumerate().map(|(k, power)| power * &Dyadic::from(k as f64 + 1.0)).collect();
            weights.insert(0, Dyadic::zero());
        }
        if is_two_sided {
            let is_root = matches!(kind, Kind::Root { .. });
            if kind == (Kind::Root { is_below: true }) {
                weights = weights.iter().map(|weight| -weight).collect();
            }
            weights.push(if is_root { Dyadic::from(-1.0) } else { Dyadic::zero() });
        }
        Functional { form, weights }
    }

    /// Returns the largest change of a linear function when the coefficients vary within the box.
    pub fn error_of(&self, functional: &Functional) -> f64 {
        let terms = functional.weights.iter().zip(&self.forms[functional.form].errors);
        terms.map(|(weight, error)| weight.to_f64().abs() * error).sum()
    }

    /// Returns all possible kinds of events, except `Touch`, which Carom never computes.
    pub fn kinds(&self) -> Vec<Kind> {
        let below = (self.shape == Shape::TwoSided).then_some(Kind::Root { is_below: true });
        let entries = (0..self.forms.len() - 1).map(Kind::Entry);
        [super::rule::ROOT, Kind::TurningPoint].into_iter().chain(below).chain(entries).collect()
    }
}
