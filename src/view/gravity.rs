use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::Vector;
use crate::io::Folder;

/// Other keys are ignored, so scenes of other versions can be read.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Scene {
    dynamics: Dynamics,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Dynamics {
    gravity: Option<[f64; 3]>,
}

/// Reads `dynamics.gravity` from the scene file of a trajectory `[length / time^2]`; `None` without gravity.
pub(super) fn gravity_beside(trajectory: &Path) -> Option<Vector> {
    let text = fs::read_to_string(Folder::scene_of(trajectory.parent().unwrap_or(Path::new("")))).ok()?;
    let scene: Scene = toml::from_str(&text).ok()?;
    scene.dynamics.gravity.map(Vector::from).filter(|gravity| gravity.norm() > 0.0 && gravity.norm().is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_is_read_from_the_scene_beside_the_trajectory() {
        let folder = tempfile::tempdir().unwrap();
        let trajectory = folder.path().join("trajectory.xyz");
        assert_eq!(gravity_beside(&trajectory), None);
        for (text, expected) in [
            ("seed = 1\n[dynamics]\ngravity = [0.0, -2.0, 0]", Some(Vector::new(0.0, -2.0, 0.0))),
            ("[dynamics]\ngravity = [0.0, 0.0, 0.0]", None),
            ("[dynamics]\ngravity = 1", None),
            ("seed = 1", None),
            ("[", None),
        ] {
            fs::write(folder.path().join("scene.toml"), text).unwrap();
            assert_eq!(gravity_beside(&trajectory), expected, "{text}");
        }
    }
}
