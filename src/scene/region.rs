//! Validates the regions of fills: shapes with an extent, inside the box.

use crate::Vector;
use crate::model::FillRegion;
use crate::model::Region;
use crate::model::space::{Boundary, Space};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::limits::{AXES, corners, not_negative, on_flat_axes, positive};
use crate::scene::unvalidated::Fill;

pub(crate) fn region(fill: &Fill, space: &Space, at: &ConfigPath) -> Result<FillRegion, SceneError> {
    region_of(fill.region, space, at)
}

/// Returns a valid region, which is the whole box if none is given.
pub(super) fn region_of(region: Option<FillRegion>, space: &Space, at: &ConfigPath) -> Result<FillRegion, SceneError> {
    let Some(region) = region else {
        return Ok(FillRegion::Box(Region { lower: space.lower, upper: space.upper() }));
    };
    let at = at.key("region");
    match &region {
        FillRegion::Box(region) => check_box(region, space, &at)?,
        FillRegion::Cone { .. } | FillRegion::Sphere { .. } => {
            check_shape(&region, space, &at)?;
            check_inside(&region, space, &at)?;
        }
    }
    Ok(region)
}

fn check_box(region: &Region, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    let axes = || (0..3).filter(|&k| space.boundary[k] != Boundary::Flat);
    corners(&region.lower, &region.upper, axes(), at)?;
    for k in axes() {
        for (key, value) in [("lower", region.lower[k]), ("upper", region.upper[k])] {
            if is_outside(value, k, space, 0.0) {
                return refuse(at.key(key).index(k), value, expected(k, space));
            }
        }
    }
    Ok(())
}

/// Returns true if a coordinate is beyond a side of the box. An axis that is open on both sides has no sides.
fn is_outside(value: f64, axis: usize, space: &Space, rounding: f64) -> bool {
    let (lower, upper) = (space.lower[axis] - rounding, space.upper()[axis] + rounding);
    space.boundary[axis] != Boundary::OPEN && !(lower..=upper).contains(&value)
}

fn expected(axis: usize, space: &Space) -> String {
    format!("{} from {} to {}, inside the box", AXES[axis], space.lower[axis], space.upper()[axis])
}

fn check_shape(region: &FillRegion, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    if space.dimensions() < 2 {
        return refuse(at.key("shape"), "given in one dimension", "`box`, which is an interval here");
    }
    match region {
        FillRegion::Cone { base, axis, radii, length } => {
            on_flat_axes(base, &space.lower, space, &at.key("base"))?;
            on_flat_axes(axis, &Vector::zeros(), space, &at.key("axis"))?;
            positive(axis.norm(), at.key("axis"))?;
            if radii[0] == radii[1] {
                positive(radii[0], at.key("radius"))?;
            }
            for (k, radius) in radii.iter().enumerate() {
                not_negative(*radius, at.key("radii").index(k))?;
            }
            positive(*length, at.key("length"))?;
        }
        FillRegion::Sphere { centre, radius } => {
            on_flat_axes(centre, &space.lower, space, &at.key("centre"))?;
            positive(*radius, at.key("radius"))?;
        }
        FillRegion::Box(_) => {}
    }
    Ok(())
}

fn check_inside(region: &FillRegion, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    let bounds = region.bounds(space);
    for k in (0..3).filter(|&k| space.boundary[k] != Boundary::Flat) {
        // Round-off in the axis may move the end of a shape slightly beyond a side of the box.
        let rounding = 1e-12 * (bounds.upper[k] - bounds.lower[k] + bounds.lower[k].abs());
        for value in [bounds.lower[k], bounds.upper[k]] {
            if is_outside(value, k, space, rounding) {
                return refuse(at.clone(), format!("one that reaches to {} = {value}", AXES[k]), expected(k, space));
            }
        }
    }
    Ok(())
}
