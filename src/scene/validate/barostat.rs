//! Validates barostats: their parameters, and whether the scene has an isothermal-isobaric ensemble.

use crate::Vector;
use crate::base::text::shortest;
use crate::model::measurement_plan::InstrumentKind;
use crate::model::molecules::Molecules;
use crate::model::{Barostat, Growth, Scene, Thermostat};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};

pub(super) fn check_numbers(barostat: Option<&Barostat>, at: &ConfigPath) -> Result<(), SceneError> {
    let checked = barostat.map_or(Ok(()), Barostat::check);
    checked.or_else(|error| refuse(at.key(error.name), shortest(error.value), error.expected))
}

struct Phase<'a> {
    at: ConfigPath,
    thermostat: Option<&'a Thermostat>,
    barostat: Option<&'a Barostat>,
    growth: Option<&'a Growth>,
    /// Whether part of the stage is simulated but not measured.
    is_prepared: bool,
    is_measured: bool,
}

/// Iterates over the stages of a run. The measurement with its equilibration comes last.
fn phases(scene: &Scene) -> impl Iterator<Item = Phase<'_>> {
    let plan = &scene.run;
    let listed = plan.stages.iter().enumerate().map(|(index, stage)| Phase {
        at: ConfigPath::entry("stage", index),
        thermostat: stage.thermostat.as_ref(),
        barostat: stage.barostat.as_ref(),
        growth: stage.growth.as_ref(),
        is_prepared: stage.measured.is_none_or(|before| !before.is_empty()),
        is_measured: stage.measured.is_some(),
    });
    listed.chain([Phase {
        at: ConfigPath::root().key("run"),
        thermostat: plan.thermostat.as_ref(),
        barostat: plan.barostat.as_ref(),
        growth: None,
        is_prepared: !plan.last_equilibration().is_empty(),
        is_measured: true,
    }])
}

/// Rejects barostats in scenes without an isothermal-isobaric ensemble. Also rejects features that need a constant
/// volume if the scene has a barostat.
pub(super) fn check_barostats(scene: &Scene) -> Result<(), SceneError> {
    if !scene.run.has_barostat() {
        return Ok(());
    }
    let first = phases(scene).find(|phase| phase.barostat.is_some()).map(|phase| phase.at.key("barostat"));
    let at = first.unwrap_or_else(ConfigPath::root);
    if let Some((what, expected)) = obstacle(scene) {
        return refuse(at, format!("given {what}"), expected);
    }
    check_bonds(scene, &at)?;
    let (mut is_found, mut is_changed) = (false, false);
    for phase in phases(scene) {
        if is_changed && phase.growth.is_some() {
            let expected = "no growth, or growth before the first stage with a barostat: after it the packing fraction is not known in advance";
            return refuse(phase.at.key("grow"), "given after a stage with a barostat", expected);
        }
        let Some(barostat) = phase.barostat else { continue };
        check_phase(&phase)?;
        is_changed = true;
        is_found |= phase.is_prepared && barostat.amplitude.is_none();
        if phase.is_measured && barostat.amplitude.is_none() && !is_found {
            let why = "the largest change of ln V in a move; or an equilibration with the barostat, which adjusts it to accept 40 % of the moves";
            return Err(missing(&phase.at.key("barostat"), "amplitude", why));
        }
    }
    check_output(scene)
}

