//! Stability: whole runs of cases that break other programs, dense, degenerate, at rest and invalid from the
//! start; and influences that must not change a run.
//!
//! Tolerances are for round-off, and derived where they are used.

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
