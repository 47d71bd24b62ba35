//! The exact oracle for features of surfaces: points, lines, segments, faces and planes. An event must be on
//! the feature.
//!
//! | modules | |
//! |---|---|
//! | `rounded` | exact numbers with bounds on their floating-point errors |
//! | `place` | signs of polynomials at roots of others, and the order of roots |
//! | `rule` | the rule with extents, decided exactly |
//! | `feature`, `question` | the questions, with their exact polynomials and boxes |
//! | `compare`, `witness` | how an answer is judged |
//! | `approach`, `families` | states, by family |
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
