//! Rejects instruments that could never measure anything in a scene.

use crate::model::Scene;
use crate::model::space::Boundary;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};

pub(in crate::scene) fn check_measurable(scene: &Scene) -> Result<(), SceneError> {
    let plan = &scene.measure;
    if plan.is_empty() {
        return Ok(());
    }
    let refuse = |key: &'static str, value: &str, expected: &str| {
        let at = ConfigPath::root().key("measure").key(key);
        refuse(at, value, expected)
    };
    if plan.pressure_tensor.is_some() && !scene.space.is_closed() {
        let expected = "no pressure_tensor, or a box that is periodic or has walls: an open one has no volume to divide by. thermo.csv has the number of events \
            in each row";
        return refuse("pressure_tensor", "given in an open box", expected);
    }
    if plan.structure_factor.is_some() && !scene.space.boundary.contains(&Boundary::Periodic) {
        let expected = "no structure_factor, or a periodic axis: its period determines the wave vectors";
        return refuse("structure_factor", "given in a box without a periodic axis", expected);
    }
    if plan.chains.is_some() && scene.bonds.is_empty() {
        return refuse("chains", "given without bonds", "no chains, or bonds from [[chain]] or [[bond]]");
    }
    Ok(())
}
