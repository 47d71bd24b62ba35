//! Who interacts with whom, and in which state: the table of species, and the memory of pairs.

pub mod contacts;
pub mod memory;
pub mod rows;
pub mod rules;
