use crate::analysis::statistics::{Estimate, ROUNDING, Stationarity};
use crate::base::numbers::MOST_EXACT;
use crate::base::text::digits;

/// Formats a mean with two digits of its standard error, such as `1.0432 +- 0.0021`. An error below round-off is left
/// out.
#[must_use]
pub fn estimate(estimate: &Estimate) -> String {
    let Estimate { mean, standard_error } = *estimate;
    match standard_error {
        Some(error) if error > ROUNDING * mean.abs() => with_error(mean, error),
        Some(_) => exact(mean),
        None => format!("{} (too short for an error)", digits(mean)),
    }
}

/// Prints whole numbers with all digits.
fn exact(mean: f64) -> String {
    if mean.fract() == 0.0 && mean.abs() < MOST_EXACT { format!("{:.0}", mean + 0.0) } else { digits(mean) }
}

/// Describes a mean, as [`estimate`] does. Adds a note for conserved values, and for pressures without events.
#[must_use]
pub fn observable(name: &str, mean: &Estimate, stationarity: Option<Stationarity>, events: u64) -> String {
    let is_of_events = name.starts_with("pressure") || name == "compressibility_factor";
    match stationarity {
        _ if mean.mean == 0.0 && name.ends_with("_wall") => "0 (not touched)".to_owned(),
        _ if mean.mean == 0.0 => estimate(mean),
        _ if is_of_events && events == 0 => format!("{} (no event)", exact(mean.mean)),
        Some(Stationarity::Constant) => format!("{} (conserved)", digits(mean.mean)),
        _ => estimate(mean),
    }
}

/// Largest number of decimals without scientific notation.
const DECIMALS: i32 = 8;

fn with_error(mean: f64, error: f64) -> String {
    // Rounding the error can remove a decimal place: 0.0996 becomes 0.10.
    let rounded = format!("{error:.1e}");
    let exponent =
        |text: &str| text.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    let decimals = 1 - exponent(&rounded);
    let largest = mean.abs().max(error);
    let text = if (0..=DECIMALS).contains(&decimals) && largest < 1e9 {
        let decimals = decimals as usize;
        format!("{mean:.decimals$} +- {error:.decimals$}")
    } else if decimals < 0 && largest < 1e9 {
        let unit = 10_f64.powi(-decimals);
        format!("{:.0} +- {:.0}", (mean / unit).round() * unit, (error / unit).round() * unit)
    } else {
        let places = (exponent(&format!("{mean:.1e}")) + decimals).clamp(0, 17) as usize;
        format!("{mean:.places$e} +- {rounded}")
    };
    // A mean that rounds to zero has no sign.
    match text.strip_prefix('-') {
        Some(positive) if positive.split(" +- ").next().and_then(|mean| mean.parse().ok()) == Some(0.0) => {
            positive.to_owned()
        }
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_is_printed_to_the_precision_of_its_error() {
        let of = |mean, standard_error| estimate(&Estimate { mean, standard_error });
        assert_eq!(of(1.043_21, Some(0.0021)), "1.0432 +- 0.0021");
        assert_eq!(of(1234.5, Some(25.0)), "1234 +- 25");
        assert_eq!(of(1.234_56, Some(0.099_6)), "1.23 +- 0.10", "the rounded error sets the number of decimals");
        assert_eq!(of(123_456.0, Some(2_543.0)), "123500 +- 2500");
        assert_eq!(of(1.234_567e-20, Some(2.5e-23)), "1.2346e-20 +- 2.5e-23");
        assert_eq!(of(-3.4e15, Some(1.2e14)), "-3.40e15 +- 1.2e14");
        assert_eq!(of(-0.001, Some(0.34)), "0.00 +- 0.34");
        assert_eq!(of(0.0, Some(2.0)), "0.0 +- 2.0");
        assert_eq!(of(0.0, Some(0.0)), "0");
        assert_eq!(of(-0.0, Some(0.0)), "0");
        assert_eq!(of(2.0, None), "2 (too short for an error)");
        assert_eq!(of(1.906_47, Some(6.6e-17)), "1.90647");
        assert_eq!([of(-428.0, Some(0.0)), of(12_345_678.0, Some(0.0))], ["-428", "12345678"]);
    }

    #[test]
    fn only_constant_observables_are_labelled_conserved() {
        let of = |name, mean, standard_error, stationarity, events| {
            observable(name, &Estimate { mean, standard_error }, stationarity, events)
        };
        let (constant, stationary) = (Some(Stationarity::Constant), Some(Stationarity::Stationary));
        assert_eq!(of("temperature", 1.906_47, Some(1e-17), constant, 9), "1.90647 (conserved)");
        assert_eq!(of("temperature", 1.906_47, None, constant, 9), "1.90647 (conserved)");
        assert_eq!(of("temperature", 1.5, Some(0.25), stationary, 9), "1.50 +- 0.25");
        assert_eq!(of("temperature", 1.5, None, Some(Stationarity::Unknown), 9), "1.5 (too short for an error)");
        assert_eq!(of("temperature", 1.0, Some(0.0), constant, 0), "1 (conserved)");
        assert_eq!(of("compressibility_factor", 1.0, Some(0.0), constant, 0), "1 (no event)");
        assert_eq!(of("pressure", 0.25, None, None, 0), "0.25 (no event)");
        assert_eq!(of("collision_rate", 0.0, Some(0.0), constant, 0), "0");
        let unknown = Some(Stationarity::Unknown);
        assert_eq!(of("heat_flux_through_lower_z_wall", 0.0, None, unknown, 9), "0 (not touched)");
        assert_eq!(of("pressure_on_upper_x_wall", 0.0, Some(0.0), constant, 0), "0 (not touched)");
        assert_eq!(of("heat_flux_through_lower_z_wall", -1.5, Some(0.25), stationary, 9), "-1.50 +- 0.25");
    }
}
