use carom::Vector;

/// Time averages. Energies are per particle.
#[derive(Debug, Clone, Copy)]
pub struct Thermodynamics {
    pub temperature: f64,
    pub potential: f64,
    pub pressure: f64,
    pub total: f64,
}

impl Thermodynamics {
    /// Evaluates a statistic, such as the mean over time, for each quantity.
    pub fn each(statistic: impl Fn(fn(&Self) -> f64) -> f64) -> Self {
        Self {
            temperature: statistic(|x| x.temperature),
            potential: statistic(|x| x.potential),
            pressure: statistic(|x| x.pressure),
            total: statistic(|x| x.total),
        }
    }

    /// The virial is the sum of `r_ij . F_ij`. The total momentum is zero.
    pub fn new(count: f64, volume: f64, kinetic: f64, potential: f64, virial: f64) -> Self {
        Self {
            temperature: 2.0 * kinetic / (3.0 * (count - 1.0)),
            potential: potential / count,
            pressure: (2.0 * kinetic + virial) / (3.0 * volume),
            total: (kinetic + potential) / count,
        }
    }
}

pub trait Fluid {
    fn advance(&mut self, time: f64) -> Thermodynamics;
}

/// The fluid at the start of all compared runs.
pub struct State {
    pub box_length: f64,
    pub positions: Vec<Vector>,
    pub velocities: Vec<Vector>,
    /// Total energy per particle in the cut and shifted potential.
    pub energy: f64,
}

impl State {
    pub fn particles(&self) -> f64 {
        self.positions.len() as f64
    }
}
