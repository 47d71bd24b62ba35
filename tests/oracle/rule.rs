//! The exact rule: a pair interacts at the first time at which `f <= 0` and `f` falls.

use super::crossing::{Crossing, first_fall};
use super::dyadic::Dyadic;
use super::polynomial::Polynomial;
use super::sturm::Chain;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Root,
    /// `f` stops rising at a value that is not positive.
    TurningPoint,
}

#[derive(Debug, Clone)]
pub enum Verdict {
    Now,
    Later(Kind, Crossing),
    None,
}

/// Returns the first time `t >= 0` at which `f(t) <= 0` and `f` falls just after `t`.
pub fn next_event(f: &Polynomial) -> Verdict {
    let now = Dyadic::zero();
    if f.sign_at(&now) > 0 {
        return later(Kind::Root, first_fall(f, &now));
    }
    let derivative = f.derivative();
    if derivative.sign_after(&now) < 0 {
        return Verdict::Now;
    }
    let Some(turn) = first_fall(&derivative, &now) else { return Verdict::None };
    if sign_at_crossing(f, &turn) <= 0 {
        return Verdict::Later(Kind::TurningPoint, turn);
    }
    // The narrowed bracket of the turning point contains no root of `f`.
    let (_, after) = turn.bracket();
    later(Kind::Root, first_fall(f, &after))
}

fn later(kind: Kind, at: Option<Crossing>) -> Verdict {
    at.map_or(Verdict::None, |at| Verdict::Later(kind, at))
}

/// Returns the sign of `f` at a root of its derivative. Narrows the bracket of the root.
pub fn sign_at_crossing(f: &Polynomial, turn: &Crossing) -> i32 {
    let chain = Chain::new(f);
    loop {
        let (lower, upper) = turn.bracket();
        let roots = chain.count(&lower, &upper);
        // The bracket contains one root of the derivative. Only this root can be a multiple root of `f`.
        if roots > 0 && chain.common.degree() > 0 && Chain::new(&chain.common).count(&lower, &upper) > 0 {
            return 0;
        }
        if roots == 0 {
            return f.sign_at(&upper);
        }
        turn.narrow();
    }
}
