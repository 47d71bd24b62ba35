use crate::base::text::shortest;
use crate::model::molecules::Molecules;
use crate::model::{Barostat, Scene};
use crate::scene::compatibility::phases;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::validate::measure::check_supported;

pub(super) fn check_numbers(barostat: Option<&Barostat>, at: &ConfigPath) -> Result<(), SceneError> {
    let checked = barostat.map_or(Ok(()), Barostat::check);
    checked.or_else(|(name, value, expected)| refuse(at.key(name), shortest(value), expected))
}

/// Rejects bonds and instruments that need a constant volume, and growth after a stage with a barostat.
pub(super) fn check_barostats(scene: &Scene) -> Result<(), SceneError> {
    if !scene.run.has_barostat() {
        return Ok(());
    }
    let first = phases(&scene.run).find(|phase| phase.barostat.is_some()).map(|phase| phase.at.key("barostat"));
    let at = first.unwrap_or_else(ConfigPath::root);
    check_bonds(scene, &at)?;
    let (mut is_found, mut is_changed) = (false, false);
    for phase in phases(&scene.run) {
        if is_changed && phase.growth.is_some() {
            let expected = "no growth, or growth before the first stage with a barostat: a barostat makes the packing fraction unpredictable";
            return refuse(phase.at.key("grow"), "given after a stage with a barostat", expected);
        }
        let Some(barostat) = phase.barostat else { continue };
        is_changed = true;
        is_found |= phase.is_prepared && barostat.amplitude.is_none();
        if phase.is_measured && barostat.amplitude.is_none() && !is_found {
            let why = "give the largest change of ln V in a move, or plan an equilibration with the barostat, which adjusts this change to accept 40 % of the moves";
            return Err(missing(&phase.at.key("barostat"), "amplitude", why));
        }
    }
    check_output(scene)
}

fn check_bonds(scene: &Scene, at: &ConfigPath) -> Result<(), SceneError> {
    let is_bond = |id: crate::model::InteractionId| scene.interactions[id.0 as usize].potential.is_bond();
    let occurs = scene.occurring_species();
    if let Some(([a, b], _)) = scene.table.iter().find(|([a, b], id)| occurs[*a] && occurs[*b] && is_bond(*id)) {
        let names = format!(
            "given with bonds between all particles of `{}` and `{}`",
            scene.species[a].name, scene.species[b].name
        );
        return refuse(
            at.clone(),
            names,
            "bonds from [[bond]] or [[chain]], because a volume move shifts each molecule as a whole",
        );
    }
    let masses = scene.particles.iter().map(|particle| scene.species[particle.species.0 as usize].mass).collect();
    let Some(bond) = Molecules::of(scene, masses).bond_around_the_box(scene) else { return Ok(()) };
    let [a, b] = bond.pair.map(|id| id.0);
    let what =
        format!("given with bonds that form a ring around the periodic box; particles {a} and {b} are in the ring");
    refuse(
        at.clone(),
        what,
        "molecules that do not span the box: bonds across the whole box would be stretched when the volume changes",
    )
}

fn check_output(scene: &Scene) -> Result<(), SceneError> {
    if !phases(&scene.run).any(|phase| phase.is_measured && phase.barostat.is_some()) {
        return Ok(());
    }
    check_supported(
        scene,
        |kind| kind.any_volume,
        |supported| {
            format!(
                "to be absent in a measurement with a barostat, which allows only {supported}: measure the density at this pressure first, then use it in a scene without the barostat"
            )
        },
    )
}
