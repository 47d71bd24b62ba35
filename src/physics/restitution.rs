//! Coefficients of restitution that may depend on the speed of impact.

use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

/// Coefficient of restitution `e`: the normal speed after a contact, divided by the normal speed `v` before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Restitution {
    /// The same number in `[0, 1]` at all speeds.
    Constant(f64),
    /// Viscoelastic spheres. They lose less energy in slower collisions:
    ///
    /// ```text
    /// e = (1 + a x) / (1 + a x + b x^2 + c x^3 + d x^4),    x^2 = 3/2 A (rho / mu)^(2/5) v^(1/5)
    /// ```
    ///
    /// with the reduced mass `mu`, a = 0.501086, b = 1.15345, c = 0.577977 and d = 0.532178. This is the approximation
    /// of P. Müller and T. Pöschel, Phys. Rev. E 84, 021302 (2011), whose first terms are the series of R. Ramírez, T.
    /// Pöschel, N. V. Brilliantov and T. Schwager, Phys. Rev. E 60, 4465 (1999). Compared with the equation of motion
    /// of two spheres with the force below, the error of `e` is at most 0.001 above `e = 0.7`, and at most 0.01
    /// elsewhere.
    Viscoelastic {
        /// `A` in the force `rho (xi^(3/2) + 3/2 A sqrt(xi) dxi/dt)` at the compression `xi` `[time]`.
        viscous_time: f64,
        /// `rho` in this force `[mass / (length^(1/2) time^2)]`. Spheres of the same material have `rho = 2 Y sqrt(R) /
        /// (3 (1 - nu^2))`, with Young's modulus `Y`, Poisson's ratio `nu`, and `1 / R = 1 / R_i + 1 / R_j`.
        stiffness: f64,
    },
    /// A measured curve.
    Table(RestitutionTable),
}

/// Coefficients of restitution at given speeds. The coefficient is interpolated linearly between these speeds. It is
/// constant below the first and above the last speed.
///
/// Contact laws are copied often, so they hold only a reference to the table. Each distinct table stays in memory until
/// the process ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "Columns", try_from = "Columns")]
pub struct RestitutionTable(&'static Columns);

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Columns {
    speeds: Vec<f64>,
    values: Vec<f64>,
}

/// All tables of this process.
static TABLES: Mutex<Vec<&'static Columns>> = Mutex::new(Vec::new());

impl From<RestitutionTable> for Columns {
    fn from(table: RestitutionTable) -> Self {
        table.0.clone()
    }
}

impl TryFrom<Columns> for RestitutionTable {
    type Error = &'static str;

    fn try_from(columns: Columns) -> Result<Self, Self::Error> {
        Self::new(&columns.speeds, &columns.values).ok_or("a table of restitutions is not valid")
    }
}

impl RestitutionTable {
    /// Creates a table with one value for each speed. There must be at least one speed. Speeds must be finite, not
    /// negative and increasing, and values must be from 0 to 1. Returns `None` otherwise.
    #[must_use]
    pub fn new(speeds: &[f64], values: &[f64]) -> Option<Self> {
        let is_increasing = speeds.windows(2).all(|two| two[0] < two[1]);
        let are_speeds = is_increasing && speeds.iter().all(|speed| *speed >= 0.0 && speed.is_finite());
        let are_values = values.iter().all(|value| (0.0..=1.0).contains(value));
        if !are_speeds || !are_values || speeds.is_empty() || speeds.len() != values.len() {
            return None;
        }
        let columns = Columns { speeds: speeds.to_vec(), values: values.to_vec() };
        let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = tables.iter().find(|known| ***known == columns) {
            return Some(Self(known));
        }
        let added: &'static Columns = Box::leak(Box::new(columns));
        tables.push(added);
        Some(Self(added))
    }

    /// The speeds of the table `[length / time]`.
    #[must_use]
    pub fn speeds(&self) -> &'static [f64] {
        &self.0.speeds
    }

    /// The coefficients of restitution at these speeds.
    #[must_use]
    pub fn values(&self) -> &'static [f64] {
        &self.0.values
    }

    fn at(self, speed: f64) -> f64 {
        let (speeds, values) = (self.speeds(), self.values());
        match speeds.partition_point(|other| *other <= speed) {
            0 => values[0],
            k if k == speeds.len() => values[k - 1],
            k => {
                let part = (speed - speeds[k - 1]) / (speeds[k] - speeds[k - 1]);
                values[k - 1] + part * (values[k] - values[k - 1])
            }
        }
    }
}

impl From<f64> for Restitution {
    fn from(restitution: f64) -> Self {
        Self::Constant(restitution)
    }
}

