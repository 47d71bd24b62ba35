//! Decides the sign of a polynomial at a root of another polynomial, and the order of two roots.

use crate::crossing::{Crossing, first_fall};
use crate::dyadic::Dyadic;
use crate::polynomial::Polynomial;
use crate::sturm::{Chain, common_factor};
use std::cmp::Ordering;

/// A time at which the sign of a polynomial is decided.
#[derive(Debug, Clone, Copy)]
pub enum Place<'a> {
    Now,
    At(&'a Crossing),
}

impl Place<'_> {
    pub fn sign(&self, g: &Polynomial) -> i32 {
        match self {
            Self::Now => g.sign_at(&Dyadic::zero()),
            Self::At(crossing) => sign_at(g, crossing),
        }
    }

    /// Returns the sign of a polynomial just after this time, which is the sign of the first nonzero derivative.
    pub fn sign_after(&self, g: &Polynomial) -> i32 {
        if g.is_zero() {
            return 0;
        }
        match self.sign(g) {
            0 => self.sign_after(&g.derivative()),
            sign => sign,
        }
    }
}

/// Number of bisections before the expensive search for a common root, which is rare.
const HALVINGS: usize = 40;

/// Number of attempts with Budan's theorem, which cannot exclude a root at a turning point.
const CHEAP: usize = 4;

/// Returns the sign of `g` at a crossing of another polynomial. Narrows the bracket as far as necessary.
fn sign_at(g: &Polynomial, crossing: &Crossing) -> i32 {
    if g.degree() == 0 {
        return g.sign_far_away();
    }
    let mut chain = None;
    for step in 0.. {
        let (lower, upper) = crossing.bracket();
        let has_root = if step < CHEAP {
            count_at_most(g, &lower, &upper) > 0
        } else {
            chain.get_or_insert_with(|| Chain::new(g)).count(&lower, &upper) > 0
        };
        if !has_root {
            return g.sign_at(&upper);
        }
        if step == HALVINGS && is_common_root(g, &crossing.f, &lower, &upper) {
            return 0;
        }
        crossing.narrow();
    }
    unreachable!("roots that differ are apart")
}

/// Returns the largest possible number of roots in `(from, to]` by Budan's theorem.
fn count_at_most(g: &Polynomial, from: &Dyadic, to: &Dyadic) -> usize {
    let variations = |x: &Dyadic| if x.sign() == 0 { g.variations() } else { g.around(x).variations() };
    variations(from) - variations(to)
}

fn is_common_root(a: &Polynomial, b: &Polynomial, from: &Dyadic, to: &Dyadic) -> bool {
    let common = common_factor(a, b);
    common.degree() > 0 && Chain::new(&common).count(from, to) > 0
}

/// Returns the order of two crossings. Narrows the brackets until they are disjoint or contain a common root.
pub fn order(a: &Crossing, b: &Crossing) -> Ordering {
    for step in 0.. {
        let ((a_lower, a_upper), (b_lower, b_upper)) = (a.bracket(), b.bracket());
        if a_upper <= b_lower {
            return Ordering::Less;
        }
        if b_upper <= a_lower {
            return Ordering::Greater;
        }
        if step == HALVINGS {
            let lower = if a_lower > b_lower { a_lower } else { b_lower };
            let upper = if a_upper < b_upper { a_upper } else { b_upper };
            if lower < upper && is_common_root(&a.f, &b.f, &lower, &upper) {
                return Ordering::Equal;
            }
        }
        let (a_width, b_width) = (&a.bracket().1 - &a.bracket().0, &b.bracket().1 - &b.bracket().0);
        if a_width > b_width { a.narrow() } else { b.narrow() }
    }
    unreachable!("roots that differ are apart")
}

/// Returns all times after now at which a polynomial changes sign from plus to minus.
pub fn falls(f: &Polynomial) -> Vec<Crossing> {
    let mut found = Vec::new();
    let mut after = Dyadic::zero();
    while let Some(crossing) = first_fall(f, &after) {
        after = crossing.bracket().1;
        found.push(crossing);
    }
    found
}
