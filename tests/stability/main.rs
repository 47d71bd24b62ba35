//! Whole runs of systems that are dense, degenerate, at rest, or invalid from the start. Tolerances for round-off are
//! derived where they are used.

mod apart;
mod bits;
mod bonds;
mod corner;
mod cradle;
mod dense;
mod fingerprints;
mod half_a_period;
mod heap;
mod invalid;
mod listed;
mod masses;
mod meshes;
mod overhang;
mod reversal;
mod rounded;
mod ties;
mod watched;
