#[derive(Debug)]
pub struct System {
    pub name: &'static str,
    /// The scene without the seed, the thermostat, the barostat and the length of the run.
    pub scene: String,
    /// Lines of the table `[run]` for a thermostat or a barostat.
    pub ensemble: &'static str,
    pub equilibration: f64,
    pub short: f64,
}

impl System {
    pub fn scene(&self, factor: f64, seed: u64) -> String {
        let Self { scene, ensemble, equilibration, short, .. } = self;
        let until = equilibration + factor * short;
        format!("seed = {seed}\n{scene}\n[run]\nequilibration_time = {equilibration}\nuntil_time = {until}\n{ensemble}")
    }
}

#[expect(clippy::too_many_lines, reason = "a table")]
pub fn systems() -> [System; 13] {
    let hard = one(HARD);
    let system = |name, parts: &[&str], ensemble, equilibration, short| System {
        name,
        scene: parts.concat(),
        ensemble,
        equilibration,
        short,
    };
    let inelastic = |restitution: f64| one(&format!("{HARD}restitution = {restitution}\n"));
    let wells = "potential = \"square-well\"\nlambda = 1.5\nwell_depth = 1.0\n";
    [
        system("fluid", &[&hard, &fill("A", 256, "fcc", DENSE, 1.0), MEASURED, "transport = true\n"], "", 2.0, 14.0),
        system("crystal", &[&hard, &fill("A", 500, "fcc", "packing_fraction = 0.54", 1.0), MEASURED], "", 2.0, 6.0),
        system(
            "square wells",
            &[&one(wells), &fill("A", 256, "fcc", "number_density = 0.5", 1.5), MEASURED, RADIAL],
            "thermostat = { kind = \"andersen\", temperature = 1.5, rate = 1.0 }\n",
            10.0,
            30.0,
        ),
        system(
            "driven gas",
            &[&inelastic(0.8), &fill("A", 256, "fcc", "packing_fraction = 0.2", 1.0), MEASURED],
            "thermostat = { kind = \"andersen\", temperature = 1.0, rate = 0.5 }\n",
            10.0,
            30.0,
        ),
        system(
            "sheared gas",
            &[&space([11.0; 3], "shear_rate = 0.2"), &inelastic(0.9), &fill("A", 500, "random", "", 0.1), MEASURED],
            "",
            100.0,
            150.0,
        ),
        system(
            "slit",
            &[
                &space([12.0, 10.0, 10.0], "x = \"walls\""),
                &two([1.0, 4.3], [1.0, 1.7]),
                &fill("B", 20, "random", "", 1.0),
                &fill("A", 240, "random", "", 1.0),
                MEASURED,
                &flow("along", "y", 5.0),
                &flow("across", "x", 6.0),
            ],
            "",
            10.0,
            30.0,
        ),
        system(
            "mixture",
            &[
                &space([8.0; 3], ""),
                &two([1.0, 3.7], [1.0, 1.4]),
                &fill("B", 60, "random", "", 1.0),
                &fill("A", 180, "random", "", 1.0),
                MEASURED,
                RADIAL,
            ],
            "",
            5.0,
            15.0,
        ),
        system(
            "polymer",
            &[
                &space([9.0; 3], ""),
                &chains(8, 0.5),
                "temperature = 1.5\n[measure]\nchains = true\npressure_tensor = true\ndiffusion = true\n",
            ],
            "thermostat = { kind = \"andersen\", temperature = 1.5, rate = 0.2 }\n",
            20.0,
            100.0,
        ),
        // Disks between two walls at different temperatures. There is no flow along the walls.
        system(
            "channel",
            &[
                &space(
                    [20.0, 15.0, 0.0],
                    "z = \"flat\"\ny = { lower = { temperature = 1.0 }, upper = { temperature = 1.5 } }",
                ),
                &hard,
                &fill("A", 130, "random", "", 1.2),
                MEASURED,
                &flow("along", "x", 5.0),
                &flow("across", "y", 7.0),
            ],
            "",
            10.0,
            40.0,
        ),
        // Particles that do not interact, between two walls at different temperatures.
        system(
            "ideal gas",
            &[
                &space([7.0, 5.0, 5.0], "x = { lower = { temperature = 1.0 }, upper = { temperature = 1.5 } }"),
                &species("A", 1.3, 0.1),
                &interaction(["A", "A"], "potential = \"none\"\n"),
                &fill("A", 60, "random", "", 1.2),
            ],
            "",
            20.0,
            200.0,
        ),
        // Rods with two different masses. Equal rods would only exchange velocities.
        system(
            "unequal rods",
            &[
                &space([7.0, 0.0, 0.0], "y = \"flat\"\nz = \"flat\""),
                &two([1.0, 1.7], [1.0, 1.0]),
                &fill("A", 2, "random", "", 1.0),
                &fill("B", 2, "random", "", 1.0),
                "[measure]\nfree_paths = true\n",
            ],
            "",
            20.0,
            400.0,
        ),
        system(
            "constant pressure",
            &[&hard, &fill("A", 108, "fcc", "packing_fraction = 0.28", 1.0)],
            "thermostat = { kind = \"andersen\", temperature = 1.0, rate = 1.0 }\n\
             barostat = { pressure = 2.0, interval = 0.02 }\n",
            100.0,
            400.0,
        ),
        // In most runs, the heat capacity has no maximum between the four temperatures.
        system(
            "exchange",
            &[
                &space([20.0; 3], ""),
                &chains(1, 1.0),
                "[exchange]\ntemperatures = [0.36, 0.44, 0.55, 0.7]\ninterval = 2.0\nrate = 1.0\n\
                 [measure]\nchains = true\n",
            ],
            "",
            500.0,
            2000.0,
        ),
    ]
}

