//! Counts distinct roots between two numbers by Sturm's theorem, in exact integers.

use super::dyadic::{Dyadic, sign};
use super::polynomial::{Polynomial, count_variations};
use num_bigint::BigInt;

/// The Sturm sequence of a polynomial, divided by its last element. Without the division, all elements would be zero at
/// a multiple root.
pub struct Chain {
    elements: Vec<Polynomial>,
    /// The greatest common divisor of the polynomial and its derivative. Roots of the divisor are multiple roots.
    pub common: Polynomial,
}

impl Chain {
    pub fn new(f: &Polynomial) -> Self {
        let mut elements = remainders(f, &f.derivative());
        let common = elements.last().cloned().expect("the polynomial itself");
        if common.degree() > 0 {
            // Division by a common factor does not change the number of sign changes.
            elements = elements.iter().map(|e| quotient(e, &common)).collect();
        }
        Self { elements, common }
    }

    /// Returns the number of distinct roots in `(from, to]`.
    pub fn count(&self, from: &Dyadic, to: &Dyadic) -> usize {
        self.variations(from) - self.variations(to)
    }

    pub fn variations(&self, x: &Dyadic) -> usize {
        count_variations(self.elements.iter().map(|e| e.sign_at(x)))
    }

    pub fn variations_far_away(&self) -> usize {
        count_variations(self.elements.iter().map(Polynomial::sign_far_away))
    }
}

/// Returns the greatest common divisor, up to a constant factor. It is constant if there are no common roots.
pub fn common_factor(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let (a, b) = if a.degree() < b.degree() { (b, a) } else { (a, b) };
    remainders(a, b).pop().expect("the polynomial itself")
}

/// Returns the sequence `f, g, -(f mod g), ...` down to the last nonzero element, up to positive factors. The degree of
/// `g` must not exceed the degree of `f`. To keep coefficients short, each pseudo-remainder is divided by a known
/// factor (subresultants, Brown and Traub 1971). The signs of these factors are tracked for Sturm's theorem.
fn remainders(f: &Polynomial, g: &Polynomial) -> Vec<Polynomial> {
    let (mut a, mut b) = (f.coefficients.clone(), g.coefficients.clone());
    // Up to positive factors, two successive elements are `sign_a a` and `sign_b b`.
    let (mut sign_a, mut sign_b) = (1, 1);
    let (mut g, mut h) = (BigInt::from(1), BigInt::from(1));
    let mut elements = vec![signed(&a, 1)];
    while !b.is_empty() {
        elements.push(signed(&b, sign_b));
        let step = u32::try_from(a.len() - b.len()).unwrap();
        let mut rest = pseudo_remainder(&a, &b);
        let divisor = &g * h.pow(step);
        for c in &mut rest {
            *c /= &divisor;
        }
        // With the leading coefficient `lc(b)`, pseudo-division gives `lc(b)^(step + 1) * a = q * b + divisor * rest`.
        // The sign of the remainder is the product of the signs of `rest`, `divisor` and the power of `lc(b)`.
        let of_leading = if step.is_multiple_of(2) { leading_sign(&b) } else { 1 };
        let sign_rest = -sign_a * of_leading * sign(&divisor);
        g = b.last().expect("not empty").clone();
        h = if step == 0 { h } else { g.pow(step) / h.pow(step - 1) };
        (a, sign_a) = (b, sign_b);
        (b, sign_b) = (rest, sign_rest);
    }
    elements
}

fn leading_sign(c: &[BigInt]) -> i32 {
    c.last().map_or(0, sign)
}

fn signed(c: &[BigInt], sign: i32) -> Polynomial {
    Polynomial::of_integers(c.iter().map(|c| c * sign).collect(), 0)
}

fn pseudo_remainder(a: &[BigInt], b: &[BigInt]) -> Vec<BigInt> {
    divide(a, b).1
}

/// Returns a positive multiple of `a / b`. The remainder must be zero.
fn quotient(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let (quotient, rest) = divide(&a.coefficients, &b.coefficients);
    assert!(rest.is_empty(), "the divisor is common to all elements");
    // Pseudo-division multiplies by a power of the leading coefficient of `b`, which may be negative.
    let power = a.coefficients.len() - b.coefficients.len() + 1;
    let flip = if power % 2 == 1 { leading_sign(&b.coefficients) } else { 1 };
    signed(&quotient, flip)
}

/// Returns `(q, r)` with `lc(b)^(deg a - deg b + 1) a = q b + r`, where `lc(b)` is the leading coefficient of `b`.
fn divide(a: &[BigInt], b: &[BigInt]) -> (Vec<BigInt>, Vec<BigInt>) {
    let leading = b.last().expect("the divisor is not zero");
    let (mut rest, mut quotient) = (a.to_vec(), Vec::new());
    for shift in (0..=a.len() - b.len()).rev() {
        let factor = rest.pop().expect("as long as the divisor");
        for c in rest.iter_mut().chain(&mut quotient) {
            *c *= leading;
        }
        for (k, c) in b[..b.len() - 1].iter().enumerate() {
            rest[shift + k] -= &factor * c;
        }
        quotient.push(factor);
    }
    quotient.reverse();
    (quotient, Polynomial::of_integers(rest, 0).coefficients)
}
