//! The exact oracle for features of surfaces: points, lines, segments, faces and planes. An event counts only if the
//! foot of the perpendicular is on the feature.
//!
//! | modules | |
//! |---|---|
//! | `rounded` | exact numbers with bounds on their floating-point errors |
//! | `place` | signs of polynomials at roots of others, and the order of roots |
//! | `rule` | the rule for the next contact, decided exactly |
//! | `feature`, `question` | the sphere and the feature, with their exact polynomials and the boxes around them |
//! | `compare`, `witness` | the judgement of an answer |
//! | `approach`, `families` | families of states |
//! | `hand`, `agreement`, `regressions` | tests: of the oracle itself, of all features, of every failure ever found |

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
