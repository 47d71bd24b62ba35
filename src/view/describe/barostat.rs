use crate::base::text::digits;
use crate::model::{Barostat, VolumeMoves};

/// Describes a barostat.
#[must_use]
pub fn barostat(barostat: &Barostat) -> String {
    let (pressure, interval) = (digits(barostat.pressure), digits(barostat.interval));
    let amplitude = match barostat.amplitude {
        Some(amplitude) => format!("by up to {}", digits(amplitude)),
        None => "by an amount that is adjusted outside of measurements to accept about 40 % of the moves".to_owned(),
    };
    format!("a volume move at intervals of {interval}, at a pressure of {pressure}: ln V changes {amplitude}")
}

/// Describes the volume moves of a measurement.
#[must_use]
pub fn volume_moves(moves: &VolumeMoves) -> String {
    let accepted = moves.acceptance().map_or_else(String::new, |part| format!(", {:.1} % accepted", 100.0 * part));
    let too_small = if moves.too_small == 0 {
        String::new()
    } else {
        let part = 100.0 * moves.too_small as f64 / moves.attempted as f64;
        format!(", {part:.1} % rejected because the box would be shorter than twice the interaction range")
    };
    format!("{}{accepted}{too_small}; each changes ln V by up to {}", moves.attempted, digits(moves.amplitude))
}
