//! Event-driven particle dynamics.

pub mod audit;
pub mod detection;
pub mod error;
pub mod event;
pub mod interaction;
pub mod motion;
pub mod neighbours;
pub mod observe;
pub mod output;
pub mod overlap;
pub mod picture;
pub mod potential;
pub mod queue;
pub mod reference;
pub mod response;
pub mod run;
pub mod scene;
pub mod simulation;
pub mod space;
pub mod statistics;

/// A vector in space; the components along flat axes are exactly zero.
pub type Vector = nalgebra::Vector3<f64>;
