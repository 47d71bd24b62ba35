//! Validates the names of units.

use crate::model::Units;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};

const LONGEST: usize = 16;

/// Units are multiplied and divided in outputs, so that digits and signs in their names would be misread.
pub(super) fn check_units(units: &Units) -> Result<(), SceneError> {
    let Units { length, mass, time } = units;
    let at = |key| ConfigPath::root().key("units").key(key);
    let is_name = |name: &str| (1..=LONGEST).contains(&name.chars().count()) && name.chars().all(char::is_alphabetic);
    for (name, key) in [(length, "length"), (mass, "mass"), (time, "time")] {
        if !is_name(name) {
            let shown: String = name.chars().take(40).flat_map(char::escape_debug).collect();
            let expected = format!(
                "a name of up to {LONGEST} letters, such as mm: outputs contain it, and no number is converted"
            );
            return refuse(at(key), format!("\"{shown}\""), expected);
        }
    }
    for (name, other, key) in [(mass, length, "mass"), (time, length, "time"), (time, mass, "time")] {
        if name == other {
            return refuse(at(key), format!("\"{name}\""), "another name than the other units");
        }
    }
    Ok(())
}
