//! Trajectories: frames, and files in the extended XYZ format that preserve all bits of a frame.

pub(crate) mod compressed;
pub mod extended_xyz;
pub mod frame;

pub use frame::Frame;
