//! The exact oracle for features of surfaces: points, lines, segments, faces and planes. An event requires that the
//! foot of the perpendicular is on the feature.
//!
//! | modules | |
//! |---|---|
//! | `rounded` | exact numbers with bounds on their floating-point errors |
//! | `place` | signs at roots, and the order of roots |
//! | `rule` | the exact rule for the next contact |
//! | `feature`, `question` | the sphere and the feature, as exact polynomials |
//! | `compare`, `witness` | the check of an answer |
//! | `approach`, `families` | families of states |
//! | `hand`, `agreement`, `regressions` | tests |

mod agreement;
mod approach;
mod compare;
mod families;
mod feature;
mod hand;
mod place;
mod question;
mod regressions;
mod rounded;
mod rule;
mod witness;
