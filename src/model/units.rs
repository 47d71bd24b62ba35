//! Names of the units in which the numbers of a scene are given.

use crate::base::text::digits;
use serde::{Deserialize, Serialize};

/// Length of the longest name of a unit, in letters.
pub(crate) const LONGEST_NAME: usize = 16;

/// Names of the units of length, mass and time, for outputs. Carom converts no number.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Units {
    /// Name of the unit of length, such as `mm`.
    pub length: String,
    /// Name of the unit of mass, such as `g`.
    pub mass: String,
    /// Name of the unit of time, such as `ms`.
    pub time: String,
}

/// Units without names: `length`, `mass` and `time`.
impl Default for Units {
    fn default() -> Self {
        Self::new("length", "mass", "time")
    }
}

impl Units {
    /// Creates units with these names.
    #[must_use]
    pub fn new(length: &str, mass: &str, time: &str) -> Self {
        Self { length: length.to_owned(), mass: mass.to_owned(), time: time.to_owned() }
    }

    /// Whether the scene gives no names.
    pub(crate) fn are_unnamed(&self) -> bool {
        *self == Self::default()
    }

    /// Names of the units of length, mass and time; `None` if the scene gives no names.
    pub(crate) fn names(&self) -> Option<[&str; 3]> {
        (!self.are_unnamed()).then_some([&self.length, &self.mass, &self.time])
    }

    /// Whether a text can be the name of a unit. Units are multiplied and divided in outputs, so that digits and signs in
    /// their names would be misread.
    pub(crate) fn is_name(text: &str) -> bool {
        (1..=LONGEST_NAME).contains(&text.chars().count()) && text.chars().all(char::is_alphabetic)
    }

    /// Returns a text for a time, with the unit if it has a name: `0.5 ms`.
    pub(crate) fn of_time(&self, time: f64) -> String {
        let unit = if self.are_unnamed() { String::new() } else { format!(" {}", self.time) };
        format!("{}{unit}", digits(time))
    }

    /// Returns the unit of a quantity in a space of `dimensions` dimensions. `unit` is a product of powers of `length`, `mass`,
    /// `time` and `energy`, such as `energy / length^D`. Other texts are returned as they are.
    ///
    /// ```
    /// use carom::model::Units;
    ///
    /// assert_eq!(Units::default().of("energy / length^D", 2), "energy / length^2");
    /// assert_eq!(Units::new("mm", "g", "ms").of("energy / length^D", 3), "g / (mm ms^2)");
    /// ```
    #[must_use]
    pub fn of(&self, unit: &str, dimensions: usize) -> String {
        let unit = with_dimensions(unit, dimensions);
        match Powers::of(&unit) {
            Some(powers) if !self.are_unnamed() && powers != Powers::default() => powers.written(self),
            _ => unit,
        }
    }
}

/// Inserts the number of dimensions. In two dimensions, `energy / length^D` becomes `energy / length^2`.
fn with_dimensions(unit: &str, dimensions: usize) -> String {
    let (volume, viscosity, conductivity, through_area) = match dimensions {
        1 => ("length", "mass length / time", "length / time", "/ time"),
        2 => ("length^2", "mass / time", "1 / time", "/ (length time)"),
        _ => ("length^3", "mass / (length time)", "1 / (length time)", "/ (length^2 time)"),
    };
    unit.replace("mass length^(2 - D) / time", viscosity)
        .replace("length^(2 - D) / time", conductivity)
        .replace("/ (length^(D - 1) time)", through_area)
        .replace("length^D", volume)
}

/// Exponents of mass, length and time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Powers([i32; 3]);

