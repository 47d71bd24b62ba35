//! Detection: the time from a relative state to the next event, if there is one.
//!
//! One rule decides, for every discontinuity that a pair can reach (paper, section 1):
//!
//! > A pair interacts at the first time at which its overlap function `f <= 0` and `df/dt < 0`.
//!
//! A pair in an invalid state does not interact while its state improves. If the state gets worse, the pair interacts
//! immediately. At a zero of `df/dt`, the next derivative that is not zero decides whether `f` falls.
//!
//! The result is exact for coefficients that differ from the given coefficients only by rounding errors. The test
//! target `oracle` checks this for components that are zero or between `1e-50` and `1e50` in magnitude. Scenes with
//! larger numbers are rejected, because a product of four such numbers would overflow.
//!
//! | module | pairs | paper |
//! |---|---|---|
//! | [`inertial`] | no relative acceleration | Algorithms 2 and 3 |
//! | [`accelerated`] | constant relative acceleration | Algorithms 4, 5 and 6 |
//! | [`plane`] | a particle and a flat wall, or the face of a cell | the rule in one dimension |
//! | [`feature`] | a particle and a point, line or face of a surface, with its ends | Algorithms 2 to 6 on the motion across it |
//! | `never` | proofs that there is never an event | |
//! | [`stretch`] | times at which an overlap function is falling and not positive, and the foot is on a feature | |
//! | [`roots`] | | bracketed roots of polynomials |

pub mod accelerated;
pub mod feature;
pub mod inertial;
pub(crate) mod lanes;
pub(crate) mod never;
pub mod plane;
pub mod roots;
pub mod stretch;
