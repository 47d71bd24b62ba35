//! What a scene says of static-sphere surfaces: names of the sides of a box, and which shapes have an extent.

use crate::prepare::surface::{BoxSide, Surface};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::limits::{finite_vector, not_negative, positive};

impl BoxSide {
    /// The names of the sides, with z upwards and y away from the viewer.
    pub const NAMES: [(&'static str, Self); 6] = {
        let [left, right, front, back, bottom, top] = Self::ALL;
        [("left", left), ("right", right), ("front", front), ("back", back), ("bottom", bottom), ("top", top)]
    };
}

impl Surface {
    /// Refuses surfaces without extent, and numbers that are none.
    pub(crate) fn check(&self, at: &ConfigPath) -> Result<(), SceneError> {
        match self {
            Self::Plane { corner, edges } => {
                finite_vector(corner, &at.key("corner"))?;
                finite_vector(&edges[0], &at.key("edge_1"))?;
                finite_vector(&edges[1], &at.key("edge_2"))?;
                let area = edges[0].cross(&edges[1]).norm();
                // Edges in one direction have an area of rounding only.
                if area <= 1e-9 * edges[0].norm() * edges[1].norm() {
                    let kind = SceneErrorKind::value("parallel to edge_1 or zero", "an edge in another direction");
                    return Err(SceneError::new(at.key("edge_2"), kind));
                }
            }
            Self::Box { lower, upper, .. } => {
                finite_vector(lower, &at.key("lower"))?;
                finite_vector(upper, &at.key("upper"))?;
                for k in 0..3 {
                    if lower[k] >= upper[k] {
                        let kind = SceneErrorKind::value(upper[k], format!("more than the lower end, {}", lower[k]));
                        return Err(SceneError::new(at.key("upper").index(k), kind));
                    }
                }
            }
            Self::Cone { base, axis, radii, length } => {
                finite_vector(base, &at.key("base"))?;
                finite_vector(axis, &at.key("axis"))?;
                positive(axis.norm(), at.key("axis"))?;
                for (k, radius) in radii.iter().enumerate() {
                    not_negative(*radius, at.key("radii").index(k))?;
                }
                positive(radii[0].max(radii[1]), at.key("radii"))?;
                positive(*length, at.key("length"))?;
            }
            Self::Sphere { centre, radius } => {
                finite_vector(centre, &at.key("centre"))?;
                positive(*radius, at.key("radius"))?;
            }
            Self::Points(points) => {
                for (index, point) in points.iter().enumerate() {
                    finite_vector(point, &at.key("points").index(index))?;
                }
                if points.is_empty() {
                    let kind = SceneErrorKind::value("empty", "at least one point");
                    return Err(SceneError::new(at.key("points"), kind));
                }
            }
        }
        Ok(())
    }
}
