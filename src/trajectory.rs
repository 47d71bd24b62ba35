//! Trajectories: a frame, and the extended XYZ that keeps all bits of it.

pub mod extended_xyz;
pub mod frame;

pub use frame::Frame;
