use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::Vector;
use crate::io::Folder;
use crate::model::Units;

/// Other keys are ignored, so scenes of other versions can be read.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Scene {
    dynamics: Dynamics,
    units: Option<Units>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Dynamics {
    gravity: Option<[f64; 3]>,
}

/// Settings of a scene file that pictures use.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Beside {
    /// `dynamics.gravity` `[length / time^2]`; `None` without gravity.
    pub gravity: Option<Vector>,
    /// Names of the units; `None` if the scene gives none.
    pub units: Option<Units>,
}

impl Beside {
    /// Reads the scene file next to a trajectory. A missing or damaged file gives nothing.
    pub fn of(trajectory: &Path) -> Self {
        let text = fs::read_to_string(Folder::scene_of(trajectory.parent().unwrap_or(Path::new(""))));
        let scene: Scene = text.ok().and_then(|text| toml::from_str(&text).ok()).unwrap_or_default();
        let is_some = |gravity: &Vector| gravity.norm() > 0.0 && gravity.norm().is_finite();
        Self { gravity: scene.dynamics.gravity.map(Vector::from).filter(is_some), units: scene.units }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_and_units_are_read_from_the_scene_beside_the_trajectory() {
        let folder = tempfile::tempdir().unwrap();
        let trajectory = folder.path().join("trajectory.xyz");
        assert_eq!(Beside::of(&trajectory), Beside::default());
        for (text, expected) in [
            ("seed = 1\n[dynamics]\ngravity = [0.0, -2.0, 0]", Some(Vector::new(0.0, -2.0, 0.0))),
            ("[dynamics]\ngravity = [0.0, 0.0, 0.0]", None),
            ("[dynamics]\ngravity = 1", None),
            ("seed = 1", None),
            ("[", None),
        ] {
            fs::write(folder.path().join("scene.toml"), text).unwrap();
            assert_eq!(Beside::of(&trajectory), Beside { gravity: expected, units: None }, "{text}");
        }
        let text = "[units]\nlength = 'mm'\nmass = 'g'\ntime = 'ms'\n[dynamics]\ngravity = [0.0, 0.0, -1.0]";
        fs::write(folder.path().join("scene.toml"), text).unwrap();
        let expected = Beside { gravity: Some(-Vector::z()), units: Some(Units::new("mm", "g", "ms")) };
        assert_eq!(Beside::of(&trajectory), expected);
    }
}
