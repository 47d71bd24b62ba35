//! Validates the names of units.

use crate::model::Units;
use crate::model::units::LONGEST_NAME;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};

pub(super) fn check_units(units: &Units) -> Result<(), SceneError> {
    let Units { length, mass, time } = units;
    let at = |key| ConfigPath::root().key("units").key(key);
    for (name, key) in [(length, "length"), (mass, "mass"), (time, "time")] {
        if !Units::is_name(name) {
            let shown: String = name.chars().take(40).flat_map(char::escape_debug).collect();
            let expected = format!(
                "a name of up to {LONGEST_NAME} letters, such as mm: outputs contain it, and no number is converted"
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
