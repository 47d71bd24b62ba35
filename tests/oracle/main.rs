//! An exact oracle for event detection.
#![allow(dead_code)]
mod crossing;
mod dyadic;
mod exact;
mod hand;
mod polynomial;
mod random;
mod rule;
mod sturm;
