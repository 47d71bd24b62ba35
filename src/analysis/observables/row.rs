/// One row of `thermo.csv`: observables at one time, and averages since the previous row. Missing values are `None`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Row {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Physical events since the start of the simulation.
    pub events: u64,
    /// Current kinetic temperature `[energy]`.
    pub temperature: Option<f64>,
    /// Current kinetic energy of the motion of the centres `[energy]`.
    pub kinetic: f64,
    /// Current kinetic energy of the rotation of the particles `[energy]`.
    pub rotational: f64,
    /// Current potential energy of pairs and of gravity `[energy]`.
    pub potential: f64,
    /// Net energy supplied so far by thermostats, walls, growth and shear `[energy]`.
    pub supplied: f64,
    /// Kinetic, rotational, potential and dissipated energy minus supplied energy: constant within round-off `[energy]`.
    pub ledger: f64,
    /// Pressure since the previous row `[energy / length^D]`.
    pub pressure: Option<f64>,
    /// Core contacts per particle and unit of time since the previous row `[1 / time]`.
    pub collision_rate: Option<f64>,
    /// Current volume of the box `[length^D]`. `None` if no stage has a barostat.
    pub volume: Option<f64>,
    /// Height of the centre of mass `[length]`.
    pub height: Option<f64>,
    /// Number of moving particles in each region of the scene.
    pub counts: Vec<usize>,
    /// Current number of particles, and the numbers that have entered and left since the start. `None` without an inlet
    /// or outlet.
    pub flow: Option<[u64; 3]>,
    /// Number of grains that sleep; `None` if grains never do.
    pub asleep: Option<usize>,
}