impl Restitution {
    /// Returns the coefficient at a normal speed of impact `[length / time]`, for a pair with the reduced mass
    /// `mu = m_i m_j / (m_i + m_j)` `[mass]`. The reduced mass of a particle at a wall is its mass.
    #[inline]
    #[must_use]
    pub fn at(&self, speed: f64, reduced_mass: f64) -> f64 {
        match self {
            Self::Constant(restitution) => *restitution,
            _ => self.at_speed(speed, reduced_mass),
        }
    }

    #[cold]
    fn at_speed(&self, speed: f64, reduced_mass: f64) -> f64 {
        match *self {
            Self::Constant(restitution) => restitution,
            Self::Viscoelastic { viscous_time, stiffness } => {
                let squared =
                    1.5 * viscous_time * libm::pow(stiffness / reduced_mass, 0.4) * libm::pow(speed.max(0.0), 0.2);
                viscoelastic(squared.sqrt())
            }
            Self::Table(table) => table.at(speed),
        }
    }

    /// Whether the coefficient is the same at all speeds.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Constant(_))
    }

    /// Whether all contacts keep the normal speed.
    #[must_use]
    pub fn is_elastic(&self) -> bool {
        match self {
            Self::Constant(restitution) => *restitution == 1.0,
            Self::Viscoelastic { viscous_time, .. } => *viscous_time == 0.0,
            Self::Table(table) => table.values().iter().all(|value| *value == 1.0),
        }
    }

    /// Upper bound of the magnitude of the derivative `d(e v)/dv` for speeds `v` in the range `[from, to]`. Here, `v`
    /// and `e v` are the speeds before and after a contact. The bound is at least 1.
    pub(crate) fn steepness(&self, [from, to]: [f64; 2]) -> f64 {
        match self {
            // The coefficient of viscoelastic spheres decreases more slowly than `1 / v`.
            Self::Constant(_) | Self::Viscoelastic { .. } => 1.0,
            Self::Table(table) => {
                let (speeds, values) = (table.speeds(), table.values());
                let of_part = |k: usize| {
                    let slope = (values[k] - values[k - 1]) / (speeds[k] - speeds[k - 1]);
                    // Within a part, the derivative of `e v` is linear in the speed.
                    let [lower, upper] = [k - 1, k].map(|end| (values[end] + slope * speeds[end]).abs());
                    lower.max(upper)
                };
                let is_met = |k: &usize| speeds[k - 1] <= to && speeds[*k] >= from;
                (1..speeds.len()).filter(is_met).map(of_part).fold(1.0, f64::max)
            }
        }
    }

    /// Numbers that define the law.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Constant(restitution) => vec![*restitution],
            // No coefficient is negative, so different kinds of laws have different numbers.
            Self::Viscoelastic { viscous_time, stiffness } => vec![-1.0, *viscous_time, *stiffness],
            Self::Table(table) => [&[-2.0, table.speeds().len() as f64], table.speeds(), table.values()].concat(),
        }
    }
}

