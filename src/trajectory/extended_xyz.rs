//! Trajectories as extended XYZ: text that OVITO and ASE open with cell, species, velocities, radii and ids.
//!
//! A frame is a line with the number of particles, a comment line of `key=value` pairs, and a line per particle:
//!
//! ```text
//! 2
//! Lattice="5 0 0 0 5 0 0 0 1" Origin="0 0 0" Properties=type:S:1:pos:R:3:velo:R:3:radius:R:1:id:I:1:map_shift:I:3:masses:R:1 Time=0.5 pbc="T T F" flat="F F T" species_table="ball" static="F" species_mass="1"
//! ball 0.5 0.5 0 1 0 0 0.5 0 0 0 0 1
//! ball 2.5 0.5 0 -1 0 0 0.5 1 -2 0 0 1
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `Lattice` | the edge vectors of the box in order; along flat axes the largest diameter, because readers reject a cell without volume; in a sheared box `Lx 0 0 d Ly 0 0 0 Lz`, where `d` is the displacement of the next image along y |
//! | `Origin` | the lower corner of the box |
//! | `Properties` | name, type (`S`, `R`, `I`, `L`) and number of each group of columns |
//! | `Time` | simulated time |
//! | `pbc` | whether each axis is periodic |
//! | `flat` | whether each axis is flat; absent if none is |
//! | `species_table`, `static` | the names of the species in the order of the scene, and whether each never moves |
//! | `species_mass` | the mass of each species, `inf` for species that never move; absent if one is unknown |
//! | `bonds` | the ids of the two ends of each bond, `0-1 1-2`; absent without bonds |
//! | `bond_table` | the names of the interactions that hold the bonds |
//! | `bond_kind` | the index of the interaction of each bond; absent if there is only one |
//! | `surfaces` | whether each surface of the scene is present; absent if all always are |
//! | `units` | the names of the units of length, mass and time, `mm g ms`; absent if the scene gives no names |
//!
//! The species is in the column `type`, because ASE accepts only chemical symbols in a column called `species`. The
//! reader accepts both names. `map_shift` is *Periodic Image* in OVITO: the number of periods that a particle has
//! travelled along each vector of `Lattice` since the start. The unwrapped position is the position plus these
//! multiples of the vectors. The column `masses` is for ASE; the value is 0 for static particles.
//!
//! Numbers have as many digits as all bits need. The reader accepts the columns in any order and requires only
//! positions. A file without `Properties` is read as plain XYZ, with a name and three coordinates per line.

mod comment;
mod error;
mod places;
mod read;
mod size;
#[cfg(test)]
mod tests;
mod write;

use std::path::Path;

pub use error::{ReadError, WriteError};
pub use places::{FramePlace, frame_at, frame_places};
pub use read::FrameReader;
pub(crate) use read::{Beside, Preamble, bounds};
pub(crate) use size::frame_bytes;
pub use write::write_frame;
pub(crate) use write::{FrameWriter, Heading};

use super::{Frame, compressed};

/// Length of the longest accepted line `[bytes]`, enough for five million bonds. A binary file may be a single line.
const LONGEST_LINE: u64 = 1 << 26;

/// A frame selected from a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Pick {
    /// The frame.
    pub frame: Frame,
    /// True if the file ends in the middle of a later frame, for example because the run was killed.
    pub is_truncated: bool,
}

/// Reads the frame nearest to `time` `[time]` from a trajectory file, or the last frame if `time` is `None`. If two
/// frames are equally near, the earlier frame in the file is returned.
///
/// # Errors
/// [`ReadError::Open`] if the file cannot be opened, [`ReadError::NoFrame`] if the file contains no frame,
/// [`ReadError::Truncated`] if it ends within the first frame; any other [`ReadError`] if it is malformed.
pub fn pick_frame(path: &Path, time: Option<f64>) -> Result<Pick, ReadError> {
    let text = compressed::open(path).map_err(|source| ReadError::Open { path: path.into(), source })?;
    let mut nearest: Option<Frame> = None;
    for frame in FrameReader::new(text) {
        match (frame, nearest.take()) {
            (Err(ReadError::Truncated { .. }), Some(frame)) => return Ok(Pick { frame, is_truncated: true }),
            (Err(error), _) => return Err(error),
            (Ok(frame), None) => nearest = Some(frame),
            (Ok(frame), Some(best)) => {
                let is_nearer = time.is_none_or(|time| (frame.time - time).abs() < (best.time - time).abs());
                nearest = Some(if is_nearer { frame } else { best });
            }
        }
    }
    nearest.map(|frame| Pick { frame, is_truncated: false }).ok_or(ReadError::NoFrame)
}
