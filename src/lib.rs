//! Event-driven particle dynamics.

pub mod error;
pub mod output;
pub mod picture;
pub mod potential;
pub mod scene;
pub mod space;

/// A vector in space; the components along flat axes are exactly zero.
pub type Vector = nalgebra::Vector3<f64>;
