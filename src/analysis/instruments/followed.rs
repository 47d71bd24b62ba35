//! The axes along which displacements of particles are followed.

use super::system::SystemDescription;
use crate::Vector;

pub struct Followed {
    pub axes: Vec<usize>,
    /// Whether all followed axes have walls, so that no motion is diffusive.
    pub is_enclosed: bool,
    /// Whether some axes are not followed because they have walls.
    pub leaves_walls_out: bool,
}

pub fn followed(system: &SystemDescription) -> Followed {
    let at_rest = |axis: &usize| system.shear_rate == 0.0 || *axis > 0;
    let across: Vec<usize> = system.axes().filter(at_rest).collect();
    let free: Vec<usize> = across.iter().copied().filter(|&axis| system.space.walls(axis) == 0).collect();
    let is_enclosed = free.is_empty();
    let axes = if is_enclosed { across.clone() } else { free };
    Followed { leaves_walls_out: axes.len() < across.len(), axes, is_enclosed }
}

impl Followed {
    /// Sets the components along other axes to zero.
    pub fn of(&self, vector: Vector) -> Vector {
        Vector::from_fn(|axis, _| if self.axes.contains(&axis) { vector[axis] } else { 0.0 })
    }
}
