//! What a run measures beyond its rows, in the form in which it is written and drawn.

pub mod quantity;

pub use quantity::{Curve, Measured, Number, Published, Series, Variable};
