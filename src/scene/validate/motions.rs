//! Checks the motions of surfaces, and of their material.

use crate::Vector;
use crate::model::space::{AXES, Boundary, Space};
use crate::model::surface_motion::Timeline;
use crate::model::{MotionKind, SceneSurface, SurfaceLaw, SurfaceMotion, SurfaceShape, SurfaceVelocity};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::limits::{direction, finite, finite_vector, on_flat_axes};

pub(super) fn check_motions(surface: &SceneSurface, space: &Space, of: &ConfigPath) -> Result<(), SceneError> {
    let mut before = f64::NEG_INFINITY;
    for (index, motion) in surface.motions.iter().enumerate() {
        let at = of.key("motion").index(index);
        let SurfaceMotion { from, until, kind } = *motion;
        finite(from, at.key("from"))?;
        if from < before {
            return refuse(at.key("from"), from, format!("at least {before}, the end of the previous motion"));
        }
        // Also rejects NaN.
        if until.partial_cmp(&from) != Some(std::cmp::Ordering::Greater) {
            return refuse(at.key("until"), until, format!("more than {from}, the start of the motion"));
        }
        before = until;
        check_kind(&kind, &at)?;
        check_box(&kind, &surface.shape, space, &at)?;
    }
    let timeline = Timeline::of(&surface.motions);
    for (index, motion) in surface.motions.iter().enumerate().filter(|(_, motion)| motion.until.is_finite()) {
        let end = timeline.at(motion.until).pose.displacement;
        if !end.iter().all(|x| x.is_finite()) {
            return refuse(
                of.key("motion").index(index).key("until"),
                motion.until,
                "an earlier end: by then the surface has moved to infinity",
            );
        }
    }
    Ok(())
}

fn check_kind(kind: &MotionKind, at: &ConfigPath) -> Result<(), SceneError> {
    match kind {
        MotionKind::Translation { velocity, acceleration } => {
            finite_vector(velocity, &at.key("velocity"))?;
            finite_vector(acceleration, &at.key("acceleration"))
        }
        MotionKind::Oscillation { amplitude, frequency, phase } => {
            finite_vector(amplitude, &at.key("amplitude"))?;
            finite(*frequency, at.key("frequency"))?;
            finite(*phase, at.key("phase")).map(drop)
        }
        MotionKind::Rotation { point, axis, frequency } => {
            finite_vector(point, &at.key("point"))?;
            direction(axis, &at.key("axis"))?;
            finite(*frequency, at.key("frequency")).map(drop)
        }
    }
}

/// A surface may not move along a flat axis. Only planes may move along a periodic axis, because images of other
/// surfaces cannot follow. If the box has a flat or periodic axis, a surface may rotate only about this axis.
fn check_box(kind: &MotionKind, shape: &SurfaceShape, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    if let MotionKind::Rotation { axis, .. } = kind {
        return check_axis(axis, space, at);
    }
    let is_plane = matches!(shape, SurfaceShape::Plane { .. });
    for k in 0..3 {
        let (why, may_move) = match space.boundary[k] {
            Boundary::Bounded { .. } => continue,
            Boundary::Flat => ("flat", false),
            Boundary::Periodic => ("periodic", is_plane),
        };
        let because = |expected: &str| format!("{expected}, because {} is {why}", AXES[k]);
        let none = |vector: &Vector, key: &'static str| match vector[k] {
            x if x == 0.0 || may_move => Ok(()),
            x => refuse(at.key(key).index(k), x, because("0")),
        };
        match kind {
            MotionKind::Translation { velocity, acceleration } => {
                none(velocity, "velocity")?;
                none(acceleration, "acceleration")?;
            }
            MotionKind::Oscillation { amplitude, .. } => none(amplitude, "amplitude")?,
            MotionKind::Rotation { .. } => {}
        }
    }
    Ok(())
}

/// The material of a surface may not move along a flat axis. If the box has a flat or periodic axis, it may rotate only
/// about this axis.
pub(super) fn check_surface_velocity(surface: &SceneSurface, space: &Space, of: &ConfigPath) -> Result<(), SceneError> {
    let Some(velocity) = &surface.surface_velocity else { return Ok(()) };
    let at = of.key("surface_velocity");
    match &surface.law {
        SurfaceLaw::Outlet => return refuse(at, "given for an outlet", "none: particles leave at an outlet"),
        SurfaceLaw::Reflecting(law) if law.roughness.is_none() => {
            let expected =
                "none, or a contact law with `friction` or `tangential_restitution`: a smooth surface cannot pull";
            return refuse(at, "given for a smooth surface", expected);
        }
        SurfaceLaw::Reflecting(_) | SurfaceLaw::Thermal { .. } => {}
    }
    match velocity {
        SurfaceVelocity::Translation { velocity } => {
            finite_vector(velocity, &at)?;
            on_flat_axes(velocity, &Vector::zeros(), space, &at)
        }
        SurfaceVelocity::Rotation { point, axis, frequency } => {
            finite_vector(point, &at.key("point"))?;
            direction(axis, &at.key("axis"))?;
            finite(*frequency, at.key("frequency"))?;
            check_axis(axis, space, &at)
        }
    }
}

/// If the box has a flat or periodic axis, a rotation must be about this axis.
fn check_axis(axis: &Vector, space: &Space, at: &ConfigPath) -> Result<(), SceneError> {
    for (k, name) in AXES.into_iter().enumerate() {
        let why = match space.boundary[k] {
            Boundary::Bounded { .. } => continue,
            Boundary::Flat => "flat",
            Boundary::Periodic => "periodic",
        };
        if (0..3).any(|other| other != k && axis[other] != 0.0) {
            let expected = format!("an axis along {name}, because {name} is {why}");
            return refuse(at.key("axis"), "in another direction", expected);
        }
    }
    Ok(())
}