impl Powers {
    /// Reads factors that are separated by spaces. A slash divides by the next factor, or by the product in parentheses that
    /// follows.
    fn of(unit: &str) -> Option<Self> {
        let (mut powers, mut sign, mut is_inside) = ([0; 3], 1, false);
        for word in unit.split(' ') {
            if word == "/" {
                if sign < 0 {
                    return None;
                }
                sign = -1;
                continue;
            }
            let factor = word.strip_prefix('(').unwrap_or(word);
            is_inside |= factor.len() < word.len();
            let (factor, ends) = factor.strip_suffix(')').map_or((factor, false), |factor| (factor, true));
            let (name, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let of_one = match name {
                "mass" => [1, 0, 0],
                "length" => [0, 1, 0],
                "time" => [0, 0, 1],
                "energy" => [1, 2, -2],
                "1" => [0; 3],
                _ => return None,
            };
            let power: i32 = power.parse().ok().filter(|power: &i32| power.abs() < 100)?;
            (0..3).for_each(|k| powers[k] += sign * power * of_one[k]);
            is_inside &= !ends;
            if !is_inside {
                sign = 1;
            }
        }
        (sign == 1 && !is_inside).then_some(Self(powers))
    }

    fn written(self, units: &Units) -> String {
        let names = [&units.mass, &units.length, &units.time];
        let factors = |sign: i32| -> Vec<String> {
            let power = |k: usize| match sign * self.0[k] {
                1 => Some(names[k].clone()),
                power if power > 1 => Some(format!("{}^{power}", names[k])),
                _ => None,
            };
            (0..3).filter_map(power).collect()
        };
        let (above, below) = (factors(1), factors(-1));
        let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        match below.as_slice() {
            [] => above,
            [one] => format!("{above} / {one}"),
            many => format!("{above} / ({})", many.join(" ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::observables::OBSERVABLES;

    #[test]
    fn units_contain_the_number_of_dimensions() {
        let all = |text: &str| [1, 2, 3].map(|dimensions| Units::default().of(text, dimensions));
        assert_eq!(all("energy / length^D"), ["energy / length", "energy / length^2", "energy / length^3"]);
        assert_eq!(all("mass length^(2 - D) / time"), ["mass length / time", "mass / time", "mass / (length time)"]);
        let fluxes = ["energy / time", "energy / (length time)", "energy / (length^2 time)"];
        assert_eq!(all("energy / (length^(D - 1) time)"), fluxes);
        assert_eq!(all("1"), ["1", "1", "1"]);
    }

    #[test]
    fn units_are_written_with_their_names() {
        let units = Units::new("mm", "g", "ms");
        for (unit, dimensions, expected) in [
            ("length", 3, "mm"),
            ("energy", 3, "g mm^2 / ms^2"),
            ("energy / length^D", 1, "g mm / ms^2"),
            ("energy / length^D", 2, "g / ms^2"),
            ("energy / length^D / time", 3, "g / (mm ms^3)"),
            ("energy time / length^D", 3, "g / (mm ms)"),
            ("mass length^(2 - D) / time", 3, "g / (mm ms)"),
            ("length^(2 - D) / time", 2, "1 / ms"),
            ("energy / (length^(D - 1) time)", 3, "g / ms^3"),
            ("length^D / energy", 3, "mm ms^2 / g"),
            ("1 / (mass length^2)", 3, "1 / (g mm^2)"),
            ("length^-2", 3, "1 / mm^2"),
            ("1", 3, "1"),
            ("", 3, ""),
        ] {
            assert_eq!(units.of(unit, dimensions), expected, "{unit}");
        }
        for other in [
            "k_B",
            "length * time",
            "length / / time",
            "length /",
            "(length",
            "length^x",
            "rad / time",
            "energy  length",
        ] {
            assert_eq!(units.of(other, 3), other);
        }
    }

    #[test]
    fn units_of_all_observables_get_names() {
        let units = Units::new("mm", "g", "ms");
        for ((name, unit), dimensions) in OBSERVABLES.iter().flat_map(|it| [1, 2, 3].map(|dimensions| (it, dimensions)))
        {
            let text = units.of(unit, dimensions);
            let is_named = ["length", "mass", "time", "energy"].iter().all(|word| !text.contains(word));
            assert!(is_named, "{name}: {text}");
        }
    }
}
