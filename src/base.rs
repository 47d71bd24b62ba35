//! Tools for all layers: exact sums, numbers as text, checksums, the memory of the machine.

pub(crate) mod checksum;
pub mod clock;
pub mod durability;
pub mod exact;
pub(crate) mod memory;
pub(crate) mod numbers;
pub(crate) mod shortest;
pub mod sum;
pub mod text;
pub(crate) mod whole;
