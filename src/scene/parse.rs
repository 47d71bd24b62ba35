//! Parses the tables of a scene file into an unvalidated scene: words become variants, and every variant has the keys that it needs.

pub(crate) mod plan;

use std::path::Path;

use crate::Vector;
use crate::model::Format;
use crate::model::Region;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face};
use crate::model::{AuditPlan, CountRegion, OutputPlan};
use crate::scene::builder::SceneBuilder;
use crate::scene::classes::{self, Distributed};
use crate::scene::config_path::ConfigPath;
use crate::scene::coordinates;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::file::{
    AxisFile, ChainFile, CountFile, DiameterFile, FillFile, InteractionFile, MeshFile, OutputFile, SceneFile,
    SpaceFile, SpeciesFile,
};
use crate::scene::polydispersity::{self, Class};
use crate::scene::surface::{BoxSide, Surface};
use crate::scene::unvalidated::{
    Amount, Arrangement, Chain, Fill, Group, Lattice, Listed, LocatedGroup, Model, SurfaceFill, UnvalidatedBond,
    UnvalidatedInteraction, UnvalidatedSpecies,
};

/// The keys of an entry that depend on its kind, and which of them are given.
pub(super) struct Keys<'k> {
    pub at: &'k ConfigPath,
    pub context: String,
    pub given: &'k [(&'static str, bool)],
}

impl Keys<'_> {
    /// Refuses every given key that is not among those of the kind.
    pub fn allow(&self, known: &[&'static str]) -> Result<(), SceneError> {
        match self.given.iter().find(|(key, is_given)| *is_given && !known.contains(key)) {
            None => Ok(()),
            Some((key, _)) => {
                let (context, known) = (self.context.clone(), known.to_vec());
                Err(SceneError::new(self.at.key(*key), SceneErrorKind::Misplaced { key, context, known }))
            }
        }
    }

    /// The value of a key that the kind needs.
    pub fn need<T>(&self, value: Option<T>, key: &'static str) -> Result<T, SceneError> {
        value.ok_or_else(|| missing(self.at, key, format!("{} needs it", self.context)))
    }
}

fn missing(at: &ConfigPath, key: &'static str, why: impl Into<String>) -> SceneError {
    SceneError::new(at.clone(), SceneErrorKind::Missing { key, why: why.into() })
}

/// What a word of a table stands for.
fn meaning<'t, T>(
    table: &'t [(&'static str, T)],
    what: &'static str,
    word: &str,
    at: &ConfigPath,
) -> Result<&'t T, SceneError> {
    table.iter().find(|(known, _)| *known == word).map(|(_, meaning)| meaning).ok_or_else(|| {
        let known = table.iter().map(|(known, _)| *known);
        SceneError::new(at.clone(), SceneErrorKind::unknown_word(what, word, known))
    })
}

fn vector(components: [f64; 3]) -> Vector {
    Vector::from(components)
}

