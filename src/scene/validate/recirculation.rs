//! Validates inlets where particles return from outlets.

use crate::Vector;
use crate::base::numbers::id;
use crate::model::{Inlet, SceneParts, SceneSurface, Species, SpeciesId, SurfaceLaw};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse, unknown};
use crate::scene::validate::inlets::has_room;
use crate::scene::validate::start::Configuration;

/// Checks that the outlets exist, that each of them belongs to one inlet, and that the inlets have room.
pub(super) fn check_recirculation(start: &Configuration<'_>, parts: &SceneParts) -> Result<(), SceneError> {
    let surfaces = start.surfaces.of_scene();
    let mut taken: Vec<(&String, &Inlet)> = Vec::new();
    for (index, inlet) in start.inlets.iter().enumerate().filter(|(_, inlet)| !inlet.recirculate.is_empty()) {
        let at = ConfigPath::entry("inlet", index);
        if let Some(keep) = inlet.keep {
            let expected =
                "count, the number of new particles: a particle that leaves returns, and needs no replacement";
            return refuse(at.key("keep"), format!("{keep} with recirculate"), expected);
        }
        for (index, name) in inlet.recirculate.iter().enumerate() {
            let at = at.key("recirculate").index(index);
            check_outlet(name, surfaces, &at)?;
            if let Some((_, other)) = taken.iter().find(|(taken, _)| *taken == name) {
                let value = format!("\"{name}\", whose particles return at inlet \"{}\"", other.name);
                return refuse(at, value, "an outlet of no other inlet, named once");
            }
            taken.push((name, inlet));
        }
        let (all, returning) = (start.interactions.species, returning_species(inlet, start));
        let species: Vec<&Species> = returning.iter().map(|index| &all[*index]).collect();
        check_motion(inlet, &species, parts, &at)?;
        let diameters = start.groups.ranges_with(all, &start.inlets);
        let largest = returning.iter().map(|index| diameters[*index].largest).fold(0.0, f64::max);
        if !has_room(&inlet.region, largest, &start.space) {
            let expected = format!("one in which a particle of diameter {largest}, which may return, has room");
            return refuse(at.key("region"), "too small", expected);
        }
    }
    Ok(())
}

fn check_outlet(name: &str, surfaces: &[SceneSurface], at: &ConfigPath) -> Result<(), SceneError> {
    let is_outlet = |surface: &&SceneSurface| surface.law == SurfaceLaw::Outlet;
    match surfaces.iter().find(|surface| surface.name == name) {
        Some(surface) if is_outlet(&surface) => Ok(()),
        Some(_) => {
            let value = format!("\"{name}\", which is no outlet");
            refuse(at.clone(), value, "the name of a [[surface]] with `outlet = true`")
        }
        None => {
            let outlets = surfaces.iter().filter(is_outlet).map(|surface| surface.name.as_str());
            Err(unknown(at, "outlet", name, outlets))
        }
    }
}

/// Indices of the moving species of the scene whose particles can leave at an outlet of the inlet.
fn returning_species(inlet: &Inlet, start: &Configuration<'_>) -> Vec<usize> {
    let outlets = start.surfaces.of_scene().iter().filter(|surface| inlet.recirculate.contains(&surface.name));
    let outlets: Vec<&SceneSurface> = outlets.collect();
    let species = start.interactions.species;
    let counts = start.groups.counts(species.len(), &start.inlets);
    let returns = |(index, species): &(usize, &Species)| {
        let is_let_out = outlets.iter().any(|outlet| outlet.meets(SpeciesId(id(*index))));
        is_let_out && counts[*index] > 0 && !species.is_static()
    };
    species.iter().enumerate().filter(returns).map(|(index, _)| index).collect()
}

/// Particles that enter at rest and do not fall would never make room for the next ones.
fn check_motion(inlet: &Inlet, returning: &[&Species], parts: &SceneParts, at: &ConfigPath) -> Result<(), SceneError> {
    let gravities = returning.iter().map(|species| species.acceleration).chain(parts.run.gravities());
    let is_at_rest = inlet.velocity == Vector::zeros() && inlet.temperature == 0.0;
    if is_at_rest && gravities.into_iter().any(|gravity| gravity == Vector::zeros()) {
        let expected =
            "a velocity, or a temperature, or gravity: particles that return must make room for the next ones";
        return refuse(at.key("velocity"), "zero", expected);
    }
    Ok(())
}
