//! Output files and audit of a run.

use serde::{Deserialize, Serialize};

use super::TriangleMesh;
use crate::Vector;

/// An axis-aligned box `[length]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Lower corner.
    pub lower: Vector,
    /// Upper corner.
    pub upper: Vector,
}

/// Limits of the audit, as fractions. The default limits follow from round-off.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct AuditPlan {
    /// Largest permitted error of the energy balance.
    pub energy: Option<f64>,
    /// Largest permitted drift of the total momentum.
    pub momentum: Option<f64>,
    /// Largest permitted depth of an overlap, relative to the contact distance.
    pub overlap: Option<f64>,
}

impl Region {
    /// Whether a point is inside the region. The lower faces belong to the region, but not the upper faces. Along an
    /// axis without extent, the coordinates must be equal.
    #[must_use]
    pub fn contains(&self, point: &Vector) -> bool {
        let Self { lower, upper } = self;
        (0..3).all(|k| (lower[k]..upper[k]).contains(&point[k]) || (lower[k] == upper[k] && point[k] == lower[k]))
    }
}

/// A region in which a run counts particles, such as a container or half of the box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CountRegion {
    /// Name of the column in `thermo.csv`, unique in the scene.
    pub name: String,
    /// The region.
    pub space: CountSpace,
}

/// Region in which centres of particles are counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum CountSpace {
    /// A box.
    Box(Region),
    /// The interior of a closed mesh, in three-dimensional scenes.
    Mesh(TriangleMesh),
}

/// Output plan of a scene. Intervals are in simulated time `[time]`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct OutputPlan {
    /// Interval between rows of `thermo.csv`; `None` for about 200 rows in each stage.
    pub thermo_interval: Option<f64>,
    /// Interval between frames in `trajectory.xyz`; `None` for about 20 frames, but at most 200 MB.
    pub frame_interval: Option<f64>,
    /// Regions in which particles are counted. Each region has a column in `thermo.csv`.
    pub regions: Vec<CountRegion>,
    /// Whether to write every physical event to `contacts.csv`.
    pub has_contacts: bool,
    /// Whether to write every event, with positions and velocities, to the folder `events`.
    pub has_event_log: bool,
    /// Formats to which the trajectory is converted at the end.
    pub formats: Vec<Format>,
}

/// Trajectory formats of other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Format {
    /// A text dump of LAMMPS.
    Lammps,
    /// The binary format of HOOMD-blue.
    Gsd,
    /// XML PolyData for ParaView.
    Vtk,
    /// NumPy arrays.
    Npy,
    /// A table with one line per particle and frame.
    Csv,
    /// Extended XYZ, for an extract of the trajectory.
    Xyz,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 6] = [Self::Lammps, Self::Gsd, Self::Vtk, Self::Npy, Self::Csv, Self::Xyz];

    /// Name of the format in scenes and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lammps => "lammps",
            Self::Gsd => "gsd",
            Self::Vtk => "vtk",
            Self::Npy => "npy",
            Self::Csv => "csv",
            Self::Xyz => "xyz",
        }
    }

    /// Description of the format in a few words.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Lammps => "Text dump of LAMMPS, .lammpstrj",
            Self::Gsd => "GSD of HOOMD-blue, .gsd",
            Self::Vtk => "ParaView: a folder with a .vtp per frame and a .pvd",
            Self::Npy => "NumPy: a folder with .npy arrays",
            Self::Csv => "One table, .csv",
            Self::Xyz => "Extended XYZ again",
        }
    }
}