/// The parts of the scene in a file. `directory` is where relative paths start.
pub(crate) fn parts(file: SceneFile, name: &str, directory: &Path) -> Result<SceneBuilder, SceneError> {
    let mut scene = SceneBuilder::new(file.name.as_deref().unwrap_or(name));
    scene.seed = file.seed.unwrap_or(scene.seed);
    scene.start_time = file.start_time.unwrap_or(0.0);
    scene.allow_invalid_start = file.allow_invalid_start;
    scene.gravity = vector(file.dynamics.gravity.unwrap_or_default());
    scene.contact_time = file.dynamics.contact_time;
    scene.audit = AuditPlan { energy: file.audit.energy, momentum: file.audit.momentum, overlap: file.audit.overlap };
    parse_space(&file.space, &mut scene)?;
    let mut distributed = Vec::new();
    for (index, species) in file.species.into_iter().enumerate() {
        let (draft, classes) = parse_species(species, &ConfigPath::entry("species", index))?;
        distributed.extend(classes.map(|classes| Distributed { index, name: draft.name.clone(), classes }));
        scene.species.push(draft);
    }
    for (index, interaction) in file.interaction.into_iter().enumerate() {
        scene.interactions.push(parse_interaction(interaction, &ConfigPath::entry("interaction", index))?);
    }
    for (index, particle) in file.particle.into_iter().enumerate() {
        let (position, velocity) = (vector(particle.position), vector(particle.velocity));
        let group = Group::Listed(vec![Listed { species: particle.species, position, velocity }]);
        scene.groups.push(LocatedGroup { at: ConfigPath::entry("particle", index), group });
    }
    // With a fill, the box follows from that.
    let sizes = coordinates::add(&file.file, directory, &file.space, file.fill.is_empty(), &mut scene)?;
    for (index, chain) in file.chain.into_iter().enumerate() {
        let at = ConfigPath::entry("chain", index);
        let group = Group::Chain(parse_chain(chain, &at)?);
        scene.groups.push(LocatedGroup { at, group });
    }
    for (index, fill) in file.fill.into_iter().enumerate() {
        let at = ConfigPath::entry("fill", index);
        let group = Group::Fill(parse_fill(fill, &at, scene.size.is_some())?);
        scene.groups.push(LocatedGroup { at, group });
    }
    for (index, surface) in file.mesh.into_iter().enumerate() {
        let at = ConfigPath::entry("mesh", index);
        let group = Group::Surface(parse_surface(surface, &at)?);
        scene.groups.push(LocatedGroup { at, group });
    }
    for (index, bond) in file.bond.into_iter().enumerate() {
        let at = ConfigPath::entry("bond", index);
        scene.bonds.push(UnvalidatedBond { pair: bond.particles, interaction: bond.interaction, at });
    }
    scene.run = plan::parse_run(file.run, file.stage)?;
    scene.measure = plan::parse_measure(file.measure);
    scene.output = parse_output(file.output)?;
    classes::expand(&mut scene, &distributed)?;
    sizes.iter().try_for_each(|sizes| sizes.agree(&scene))?;
    Ok(scene)
}

fn parse_output(output: OutputFile) -> Result<OutputPlan, SceneError> {
    let format = |(index, word): (usize, &String)| {
        Format::ALL.into_iter().find(|format| format.name() == word).ok_or_else(|| {
            let kind = SceneErrorKind::unknown_word("format", word, Format::ALL.map(Format::name));
            SceneError::new(ConfigPath::root().key("output").key("formats").index(index), kind)
        })
    };
    let region = |count: CountFile| CountRegion {
        name: count.name,
        region: Region { lower: vector(count.lower), upper: vector(count.upper) },
    };
    Ok(OutputPlan {
        thermo_interval: output.thermo_interval,
        frame_interval: output.frame_interval,
        regions: output.count.into_iter().map(region).collect(),
        has_contacts: output.contacts,
        has_event_log: output.events,
        formats: output.formats.iter().enumerate().map(format).collect::<Result<_, _>>()?,
    })
}

/// The words for what happens at both sides of an axis.
pub(crate) const BOUNDARIES: [(&str, Boundary); 4] = [
    ("periodic", Boundary::Periodic),
    ("open", Boundary::OPEN),
    ("walls", Boundary::walls(1.0)),
    ("flat", Boundary::Flat),
];

/// The words for one side of an axis, with a perfectly elastic wall.
pub(crate) const SIDES: [(&str, Face); 2] = [("open", Face::Open), ("wall", Face::Wall { restitution: 1.0 })];

fn parse_space(space: &SpaceFile, scene: &mut SceneBuilder) -> Result<(), SceneError> {
    scene.size = space.size.map(vector);
    scene.lower = vector(space.lower.unwrap_or_default());
    scene.shear_rate = space.shear_rate;
    for (k, (name, axis)) in [("x", &space.x), ("y", &space.y), ("z", &space.z)].into_iter().enumerate() {
        let at = ConfigPath::root().key("space").key(name);
        scene.boundary[k] = match axis {
            None => Boundary::Periodic,
            Some(AxisFile::Word(word)) => *meaning(&BOUNDARIES, "boundary", word, &at)?,
            Some(AxisFile::Sides(sides)) => {
                scene.wall_temperatures[k] = sides.temperature;
                if sides.temperature.is_some() && sides.restitution.is_some() {
                    let kind = SceneErrorKind::value("given as well", "either it or a temperature");
                    return Err(SceneError::new(at.key("restitution"), kind));
                }
                let face = |key: &'static str, word: &str| {
                    let face = *meaning(&SIDES, "side", word, &at.key(key))?;
                    Ok(match (face, sides.restitution) {
                        (Face::Wall { .. }, Some(restitution)) => Face::Wall { restitution },
                        _ => face,
                    })
                };
                Boundary::Bounded { lower: face("lower", &sides.lower)?, upper: face("upper", &sides.upper)? }
            }
        };
    }
    Ok(())
}

