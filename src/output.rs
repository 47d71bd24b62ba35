//! What a run leaves behind.

pub mod extended_xyz;
pub mod frame;

pub use frame::Frame;