/// Finds a reason why the volume of a scene cannot change. Returns the obstacle, and what is expected instead.
fn obstacle(scene: &Scene) -> Option<(&'static str, &'static str)> {
    let falls = scene.accelerations().any(|acceleration| acceleration != Vector::zeros());
    let is_static = |index: usize| scene.species[index].is_static();
    let has_static = scene.particles.iter().any(|particle| is_static(particle.species.0 as usize));
    let all = [
        (
            !scene.space.is_fully_periodic(),
            "in a box with open sides or walls",
            "a box whose axes are all periodic or flat",
        ),
        (
            !scene.surfaces.is_empty(),
            "with surfaces",
            "to be absent with a [[surface]]: surfaces do not scale with the box",
        ),
        (has_static, "with static particles", "to be absent with static particles: they do not scale with the box"),
        (
            falls,
            "with gravity",
            "to be absent with gravity: particles that fall along a periodic axis have no equilibrium",
        ),
        (
            scene.shear_rate.is_some(),
            "in a sheared box",
            "to be absent with space.shear_rate: a sheared system has no equilibrium",
        ),
        (
            scene.contact_time.is_some(),
            "with the TC model",
            "to be absent with dynamics.contact_time: contacts must be elastic",
        ),
        (
            !scene.has_elastic_pairs(),
            "with a restitution below 1",
            "a restitution of 1: a system that loses energy has no equilibrium",
        ),
        (
            scene.allow_invalid_start,
            "with allow_invalid_start",
            "a start without overlaps: volume moves are rejected as long as particles overlap",
        ),
    ];
    all.into_iter().find(|(is_so, ..)| *is_so).map(|(_, what, expected)| (what, expected))
}

/// Rejects bonds whose lengths depend on the volume.
fn check_bonds(scene: &Scene, at: &ConfigPath) -> Result<(), SceneError> {
    let is_bond = |id: crate::model::InteractionId| scene.interactions[id.0 as usize].potential.is_bond();
    let mut is_there = vec![false; scene.species.len()];
    scene.particles.iter().for_each(|particle| is_there[particle.species.0 as usize] = true);
    if let Some(([a, b], _)) = scene.table.iter().find(|([a, b], id)| is_there[*a] && is_there[*b] && is_bond(*id)) {
        let names = format!(
            "given with bonds between all particles of `{}` and `{}`",
            scene.species[a].name, scene.species[b].name
        );
        return refuse(
            at.clone(),
            names,
            "bonds between single pairs, from [[bond]] or [[chain]]: each molecule moves as a whole",
        );
    }
    let masses = scene.particles.iter().map(|particle| scene.species[particle.species.0 as usize].mass).collect();
    let Some(bond) = Molecules::of(scene, masses).bond_around_the_box(scene) else { return Ok(()) };
    let [a, b] = bond.pair.map(|id| id.0);
    let what =
        format!("given with a chain of bonds around the periodic box, through the bond between particles {a} and {b}");
    refuse(
        at.clone(),
        what,
        "molecules that do not span the box: bonds across the whole box would be stretched when the volume changes",
    )
}

fn check_phase(phase: &Phase<'_>) -> Result<(), SceneError> {
    if phase.growth.is_some() {
        return refuse(
            phase.at.key("barostat"),
            "given together with grow",
            "only one of them: volume moves need constant diameters",
        );
    }
    let expected =
        "a thermostat of the kind \"andersen\" in the same table: it gives the temperature of the volume moves";
    match phase.thermostat {
        Some(Thermostat::Andersen { .. }) => Ok(()),
        Some(Thermostat::Rescaling { .. }) => {
            refuse(phase.at.key("barostat"), "given together with a thermostat that scales velocities", expected)
        }
        None => refuse(phase.at.key("barostat"), "given without a thermostat", expected),
    }
}

/// Rejects instruments that need a constant box.
fn check_output(scene: &Scene) -> Result<(), SceneError> {
    let root = ConfigPath::root();
    if !scene.output.regions.is_empty() {
        let expected = "to be absent with a barostat: regions do not scale with the box";
        return refuse(root.key("output").key("count"), "given", expected);
    }
    if !phases(scene).any(|phase| phase.is_measured && phase.barostat.is_some()) {
        return Ok(());
    }
    match scene.measure.requested().find(|it| !it.kind.any_volume) {
        Some(it) => {
            let expected = format!(
                "to be absent in a measurement with a barostat, which allows only {}: measure the density at this pressure first, then use it in a scene without the barostat",
                InstrumentKind::listed(|kind| kind.any_volume)
            );
            refuse(root.key("measure").key(it.kind.key), "given", expected)
        }
        None => Ok(()),
    }
}
