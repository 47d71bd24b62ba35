//! The first time at which a polynomial falls through zero. The bracket of this time can be narrowed to any width.

use super::dyadic::Dyadic;
use super::polynomial::Polynomial;
use super::sturm::Chain;
use std::cell::RefCell;

/// The unique point in `(lower, upper]` at which `f` changes sign from plus to minus.
#[derive(Debug, Clone)]
pub struct Crossing {
    pub f: Polynomial,
    bracket: RefCell<(Dyadic, Dyadic)>,
}

impl Crossing {
    fn new(f: &Polynomial, lower: Dyadic, upper: Dyadic) -> Self {
        Self { f: f.clone(), bracket: RefCell::new((lower, upper)) }
    }

    pub fn bracket(&self) -> (Dyadic, Dyadic) {
        self.bracket.borrow().clone()
    }

    /// Returns whether the crossing is after `x`. Narrows the bracket as far as necessary.
    pub fn is_after(&self, x: &Dyadic) -> bool {
        let (lower, upper) = self.bracket();
        if *x <= lower {
            return true;
        }
        if *x >= upper {
            return false;
        }
        let is_after = self.f.sign_after(x) > 0;
        *self.bracket.borrow_mut() = if is_after { (x.clone(), upper) } else { (lower, x.clone()) };
        is_after
    }

    pub fn narrow(&self) {
        let (lower, upper) = self.bracket();
        self.is_after(&middle(&lower, &upper));
    }

    /// Narrows the bracket until its width is at most `2^-bits` times its upper end.
    pub fn refine(&self, bits: i64) -> (Dyadic, Dyadic) {
        loop {
            let (lower, upper) = self.bracket();
            if (&upper - &lower).magnitude() <= upper.magnitude() - bits {
                return (lower, upper);
            }
            self.narrow();
        }
    }
}

/// Returns the first `t > after` at which `f` changes sign from plus to minus.
pub fn first_fall(f: &Polynomial, after: &Dyadic) -> Option<Crossing> {
    if f.degree() == 0 {
        return None;
    }
    // Number of later roots, possibly plus an even number (Budan's theorem).
    let most = if after.sign() == 0 { f.variations() } else { f.around(after).variations() };
    let upper = Dyadic::power_of_two(f.bound_of_roots());
    if most == 0 || *after >= upper {
        return None;
    }
    let lower = Dyadic::power_of_two(lower_bound(f));
    let lower = if lower > *after { lower } else { after.clone() };
    if most == 1 {
        return (f.sign_far_away() < 0).then(|| Crossing::new(f, lower, upper));
    }
    let chain = Chain::new(f);
    let counts = (chain.variations(&lower), chain.variations_far_away());
    search(f, &chain, (&lower, counts.0), (&upper, counts.1))
}

/// Like [`first_fall`], but only by Sturm's theorem.
pub fn first_fall_by_sturm(f: &Polynomial, after: &Dyadic) -> Option<Crossing> {
    let upper = Dyadic::power_of_two(f.bound_of_roots());
    if f.degree() == 0 || *after >= upper {
        return None;
    }
    let chain = Chain::new(f);
    search(f, &chain, (after, chain.variations(after)), (&upper, chain.variations(&upper)))
}

/// Returns a `k` such that all positive roots are above `2^k`.
fn lower_bound(f: &Polynomial) -> i64 {
    let at_zero = f.coefficients.iter().position(|c| c.bits() != 0).expect("not the polynomial 0");
    let rest = Polynomial::of_integers(f.coefficients[at_zero..].to_vec(), 0);
    if rest.degree() == 0 { 0 } else { rest.bound_of_positive_roots_below() }
}

/// Finds the first fall through zero in `(from, to]`. Halves the interval to isolate roots.
fn search(f: &Polynomial, chain: &Chain, from: (&Dyadic, usize), to: (&Dyadic, usize)) -> Option<Crossing> {
    match from.1 - to.1 {
        0 => None,
        1 => {
            let falls = f.sign_after(from.0) > 0 && f.sign_after(to.0) < 0;
            falls.then(|| Crossing::new(f, from.0.clone(), to.0.clone()))
        }
        _ => {
            let at = middle(from.0, to.0);
            let half = (&at, chain.variations(&at));
            search(f, chain, from, half).or_else(|| search(f, chain, half, to))
        }
    }
}

/// Returns the mean of two non-negative numbers. If the numbers are far apart, returns a power of two between them.
fn middle(lower: &Dyadic, upper: &Dyadic) -> Dyadic {
    let below = if lower.sign() == 0 { upper.magnitude() - 64 } else { lower.magnitude() };
    if upper.magnitude() - below > 2 {
        Dyadic::power_of_two((below + upper.magnitude()).div_euclid(2))
    } else {
        (lower + upper).half()
    }
}
