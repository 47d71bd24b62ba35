//! Small systems, with shear, thermostats, thermal walls and other influences on trajectories.

use carom::model::Scene;

const SPHERES: &str = r#"
space.size = [6.0, 6.0, 6.0]
run.until_events = 4000
interaction = [{ species = ["A", "A"], potential = "hard-sphere" }]

[[species]]
name = "A"
mass = 1.7
diameter = 1.0

[[fill]]
species = "A"
arrangement = "random"
count = 60
temperature = 1.3
"#;

const MIXTURE: &str = r#"
space.size = [7.0, 7.0, 7.0]
run.until_events = 4000
interaction = [
    { species = ["A", "A"], potential = "square-well", lambda = 1.4, well_depth = 0.7 },
    { species = ["A", "B"], potential = "square-shoulder", lambda = 1.3, height = 0.4 },
    { species = ["B", "B"], potential = "hard-sphere" },
    { name = "link", potential = "bond", shortest = 0.9, longest = 1.25 },
]

[[species]]
name = "A"
mass = 1.7
diameter = 1.1

[[species]]
name = "B"
mass = 0.3
diameter = 0.7

[[fill]]
composition = { A = 2, B = 3 }
arrangement = "random"
count = 70
temperature = 1.3
"#;

/// Chains hang from a static sphere above a mesh. The interaction of a bonded pair does not keep the pair together.
const BONDED: &str = r#"
space.size = [6.3, 6.4, 9.0]
run.until_events = 4000
interaction = [
    { species = ["A", "A"], potential = "square-well", lambda = 1.3, well_depth = 0.6, restitution = 0.95 },
    { species = ["A", "S"], potential = "hard-sphere", restitution = 0.8 },
    { name = "link", potential = "bond", shortest = 0.8, longest = 1.2 },
    { name = "own", potential = "square-well", lambda = 1.6, well_depth = 2.0, diameter = 0.9 },
]
chain = [{ species = "A", length = 5, count = 4, bond = "link", temperature = 1.0 }]
bond = [{ particles = [0, 1], interaction = "link" }, { particles = [2, 3], interaction = "own" }]
mesh = [{ species = "S", surface = "plane", corner = [1.0, 1.0, 1.0], edge_1 = [3.0, 0.0, 0.0], edge_2 = [0.0, 3.0, 0.0] }]

[[species]]
name = "A"
mass = 1.3
diameter = 1.0

[[species]]
name = "S"
diameter = 1.0
static = true

[[particle]]
species = "S"
position = [3.1, 3.2, 8.0]

[[particle]]
species = "A"
position = [4.1, 3.2, 8.0]
velocity = [0.0, 0.7, 0.2]

[[particle]]
species = "A"
position = [0.6, 0.7, 5.0]
velocity = [-0.9, 0.3, 0.6]

[[particle]]
species = "A"
position = [5.2, 5.6, 4.0]
velocity = [0.4, -0.8, 0.9]
"#;

/// In this small box, several images of a partner are near.
const PAIR: &str = r#"
space.size = [3.3, 3.2, 3.4]
run.until_events = 4000
interaction = [{ species = ["A", "A"], potential = "square-well", lambda = 1.5, well_depth = 0.8 }]
species = [{ name = "A", mass = 1.7, diameter = 1.0 }]
particle = [
    { species = "A", position = [0.3, 0.4, 0.5], velocity = [0.9, -0.2, 0.4] },
    { species = "A", position = [1.9, 2.0, 2.1], velocity = [-0.3, 0.6, -0.7] },
]
"#;

/// Name, scene, and values that override values of the scene.
type System = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