fn viscoelastic(x: f64) -> f64 {
    const A: f64 = 0.501_086;
    const B: f64 = 1.153_45;
    const C: f64 = 0.577_977;
    const D: f64 = 0.532_178;
    let upper = 1.0 + A * x;
    // Far beyond all masses and speeds in practice, `x^4` may overflow. The quotient is then 0.
    upper / (upper + x * x * (B + x * (C + x * D)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficient of restitution of two spheres, from the equation of motion `xi'' = -(rho / mu) (xi^(3/2) + 3/2 A
    /// sqrt(xi) xi')`. The contact ends when the force is zero.
    fn simulated(viscous_time: f64, stiffness: f64, mass: f64, speed: f64) -> f64 {
        let k = stiffness / mass;
        let root = |xi: f64| xi.max(0.0).sqrt();
        let pull = |[xi, v]: [f64; 2]| [v, -k * root(xi) * (xi + 1.5 * viscous_time * v)];
        let step = 2e-4 / (libm::pow(k, 0.4) * libm::pow(speed, 0.2));
        let mut state = [0.0, speed];
        for n in 0..1_000_000_i32 {
            // The root makes the force steep at the beginning.
            let h = step * libm::pow(1.02, f64::from(n.min(1_000)) - 465.0).min(1.0);
            let shifted = |by: f64, slope: [f64; 2]| [state[0] + by * slope[0], state[1] + by * slope[1]];
            let first = pull(state);
            let second = pull(shifted(0.5 * h, first));
            let third = pull(shifted(0.5 * h, second));
            let fourth = pull(shifted(h, third));
            let sum = |k: usize| h / 6.0 * (first[k] + 2.0 * second[k] + 2.0 * third[k] + fourth[k]);
            state = [state[0] + sum(0), state[1] + sum(1)];
            if state[1] < 0.0 && state[0] + 1.5 * viscous_time * state[1] <= 0.0 {
                return -state[1] / speed;
            }
        }
        f64::NAN
    }

    #[test]
    fn viscoelastic_spheres_follow_their_equation_of_motion() {
        for (viscous_time, bound) in [(1e-3, 1e-5), (0.05, 5e-5), (0.1, 3e-4), (0.2, 1e-3), (0.5, 5e-3), (2.0, 0.01)] {
            for (stiffness, mass, speed) in [(1.0, 1.0, 1.0), (2.3, 1.7, 0.3)] {
                let law = Restitution::Viscoelastic { viscous_time, stiffness };
                let (found, exact) = (law.at(speed, mass), simulated(viscous_time, stiffness, mass, speed));
                assert!((found - exact).abs() < bound, "A = {viscous_time}: {found} {exact}");
                assert!(exact > 0.1 && exact < 0.9985);
            }
        }
        let law = Restitution::Viscoelastic { viscous_time: 0.1, stiffness: 3.0 };
        assert_eq!((law.at(0.0, 1.3), law.at(f64::MAX, f64::MIN_POSITIVE) < 1e-3), (1.0, true));
        // The speed after a contact increases with the speed before, but at most by the bound.
        let speeds = (-300..300).map(|k| libm::pow(1.1, f64::from(k)));
        let [mut before, mut after] = [0.0, 0.0];
        for speed in speeds {
            let left = law.at(speed, 1.3) * speed;
            assert!(left > after && left - after < law.steepness([before, speed]) * (speed - before), "{speed}");
            [before, after] = [speed, left];
        }
    }

    #[test]
    fn tables_are_linear_between_their_speeds_and_constant_outside() {
        let table = RestitutionTable::new(&[0.5, 1.5, 1.75], &[0.9, 0.7, 0.8]).unwrap();
        let law = Restitution::Table(table);
        for (speed, value) in
            [(0.0, 0.9), (0.5, 0.9), (0.75, 0.85), (1.0, 0.8), (1.5, 0.7), (1.625, 0.75), (1.75, 0.8), (9.0, 0.8)]
        {
            assert!((law.at(speed, f64::NAN) - value).abs() < 1e-15, "{speed}: {}", law.at(speed, f64::NAN));
        }
        // At 1.75, the derivative of `e v` is 0.8 + 0.4 * 1.75.
        assert!((law.steepness([0.0, 9.0]) - 1.5).abs() < 1e-15);
        // Elsewhere, the derivative is below 1, which is the least value of the bound.
        assert_eq!([law.steepness([0.6, 0.7]), law.steepness([2.0, 9.0])], [1.0, 1.0]);
        assert!(std::ptr::eq(table.0, RestitutionTable::new(&[0.5, 1.5, 1.75], &[0.9, 0.7, 0.8]).unwrap().0));
        let text = serde_json::to_string(&law).unwrap();
        assert_eq!(serde_json::from_str::<Restitution>(&text).unwrap(), law);
        assert!(serde_json::from_str::<Restitution>(&text.replace("0.8", "1.8")).is_err());
        assert_eq!(law.numbers(), [-2.0, 3.0, 0.5, 1.5, 1.75, 0.9, 0.7, 0.8]);
        for (speeds, values) in [
            (vec![], vec![]),
            (vec![1.0], vec![]),
            (vec![-1.0], vec![0.5]),
            (vec![1.0], vec![1.1]),
            (vec![f64::NAN, 1.0], vec![0.5, 0.5]),
            (vec![1.0, f64::INFINITY], vec![0.5, 0.5]),
            (vec![1.0, 1.0], vec![0.5, 0.5]),
        ] {
            assert_eq!(RestitutionTable::new(&speeds, &values), None, "{speeds:?}");
        }
    }

    #[test]
    fn elastic_laws_are_recognised() {
        let table = |values: [f64; 2]| Restitution::Table(RestitutionTable::new(&[1.0, 2.0], &values).unwrap());
        assert!(Restitution::from(1.0).is_elastic() && table([1.0, 1.0]).is_elastic());
        assert!(!Restitution::from(0.9).is_elastic() && !table([1.0, 0.9]).is_elastic());
        assert!(!Restitution::Viscoelastic { viscous_time: 1e-6, stiffness: 1e6 }.is_elastic());
    }
}
