//! Parses the keys of a contact law, which interactions, walls and surfaces share.

use crate::base::text::plural;
use crate::model::{ContactLaw, Restitution, RestitutionTable};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::file::{RestitutionFile, VaryingFile};
use crate::scene::limits;

/// Returns the contact law of a table. Contacts are smooth without the keys of rough contacts.
pub(super) fn contact_law(
    restitution: Option<&RestitutionFile>,
    tangential: Option<f64>,
    friction: Option<f64>,
    at: &ConfigPath,
) -> Result<ContactLaw, SceneError> {
    let mut law = ContactLaw::smooth(1.0);
    if let Some(file) = restitution {
        law.restitution = parse_restitution(file, &at.key("restitution"))?;
    }
    let law = tangential.map_or(law, |tangential| law.with_tangential_restitution(tangential));
    Ok(friction.map_or(law, |friction| law.with_friction(friction)))
}

fn parse_restitution(file: &RestitutionFile, at: &ConfigPath) -> Result<Restitution, SceneError> {
    let VaryingFile { speeds, values, viscous_time, stiffness } = match file {
        RestitutionFile::Number(restitution) => return Ok(Restitution::Constant(*restitution)),
        RestitutionFile::Varying(varying) => varying,
    };
    match (speeds, values, *viscous_time, *stiffness) {
        (Some(speeds), Some(values), None, None) => table(speeds, values, at),
        (None, None, Some(viscous_time), Some(stiffness)) => Ok(Restitution::Viscoelastic { viscous_time, stiffness }),
        (None, None, Some(_), None) => Err(missing(at, "stiffness", "viscoelastic spheres need it")),
        (None, None, None, Some(_)) => Err(missing(at, "viscous_time", "viscoelastic spheres need it")),
        (Some(_), None, None, None) => Err(missing(at, "values", "give the coefficient of restitution at each speed")),
        (None, Some(_), None, None) => Err(missing(at, "speeds", "give the speed of impact for each value")),
        (None, None, None, None) => {
            Err(missing(at, "speeds", "give `speeds` and `values`, or `viscous_time` and `stiffness`"))
        }
        _ => {
            let key = if viscous_time.is_some() { "viscous_time" } else { "stiffness" };
            refuse(at.key(key), "given for a table", "either speeds and values, or viscous_time and stiffness")
        }
    }
}

fn table(speeds: &[f64], values: &[f64], at: &ConfigPath) -> Result<Restitution, SceneError> {
    if speeds.is_empty() {
        return refuse(at.key("speeds"), "empty", "at least one speed");
    }
    if values.len() != speeds.len() {
        let expected = format!("one for each of {}", plural(speeds.len(), "speed"));
        return refuse(at.key("values"), plural(values.len(), "value"), expected);
    }
    for (k, (&speed, &value)) in speeds.iter().zip(values).enumerate() {
        limits::not_negative(speed, at.key("speeds").index(k))?;
        limits::restitution(value, at.key("values").index(k))?;
        if k > 0 && speed <= speeds[k - 1] {
            return refuse(at.key("speeds").index(k), speed, format!("more than the speed before, {}", speeds[k - 1]));
        }
    }
    match RestitutionTable::new(speeds, values) {
        Some(table) => Ok(Restitution::Table(table)),
        None => refuse(at.key("speeds"), "no table", "increasing speeds and values from 0 to 1"),
    }
}