/// A species, and the classes of its diameters if they are distributed.
fn parse_species(
    species: SpeciesFile,
    at: &ConfigPath,
) -> Result<(UnvalidatedSpecies, Option<Vec<Class>>), SceneError> {
    let SpeciesFile { name, diameter, mass, is_static, acceleration } = species;
    match mass {
        None if !is_static => return Err(missing(at, "mass", "every species that moves has one")),
        Some(mass) if is_static => {
            let kind = SceneErrorKind::value(mass, "no mass: static = true makes it infinite");
            return Err(SceneError::new(at.key("mass"), kind));
        }
        _ => {}
    }
    let (diameter, classes) = match diameter {
        DiameterFile::Number(diameter) => (diameter, None),
        // Every class will have its own.
        DiameterFile::Distribution(file) => (0.0, Some(polydispersity::parse(file, &at.key("diameter"))?)),
    };
    Ok((UnvalidatedSpecies { name, mass, diameter, acceleration: acceleration.map(vector) }, classes))
}

/// The shorthands, and the keys that each one takes.
pub(crate) const POTENTIALS: [(&str, &[&str]); 8] = [
    ("hard-sphere", &["diameter"]),
    ("square-well", &["diameter", "lambda", "well_depth"]),
    ("square-shoulder", &["diameter", "lambda", "height"]),
    ("penetrable", &["diameter", "height"]),
    ("bond", &["diameter", "lambda", "shortest", "longest"]),
    ("stepped", &["radii", "energies"]),
    ("stepped-lennard-jones", &["diameter", "well_depth", "cutoff", "steps", "core_energy"]),
    ("none", &[]),
];

fn parse_interaction(file: InteractionFile, at: &ConfigPath) -> Result<UnvalidatedInteraction, SceneError> {
    let Some((word, known)) = POTENTIALS.into_iter().find(|(word, _)| *word == file.potential) else {
        let kind = SceneErrorKind::unknown_word("potential", &file.potential, POTENTIALS.map(|(word, _)| word));
        return Err(SceneError::new(at.key("potential"), kind));
    };
    let given = [
        ("diameter", file.diameter.is_some()),
        ("lambda", file.lambda.is_some()),
        ("well_depth", file.well_depth.is_some()),
        ("height", file.height.is_some()),
        ("shortest", file.shortest.is_some()),
        ("longest", file.longest.is_some()),
        ("radii", file.radii.is_some()),
        ("energies", file.energies.is_some()),
        ("cutoff", file.cutoff.is_some()),
        ("steps", file.steps.is_some()),
        ("core_energy", file.core_energy.is_some()),
    ];
    let keys = Keys { at, context: format!("potential = \"{word}\""), given: &given };
    keys.allow(known)?;
    if file.species.is_none() && file.name.is_none() {
        return Err(missing(at, "species", "or a name, to use it in bonds"));
    }
    let model = match word {
        "hard-sphere" => Model::HardSphere,
        "square-well" => Model::SquareWell {
            lambda: keys.need(file.lambda, "lambda")?,
            well_depth: keys.need(file.well_depth, "well_depth")?,
        },
        "square-shoulder" => Model::SquareShoulder {
            lambda: keys.need(file.lambda, "lambda")?,
            height: keys.need(file.height, "height")?,
        },
        "penetrable" => Model::Penetrable { height: keys.need(file.height, "height")? },
        "bond" => parse_bond(&file, &keys)?,
        "stepped" => {
            let (radii, energies) = (keys.need(file.radii, "radii")?, keys.need(file.energies, "energies")?);
            Model::Exact(Potential::new(radii, energies).map_err(|error| SceneError::new(stepped(at, &error), error))?)
        }
        "stepped-lennard-jones" => Model::SteppedLennardJones {
            well_depth: keys.need(file.well_depth, "well_depth")?,
            cutoff: keys.need(file.cutoff, "cutoff")?,
            steps: usize::try_from(keys.need(file.steps, "steps")?).unwrap_or(usize::MAX),
            core_energy: keys.need(file.core_energy, "core_energy")?,
        },
        _ => Model::None,
    };
    let restitution = file.restitution.unwrap_or(1.0);
    Ok(UnvalidatedInteraction { name: file.name, species: file.species, model, diameter: file.diameter, restitution })
}

