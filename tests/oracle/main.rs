//! An exact oracle for event detection.
#![allow(dead_code)]
mod agreement;
mod cases;
mod compare;
mod crossing;
mod detection;
mod dyadic;
mod evaluations;
mod exact;
mod hand;
mod hard_cases;
mod long_run;
mod measure;
mod polynomial;
mod random;
mod regressions;
mod rule;
mod sturm;
mod table;
mod tally;
mod witness;
