//! Trajectories: a frame, and the extended XYZ that keeps all bits of it.

pub(crate) mod compressed;
pub mod extended_xyz;
pub mod frame;

pub use frame::Frame;
