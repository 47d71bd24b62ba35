use crate::base::text::shortest;
use crate::model::{Scene, Swap};
use crate::scene::compatibility::phases;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::validate::measure::{check_no_arrays, check_supported};

pub(super) fn check_numbers(swap: Option<&Swap>, at: &ConfigPath) -> Result<(), SceneError> {
    let checked = swap.map_or(Ok(()), Swap::check);
    checked.or_else(|(name, value, expected)| refuse(at.key(name), shortest(value), expected))
}

/// Rejects instruments and formats that need particles of constant species.
pub(super) fn check_output(scene: &Scene) -> Result<(), SceneError> {
    if !scene.run.has_swaps() {
        return Ok(());
    }
    check_no_arrays(scene, "particles of the same species in all frames, and swap moves change the species")?;
    if !phases(&scene.run).any(|phase| phase.is_measured && phase.swap.is_some()) {
        return Ok(());
    }
    check_supported(
        scene,
        |kind| kind.any_species,
        |supported| {
            format!(
                "to be absent in a measurement with swap moves, which allows only {supported}: let swap moves equilibrate the system in a stage, and measure without them"
            )
        },
    )
}
