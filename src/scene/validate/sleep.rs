//! Validates when grains fall asleep.

use crate::base::text::shortest;
use crate::model::diameters::Diameters;
use crate::model::{SceneParts, Sleep, Species};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::limits::positive;

/// Minimum interval between two searches for grains at rest, in contact times. A grain at rest has several contacts in
/// this interval.
const MOST_FREQUENT: f64 = 20.0;

/// Maximum of `distance`, in units of the smallest diameter. The neighbour search finds grains at most this far from
/// contact.
const LONGEST: f64 = 0.05;

pub(super) fn check_sleep(parts: &SceneParts, species: &[Species], diameters: &[Diameters]) -> Result<(), SceneError> {
    let Some(sleep) = parts.sleep else { return Ok(()) };
    let at = |key| ConfigPath::root().key("dynamics").key("sleep").key(key);
    let Sleep { interval, distance, wake_speed } = sleep;
    for (value, key) in [(interval, "interval"), (distance, "distance"), (wake_speed, "wake_speed")] {
        positive(value, at(key))?;
    }
    let least = parts.contact_time.map_or(0.0, |contact_time| MOST_FREQUENT * contact_time);
    if interval < least {
        return refuse(at("interval"), interval, format!("at least {MOST_FREQUENT} contact times, which is {least}"));
    }
    let moving = species.iter().zip(diameters).filter(|(species, _)| !species.is_static());
    let most = LONGEST * moving.map(|(_, range)| range.smallest).fold(f64::INFINITY, f64::min);
    if distance > most {
        let expected = format!("at most {LONGEST} of the smallest diameter, which is {}", shortest(most));
        return refuse(at("distance"), distance, expected);
    }
    Ok(())
}