/// Which of the lists of a stepped potential an error is about.
fn stepped(at: &ConfigPath, error: &crate::model::error::PotentialError) -> ConfigPath {
    use crate::model::error::PotentialError as E;
    match *error {
        E::Radius { index, .. } | E::Order { index, .. } => at.key("radii").index(index),
        E::Energy { index, .. } => at.key("energies").index(index),
        E::Outside { .. } => at.key("energies").index(0),
        E::NoRadius => at.key("radii"),
        _ => at.key("energies"),
    }
}

/// Two ways to give a bond: by its lengths, or relative to the diameter.
fn parse_bond(file: &InteractionFile, keys: &Keys<'_>) -> Result<Model, SceneError> {
    if let Some(lambda) = file.lambda {
        keys.allow(&["diameter", "lambda"])?;
        return Ok(Model::Bond { lambda });
    }
    if file.diameter.is_some() {
        return Err(missing(keys.at, "lambda", "a bond with a diameter reaches to lambda times the diameter"));
    }
    let shortest = keys.need(file.shortest, "shortest")?;
    let longest = keys.need(file.longest, "longest")?;
    let potential =
        Potential::bond(shortest, longest).map_err(|error| SceneError::new(keys.at.key("longest"), error))?;
    Ok(Model::Exact(potential))
}

fn parse_chain(file: ChainFile, at: &ConfigPath) -> Result<Chain, SceneError> {
    let straight = match (file.start, file.direction) {
        (Some(start), Some(direction)) => Some((vector(start), vector(direction))),
        (None, None) => None,
        (Some(_), None) => return Err(missing(at, "direction", "a straight chain has a start and a direction")),
        (None, Some(_)) => return Err(missing(at, "start", "a straight chain has a start and a direction")),
    };
    Ok(Chain {
        species: file.species,
        length: file.length,
        count: file.count.unwrap_or(1),
        bond: file.bond,
        spacing: file.spacing,
        straight,
        temperature: file.temperature,
    })
}

/// The words for arrangements.
pub(crate) const ARRANGEMENTS: [(&str, Arrangement); 8] = [
    ("sc", Arrangement::Lattice(Lattice::SimpleCubic)),
    ("bcc", Arrangement::Lattice(Lattice::BodyCentredCubic)),
    ("fcc", Arrangement::Lattice(Lattice::FaceCentredCubic)),
    ("hcp", Arrangement::Lattice(Lattice::HexagonalClosePacked)),
    ("square", Arrangement::Lattice(Lattice::Square)),
    ("hexagonal", Arrangement::Lattice(Lattice::Hexagonal)),
    ("line", Arrangement::Lattice(Lattice::Line)),
    ("random", Arrangement::Random),
];

