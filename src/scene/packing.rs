//! Positions of particles that are not listed: random insertion, and compression of small spheres where that finds no room.

pub(crate) mod compression;
pub(crate) mod insertion;
pub(crate) mod occupancy;
