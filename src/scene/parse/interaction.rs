//! Parses `[[interaction]]`: named potentials, or lists of steps.

use super::Keys;
use super::contact_law::contact_law;
use super::materials::Materials;
use crate::model::potential::Potential;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing};
use crate::scene::file::InteractionFile;
use crate::scene::unvalidated::{InteractionDraft, Model};

pub(crate) const POTENTIALS: [(&str, &[&str]); 8] = [
    ("hard-sphere", &["diameter"]),
    ("square-well", &["diameter", "lambda", "well_depth"]),
    ("square-shoulder", &["diameter", "lambda", "height"]),
    ("penetrable", &["diameter", "height"]),
    ("bond", &["diameter", "lambda", "shortest", "longest"]),
    ("stepped", &["radii", "energies"]),
    ("stepped-lennard-jones", &["diameter", "well_depth", "cutoff", "steps", "core_energy"]),
    ("none", &[]),
];

pub(super) fn parse_interaction(
    file: InteractionFile,
    materials: &Materials,
    at: &ConfigPath,
) -> Result<InteractionDraft, SceneError> {
    let (word, keys) = Keys::of_kind(&POTENTIALS, "potential", &file.potential, at, &file)?;
    if file.species.is_none() && file.name.is_none() {
        return Err(missing(at, "species", "give it, or give `name` to use the interaction for bonds"));
    }
    let model = match word {
        "hard-sphere" => Model::HardSphere,
        "square-well" => Model::SquareWell { lambda: keys.need("lambda")?, well_depth: keys.need("well_depth")? },
        "square-shoulder" => Model::SquareShoulder { lambda: keys.need("lambda")?, height: keys.need("height")? },
        "penetrable" => Model::Penetrable { height: keys.need("height")? },
        "bond" => parse_bond(&file, &keys)?,
        "stepped" => {
            let (radii, energies) = (keys.need("radii")?, keys.need("energies")?);
            Model::Exact(Potential::new(radii, energies).map_err(|error| SceneError::new(stepped(at, &error), error))?)
        }
        "stepped-lennard-jones" => Model::SteppedLennardJones {
            well_depth: keys.need("well_depth")?,
            cutoff: keys.need("cutoff")?,
            steps: keys.need("steps")?,
            core_energy: keys.need("core_energy")?,
        },
        _ => Model::None,
    };
    let own = contact_law(file.restitution.as_ref(), file.tangential_restitution, file.friction, at)?;
    let has_own = file.restitution.is_some() || own.roughness.is_some();
    let law = match &file.species {
        Some(species) if !has_own => materials.of_pair(species, &model, at)?.unwrap_or(own),
        _ => own,
    };
    Ok(InteractionDraft { name: file.name, species: file.species, model, diameter: file.diameter, law })
}

/// Config path of the number or list that causes an error in a stepped potential.
fn stepped(at: &ConfigPath, error: &crate::model::error::PotentialError) -> ConfigPath {
    use crate::model::error::PotentialError as E;
    match *error {
        E::Radius { index, .. } | E::Order { index, .. } => at.key("radii").index(index),
        E::Energy { index, .. } => at.key("energies").index(index),
        E::Outside { .. } => at.key("energies").index(0),
        E::NoRadius => at.key("radii"),
        _ => at.key("energies"),
    }
}

fn parse_bond(file: &InteractionFile, keys: &Keys<'_>) -> Result<Model, SceneError> {
    if let Some(lambda) = file.lambda {
        keys.allow(&["diameter", "lambda"])?;
        return Ok(Model::Bond { lambda });
    }
    if file.diameter.is_some() {
        return Err(missing(
            keys.at,
            "lambda",
            "the maximum length of a bond with a diameter is lambda times the diameter",
        ));
    }
    let bond = Potential::bond(keys.need("shortest")?, keys.need("longest")?);
    bond.map(Model::Exact).map_err(|error| SceneError::new(keys.at.key("longest"), error))
}
