//! Parses the motions of surfaces.

use super::{Keys, vector};
use crate::model::{MotionKind, SurfaceMotion};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::file::MotionFile;

pub(crate) const MOTIONS: [(&str, &[&str]); 3] = [
    ("translation", &["velocity", "acceleration"]),
    ("oscillation", &["amplitude", "frequency", "phase"]),
    ("rotation", &["point", "axis", "frequency"]),
];

/// Parses the motions of a surface. If a motion names a stage, its times are relative to the start of the stage.
pub(super) fn parse_motions(
    files: Vec<MotionFile>,
    of: &ConfigPath,
) -> Result<Vec<(Option<String>, SurfaceMotion)>, SceneError> {
    let mut motions: Vec<(Option<String>, SurfaceMotion)> = Vec::with_capacity(files.len());
    for (index, file) in files.into_iter().enumerate() {
        let at = of.key("motion").index(index);
        let before = motions.last().filter(|(stage, before)| *stage == file.stage || before.until == f64::INFINITY);
        let from = file.from.unwrap_or(before.map_or(0.0, |(_, before)| before.until));
        if from == f64::INFINITY {
            return refuse(
                of.key("motion").index(index - 1).key("until"),
                "not given",
                "a time, because another motion follows",
            );
        }
        let (word, keys) = Keys::of_kind(&MOTIONS, "kind", &file.kind, &at, &file)?;
        let kind = match word {
            "translation" => {
                if file.velocity.is_none() && file.acceleration.is_none() {
                    return refuse(at, "given without a velocity or an acceleration", "at least one of them");
                }
                let [velocity, acceleration] =
                    [file.velocity, file.acceleration].map(|given| vector(given.unwrap_or_default()));
                MotionKind::Translation { velocity, acceleration }
            }
            "oscillation" => MotionKind::Oscillation {
                amplitude: keys.vector("amplitude")?,
                frequency: keys.need("frequency")?,
                phase: file.phase.unwrap_or(0.0) / 360.0,
            },
            _ => MotionKind::Rotation {
                point: keys.vector("point")?,
                axis: keys.vector("axis")?,
                frequency: keys.need("frequency")?,
            },
        };
        let motion = SurfaceMotion { from, until: file.until.unwrap_or(f64::INFINITY), kind };
        motions.push((file.stage, motion));
    }
    Ok(motions)
}
