//! Instruments that would measure nothing in a scene, whatever happens in it.

use crate::analysis::instruments::SystemDescription;
use crate::model::Scene;
use crate::model::space::Boundary;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};

/// Refuses instruments whose numbers have no meaning in the scene.
pub(in crate::scene) fn check_measurable(scene: &Scene) -> Result<(), SceneError> {
    let plan = &scene.measure;
    if plan.is_empty() {
        return Ok(());
    }
    let system = SystemDescription::of(scene);
    let refuse = |key: &'static str, value: &str, expected: &str| {
        let at = ConfigPath::root().key("measure").key(key);
        Err(SceneError::new(at, SceneErrorKind::value(value, expected)))
    };
    if plan.pressure_tensor.is_some() && !system.has_volume() {
        let value = if scene.space.is_closed() { "given with static particles" } else { "given in an open box" };
        let expected = "no pressure_tensor, or a box that is periodic or has walls and in which all particles move: elsewhere there is no volume to divide \
            by. thermo.csv has the number of events in each row";
        return refuse("pressure_tensor", value, expected);
    }
    if plan.transport.is_some()
        && let Some(obstacle) = system.obstacle_to_transport()
    {
        let expected = "no transport, or elastic particles in a periodic box without gravity, static particles and a heat bath: Einstein-Helfand relations \
            hold in equilibrium where momentum and energy are conserved";
        return refuse("transport", &format!("given {obstacle}"), expected);
    }
    if plan.structure_factor.is_some() && !scene.space.boundary.contains(&Boundary::Periodic) {
        let expected = "no structure_factor, or an axis that is periodic: its wave vectors are those of the periods";
        return refuse("structure_factor", "given in a box without periods", expected);
    }
    if plan.chains.is_some() && scene.bonds.is_empty() {
        return refuse("chains", "given without bonds", "no chains, or particles with bonds: a [[chain]] or [[bond]]");
    }
    Ok(())
}
