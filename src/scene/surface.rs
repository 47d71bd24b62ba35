//! Validates surfaces that consist of static spheres. Defines the names of the sides of a box.

use crate::Vector;
use crate::model::space::Space;
use crate::prepare::surface::curve::plane_axes;
use crate::prepare::surface::{BoxSide, Surface};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::limits::{
    AXES, corners, direction, finite_vector, not_negative, on_flat_axes, parallelogram, positive,
};

impl BoxSide {
    /// Names of the sides of a box, where z points up and y away from the viewer.
    pub const NAMES: [(&'static str, Self); 6] = {
        let [left, right, front, back, bottom, top] = Self::ALL;
        [("left", left), ("right", right), ("front", front), ("back", back), ("bottom", bottom), ("top", top)]
    };
}

impl Surface {
    /// Rejects surfaces without extent, numbers that are not finite, and shapes of another dimension than the box.
    pub(crate) fn check(&self, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
        match self {
            Self::Line { .. } | Self::Ring { .. } | Self::Rectangle { .. } => self.check_in_plane(space, at)?,
            Self::Plane { corner, edges } => parallelogram(corner, edges, at)?,
            Self::Box { lower, upper, .. } => corners(lower, upper, 0..3, at)?,
            Self::Cone { base, axis, radii, length } => {
                finite_vector(base, &at.key("base"))?;
                direction(axis, &at.key("axis"))?;
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
                    return refuse(at.key("points"), "empty", "at least one point");
                }
            }
        }
        Ok(())
    }

    fn check_in_plane(&self, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
        let Some(axes) = plane_axes(space) else {
            let (is_in, cure) = match space.dimensions() {
                3 => (
                    "three dimensions",
                    "`plane`, `box`, `cylinder`, `cone`, `sphere` or `points`, or a box with one flat axis",
                ),
                _ => ("one dimension", "`points`, or a box with one flat axis"),
            };
            return refuse(at.key("surface"), format!("a two-dimensional shape in {is_in}"), cure);
        };
        let in_plane = |point: &Vector, key: &'static str| on_flat_axes(point, &space.lower, space, &at.key(key));
        match self {
            Self::Line { ends } => {
                in_plane(&ends[0], "start")?;
                in_plane(&ends[1], "end")?;
                if ends[0] == ends[1] {
                    return refuse(at.key("end"), "the same as start", "a different point");
                }
            }
            Self::Ring { centre, radius } => {
                in_plane(centre, "centre")?;
                positive(*radius, at.key("radius"))?;
            }
            Self::Rectangle { lower, upper, open } => {
                in_plane(lower, "lower")?;
                in_plane(upper, "upper")?;
                corners(lower, upper, axes.into_iter(), at)?;
                check_open_sides(open, axes, at)?;
            }
            _ => {}
        }
        Ok(())
    }
}

fn check_open_sides(open: &[BoxSide], axes: [usize; 2], at: &ConfigPath) -> Result<(), SceneError> {
    let sides = || BoxSide::NAMES.iter().filter(|(_, side)| axes.contains(&side.axis));
    if let Some((index, side)) = open.iter().enumerate().find(|(_, side)| !axes.contains(&side.axis)) {
        let names: Vec<String> = sides().map(|(name, _)| format!("`{name}`")).collect();
        return refuse(
            at.key("open").index(index),
            format!("across {}, which is flat", AXES[side.axis.min(2)]),
            names.join(", "),
        );
    }
    if sides().all(|(_, side)| open.contains(side)) {
        return refuse(at.key("open"), "all four sides", "at least one side that is not open");
    }
    Ok(())
}
