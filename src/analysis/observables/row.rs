//! A row of measurements.

/// Thermodynamic observables at one time, and averages since the row before: a row of `thermo.csv`.
///
/// Quantities that mean nothing for the scene, or cannot be known yet, are `None`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Row {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Physical events since the start of the simulation.
    pub events: u64,
    /// Kinetic temperature now `[energy]`.
    pub temperature: Option<f64>,
    /// Kinetic energy now `[energy]`.
    pub kinetic: f64,
    /// Potential energy now, of pairs and of weight `[energy]`.
    pub potential: f64,
    /// Energy that thermostats, walls, growth and shear have supplied so far, less what they took `[energy]`.
    pub supplied: f64,
    /// Kinetic and potential energy, and what was dissipated so far, less what was supplied: constant within round-off `[energy]`.
    pub ledger: f64,
    /// Pressure since the row before `[energy / length^D]`.
    pub pressure: Option<f64>,
    /// Core contacts per particle and time since the row before `[1 / time]`.
    pub collision_rate: Option<f64>,
    /// Volume of the box now, where a barostat changes it in some stage `[length^D]`.
    pub volume: Option<f64>,
    /// Height of the centre of mass against gravity `[length]`.
    pub height: Option<f64>,
    /// Number of moving particles in each of the regions that the scene counts in.
    pub counts: Vec<usize>,
}
