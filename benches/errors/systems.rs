//! Systems whose means have errors of different origins.

/// A system, and the length of a short run of it.
#[derive(Debug)]
pub struct System {
    pub name: &'static str,
    /// Species and interactions that several systems share.
    pub matter: &'static str,
    /// Everything but the seed, the times and what acts during the run.
    pub scene: &'static str,
    /// Thermostat and barostat, in the table `[run]`.
    pub ensemble: &'static str,
    pub equilibration: f64,
    pub short: f64,
}

impl System {
    /// The scene of a run `factor` times as long as a short one.
    pub fn scene(&self, factor: f64, seed: u64) -> String {
        let Self { matter, scene, ensemble, equilibration, short, .. } = self;
        let until = equilibration + factor * short;
        format!(
            "seed = {seed}\n{matter}{scene}\n[run]\nequilibration_time = {equilibration}\nuntil_time = {until}\n{ensemble}"
        )
    }
}

pub const SYSTEMS: [System; 13] = [
    System { name: "fluid", matter: HARD_SPHERES, scene: FLUID, ensemble: "", equilibration: 2.0, short: 14.0 },
    System { name: "crystal", matter: HARD_SPHERES, scene: CRYSTAL, ensemble: "", equilibration: 2.0, short: 6.0 },
    System { name: "square wells", matter: "", scene: WELLS, ensemble: WARM, equilibration: 10.0, short: 30.0 },
    System { name: "driven gas", matter: "", scene: DRIVEN, ensemble: DRIVING, equilibration: 10.0, short: 30.0 },
    System { name: "sheared gas", matter: "", scene: SHEARED, ensemble: "", equilibration: 100.0, short: 150.0 },
    System { name: "slit", matter: "", scene: SLIT, ensemble: "", equilibration: 10.0, short: 30.0 },
    System { name: "mixture", matter: "", scene: MIXTURE, ensemble: "", equilibration: 5.0, short: 15.0 },
    System { name: "polymer", matter: "", scene: POLYMER, ensemble: WARM_SLOWLY, equilibration: 20.0, short: 100.0 },
    System { name: "channel", matter: HARD_SPHERES, scene: CHANNEL, ensemble: "", equilibration: 10.0, short: 40.0 },
    System { name: "ideal gas", matter: "", scene: IDEAL, ensemble: "", equilibration: 20.0, short: 200.0 },
    System { name: "unequal rods", matter: "", scene: RODS, ensemble: "", equilibration: 20.0, short: 400.0 },
    System {
        name: "constant pressure",
        matter: HARD_SPHERES,
        scene: ISOBARIC,
        ensemble: PRESSING,
        equilibration: 100.0,
        short: 400.0,
    },
    System { name: "exchange", matter: "", scene: EXCHANGE, ensemble: "", equilibration: 500.0, short: 2000.0 },
];

const WARM: &str = r#"thermostat = { kind = "andersen", temperature = 1.5, rate = 1.0 }
"#;
const WARM_SLOWLY: &str = r#"thermostat = { kind = "andersen", temperature = 1.5, rate = 0.2 }
"#;
const DRIVING: &str = r#"thermostat = { kind = "andersen", temperature = 1.0, rate = 0.5 }
"#;
const PRESSING: &str = r#"thermostat = { kind = "andersen", temperature = 1.0, rate = 1.0 }
barostat = { pressure = 2.0, interval = 0.02 }
"#;

/// One species of hard spheres.
const HARD_SPHERES: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
"#;

/// 256 hard spheres.
const FLUID: &str = r#"
[[fill]]
species = "A"
arrangement = "fcc"
count = 256
packing_fraction = 0.40
temperature = 1.0
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
transport = true
"#;

/// 500 hard spheres.
const CRYSTAL: &str = r#"
[[fill]]
species = "A"
arrangement = "fcc"
count = 500
packing_fraction = 0.54
temperature = 1.0
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
"#;

/// 256 square wells in a heat bath.
const WELLS: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[fill]]
species = "A"
arrangement = "fcc"
count = 256
number_density = 0.5
temperature = 1.5
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
radial_distribution = true
"#;

/// 256 inelastic spheres in a heat bath.
const DRIVEN: &str = r#"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
restitution = 0.8
[[fill]]
species = "A"
arrangement = "fcc"
count = 256
packing_fraction = 0.2
temperature = 1.0
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
"#;

