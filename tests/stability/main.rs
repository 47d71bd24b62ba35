//! Stability: whole runs of the cases that break others, dense, degenerate, at rest and invalid from the start; and what must
//! not change a run, or undoes it.
//!
//! Tolerances are those of round-off, derived where they are used.

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
