//! When is the next event? From a relative state to a time from now, or none.
//!
//! One rule decides, for every discontinuity that a pair can reach (paper, section 1):
//!
//! > A pair interacts at the first time at which its overlap function `f <= 0` and `df/dt < 0`.
//!
//! An invalid state that improves is left alone; one that does not gets an interaction now. Nothing here knows absolute
//! time, particle ids or boxes. At a zero of `df/dt` the next derivative that is not zero decides whether `f` falls at once.
//!
//! | module | pairs | paper |
//! |---|---|---|
//! | [`inertial`] | no relative acceleration | Algorithms 2 and 3 |
//! | [`accelerated`] | constant relative acceleration | Algorithms 4, 5 and 6 |
//! | [`plane`] | a particle and a flat wall, or the side of a cell | the rule in one dimension |
//! | [`roots`] | | bracketed roots of polynomials |

pub mod accelerated;
pub mod inertial;
pub mod plane;
pub mod roots;
