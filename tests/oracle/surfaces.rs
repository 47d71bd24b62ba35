//! The exact oracle for features of surfaces: points, lines, segments, faces and planes, where an event has to be on the feature.
//!
//! | modules | |
//! |---|---|
//! | `rounded` | exact numbers with bounds of what floats make of them |
//! | `place` | signs of polynomials at roots of others, and which root comes first |
//! | `rule` | the rule with extents, decided exactly |
//! | `feature`, `question` | what is asked, and its exact polynomials with their boxes |
//! | `compare`, `witness` | how an answer is judged |
//! | `approach`, `families` | states, by family |
//! | `hand`, `agreement`, `regressions` | tests: of the oracle itself, of all features, of each failure ever found |

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
