//! The oracle itself.
