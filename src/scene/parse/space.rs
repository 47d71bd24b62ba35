//! Parses `[space]`: the box and its sides.

use super::{variant, vector};
use crate::model::space::{Boundary, Face};
use crate::scene::builder::SceneBuilder;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::file::{AxisFile, SpaceFile};

/// The words for what happens at both sides of an axis.
pub(crate) const BOUNDARIES: [(&str, Boundary); 4] = [
    ("periodic", Boundary::Periodic),
    ("open", Boundary::OPEN),
    ("walls", Boundary::walls(1.0)),
    ("flat", Boundary::Flat),
];

/// The words for one side of an axis, with a perfectly elastic wall.
pub(crate) const SIDES: [(&str, Face); 2] = [("open", Face::Open), ("wall", Face::Wall { restitution: 1.0 })];

pub(super) fn parse_space(space: &SpaceFile, scene: &mut SceneBuilder) -> Result<(), SceneError> {
    scene.size = space.size.map(vector);
    scene.lower = vector(space.lower.unwrap_or_default());
    scene.shear_rate = space.shear_rate;
    for (k, (name, axis)) in [("x", &space.x), ("y", &space.y), ("z", &space.z)].into_iter().enumerate() {
        let at = ConfigPath::root().key("space").key(name);
        scene.boundary[k] = match axis {
            None => Boundary::Periodic,
            Some(AxisFile::Word(word)) => *variant(&BOUNDARIES, "boundary", word, &at)?,
            Some(AxisFile::Sides(sides)) => {
                scene.wall_temperatures[k] = sides.temperature;
                if sides.temperature.is_some() && sides.restitution.is_some() {
                    let kind = SceneErrorKind::value("given as well", "either it or a temperature");
                    return Err(SceneError::new(at.key("restitution"), kind));
                }
                let face = |key: &'static str, word: &str| {
                    let face = *variant(&SIDES, "side", word, &at.key(key))?;
                    Ok(match (face, sides.restitution) {
                        (Face::Wall { .. }, Some(restitution)) => Face::Wall { restitution },
                        _ => face,
                    })
                };
                Boundary::Bounded { lower: face("lower", &sides.lower)?, upper: face("upper", &sides.upper)? }
            }
        };
    }
    Ok(())
}
