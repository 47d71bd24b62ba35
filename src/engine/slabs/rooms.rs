//! Memory in shared arrays that is set apart for one thread.

use std::ops::Range;

/// Places in shared arrays that one thread may fill. The arrays cannot be enlarged while several threads use them.
#[derive(Debug, Clone, Default)]
pub struct Rooms {
    /// Unused blocks of the neighbour lists, and free runs of blocks by their length.
    pub blocks: Range<u32>,
    pub runs: Vec<Vec<u32>>,
    /// Number of blocks that suffices for a rebuild.
    pub needed: u32,
    /// Unused blocks of the cells of each level.
    pub of_levels: Vec<Vec<u32>>,
}