fn parse_fill(file: FillFile, at: &ConfigPath, has_size: bool) -> Result<Fill, SceneError> {
    let arrangement = *meaning(&ARRANGEMENTS, "arrangement", &file.arrangement, &at.key("arrangement"))?;
    let contradiction = |key: &'static str, given: &str| {
        let kind = SceneErrorKind::value("given as well", format!("either it or {given}"));
        Err(SceneError::new(at.key(key), kind))
    };
    let composition = match (file.species, file.composition) {
        (Some(_), Some(_)) => return contradiction("composition", "species"),
        (Some(species), None) => vec![(species, 1.0)],
        (None, Some(composition)) => composition.into_iter().collect(),
        (None, None) => return Err(missing(at, "species", "or composition, for a mixture")),
    };
    let amount = match (file.number_density, file.packing_fraction) {
        (Some(_), Some(_)) => return contradiction("packing_fraction", "number_density"),
        (Some(density), None) => Some(Amount::NumberDensity(density)),
        (None, Some(fraction)) => Some(Amount::PackingFraction(fraction)),
        (None, None) => None,
    };
    if amount.is_some() && file.count.is_some() && (has_size || file.region.is_some()) {
        return contradiction("count", "a density, because the volume is given");
    }
    Ok(Fill {
        composition,
        arrangement,
        count: file.count,
        amount,
        region: file.region.map(|region| Region { lower: vector(region.lower), upper: vector(region.upper) }),
        temperature: file.temperature,
        velocity: vector(file.velocity.unwrap_or_default()),
    })
}

/// The surfaces, and the keys that each one takes.
pub(crate) const SURFACES: [(&str, &[&str]); 6] = [
    ("plane", &["corner", "edge_1", "edge_2"]),
    ("box", &["lower", "upper", "open"]),
    ("cylinder", &["base", "axis", "radius", "length"]),
    ("cone", &["base", "axis", "radii", "length"]),
    ("sphere", &["centre", "radius"]),
    ("points", &["points"]),
];

fn parse_surface(file: MeshFile, at: &ConfigPath) -> Result<SurfaceFill, SceneError> {
    let Some((word, known)) = SURFACES.into_iter().find(|(word, _)| *word == file.surface) else {
        let kind = SceneErrorKind::unknown_word("surface", &file.surface, SURFACES.map(|(word, _)| word));
        return Err(SceneError::new(at.key("surface"), kind));
    };
    let given = [
        ("corner", file.corner.is_some()),
        ("edge_1", file.edge_1.is_some()),
        ("edge_2", file.edge_2.is_some()),
        ("lower", file.lower.is_some()),
        ("upper", file.upper.is_some()),
        ("open", file.open.is_some()),
        ("base", file.base.is_some()),
        ("axis", file.axis.is_some()),
        ("length", file.length.is_some()),
        ("radii", file.radii.is_some()),
        ("radius", file.radius.is_some()),
        ("centre", file.centre.is_some()),
        ("points", file.points.is_some()),
    ];
    let keys = Keys { at, context: format!("surface = \"{word}\""), given: &given };
    keys.allow(known)?;
    let shape = match word {
        "plane" => Surface::Plane {
            corner: vector(keys.need(file.corner, "corner")?),
            edges: [vector(keys.need(file.edge_1, "edge_1")?), vector(keys.need(file.edge_2, "edge_2")?)],
        },
        "box" => Surface::Box {
            lower: vector(keys.need(file.lower, "lower")?),
            upper: vector(keys.need(file.upper, "upper")?),
            open: parse_sides(&file.open.unwrap_or_default(), at)?,
        },
        "cylinder" | "cone" => Surface::Cone {
            base: vector(keys.need(file.base, "base")?),
            axis: vector(keys.need(file.axis, "axis")?),
            radii: if word == "cone" {
                keys.need(file.radii, "radii")?
            } else {
                [keys.need(file.radius, "radius")?; 2]
            },
            length: keys.need(file.length, "length")?,
        },
        "sphere" => Surface::Sphere {
            centre: vector(keys.need(file.centre, "centre")?),
            radius: keys.need(file.radius, "radius")?,
        },
        _ => Surface::Points(keys.need(file.points, "points")?.into_iter().map(vector).collect()),
    };
    Ok(SurfaceFill { name: file.name, species: file.species, shape, spacing: file.spacing })
}

fn parse_sides(words: &[String], at: &ConfigPath) -> Result<Vec<BoxSide>, SceneError> {
    let side =
        |(index, word): (usize, &String)| meaning(&BoxSide::NAMES, "side", word, &at.key("open").index(index)).copied();
    words.iter().enumerate().map(side).collect()
}