const HARD: &str = "potential = \"hard-sphere\"\n";
const DENSE: &str = "packing_fraction = 0.40";
const MEASURED: &str = "[measure]\nfree_paths = true\npressure_tensor = true\ndiffusion = true\n";
const RADIAL: &str = "radial_distribution = true\n";

fn space(size: [f64; 3], sides: &str) -> String {
    format!("[space]\nsize = {size:?}\n{sides}\n")
}

fn species(name: &str, mass: f64, diameter: f64) -> String {
    format!("[[species]]\nname = \"{name}\"\nmass = {mass:?}\ndiameter = {diameter:?}\n")
}

fn interaction(pair: [&str; 2], potential: &str) -> String {
    format!("[[interaction]]\nspecies = {pair:?}\n{potential}")
}

fn one(potential: &str) -> String {
    species("A", 1.0, 1.0) + &interaction(["A", "A"], potential)
}

fn two(masses: [f64; 2], diameters: [f64; 2]) -> String {
    let pairs = [["A", "A"], ["A", "B"], ["B", "B"]].map(|pair| interaction(pair, HARD)).concat();
    species("A", masses[0], diameters[0]) + &species("B", masses[1], diameters[1]) + &pairs
}

fn chains(count: u32, depth: f64) -> String {
    let well = format!("potential = \"square-well\"\nlambda = 1.5\nwell_depth = {depth:?}\n");
    species("bead", 1.0, 1.0)
        + &interaction(["bead", "bead"], &well)
        + "[[interaction]]\nname = \"link\"\npotential = \"bond\"\nshortest = 0.9\nlongest = 1.1\n"
        + &format!("[[chain]]\nspecies = \"bead\"\nlength = 16\ncount = {count}\nbond = \"link\"\n")
}

/// A `[[fill]]` table. `density` is an optional line that sets the size of the box.
fn fill(species: &str, count: u32, arrangement: &str, density: &str, temperature: f64) -> String {
    format!(
        "[[fill]]\nspecies = \"{species}\"\narrangement = \"{arrangement}\"\ncount = {count}\n{density}\n\
         temperature = {temperature:?}\n"
    )
}

fn flow(name: &str, axis: &str, at: f64) -> String {
    format!("[[measure.flow]]\nname = \"{name}\"\naxis = \"{axis}\"\nat = {at:?}\n")
}