/// 500 inelastic spheres in steady shear.
const SHEARED: &str = r#"
[space]
size = [11.0, 11.0, 11.0]
shear_rate = 0.2
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
restitution = 0.9
[[fill]]
species = "A"
arrangement = "random"
count = 500
temperature = 0.1
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
"#;

/// Two species between walls.
const SLIT: &str = r#"
[space]
size = [12.0, 10.0, 10.0]
x = "walls"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[species]]
name = "B"
mass = 4.3
diameter = 1.7
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[fill]]
species = "B"
arrangement = "random"
count = 20
temperature = 1.0
[[fill]]
species = "A"
arrangement = "random"
count = 240
temperature = 1.0
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
[[measure.flow]]
name = "along"
axis = "y"
at = 5.0
[[measure.flow]]
name = "across"
axis = "x"
at = 6.0
"#;

/// Two species in a periodic box.
const MIXTURE: &str = r#"
[space]
size = [8.0, 8.0, 8.0]
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[species]]
name = "B"
mass = 3.7
diameter = 1.4
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[fill]]
species = "B"
arrangement = "random"
count = 60
temperature = 1.0
[[fill]]
species = "A"
arrangement = "random"
count = 180
temperature = 1.0
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
radial_distribution = true
"#;

/// Eight chains of 16 beads in a heat bath.
const POLYMER: &str = r#"
[space]
size = [9.0, 9.0, 9.0]
[[species]]
name = "bead"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["bead", "bead"]
potential = "square-well"
lambda = 1.5
well_depth = 0.5
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.9
longest = 1.1
[[chain]]
species = "bead"
length = 16
count = 8
bond = "link"
temperature = 1.5
[measure]
chains = true
pressure_tensor = true
diffusion = true
"#;

/// Disks in a channel between two walls at different temperatures, without mean flow along it.
const CHANNEL: &str = r#"
[space]
size = [20.0, 15.0, 0.0]
z = "flat"
y = { lower = { temperature = 1.0 }, upper = { temperature = 1.5 } }
[[fill]]
species = "A"
arrangement = "random"
count = 130
temperature = 1.2
[measure]
free_paths = true
pressure_tensor = true
diffusion = true
[[measure.flow]]
name = "along"
axis = "x"
at = 5.0
[[measure.flow]]
name = "across"
axis = "y"
at = 7.0
"#;

/// Point particles between two walls at different temperatures, which never meet.
const IDEAL: &str = r#"
[space]
size = [7.0, 5.0, 5.0]
x = { lower = { temperature = 1.0 }, upper = { temperature = 1.5 } }
[[species]]
name = "A"
mass = 1.3
diameter = 0.1
[[interaction]]
species = ["A", "A"]
potential = "none"
[[fill]]
species = "A"
arrangement = "random"
count = 60
temperature = 1.2
"#;

/// Four rods of two masses on a line. Equal rods only exchange velocities and have no errors.
const RODS: &str = r#"
[space]
size = [7.0, 0.0, 0.0]
y = "flat"
z = "flat"
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[species]]
name = "B"
mass = 1.7
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "random"
count = 2
temperature = 1.0
[[fill]]
species = "B"
arrangement = "random"
count = 2
temperature = 1.0
[measure]
free_paths = true
"#;

/// 108 hard spheres at constant pressure.
const ISOBARIC: &str = r#"
[[fill]]
species = "A"
arrangement = "fcc"
count = 108
packing_fraction = 0.28
temperature = 1.0
"#;

/// A chain of 16 beads at four temperatures, mostly above the maximum of its heat capacity.
const EXCHANGE: &str = r#"
[space]
size = [20.0, 20.0, 20.0]
[[species]]
name = "bead"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["bead", "bead"]
potential = "square-well"
lambda = 1.5
well_depth = 1.0
[[interaction]]
name = "link"
potential = "bond"
shortest = 0.9
longest = 1.1
[[chain]]
species = "bead"
length = 16
count = 1
bond = "link"
[exchange]
temperatures = [0.36, 0.44, 0.55, 0.7]
interval = 2.0
rate = 1.0
[measure]
chains = true
"#;
