//! The exact rule for a contact with a feature that has ends:
//!
//! > The first time `t >= 0` at which `f(t) <= 0`, `f` falls just after `t`, and no extent `b_k(t) < 0`.
//!
//! An extent is the distance of the foot of the perpendicular from an end of the feature. It is positive on the
//! feature. The first contact is now, or when the conditions on `f` begin to be true, or when an extent stops being
//! negative.

use super::place::{Place, falls, order};
use crate::crossing::Crossing;
use crate::dyadic::Dyadic;
use crate::polynomial::Polynomial;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The overlap function falls through zero. A sphere may come from below a face.
    Root { is_below: bool },
    /// The overlap function stops rising at a value that is not positive.
    TurningPoint,
    /// An extent rises through zero while the overlap function is not positive and falls.
    Entry(usize),
    /// An extent touches zero from below while the overlap function is not positive and falls.
    Touch(usize),
}

/// The overlap function falls through zero. A face is approached from above.
pub const ROOT: Kind = Kind::Root { is_below: false };

#[derive(Debug, Clone)]
pub enum Verdict {
    Now,
    Later(Kind, Crossing),
    None,
}

#[derive(Debug, Clone)]
pub enum Overlap {
    /// `f(t)`.
    Value(Polynomial),
    /// `|h(t)| - s`, for a face.
    Height(Polynomial, Dyadic),
}

#[derive(Debug, Clone)]
pub struct Exact {
    pub overlap: Overlap,
    pub extents: Vec<Polynomial>,
}

impl Overlap {
    /// Returns the gaps above and below a face, `h - s` and `-h - s`.
    fn gaps(height: &Polynomial, distance: &Dyadic) -> [Polynomial; 2] {
        [1, -1].map(|side| shifted(height, side, distance))
    }

    fn asks_at(&self, place: &Place<'_>) -> bool {
        match self {
            Self::Value(f) => place.sign(f) <= 0 && place.sign_after(&f.derivative()) < 0,
            Self::Height(height, distance) => {
                // At height 0, the distance from the face has its minimum.
                let side = place.sign(height);
                side * place.sign_after(&height.derivative()) < 0
                    && Self::gaps(height, distance).iter().all(|gap| place.sign(gap) <= 0)
            }
        }
    }

    /// Returns the times after now at which the conditions on the overlap function may become true.
    fn beginnings(&self) -> Vec<(Kind, Crossing)> {
        let mut found = Vec::new();
        let mut add = |kind: Kind, f: &Polynomial| found.extend(falls(f).into_iter().map(|crossing| (kind, crossing)));
        match self {
            Self::Value(f) => {
                add(ROOT, f);
                add(Kind::TurningPoint, &f.derivative());
            }
            // By round-off, the contact distance may be zero or negative. Then no contact is possible.
            Self::Height(_, distance) if distance.sign() <= 0 => {}
            Self::Height(height, distance) => {
                let [above, below] = Self::gaps(height, distance);
                add(ROOT, &above);
                add(Kind::Root { is_below: true }, &below);
                let rate = height.derivative();
                add(Kind::TurningPoint, &rate);
                add(Kind::TurningPoint, &negative(&rate));
            }
        }
        found
    }
}

fn shifted(f: &Polynomial, side: i32, distance: &Dyadic) -> Polynomial {
    let mut coefficients: Vec<_> = f
        .coefficients
        .iter()
        .map(|c| Dyadic { mantissa: c * side, exponent: f.exponent })
        .chain(f.is_zero().then(Dyadic::zero))
        .collect();
    coefficients[0] = &coefficients[0] - distance;
    Polynomial::new(&coefficients)
}

fn negative(f: &Polynomial) -> Polynomial {
    Polynomial { coefficients: f.coefficients.iter().map(|c| -c).collect(), exponent: f.exponent }
}

pub fn next_event(exact: &Exact) -> Verdict {
    if exact.overlap.asks_at(&Place::Now) && exact.is_on(&Place::Now, None) {
        return Verdict::Now;
    }
    // Of simultaneous events, the first in the list is returned.
    let first = possible_events(exact).reduce(|a, b| if order(&a.1, &b.1).is_gt() { b } else { a });
    first.map_or(Verdict::None, |(kind, crossing)| Verdict::Later(kind, crossing))
}

/// Returns all times after now at which the conditions of the rule begin to be true, with the kind of event.
pub fn possible_events(exact: &Exact) -> impl Iterator<Item = (Kind, Crossing)> {
    let Exact { overlap, extents } = exact;
    let mut candidates = overlap.beginnings();
    for (k, extent) in extents.iter().enumerate() {
        candidates.extend(falls(&negative(extent)).into_iter().map(|crossing| (Kind::Entry(k), crossing)));
        candidates.extend(touch(extent).map(|crossing| (Kind::Touch(k), crossing)));
    }
    candidates.into_iter().filter(|(kind, crossing)| {
        let place = Place::At(crossing);
        match kind {
            // At a fall through zero, the overlap function is always falling and not positive.
            Kind::Root { .. } => exact.is_on(&place, None),
            Kind::TurningPoint => overlap.asks_at(&place) && exact.is_on(&place, None),
            Kind::Entry(k) | Kind::Touch(k) => overlap.asks_at(&place) && exact.is_on(&place, Some(*k)),
        }
    })
}

impl Exact {
    fn is_on(&self, place: &Place<'_>, zero: Option<usize>) -> bool {
        let mut extents = self.extents.iter().enumerate();
        extents.all(|(k, extent)| zero == Some(k) || place.sign(extent) >= 0)
    }
}

/// Returns the time after now at which a parabola touches zero from below.
fn touch(extent: &Polynomial) -> Option<Crossing> {
    if extent.degree() != 2 || extent.sign_far_away() > 0 {
        return None;
    }
    let [c, b, a] = &extent.coefficients[..] else { return None };
    (b * b == a * c * 4).then(|| falls(&extent.derivative()).pop())?
}
