//! Parses the tables of inlets.

use super::particles::{composition, parse_region};
use super::vector;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};
use crate::scene::file::InletFile;
use crate::scene::inlet_draft::{InletDraft, RATE, Rate};

pub(super) fn parse_inlet(file: InletFile, index: usize) -> Result<InletDraft, SceneError> {
    let at = ConfigPath::entry("inlet", index);
    let rate = match (file.rate, file.mass_rate) {
        (Some(_), Some(_)) => return refuse(at.key("mass_rate"), "given as well", "either mass_rate or rate"),
        (Some(rate), None) => Some(Rate::Number(rate)),
        (None, Some(rate)) => Some(Rate::Mass(rate)),
        (None, None) if file.recirculate.is_some() => None,
        (None, None) => return Err(missing(&at, "rate", RATE)),
    };
    if file.recirculate.as_ref().is_some_and(Vec::is_empty) {
        return refuse(at.key("recirculate"), "empty", "the name of at least one outlet");
    }
    let is_single = rate.is_none() && file.species.is_none() && file.composition.is_none();
    let composition = if is_single { Vec::new() } else { composition(file.species, file.composition, &at)? };
    Ok(InletDraft {
        name: file.name.unwrap_or_else(|| format!("inlet {}", index + 1)),
        composition,
        region: parse_region(&file.region, &at.key("region"))?,
        rate,
        velocity: vector(file.velocity.unwrap_or_default()),
        temperature: file.temperature.unwrap_or(0.0),
        stage: file.stage,
        from: file.from,
        until: file.until,
        count: file.count,
        keep: file.keep,
        recirculate: file.recirculate.unwrap_or_default(),
    })
}