const ANDERSEN: (&str, &str) = ("run.thermostat", r#"{ kind = "andersen", temperature = 0.9, rate = 0.7 }"#);
const DISSIPATES: (&str, &str) = ("interaction.0.restitution", "0.9");
const SHEAR: (&str, &str) = ("space.shear_rate", "0.3");
const WEIGHT: (&str, &str) = ("dynamics.gravity", "[0.1, 0.0, -1.0]");
const DISKS: [(&str, &str); 2] = [("space.size", "[12.0, 11.0, 0.0]"), ("space.z", r#""flat""#)];
const LINE: [(&str, &str); 3] =
    [("space.size", "[95.0, 0.0, 0.0]"), ("space.y", r#""flat""#), ("space.z", r#""flat""#)];
const SEVERAL: (&str, &str) = ("space.size", "[3.3, 3.2, 3.5]");
const CHAINS: (&str, &str) =
    ("chain", r#"[{ species = "A", length = 5, count = 3, bond = "link", temperature = 1.0 }]"#);
const OWN_DIAMETERS: [(&str, &str); 2] = [
    ("species.0.diameter", r#"{ distribution = "power-law", exponent = 2.5, lower = 0.7, upper = 1.6 }"#),
    ("species.0.diameters", r#""individual""#),
];
const FEW: (&str, &str) = ("fill.0.count", "9");

pub const SYSTEMS: &[System] = &[
    ("sheared", SPHERES, &[SHEAR, DISSIPATES]),
    ("sheared disks", SPHERES, &[DISKS[0], DISKS[1], SHEAR, DISSIPATES]),
    ("sheared mixture", MIXTURE, &[SHEAR]),
    ("sheared in a bath", MIXTURE, &[SHEAR, ANDERSEN]),
    ("sheared small box", MIXTURE, &[("space.size", "[6.2, 6.3, 6.2]"), FEW, SHEAR]),
    ("sheared chains", MIXTURE, &[SHEAR, CHAINS]),
    (
        "growth",
        SPHERES,
        &[(
            "stage",
            r#"[{ name = "grow", grow = { rate = 0.2, packing_fraction = 0.45 },
                  thermostat = { kind = "rescaling", temperature = 1.0, interval = 0.1 } }]"#,
        )],
    ),
    (
        "growth of disks",
        SPHERES,
        &[
            DISKS[0],
            DISKS[1],
            ("stage", r#"[{ name = "grow", grow = { rate = 0.05, compressibility_factor = 8.0 } }]"#),
        ],
    ),
    ("andersen", MIXTURE, &[ANDERSEN]),
    (
        "andersen on two axes",
        SPHERES,
        &[("run.thermostat", r#"{ kind = "andersen", temperature = 0.9, rate = 0.7, axes = ["x", "z"] }"#)],
    ),
    ("rescaling", MIXTURE, &[("run.thermostat", r#"{ kind = "rescaling", temperature = 0.9, interval = 0.3 }"#)]),
    (
        "stages",
        MIXTURE,
        &[
            ANDERSEN,
            (
                "stage",
                r#"[{ name = "hot", measure = true, equilibration_events = 500, until_events = 1000,
                      thermostat = { kind = "andersen", temperature = 2.0, rate = 1.0 } },
                    { name = "free", until_time = 0.7 }]"#,
            ),
        ],
    ),
    (
        "thermal walls",
        SPHERES,
        &[
            ("space.x", r#"{ lower = { temperature = 2.0 }, upper = { temperature = 0.7 } }"#),
            ("space.y", r#"{ lower = { temperature = 1.5 }, upper = "wall" }"#),
        ],
    ),
    (
        "thermal walls of a mixture",
        MIXTURE,
        &[("space.z", r#"{ lower = { temperature = 2.0 }, upper = { temperature = 0.7 } }"#), WEIGHT],
    ),
    (
        "dissipative walls",
        SPHERES,
        &[
            ("space.x", r#"{ lower = { restitution = 0.7 }, upper = { restitution = 0.95 } }"#),
            ("space.y", r#""walls""#),
        ],
    ),
    (
        "dissipative floor",
        MIXTURE,
        &[("space.z", r#"{ lower = "wall", upper = "open", restitution = 0.9 }"#), ("space.x", r#""walls""#), WEIGHT],
    ),
    (
        "TC model",
        SPHERES,
        &[
            ("space.z", r#"{ lower = "wall", upper = "open", restitution = 0.6 }"#),
            ("interaction.0.restitution", "0.6"),
            ("dynamics.contact_time", "0.003"),
            WEIGHT,
        ],
    ),
    ("line", MIXTURE, &LINE),
    ("disks", MIXTURE, &DISKS),
    ("hard disks", SPHERES, &DISKS),
    ("small box", MIXTURE, &[SEVERAL, FEW]),
    ("pair", PAIR, &[]),
    ("hard pair", PAIR, &[("interaction", r#"[{ species = ["A", "A"], potential = "hard-sphere" }]"#)]),
    ("falling pair", PAIR, &[WEIGHT, ("space.z", r#""walls""#)]),
    ("chains", BONDED, &[]),
    ("chains that slide", BONDED, &[("interaction.2.restitution", "0.9"), ("dynamics.contact_time", "0.001")]),
    (
        "falling chains",
        BONDED,
        &[
            ("interaction.2.restitution", "0.9"),
            WEIGHT,
            ("space.z", r#"{ lower = "wall", upper = "open", restitution = 0.9 }"#),
            ("dynamics.contact_time", "0.001"),
        ],
    ),
    (
        "distributed diameters",
        SPHERES,
        &[("species.0.diameter", r#"{ distribution = "gaussian", mean = 1.0, deviation = 0.15, classes = 5 }"#)],
    ),
    ("individual diameters", SPHERES, &OWN_DIAMETERS),
    (
        "individual diameters in wells",
        MIXTURE,
        &[OWN_DIAMETERS[0], OWN_DIAMETERS[1], WEIGHT, ("space.x", r#""walls""#), ("space.z", r#""walls""#)],
    ),
    (
        "individual diameters that grow and are exchanged",
        SPHERES,
        &[
            OWN_DIAMETERS[0],
            OWN_DIAMETERS[1],
            ("run.swap", "{ interval = 0.3 }"),
            ("stage", r#"[{ name = "grow", grow = { rate = 0.2, packing_fraction = 0.4 } }]"#),
        ],
    ),
];

pub fn scene_of((name, text, values): &System) -> Scene {
    Scene::from_toml_with(*text, format!("{}.toml", name.replace(' ', "_")), values)
        .unwrap_or_else(|error| panic!("{name}: {error:?}"))
}
